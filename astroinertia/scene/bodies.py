"""The kinds of bodies that a scene may ask for, validated and frozen, in SI (or code units)."""

import math
import re
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from astroinertia.errors import NumericalError, SceneError
from astroinertia.scene.dimensional import (
    AngularMomentum,
    AngularVelocity,
    Duration,
    Length,
    Mass,
    Moment,
    NumberNotNegative,
    PositiveNumber,
    Real,
    SpecificEnergy,
    Speed,
)
from astroinertia.scene.fluids import Part, as_tuple
from astroinertia.scene.initial_body import (
    OF_BREAK_UP,
    UNIT_MATRIX,
    Body,
    Count,
    Fraction,
    Matrix,
    Perturbation,
    PlanLine,
    Shown,
    ascending,
    at_right_angles,
    exactly_one,
    law_with_scale,
    numbers,
)
from astroinertia.scene.own_body import OwnBody
from astroinertia.units import shown

_ROCK = 5e3  # kg/m3: what sets the unit of length of a planet whose radius is not known before it is solved for
_HOMOGENEOUS = 0.4  # I/(M R^2) where nothing is known of the inside
UNBOXED = ("noh", "keplerian_disc")  # standard problems that end before a box would

Axes = Annotated[tuple[PositiveNumber, PositiveNumber, PositiveNumber], BeforeValidator(as_tuple)]
Moments = Annotated[tuple[Moment, Moment, Moment], BeforeValidator(as_tuple)]
MomentRatios = Annotated[tuple[NumberNotNegative, NumberNotNegative, NumberNotNegative], BeforeValidator(as_tuple)]
StarLaw = Literal["rigid", "j_constant", "v_constant", "maclaurin"]


def _profiles() -> Any:
    from astroinertia.sph import profiles  # with SciPy, which a scene does without until something is asked of it

    return profiles


class _Unknown:
    """Of a body whose mass and radius only what it is made from knows."""

    mass = None
    radius = None


class _Stretched(Body):
    particles: Count | None = Field(default=None, description="number of particles (model sph)")
    axes: Axes = Field(default=(1.0, 1.0, 1.0), description="stretch along x, y and z, or along axes_at_start")
    axes_at_start: Matrix = Field(
        default=UNIT_MATRIX, description="directions that axes stretch along, one a row, at right angles"
    )
    perturbation: Perturbation | None = Field(default=None, description="a density that is uneven about the z axis")

    @model_validator(mode="after")
    def _has_right_angles(self) -> Self:
        at_right_angles(self.axes_at_start)
        return self

    @model_validator(mode="after")
    def _uneven_about_its_axis(self) -> Self:
        tilted = self.rotation is not None and any(self.rotation.direction[:2])
        if self.perturbation is not None and tilted:
            raise ValueError("has a perturbation about z, but a rotation about another axis.")
        return self


class _Sized(_Stretched):
    mass: Mass = Field(description="total mass")
    radius: Length = Field(description="radius before the axes stretch it; semi-axes are radius * axes")


class PolytropeBody(_Sized):
    """A polytrope (Lane-Emden), stretched along its axes."""

    kind: Literal["polytrope"]
    index: Annotated[Real, Field(ge=0.0, lt=5.0)] = Field(description="polytropic index n: P ~ rho^(1 + 1/n)")
    shape: ClassVar[str] = "index"
    has_core: ClassVar[bool] = True

    @property
    def homogeneous(self) -> bool:
        """That of index 0 is."""
        return self.index == 0.0

    @property
    def polytropic_index(self) -> float:
        """Its index."""
        return self.index

    @property
    def settles(self) -> bool:
        """All but that of index 0, whose pressure no gas has."""
        return self.index > 0

    def profile(self) -> Any:
        """Lane and Emden's."""
        return _profiles().polytrope(self.index)

    def central(self, mass: float, radius: float) -> tuple[float, float]:
        """By Lane and Emden's constants."""
        from astroinertia.bodies.polytrope import Polytrope

        star = Polytrope(self.index, mass, radius)
        return star.central_pressure, star.central_density


