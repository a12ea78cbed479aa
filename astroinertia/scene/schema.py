"""The scene: what a person may ask for, validated and frozen.

Every quantity is a float in SI units once validated (in code units, G = 1, where the scene says `units = "code"`). The
field descriptions are what `astroinertia new` writes as comments. Effects are checked in load.py, against the plain
data of effects/catalogue.py, so that no effect that a scene does not list is imported.
"""

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator

from astroinertia.scene.fluids import AnyEquationOfState, Part, as_tuple
from astroinertia.scene.quantities import (
    AngularMomentum,
    AngularVelocity,
    Duration,
    Length,
    Mass,
    Number,
    PositiveNumber,
    SpecificEnergy,
    VelocityGradient,
    checked,
    dimensional,
)
from astroinertia.units import pressure_constant_dimension

MOST_PARTICLES = 50_000_000
MOST_RECORDS = 1e6  # a record holds some hundreds of numbers
MOST_SNAPSHOTS = 1e5
MOST_STEPS = 1e10

Vector = Annotated[tuple[Number, Number, Number], BeforeValidator(as_tuple)]
Axes = Annotated[tuple[PositiveNumber, PositiveNumber, PositiveNumber], BeforeValidator(as_tuple)]
_Row = tuple[VelocityGradient, VelocityGradient, VelocityGradient]
GradientMatrix = Annotated[tuple[_Row, _Row, _Row], BeforeValidator(as_tuple)]
Seed = Annotated[int, Field(ge=0, le=2**32 - 1)]
Law = Literal["rigid", "j_constant", "v_constant"]


def _exactly_one(part: Part, *names: str) -> None:
    given = [name for name in names if getattr(part, name) is not None]
    if len(given) != 1:
        told = "none is given" if not given else f"{' and '.join(given)} are given"
        raise ValueError(f"needs exactly one of {', '.join(names[:-1])} and {names[-1]}, but {told}.")


def _law_with_scale(part: Any) -> None:
    if part.law != "rigid" and part.scale is None:
        raise ValueError(f"needs a scale, for its law is {part.law}.")
    if part.law == "rigid" and part.scale is not None:
        raise ValueError("has a scale, which only the laws j_constant and v_constant use.")


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
        if sum(component**2 for component in self.axis) == 0.0:
            raise ValueError("has an axis of zero length.")
        return self


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


class _Sized(Body):
    particles: Count = Field(description="number of particles")
    mass: Mass = Field(description="total mass")
    radius: Length = Field(description="radius before the axes stretch it; semi-axes are radius * axes")
    axes: Axes = Field(default=(1.0, 1.0, 1.0), description="stretch along x, y and z")


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
    gamma: Annotated[float, Field(gt=1.0, le=10.0)] = Field(description="adiabatic exponent of the profile")


class RotatingStarBody(Body):
    """A rotating polytrope in equilibrium (self-consistent field), up to mass shedding; it turns about z."""

    kind: Literal["rotating_star"]
    particles: Count = Field(description="number of particles")
    mass: Mass = Field(description="total mass")
    radius: Length = Field(description="equatorial radius of a rotating_star")
    index: Annotated[float, Field(gt=0.0, le=4.5)] = Field(description="polytropic index n: P ~ rho^(1 + 1/n)")
    law: Law = Field(default="rigid", description="rotation law, as in body.rotation")
    scale: Length | None = Field(default=None, description="length over which a law that is not rigid falls off")
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


class TableBody(Body):
    """The user's own particles."""

    kind: Literal["table"]
    file: Annotated[str, Field(min_length=1, max_length=512)] = Field(
        description="particle table (.csv .npz .nc .h5), relative to the scene: mass x y z and, if wanted, vx vy vz u"
    )
    relax: bool = Field(default=False, description="settle the particles to equilibrium before the start")


AnyBody = Annotated[
    PolytropeBody | UniformBody | PowerLawBody | DysonBody | RotatingStarBody | TableBody, Field(discriminator="kind")
]


