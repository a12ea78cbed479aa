"""Materials in a scene: Tillotson's equation, or tables."""

from typing import Annotated, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from astroinertia.scene.dimensional import Density, Pressure, Real, SpecificEnergy
from astroinertia.scene.fluids import Fluid, Part, as_tuple


class Material(Part):
    """Matter whose pressure is a function of density and energy: Tillotson's equation for one substance, or a table."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_\-]{0,63}$")] = Field(
        description="what the layers of a body call it"
    )
    tillotson: Literal["iron", "granite", "basalt", "ice"] | None = Field(
        default=None, description="substance of Tillotson's equation; or give a file"
    )
    file: Annotated[str, Field(min_length=1, max_length=512)] | None = Field(
        default=None,
        description="table (.csv .npz .h5), relative to the scene: columns density internal_energy pressure, in SI or "
        "the units that it states; or one over density, temperature and electron fraction in the HDF5 "
        "layout of stellarcollapse.org",
    )
    electron_fraction: Annotated[Real, Field(gt=0.0, le=1.0)] | None = Field(
        default=None, description="of a table over electron fractions: that of this material, electrons a nucleon"
    )
    reference_density: Density | None = Field(
        default=None, description="with a file: the density at which isentropes are distinguished by their energy"
    )
    hottest: SpecificEnergy | None = Field(
        default=None,
        description="energy of the hottest isentrope at the reference density; 1e9 J/kg, or the file's (with an "
        "electron_fraction at most 1e16 J/kg)",
    )
    tension: bool = Field(default=False, description="let matter be pulled, down to half its reference density")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.tillotson is None) == (self.file is None):
            raise ValueError("needs exactly one of tillotson and file.")
        if (self.file is None) != (self.reference_density is None):
            raise ValueError("needs a reference_density with a file, and none with tillotson.")
        if self.file is None and self.electron_fraction is not None:
            raise ValueError("needs an electron_fraction only with a file of such a table.")
        if self.tension and self.electron_fraction is not None:
            raise ValueError("cannot be pulled with an electron_fraction: no tension.")
        return self


class Materials(Fluid):
    """Materials, each with its own P(rho, u), as tables of isentropes that conserve energy exactly."""

    kind: Literal["materials"]
    rank: ClassVar[int] = 6
    made_by: ClassVar[str] = "materials.materials"
    materials: Annotated[tuple[Material, ...], BeforeValidator(as_tuple), Field(min_length=1, max_length=16)] = Field(
        description="what the layers of a body are of; a body without layers is of the first"
    )
    boundary_pressure: Pressure | None = Field(
        default=None,
        description="keep densities sharp where materials meet, which are compared by those that they have at this "
        "pressure; without it sums of mass smooth them",
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = [material.name for material in self.materials]
        if len(set(names)) < len(names):
            raise ValueError("needs materials of different names.")
        return self