class HomologousCoreBody(_Sized):
    """The core of a star that collapses homologously, of a gas of exponent 4/3 (Goldreich & Weber 1980)."""

    kind: Literal["homologous_core"]
    collapse_rate: Annotated[Real, Field(ge=0.0, le=1.0)] = Field(
        default=1.0, description="how fast it falls: lambda of Goldreich & Weber over the largest that there is"
    )
    start: Literal["parabolic", "rest"] = Field(
        default="parabolic",
        description="how it falls at first: parabolic (a ~ (t0 - t)^(2/3), which stays similar to itself) or rest",
    )
    structure: ClassVar[str] = "spheres.homologous"
    shape: ClassVar[str] = "collapse_rate"
    has_core: ClassVar[bool] = True
    settles: ClassVar[bool] = True
    homologous: ClassVar[bool] = True

    def core(self, mass: float, radius: float, gravitational_constant: float = 1.0) -> Any:
        """The exact collapse (bodies.homologous_core.HomologousCore)."""
        from astroinertia.bodies.homologous_core import HomologousCore

        return HomologousCore(self.collapse_rate, mass, radius, self.start, gravitational_constant)

    def profile(self) -> Any:
        """Goldreich and Weber's."""
        return _profiles().homologous_core(self.collapse_rate)

    def central(self, mass: float, radius: float) -> tuple[float, float]:
        """By Goldreich and Weber's constants."""
        core = self.core(mass, radius)
        return core.central_pressure, core.central_density

    def expansion(self, mass: float, radius: float, gravitational_constant: float = 1.0) -> float:
        """Negative: that of its collapse."""
        return self.core(mass, radius, gravitational_constant).starting_rate

    @property
    def support(self) -> float:
        """Less than 1: the rest of gravity draws it together."""
        core = self.core(1.0, 1.0)
        return -core.internal_energy / core.gravitational_energy

    def describe(self, scene: Any, gravitational_constant: float, shown: Shown) -> list[PlanLine]:
        """With the end of its collapse."""
        core = self.core(self.mass, self.radius, gravitational_constant)
        lines = super().describe(scene, gravitational_constant, shown)
        rate = (
            "nothing draws it in" if math.isinf(core.collapse_time) else f"over at {shown(core.collapse_time, 'time')}"
        )
        return [*lines, ("collapse", f"starts {'from ' * (self.start == 'rest')}{self.start}", rate)]

    def check(self, scene: Any) -> None:
        """Particles settle to its flow with entropies of their own."""
        super().check(scene)
        fluid = scene.equation_of_state
        settles = scene.model == "sph" and self.relax and {"gravity", "pressure"} <= set(scene.effects)
        if not settles:
            return
        if self.rotation is not None:
            raise ValueError(
                "[body] of the kind homologous_core settles without rotation: take the rotation away, or relax = false."
            )
        own = [name for name in ("specific_internal_energy", "entropy") if getattr(self, name) is not None]
        if own or fluid is None or fluid.kind != "ideal" or abs(fluid.gamma - 4.0 / 3.0) > 1e-6:
            what = f"has {own[0]}" if own else "has another equation_of_state"
            raise ValueError(
                "[body] of the kind homologous_core settles as an ideal gas of gamma = 1.3333333333333333, whose "
                f"entropy it finds itself, but {what}: change that, or take relax = false."
            )


class UniformBody(_Sized):
    """A sphere or ellipsoid of uniform density."""

    kind: Literal["uniform"]
    has_core: ClassVar[bool] = True

    @property
    def homogeneous(self) -> bool:
        """It is."""
        return True

    def profile(self) -> Any:
        """Of one density."""
        return _profiles().uniform()


class PowerLawBody(_Sized):
    """A sphere or ellipsoid with rho ~ r^-exponent (Evrard's cloud has 1)."""

    kind: Literal["power_law"]
    exponent: Annotated[Real, Field(ge=0.0, lt=3.0)] = Field(description="exponent of rho ~ r^-exponent")
    shape: ClassVar[str] = "exponent"

    @property
    def homogeneous(self) -> bool:
        """That of exponent 0 is."""
        return self.exponent == 0.0

    def profile(self) -> Any:
        """The power of r."""
        return _profiles().power_law(self.exponent)


