"""The body that a scene may ask for, its rotation and prescribed size: validated and frozen, in SI (or code units)."""

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator

from astroinertia.scene.fluids import Part, as_tuple
from astroinertia.scene.places import Position, Velocity
from astroinertia.scene.quantities import (
    AngularMomentum,
    AngularVelocity,
    Duration,
    Length,
    Mass,
    Moment,
    Number,
    NumberNotNegative,
    PositiveNumber,
    SpecificEnergy,
    VelocityGradient,
    checked,
    dimensional,
)
from astroinertia.units import pressure_constant_dimension

MOST_PARTICLES = 50_000_000

Vector = Annotated[tuple[Number, Number, Number], BeforeValidator(as_tuple)]
Axes = Annotated[tuple[PositiveNumber, PositiveNumber, PositiveNumber], BeforeValidator(as_tuple)]
Moments = Annotated[tuple[Moment, Moment, Moment], BeforeValidator(as_tuple)]
MomentRatios = Annotated[tuple[NumberNotNegative, NumberNotNegative, NumberNotNegative], BeforeValidator(as_tuple)]
Matrix = Annotated[tuple[Vector, Vector, Vector], BeforeValidator(as_tuple)]
Times = Annotated[tuple[Duration, ...], BeforeValidator(as_tuple), Field(min_length=1, max_length=1000)]
Factors = Annotated[tuple[PositiveNumber, ...], BeforeValidator(as_tuple), Field(min_length=1, max_length=1000)]
_Row = tuple[VelocityGradient, VelocityGradient, VelocityGradient]
GradientMatrix = Annotated[tuple[_Row, _Row, _Row], BeforeValidator(as_tuple)]
Seed = Annotated[int, Field(ge=0, le=2**32 - 1)]
Law = Literal["rigid", "j_constant", "v_constant"]
StarLaw = Literal["rigid", "j_constant", "v_constant", "maclaurin"]
_SCALED = ("j_constant", "v_constant")


def _exactly_one(part: Part, *names: str) -> None:
    given = [name for name in names if getattr(part, name) is not None]
    if len(given) != 1:
        problem = "none is given" if not given else f"{' and '.join(given)} are given"
        raise ValueError(f"needs exactly one of {', '.join(names[:-1])} and {names[-1]}, but {problem}.")


def _law_with_scale(part: Any) -> None:
    if part.law in _SCALED and part.scale is None:
        raise ValueError(f"needs a scale, for its law is {part.law}.")
    if part.law not in _SCALED and part.scale is not None:
        raise ValueError("has a scale, which only the laws j_constant and v_constant use.")


UNIT_MATRIX = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _at_right_angles(rows: tuple[tuple[float, ...], ...]) -> None:
    sizes = [sum(x * x for x in row) for row in rows]
    for k, one in enumerate(rows):
        across = abs(sum(x * y for x, y in zip(one, rows[k - 1], strict=True)))
        if sizes[k] == 0.0 or across > 1e-6 * (sizes[k] * sizes[k - 1]) ** 0.5:
            raise ValueError("needs axes_at_start at right angles to each other.")


class Rotation(Part):
    """How the body turns at the start; exactly one of rate, period, angular_momentum and t_over_w."""

    law: Law = Field(
        default="rigid",
        description="rigid: one rate; j_constant: rate / (1 + s^2/scale^2), v_constant: rate / (1 + s^2/scale^2)^(1/2) "
        "with s from the axis",
    )
    rate: AngularVelocity | None = Field(default=None, description="angular velocity on the axis")
    period: Duration | None = Field(default=None, description="rotation period on the axis")
    angular_momentum: AngularMomentum | None = Field(default=None, description="total angular momentum")
    t_over_w: Annotated[float, Field(ge=0.0, lt=0.5)] | None = Field(
        default=None, description="rotational kinetic over absolute gravitational energy, T/|W|"
    )
    axis: Vector = Field(default=(0.0, 0.0, 1.0), description="direction of the rotation axis, any length")
    scale: Length | None = Field(default=None, description="length over which a law that is not rigid falls off")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        _exactly_one(self, "rate", "period", "angular_momentum", "t_over_w")
        _law_with_scale(self)
        if not any(self.axis):
            raise ValueError("has an axis of zero length.")
        return self


