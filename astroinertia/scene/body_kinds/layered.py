"""Planets of layers in a scene."""

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from astroinertia.scene.dimensional import Mass, PositiveNumber, SpecificEnergy
from astroinertia.scene.fluids import Part, as_tuple
from astroinertia.scene.initial_body import Body, Count, PlanLine
from astroinertia.units import shown

_ROCK = 5e3  # kg/m3: what sets the unit of length of a planet whose radius is not known before it is solved for


class Layer(Part):
    """A layer of a body, one of the materials of the equation of state."""

    material: Annotated[str, Field(max_length=64)] = Field(description="name of its material")
    mass_fraction: PositiveNumber = Field(description="its share of the mass; those of all layers are 1 together")
    isentrope: SpecificEnergy = Field(
        default=0.0,
        description="specific energy that its matter has at the reference density of its material, above the coldest",
    )


class LayeredPlanet(Body):
    """A planet of layers from the centre outwards, each isentropic, in hydrostatic equilibrium; its radius follows."""

    kind: Literal["layered"]
    rank: ClassVar[int] = 7
    structure: ClassVar[str] = "planets.planet"
    placing: ClassVar[str] = "placing.of_planet"
    composite: ClassVar[bool] = True
    settles: ClassVar[bool] = True
    particles: Count | None = Field(default=None, description="number of particles (model sph), all of one mass")
    mass: Mass = Field(description="total mass")
    layers: Annotated[tuple[Layer, ...], BeforeValidator(as_tuple), Field(min_length=1, max_length=16)] = Field(
        description="layers, from the centre outwards"
    )
    surface: Literal["smoothed", "full"] = Field(
        default="smoothed",
        description="full: particles near the surface carry, for good, the factor by which their sums over neighbours "
        "are short of the planet's density there; for planets that stay whole, with a boundary_pressure",
    )

    @property
    def radius(self) -> None:
        """Unknown before the planet is solved for."""
        return None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        total = sum(layer.mass_fraction for layer in self.layers)
        if abs(total - 1.0) > 1e-6:
            raise ValueError(f"needs layers whose mass_fractions are 1 together, not {total:g}.")
        for name in ("specific_internal_energy", "entropy", "pressure_fraction"):
            if getattr(self, name) is not None:
                raise ValueError(f"has a {name}, but the matter of its layers is on the isentropes that they give.")
        return self

    @property
    def unit_length(self) -> float:
        """That of a rock of its mass."""
        return (self.mass / _ROCK) ** (1 / 3)

    def check(self, scene: Any) -> None:
        """It needs its materials."""
        fluid = scene.equation_of_state
        if scene.model != "sph" or fluid is None or fluid.kind != "materials":
            raise ValueError("[body] of the kind layered is for the model sph with materials for equation_of_state.")
        names = [material.name for material in fluid.materials]
        for layer in self.layers:
            if layer.material not in names:
                raise ValueError(f"[body] layers are of {', '.join(names)}, but one is of '{shown(layer.material)}'.")
        if self.surface == "full" and (fluid.boundary_pressure is None or len(names) == 1):
            raise ValueError('[body] surface = "full" needs two materials with a boundary_pressure.')
        super().check(scene)

    def characteristic(self) -> dict[str, Any]:
        """It is in equilibrium, of a size that is found when it is placed."""
        return {"mass": self.mass}

    def describe(self, scene: Any) -> list[PlanLine]:
        """Its layers."""
        particle_mass = scene.shown(self.mass / (self.particles or 1), "mass")
        lines: list[PlanLine] = [
            ("kind", "layered"),
            ("particles", f"{self.particles}", f"of {particle_mass} each"),
            ("mass", scene.shown(self.mass, "mass")),
        ]
        if self.surface == "full":
            lines.append(("surface", "full", "factors of densities make up for neighbours that are missing"))
        for layer in self.layers:
            label = scene.shown(layer.isentrope, "specific_energy")
            lines.append((f"layer of {layer.material}", f"{layer.mass_fraction:g} of the mass", f"isentrope {label}"))
        return lines