class DysonBody(_Sized):
    """Dyson's isentropic gas ellipsoid: rho ~ (1 - s^2)^(1/(gamma-1)), s^2 = sum (x/a)^2."""

    kind: Literal["dyson"]
    gamma: Annotated[Real, Field(ge=1.001, le=10.0)] = Field(description="adiabatic exponent of the profile")
    shape: ClassVar[str] = "gamma"
    has_core: ClassVar[bool] = True
    isentropic: ClassVar[bool] = True

    def profile(self) -> Any:
        """The power of 1 - s^2."""
        return _profiles().dyson(self.gamma)


class RotatingStarBody(Body):
    """A rotating polytrope in equilibrium (self-consistent field), up to mass shedding; it turns about z."""

    kind: Literal["rotating_star"]
    structure: ClassVar[str] = "spheres.rotating"
    shape: ClassVar[str] = "index"
    settles: ClassVar[bool] = True
    rotates_itself: ClassVar[bool] = True
    particles: Count | None = Field(default=None, description="number of particles (model sph)")
    mass: Mass = Field(description="total mass")
    radius: Length = Field(description="equatorial radius of a rotating_star")
    index: Annotated[Real, Field(gt=0.0, le=4.5)] = Field(description="polytropic index n: P ~ rho^(1 + 1/n)")
    law: StarLaw = Field(
        default="rigid",
        description="rotation law, as in body.rotation; or maclaurin: rings of equal mass have the angular momentum "
        "that those of a Maclaurin spheroid have",
    )
    scale: Length | None = Field(default=None, description="length over which a law that is not rigid falls off")
    perturbation: Perturbation | None = Field(default=None, description="a density that is uneven about the z axis")
    axis_ratio: Annotated[Real, Field(gt=0.0, le=1.0)] | None = Field(
        default=None, description="polar over equatorial radius; or another of breakup_fraction to angular_momentum"
    )
    breakup_fraction: Fraction | None = Field(default=None, description=OF_BREAK_UP)
    t_over_w: Annotated[Real, Field(ge=0.0, lt=0.5)] | None = Field(default=None, description="T/|W| of the star")
    rate: AngularVelocity | None = Field(default=None, description="angular velocity on the star's axis")
    period: Duration | None = Field(default=None, description="rotation period on the star's axis")
    angular_momentum: AngularMomentum | None = Field(default=None, description="total angular momentum of the star")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.rotation is not None:
            raise ValueError("has a table rotation, but a rotating_star turns as its own law and axis_ratio say.")
        exactly_one(self, "axis_ratio", "breakup_fraction", "t_over_w", "rate", "period", "angular_momentum")
        law_with_scale(self)
        return self

    @property
    def spin(self) -> Any:
        """The star itself."""
        return self

    @property
    def volume_ratio(self) -> float:
        """By its axes, as of a spheroid."""
        return self.axis_ratio or 1.0

    def profile(self) -> Any:
        """That of the polytrope at rest."""
        return _profiles().polytrope(self.index)

    @property
    def quickly_known(self) -> bool:
        """Whether a plan can solve for the star: with the law maclaurin, that takes as long as some runs."""
        return self.law != "maclaurin"

    def equilibrium(self, gravitational_constant: float) -> Any:
        """The RotatingStar that it is; SceneError, with the limit, where there is none."""
        gravity = gravitational_constant * self.mass / self.radius**3
        rate, spin = math.sqrt(gravity), self.mass * self.radius**2 * math.sqrt(gravity)
        wanted = {
            "axis_ratio": self.axis_ratio,
            "t_over_w": self.t_over_w,
            "breakup_fraction": self.breakup_fraction,
            "period": None if self.period is None else self.period * rate,
            "spin": None if self.rate is None else self.rate / rate,
            "angular_momentum": None if self.angular_momentum is None else self.angular_momentum / spin,
        }
        ((quantity, value),) = ((name, value) for name, value in wanted.items() if value is not None)
        key = "rate" if quantity == "spin" else quantity
        scale = None if self.scale is None else self.scale / self.radius
        if value < 0.0:
            raise SceneError(f"[body] {key} must not be negative, for a rotating_star turns about z.")
        try:
            star = _unit_star(self.index, self.law, scale, quantity, value)
        except (ValueError, NumericalError) as error:
            size = {"period": 1.0 / rate, "spin": rate, "angular_momentum": spin}.get(quantity, 1.0)
            unit = {"period": " s", "spin": " rad s-1", "angular_momentum": " kg m2 s-1"}.get(quantity, "")
            unit = "" if gravitational_constant == 1.0 else unit
            limit = ""
            if isinstance(error, NumericalError):
                last = _last_star(self.index, self.law, scale)
                most = {
                    "axis_ratio": last.field.axis_ratio, "period": 2.0 * math.pi / last.angular_velocity,
                    "spin": last.angular_velocity, "breakup_fraction": last.keplerian_fraction,
                    "t_over_w": last.rotational_to_gravitational, "angular_momentum": last.angular_momentum,
                }[quantity]  # fmt: skip
                bound = "least" if quantity in ("axis_ratio", "period") else "most"
                limit = f"; the {bound} {key} is {most * size:.4g}{unit}"
                limit += "" if key == "axis_ratio" else f", at axis ratio {last.field.axis_ratio:.4g}"
            reason = str(error).rpartition(", and ")[2]
            if key != "axis_ratio":  # where the search ended
                reason = re.sub(r"with axis ratio \S+ and ", "with ", reason)
            raise SceneError(f"[body] {key} of {value * size:.6g}{unit}: {reason}{limit}.") from None
        return replace(
            star, mass=self.mass, equatorial_radius=self.radius, gravitational_constant=gravitational_constant
        )

    def turning(self, tensor: np.ndarray, gravitational: float | None) -> dict[str, Any]:
        """An estimate for the law maclaurin, whose star takes long to solve for: as the sphere of its radius, with the
        T/|W| that Maclaurin's spheroid has at its axis ratio.
        """
        assert gravitational is not None  # it has a profile
        moment = float(tensor[2, 2])
        if self.t_over_w is not None:
            ratio = self.t_over_w
        elif self.rate is not None:
            ratio = 0.5 * moment * self.rate**2 / gravitational
        elif self.period is not None:
            ratio = 0.5 * moment * (2.0 * math.pi / self.period) ** 2 / gravitational
        elif self.breakup_fraction is not None:
            orbit = (5.0 - self.index) / (3.0 * self.mass * self.radius**2)  # over |W|, as of the polytrope at rest
            ratio = 0.5 * moment * self.breakup_fraction**2 * orbit
        elif self.angular_momentum is not None:
            ratio = 0.5 * self.angular_momentum**2 / moment / gravitational
        else:
            assert self.axis_ratio is not None
            e = math.sqrt(1.0 - self.axis_ratio**2)
            sine = math.asin(e)
            ratio = 0.0 if e < 1e-3 else 1.5 / e**2 - 1.0 - 1.5 * math.sqrt(1.0 - e**2) / (e * sine)
        rotational = ratio * gravitational
        spin = math.sqrt(2.0 * rotational / moment)
        backwards = (self.rate or self.angular_momentum or 0.0) < 0.0
        axis = (0.0, 0.0, -1.0 if backwards else 1.0)
        shear = 0.0 if self.law == "rigid" else spin
        return {"spin": spin, "spin_axis": axis, "wobble": 0.0, "rotational": rotational, "shear": shear}