class Numerics(Part):
    """How it is computed: engine, precision, kernel and time-step factors."""

    engine: Literal["numba_cpu", "xla"] = Field(
        default="numba_cpu", description="numba_cpu: threaded loops; xla: dense tiles, for GPUs and gradients"
    )
    precision: Literal["float64", "mixed"] = Field(
        default="float64", description="mixed: pair sums in float32, state in float64"
    )
    kernel: Literal["cubic", "quartic", "quintic", "wendland_c2", "wendland_c4", "wendland_c6"] = Field(
        default="wendland_c2", description="smoothing kernel"
    )
    eta: Annotated[float, Field(ge=0.8, le=3.0)] | None = Field(
        default=None,
        description="smoothing length over particle spacing; without it, what is recommended for the kernel",
    )
    neighbours: Annotated[float, Field(ge=20.0, le=1000.0)] | None = Field(
        default=None, description="mean number of neighbours, another way to give eta"
    )
    smoothing_tolerance: Annotated[float, Field(ge=1e-15, le=1e-2)] = Field(
        default=1e-8, description="relative tolerance of the smoothing lengths"
    )
    courant: Annotated[float, Field(gt=0.0, le=1.0)] = Field(
        default=0.3, description="time step over smoothing length / signal speed (Monaghan 1992: 0.3)"
    )
    acceleration_factor: Annotated[float, Field(gt=0.0, le=2.0)] = Field(
        default=0.25, description="time step over sqrt(smoothing length / acceleration) (Monaghan 1989: 0.25)"
    )
    energy_factor: Annotated[float, Field(gt=0.0, le=2.0)] = Field(
        default=0.25, description="time step over internal energy / its rate of change"
    )
    max_timestep: Duration | None = Field(default=None, description="the time step never exceeds this")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.eta is not None and self.neighbours is not None:
            raise ValueError("has both eta and neighbours, which say the same thing; keep one.")
        return self


class TimeSpan(Part):
    """From time 0 to the end."""

    end: Duration = Field(description="the run ends here")
    max_steps: Annotated[int, Field(ge=1, le=10**12)] | None = Field(default=None, description="or after so many steps")


class Output(Part):
    """What is written and how often; without any of them, 200 records and 10 snapshots a run."""

    series_every: Duration | None = Field(default=None, description="time between records of the series")
    series_steps: Annotated[int, Field(ge=1, le=10**9)] | None = Field(
        default=None, description="steps between records, instead of series_every"
    )
    snapshot_every: Duration | None = Field(default=None, description="time between snapshots of all particles")
    align: bool = Field(
        default=False,
        description="shorten time steps to meet each record; otherwise the first step past its time is recorded",
    )
    checkpoint_seconds: Annotated[float, Field(ge=0.0, le=1e6)] = Field(
        default=60.0, description="seconds of wall time between checkpoints"
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.series_every is not None and self.series_steps is not None:
            raise ValueError("has both series_every and series_steps; keep one.")
        return self


class Units(Part):
    """Code units (G = 1) that the run uses inside; without them, the body's mass and radius."""

    mass: Mass = Field(description="unit of mass")
    length: Length = Field(description="unit of length")


class Scene(Part):
    """A whole scene. `source` and `overrides` are the text it came from and the --set arguments, for the record."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_\-]{0,63}$")] = Field(
        description="short name: letters, digits, _ and -; names the run's folder"
    )
    description: Annotated[str, Field(max_length=2000)] = Field(default="", description="what the scene is for")
    model: Literal["sph"] = Field(default="sph", description="which model answers the scene")
    units: Literal["code"] | Units | None = Field(
        default=None, description='"code": plain numbers with G = 1 everywhere; or a table with mass and length'
    )
    body: AnyBody
    equation_of_state: AnyEquationOfState
    effects: dict[str, dict[str, Any]] = Field(description="kind of each effect called for, with all its options")
    numerics: Numerics = Field(default_factory=Numerics)
    time: TimeSpan
    output: Output = Field(default_factory=Output)
    source: str = ""
    overrides: tuple[str, ...] = ()
    origin: str | None = None

    @property
    def dimensionless(self) -> bool:
        """Whether the scene is in code units, with G = 1 and no conversion at either end."""
        return self.units == "code"

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for table, key, most in (
            ("output", "series_every", MOST_RECORDS),
            ("output", "snapshot_every", MOST_SNAPSHOTS),
            ("numerics", "max_timestep", MOST_STEPS),
        ):
            value = getattr(getattr(self, table), key)
            if value is not None and self.time.end > most * value:
                raise ValueError(f"[{table}] {key} divides the run into more than {most:.0e} parts; make it longer.")
        if self.body.kind == "table" and self.units is None:
            raise ValueError('[units] with mass and length (or units = "code") is needed for a body of kind table.')
        return self