class Change(Part):
    """A size that is prescribed, as of a skater or a contracting star; without it the model says what the body does."""

    times: Times = Field(description="when, rising; at time 0 the factor is 1, after the last of them it stays")
    factors: Factors = Field(
        description="the inertia tensor over that at time 0, at those times; a smooth curve that never overshoots goes "
        "through them"
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if len(self.times) != len(self.factors):
            raise ValueError(f"needs as many times as factors, but has {len(self.times)} and {len(self.factors)}.")
        if any(b <= a for a, b in zip(self.times, self.times[1:], strict=False)):
            raise ValueError("needs times that rise.")
        return self


class Perturbation(Part):
    """A density that goes round the z axis as 1 + amplitude cos(mode phi), as that of clouds that break up."""

    mode: Annotated[int, Field(ge=2, le=16)] = Field(description="number of dense sides about the z axis")
    amplitude: Annotated[float, Field(gt=0.0, lt=1.0)] = Field(description="of the density, over its mean")


class Body(Part):
    """What every body has, whatever its kind."""

    placement: Literal["glass", "lattice", "random"] = Field(
        default="glass",
        description="how particles are laid out: glass (low noise, no grid), lattice, or random (Poisson noise)",
    )
    seed: Seed = Field(default=1, description="seed of everything random in the placement")
    relax: bool = Field(default=True, description="settle the particles to equilibrium before the start")
    specific_internal_energy: SpecificEnergy | None = Field(
        default=None, description="thermal energy per mass, uniform, instead of that of equilibrium"
    )
    entropy: float | None = Field(
        default=None,
        description="entropy function A = P / rho^gamma (thermal part), uniform, instead of that of equilibrium",
    )
    pressure_fraction: Annotated[float, Field(gt=0.0, le=100.0)] | None = Field(
        default=None, description="pressure as a fraction of that of equilibrium; below 1 the body collapses"
    )
    velocity_gradient: GradientMatrix | None = Field(
        default=None, description="matrix G of a linear velocity field v = G x, added to the rotation"
    )
    rotation: Rotation | None = Field(default=None, description="rotation at the start; without it the body is at rest")
    position: Position | None = Field(default=None, description="where its centre is at first (sph); the origin")
    velocity: Velocity | None = Field(default=None, description="velocity of its centre at first (sph); at rest")
    change: Change | None = Field(default=None, description="a prescribed size (models rigid and scaling)")

    @field_validator("entropy", mode="before")
    @classmethod
    def _entropy(cls, value: Any, info: ValidationInfo) -> float | None:
        if value is None:
            return None
        gamma = (info.context or {}).get("gamma_thermal")
        if gamma is None:
            raise ValueError("needs an equation of state with a thermal part (ideal or hybrid).")
        code = bool((info.context or {}).get("code"))
        return checked(dimensional(value, pressure_constant_dimension(gamma), code), "not negative")

    @model_validator(mode="after")
    def _one_thermal_choice(self) -> Self:
        names = ("specific_internal_energy", "entropy", "pressure_fraction")
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(f"may have only one of {', '.join(names)}, but has {' and '.join(given)}.")
        return self


Count = Annotated[int, Field(ge=16, le=MOST_PARTICLES)]


class _Stretched(Body):
    particles: Count | None = Field(default=None, description="number of particles (model sph)")
    axes: Axes = Field(default=(1.0, 1.0, 1.0), description="stretch along x, y and z, or along axes_at_start")
    axes_at_start: Matrix = Field(
        default=UNIT_MATRIX, description="directions that axes stretch along, one a row, at right angles"
    )
    perturbation: Perturbation | None = Field(default=None, description="a density that is uneven about the z axis")

    @model_validator(mode="after")
    def _has_right_angles(self) -> Self:
        _at_right_angles(self.axes_at_start)
        return self

    @model_validator(mode="after")
    def _uneven_about_its_axis(self) -> Self:
        tilted = self.rotation is not None and (self.rotation.axis[0] != 0.0 or self.rotation.axis[1] != 0.0)
        if self.perturbation is not None and tilted:
            raise ValueError("has a perturbation about z, but a rotation about another axis.")
        return self


class _Sized(_Stretched):
    mass: Mass = Field(description="total mass")
    radius: Length = Field(description="radius before the axes stretch it; semi-axes are radius * axes")


class PolytropeBody(_Sized):
    """A polytrope (Lane-Emden), stretched along its axes."""

    kind: Literal["polytrope"]
    index: Annotated[float, Field(ge=0.0, lt=5.0)] = Field(description="polytropic index n: P ~ rho^(1 + 1/n)")


class UniformBody(_Sized):
    """A sphere or ellipsoid of uniform density."""

    kind: Literal["uniform"]


class PowerLawBody(_Sized):
    """A sphere or ellipsoid with rho ~ r^-exponent (Evrard's cloud has 1)."""

    kind: Literal["power_law"]
    exponent: Annotated[float, Field(ge=0.0, lt=3.0)] = Field(description="exponent of rho ~ r^-exponent")


class DysonBody(_Sized):
    """Dyson's isentropic gas ellipsoid: rho ~ (1 - s^2)^(1/(gamma-1)), s^2 = sum (x/a)^2."""

    kind: Literal["dyson"]
    gamma: Annotated[float, Field(ge=1.001, le=10.0)] = Field(description="adiabatic exponent of the profile")


class RotatingStarBody(Body):
    """A rotating polytrope in equilibrium (self-consistent field), up to mass shedding; it turns about z."""

    kind: Literal["rotating_star"]
    particles: Count | None = Field(default=None, description="number of particles (model sph)")
    mass: Mass = Field(description="total mass")
    radius: Length = Field(description="equatorial radius of a rotating_star")
    index: Annotated[float, Field(gt=0.0, le=4.5)] = Field(description="polytropic index n: P ~ rho^(1 + 1/n)")
    law: StarLaw = Field(
        default="rigid",
        description="rotation law, as in body.rotation; or maclaurin: rings of equal mass have the angular momentum "
        "that those of a Maclaurin spheroid have",
    )
    scale: Length | None = Field(default=None, description="length over which a law that is not rigid falls off")
    perturbation: Perturbation | None = Field(default=None, description="a density that is uneven about the z axis")
    axis_ratio: Annotated[float, Field(gt=0.0, le=1.0)] | None = Field(
        default=None, description="polar over equatorial radius; or give t_over_w, rate or angular_momentum"
    )
    t_over_w: Annotated[float, Field(ge=0.0, lt=0.5)] | None = Field(default=None, description="T/|W| of the star")
    rate: AngularVelocity | None = Field(default=None, description="angular velocity on the star's axis")
    angular_momentum: AngularMomentum | None = Field(default=None, description="total angular momentum of the star")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.rotation is not None:
            raise ValueError("has a table rotation, but a rotating_star turns as its own law and axis_ratio say.")
        _exactly_one(self, "axis_ratio", "t_over_w", "rate", "angular_momentum")
        _law_with_scale(self)
        return self


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


class RigidBody(Body):
    """A body of which only the mass and the inertia tensor are known."""

    kind: Literal["rigid"]
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
        _exactly_one(self, "moments", "moment_ratios")
        if self.moment_ratios is not None and self.radius is None:
            raise ValueError("needs a radius, for it has moment_ratios.")
        a, b, c = sorted(self.moments or self.moment_ratios or ())
        if c <= 0.0:
            raise ValueError("needs moments of which two at least are positive.")
        if c > (a + b) * (1.0 + 1e-12):
            raise ValueError("needs moments of which none is larger than the sum of the others.")
        _at_right_angles(self.axes_at_start)
        return self


class TableBody(Body):
    """The user's own particles."""

    kind: Literal["table"]
    file: Annotated[str, Field(min_length=1, max_length=512)] = Field(
        description="particle table (.csv .npz .nc .h5), relative to the scene: mass x y z and, if wanted, vx vy vz u; "
        "or a snapshot of GADGET or SWIFT (.hdf5), or a dump of Phantom"
    )
    relax: bool = Field(default=False, description="settle the particles to equilibrium before the start")


class ProfileBody(_Stretched):
    """A star from a code of stellar evolution: shells with mass, density, pressure and rotation."""

    kind: Literal["profile"]
    file: Annotated[str, Field(min_length=1, max_length=512)] = Field(
        description="stellar profile, relative to the scene: MESA profile.data, KEPLER presupernova file or .csv with "
        "units"
    )
    inner_mass: Mass | None = Field(default=None, description="take only what lies within this enclosed mass")
    rotation_factor: Annotated[float, Field(ge=-1e6, le=1e6)] = Field(
        default=1.0, description="shells turn about z at this many times the file's rate, where it tells one"
    )
    mean_molecular_weight: Annotated[float, Field(gt=0.1, le=300.0)] | None = Field(
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


class StandardBody(Body):
    """The gas of a problem with a known solution, on which hydrodynamics is tested (code units)."""

    kind: Literal["standard"]
    problem: Literal["sod", "strong_tube", "sedov", "noh", "gresho", "kelvin_helmholtz", "square", "keplerian_disc"] = (
        Field(description="which problem")
    )
    particles: Count | None = Field(default=None, description="number of particles, about: lattices have their own")
    relax: bool = Field(default=False, description="settle the particles to equilibrium before the start")

    @model_validator(mode="after")
    def _has_its_own_state(self) -> Self:
        own = ("specific_internal_energy", "entropy", "pressure_fraction", "velocity_gradient", "rotation", "change")
        given = [name for name in own if getattr(self, name) is not None] + ["relax"] * self.relax
        if given:
            raise ValueError(f"has {given[0]}, but a standard problem has a state of its own.")
        return self


AnyBody = Annotated[
    PolytropeBody
    | UniformBody
    | PowerLawBody
    | DysonBody
    | RotatingStarBody
    | LayeredBody
    | RigidBody
    | TableBody
    | ProfileBody
    | StandardBody,
    Field(discriminator="kind"),
]