@lru_cache(maxsize=8)
def _unit_star(index: float, kind: str, scale: float | None, quantity: str, value: float) -> Any:
    """In units of its mass, equatorial radius and G."""
    from astroinertia.bodies.rotating_star import rotating_star_with  # only scenes with stars solve for one

    return rotating_star_with(quantity, value, *_matter_and_law(index, kind, scale))


@lru_cache(maxsize=8)
def _last_star(index: float, kind: str, scale: float | None) -> Any:
    """The flattest, in the same units."""
    from astroinertia.bodies.rotating_star import end_of_sequence

    return end_of_sequence(*_matter_and_law(index, kind, scale))


def _matter_and_law(index: float, kind: str, scale: float | None) -> tuple[Any, Any]:
    from astroinertia.bodies.maclaurin_momentum import MomentumLaw
    from astroinertia.bodies.rotation_laws import RotationLaw
    from astroinertia.matter.barotropes import polytropic_matter

    return polytropic_matter(index), MomentumLaw() if kind == "maclaurin" else RotationLaw(kind, scale)


class Layer(Part):
    """A layer of a body, one of the materials of the equation of state."""

    material: Annotated[str, Field(max_length=64)] = Field(description="name of its material")
    mass_fraction: PositiveNumber = Field(description="its share of the mass; those of all layers are 1 together")
    isentrope: SpecificEnergy = Field(
        default=0.0,
        description="specific energy that its matter has at the reference density of its material, above the coldest",
    )


class LayeredBody(Body):
    """A planet of layers from the centre outwards, each isentropic, in hydrostatic equilibrium; its radius follows."""

    kind: Literal["layered"]
    structure: ClassVar[str] = "planets.planet"
    placing: ClassVar[str] = "placing.of_planet"
    composite: ClassVar[bool] = True
    settles: ClassVar[bool] = True
    particles: Count | None = Field(default=None, description="number of particles (model sph), all of one mass")
    mass: Mass = Field(description="total mass")
    layers: Annotated[tuple[Layer, ...], BeforeValidator(as_tuple), Field(min_length=1, max_length=16)] = Field(
        description="layers, from the centre outwards"
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
        super().check(scene)

    def characteristic(self) -> dict[str, Any]:
        """It is in equilibrium, of a size that is found when it is placed."""
        return {"mass": self.mass}

    def describe(self, scene: Any, gravitational_constant: float, shown: Shown) -> list[PlanLine]:
        """Its layers."""
        particle_mass = shown(self.mass / (self.particles or 1), "mass")
        lines: list[PlanLine] = [
            ("kind", "layered"),
            ("particles", f"{self.particles}", f"of {particle_mass} each"),
            ("mass", shown(self.mass, "mass")),
        ]
        for layer in self.layers:
            label = shown(layer.isentrope, "specific_energy")
            lines.append((f"layer of {layer.material}", f"{layer.mass_fraction:g} of the mass", f"isentrope {label}"))
        return lines


class RigidBody(Body):
    """A body of which only the mass and the inertia tensor are known."""

    kind: Literal["rigid"]
    models: ClassVar[tuple[str, ...]] = ("rigid", "scaling")
    structure: ClassVar[str] = ""
    moments_from: ClassVar[str] = "rigid.of_solid"
    solid: ClassVar[bool] = True
    particles: ClassVar[None] = None
    mass: Mass = Field(description="total mass")
    radius: Length | None = Field(default=None, description="a radius, for moment_ratios and I/(M R^2)")
    moments: Moments | None = Field(default=None, description="principal moments of inertia; or give moment_ratios")
    moment_ratios: MomentRatios | None = Field(default=None, description="principal moments over mass radius^2")
    axes_at_start: Matrix = Field(
        default=UNIT_MATRIX,
        description="directions of the principal axes at the start, one a row, at right angles",
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        exactly_one(self, "moments", "moment_ratios")
        if self.moment_ratios is not None and self.radius is None:
            raise ValueError("needs a radius, for it has moment_ratios.")
        a, b, c = sorted(self.moments or self.moment_ratios or ())
        if c <= 0.0:
            raise ValueError("needs moments of which two at least are positive.")
        if c > (a + b) * (1.0 + 1e-12):
            raise ValueError("needs moments of which none is larger than the sum of the others.")
        at_right_angles(self.axes_at_start)
        return self

    @property
    def unit_length(self) -> float:
        """Its radius, or a radius of gyration."""
        if self.radius is not None:
            return self.radius
        assert self.moments is not None
        return math.sqrt(max(self.moments) / self.mass)

    def characteristic(self) -> dict[str, Any]:
        """By its moments; without a radius, as of a homogeneous body."""
        if self.moments is not None:
            moments = np.asarray(self.moments, dtype=float)
        else:
            assert self.radius is not None
            moments = np.asarray(self.moment_ratios, dtype=float) * self.mass * self.radius**2
        rows = self.rows_at_start
        radius = math.sqrt(moments.max() / self.mass / _HOMOGENEOUS) if self.radius is None else self.radius
        turning = self.turning(rows.T @ np.diag(moments) @ rows, None)
        return {"mass": self.mass, "radius": radius, "moments": ascending(moments), **turning}

    def describe(self, scene: Any, gravitational_constant: float, shown: Shown) -> list[PlanLine]:
        """Its mass and moments."""
        lines: list[PlanLine] = [("kind", "rigid"), ("mass", shown(self.mass, "mass"))]
        if self.radius is not None:
            lines.append(("radius", shown(self.radius, "length")))
        if self.moments is not None:
            moments = ", ".join(shown(moment, "moment_of_inertia") for moment in self.moments)
            return [*lines, ("principal moments", moments)]
        assert self.moment_ratios is not None
        return [*lines, ("principal moments", numbers(self.moment_ratios), "over mass radius^2")]


class TableBody(_Unknown, Body):
    """The user's own particles."""

    kind: Literal["table"]
    models: ClassVar[tuple[str, ...]] = ("sph", "rigid")
    structure: ClassVar[str] = ""
    placing: ClassVar[str] = "placing.of_table"
    moments_from: ClassVar[str] = "rigid.of_table"
    turns_with_axis: ClassVar[bool] = False
    boxed: ClassVar[bool] = True
    without_heat: ClassVar[str] = "a table without a column u"
    particles: ClassVar[None] = None
    file: Annotated[str, Field(min_length=1, max_length=512)] = Field(
        description="particle table (.csv .npz .nc .h5), relative to the scene: mass x y z and, if wanted, vx vy vz u; "
        "or a snapshot of GADGET or SWIFT (.hdf5), or a dump of Phantom"
    )
    velocity_unit: Speed | None = Field(
        default=None,
        description="unit of the velocities of a snapshot that states no units: its masses and lengths are in those of "
        "[units], and so are velocities, with G = 1, without it",
    )
    relax: bool = Field(default=False, description="settle the particles to equilibrium before the start")

    def path(self, scene: Any) -> Path:
        """Where its file is."""
        return Path(scene.origin or ".") / self.file

    def check(self, scene: Any) -> None:
        """A file that states no units has them in the scene; `load` takes those of one that does."""
        super().check(scene)
        if scene.units in (None, "SI"):
            raise ValueError(
                '[units] with mass and length (or units = "code") is needed for a body of kind table, whose file '
                'states no units; a table in SI takes units = "SI", and heads of CSV columns may have units: "x (km)".'
            )

    def describe(self, scene: Any, gravitational_constant: float, shown: Shown) -> list[PlanLine]:
        """What is in its file."""
        from astroinertia.scene.plan_table import table_lines  # only where there is a file to open

        return table_lines(self, scene, shown)


class ProfileBody(_Unknown, _Stretched):
    """A star from a code of stellar evolution: shells with mass, density, pressure and rotation."""

    kind: Literal["profile"]
    models: ClassVar[tuple[str, ...]] = ("sph",)
    structure: ClassVar[str] = "spheres.progenitor"
    rotates_itself: ClassVar[bool] = True
    file: Annotated[str, Field(min_length=1, max_length=512)] = Field(
        description="stellar profile, relative to the scene: MESA profile.data, KEPLER presupernova file or .csv with "
        "units"
    )
    inner_mass: Mass | None = Field(default=None, description="take only what lies within this enclosed mass")
    rotation_factor: Annotated[Real, Field(ge=-1e6, le=1e6)] = Field(
        default=1.0, description="shells turn about z at this many times the file's rate, where it tells one"
    )
    mean_molecular_weight: Annotated[Real, Field(gt=0.1, le=300.0)] | None = Field(
        default=None, description="of the ideal gas whose pressure is taken where a file has temperatures but none"
    )
    relax: bool = Field(default=False, description="must be false: a profile is placed as it is")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.relax:
            raise ValueError("has relax = true, but a profile is placed as the file has it.")
        if self.rotation is not None and "rotation_factor" in self.model_fields_set:
            raise ValueError("has a table rotation, which takes the place of the file's, and a rotation_factor.")
        return self

    def check(self, scene: Any) -> None:
        """Its file is in SI and sets no units."""
        super().check(scene)
        if scene.units in (None, "SI") or scene.dimensionless:
            raise ValueError("[units] with mass and length is needed for a body of kind profile.")

    def describe(self, scene: Any, gravitational_constant: float, shown: Shown) -> list[PlanLine]:
        """Its file and what is taken of it."""
        part = "all of it"
        if self.inner_mass is not None:
            part = f"the inner {shown(self.inner_mass, 'mass')}"
        lines: list[PlanLine] = [("kind", f"profile from {self.file}", part), ("particles", f"{self.particles}")]
        if self.rotation is None:
            lines.append(("shells turn", f"{self.rotation_factor:g} times as fast as the file says", "about z"))
        return [*lines, ("placement", self.placement, f"seed {self.seed}, not settled first")]


class StandardBody(_Unknown, Body):
    """The gas of a problem with a known solution, on which hydrodynamics is tested (code units)."""

    kind: Literal["standard"]
    models: ClassVar[tuple[str, ...]] = ("sph",)
    structure: ClassVar[str] = ""
    placing: ClassVar[str] = "placing.of_problem"
    composite: ClassVar[bool] = True
    boxed: ClassVar[bool] = True
    laid_out: ClassVar[bool] = False
    problem: Literal["sod", "strong_tube", "sedov", "noh", "gresho", "kelvin_helmholtz", "square", "keplerian_disc"] = (
        Field(description="which problem")
    )
    particles: Count | None = Field(default=None, description="number of particles, about: lattices have their own")
    relax: bool = Field(default=False, description="settle the particles to equilibrium before the start")

    @model_validator(mode="after")
    def _has_its_own_state(self) -> Self:
        own = ("specific_internal_energy", "entropy", "pressure_fraction", "velocity_gradient", "rotation", "change")
        own_keys = [name for name in own if getattr(self, name) is not None] + ["relax"] * self.relax
        if own_keys:
            raise ValueError(f"has {own_keys[0]}, but a standard problem has a state of its own.")
        return self

    def check(self, scene: Any) -> None:
        """It needs code units, an ideal gas, and the box that its problem fills."""
        if scene.model != "sph" or scene.bodies:
            raise ValueError("[body] of the kind standard is for the model sph, and alone.")
        super().check(scene)
        if not scene.dimensionless:
            raise ValueError('[body] of the kind standard needs a scene in code units: units = "code".')
        if scene.equation_of_state is None or scene.equation_of_state.kind != "ideal":
            raise ValueError("[body] of the kind standard needs an equation_of_state of the kind ideal.")
        without = self.problem in UNBOXED
        if without != (scene.box is None) or (scene.box is not None and not all(scene.box.repeats)):
            needs = "ends by itself and has no box" if without else "fills a box that is periodic along all axes"
            raise ValueError(f"[body] the problem {self.problem} {needs}.")

    def describe(self, scene: Any, gravitational_constant: float, shown: Shown) -> list[PlanLine]:
        """Its problem."""
        return [("problem", self.problem), ("particles", f"about {self.particles}", "on lattices")]


AnyBody = Annotated[
    PolytropeBody
    | HomologousCoreBody
    | UniformBody
    | PowerLawBody
    | DysonBody
    | RotatingStarBody
    | LayeredBody
    | RigidBody
    | TableBody
    | ProfileBody
    | StandardBody
    | OwnBody,
    Field(discriminator="kind"),
]
KINDS: dict[str, type[Body]] = {
    get_args(made.model_fields["kind"].annotation)[0]: made
    for made in get_args(get_args(AnyBody)[0])
    if made is not OwnBody
}
