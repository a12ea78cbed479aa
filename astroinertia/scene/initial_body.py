"""What every body of a scene has, whatever its kind: its state, rotation and prescribed size, in SI (or code units).

What the rest of the package asks of a kind of body is an attribute or a method of its class (scene.body_kinds); those
of `Body` are what most kinds have.
"""

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator

from astroinertia.effects.characteristic import Vector as Triple
from astroinertia.errors import SceneError
from astroinertia.inertia.principal import EQUAL_MOMENTS
from astroinertia.scene.dimensional import (
    Angle,
    AngularMomentum,
    AngularVelocity,
    Duration,
    Length,
    Number,
    PositiveNumber,
    Real,
    SpecificEnergy,
    VelocityGradient,
    Whole,
    checked,
    dimensional,
)
from astroinertia.scene.fluids import Part, as_tuple
from astroinertia.scene.places import Position, Velocity
from astroinertia.units import ALL_MODELS, Dimension, Option, pressure_constant_dimension

MOST_PARTICLES = 50_000_000
Count = Annotated[Whole, Field(ge=16, le=MOST_PARTICLES)]
PlanLine = tuple[str, ...]

Vector = Annotated[tuple[Number, Number, Number], BeforeValidator(as_tuple)]
Matrix = Annotated[tuple[Vector, Vector, Vector], BeforeValidator(as_tuple)]
Times = Annotated[tuple[Duration, ...], BeforeValidator(as_tuple), Field(min_length=1, max_length=1000)]
Factors = Annotated[tuple[PositiveNumber, ...], BeforeValidator(as_tuple), Field(min_length=1, max_length=1000)]
_Row = tuple[VelocityGradient, VelocityGradient, VelocityGradient]
GradientMatrix = Annotated[tuple[_Row, _Row, _Row], BeforeValidator(as_tuple)]
Seed = Annotated[Whole, Field(ge=0, le=2**32 - 1)]
Law = Literal["rigid", "j_constant", "v_constant"]
_SCALED = ("j_constant", "v_constant")
Fraction = Annotated[Real, Field(ge=0.0, lt=1.0)]
OF_BREAK_UP = "angular velocity of the equator over that of an orbit there, 1 where mass is shed"


def exactly_one(part: Part, *names: str) -> None:
    """ValueError where none, or more than one, of the keys of those names is given."""
    keys = [name for name in names if getattr(part, name) is not None]
    if len(keys) != 1:
        problem = "none is given" if not keys else f"{' and '.join(keys)} are given"
        raise ValueError(f"needs exactly one of {', '.join(names[:-1])} and {names[-1]}, but {problem}.")


def law_with_scale(part: Any) -> None:
    """ValueError where a rotation law that needs a scale has none, or one that needs none has one."""
    if part.law in _SCALED and part.scale is None:
        raise ValueError(f"needs a scale, for its law is {part.law}.")
    if part.law not in _SCALED and part.scale is not None:
        raise ValueError("has a scale, which only the laws j_constant and v_constant use.")


UNIT_MATRIX = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def at_right_angles(rows: tuple[tuple[float, ...], ...]) -> None:
    """ValueError where directions, one a row, are not at right angles to each other."""
    sizes = [sum(x * x for x in row) for row in rows]
    for k, one in enumerate(rows):
        across = abs(sum(x * y for x, y in zip(one, rows[k - 1], strict=True)))
        if sizes[k] == 0.0 or across > 1e-6 * (sizes[k] * sizes[k - 1]) ** 0.5:
            raise ValueError("needs axes_at_start at right angles to each other.")


def numbers(values: tuple[float, ...]) -> str:
    """Plain numbers in brackets."""
    return f"({', '.join(f'{value:g}' for value in values)})"


def option_text(value: Any, dimension: str | Dimension, scene: Any) -> str:
    """An option's value, as written for a person."""
    if isinstance(value, str | bool):
        return value if isinstance(value, str) else str(value).lower()
    if isinstance(value, tuple | list):
        return f"({', '.join(option_text(item, dimension, scene) for item in value)})"
    return scene.shown(value, dimension)


def option_lines(options: Mapping[str, Any], declared: Mapping[str, Option], scene: Any) -> list[PlanLine]:
    """The lines of the plan on the options of what is not of this package."""
    return [
        (name.replace("_", " "), option_text(value, declared[name].dimension, scene), declared[name].text)
        for name, value in options.items()
        if value is not None
    ]


def ascending(moments: np.ndarray) -> Triple:
    """Principal moments, the least first."""
    least, middle, largest = np.sort(moments)
    return float(least), float(middle), float(largest)


def unit(vector: Any) -> Triple:
    """The direction of a vector."""
    x, y, z = np.asarray(vector, dtype=float) / np.linalg.norm(vector)
    return float(x), float(y), float(z)


def unit_rows(rows: Any) -> np.ndarray:
    """Directions (3, 3), one a row, as unit vectors."""
    rows = np.asarray(rows, dtype=float)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def wobbling(moments: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Directions (3,) of L and of omega in the principal axes, moments (3,) ascending, at that angle of wobble.

    L lies between the axes of the largest and of the least moment. SceneError where there is no axis of the largest.
    """
    if not moments[2] > moments[1] * (1.0 + EQUAL_MOMENTS):
        raise SceneError("[body.rotation] wobble needs one moment that is larger than the others.")
    if moments[0] <= 0.0:
        raise SceneError("[body.rotation] wobble needs moments that are all positive.")
    momentum = np.array([math.sin(angle), 0.0, math.cos(angle)])
    spin = momentum / moments * moments[2]
    return momentum, spin / np.linalg.norm(spin)


def spin_of(turns: Any, moment: float, gravitational: float | None) -> float | None:
    """The rate about an axis of that moment in a body of that |W|, as a part of a scene that turns states it.

    None where it does not follow from a rate, period, angular_momentum or t_over_w.
    """
    if turns.rate is not None:
        return abs(turns.rate)
    if turns.period is not None:
        return 2.0 * math.pi / turns.period
    if turns.angular_momentum is not None:
        return abs(turns.angular_momentum) / moment if moment else None
    if gravitational is None or turns.t_over_w is None:
        return None
    return math.sqrt(2.0 * turns.t_over_w * gravitational / moment)


class Rotation(Part):
    """How the body turns at the start; exactly one of rate, period, angular_momentum, t_over_w and breakup_fraction."""

    law: Law = Field(
        default="rigid",
        description="rigid: one rate; j_constant: rate / (1 + s^2/scale^2), v_constant: rate / (1 + s^2/scale^2)^(1/2) "
        "with s from the axis",
    )
    rate: AngularVelocity | None = Field(default=None, description="angular velocity on the axis")
    period: Duration | None = Field(default=None, description="rotation period on the axis")
    angular_momentum: AngularMomentum | None = Field(default=None, description="total angular momentum")
    t_over_w: Annotated[Real, Field(ge=0.0, lt=0.5)] | None = Field(
        default=None, description="rotational kinetic over absolute gravitational energy, T/|W|"
    )
    breakup_fraction: Fraction | None = Field(default=None, description=f"of a polytrope in equilibrium: {OF_BREAK_UP}")
    axis: Vector = Field(
        default=(0.0, 0.0, 1.0),
        description="direction of the rotation axis, any length; the body stays as it is, so that a rigid one wobbles "
        "about an axis that is none of its principal ones",
    )
    obliquity: Annotated[Angle, Field(ge=0.0, le=math.pi)] | None = Field(
        default=None,
        description="turns the body and its axis together by so much about x, from z (the pole of the x-y plane, in "
        "which orbits without inclination lie) towards y: then x is the equinox",
    )
    wobble: Annotated[Angle, Field(ge=0.0, le=0.5 * math.pi)] | None = Field(
        default=None,
        description="angle between the angular momentum and the axis of the largest moment, towards that of the least: "
        "the body is turned so, and the angular momentum is along `axis` (model rigid)",
    )
    scale: Length | None = Field(default=None, description="length over which a law that is not rigid falls off")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        exactly_one(self, "rate", "period", "angular_momentum", "t_over_w", "breakup_fraction")
        law_with_scale(self)
        if self.breakup_fraction is not None and self.law != "rigid":
            raise ValueError(f"has a breakup_fraction, which is of the law rigid, not of {self.law}.")
        if not any(self.axis):
            raise ValueError("has an axis of zero length.")
        return self

    @property
    def tilt(self) -> np.ndarray:
        """The rotation (3, 3) by its obliquity."""
        sine, cosine = math.sin(self.obliquity or 0.0), math.cos(self.obliquity or 0.0)
        return np.array([[1.0, 0.0, 0.0], [0.0, cosine, sine], [0.0, -sine, cosine]])

    @property
    def direction(self) -> Triple:
        """The axis, turned by the obliquity, any length."""
        if self.obliquity is None:
            return self.axis
        x, y, z = (float(component) for component in self.tilt @ self.axis)
        return x, y, z


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

    mode: Annotated[Whole, Field(ge=2, le=16)] = Field(description="number of dense sides about the z axis")
    amplitude: Annotated[Real, Field(gt=0.0, lt=1.0)] = Field(description="of the density, over its mean")


class Body(Part):
    """What every body has, whatever its kind."""

    rank: ClassVar[int] = 100
    """Its place in lists of all kinds."""
    models: ClassVar[tuple[str, ...]] = ALL_MODELS
    """Models that take it."""
    structure: ClassVar[str] = "spheres.stretched"
    """The function, of a module of astroinertia.build, that makes the sphere, star or planet that it is at first."""
    placing: ClassVar[str] = "placing.of_sphere"
    """That which makes its particles."""
    moments_from: ClassVar[str] = "rigid.of_sphere"
    """That which makes its moments for the model rigid."""
    shape: ClassVar[str] = ""
    """The key that says its profile."""
    has_core: ClassVar[bool] = False
    """Whether its profile has a core of bounded density whose share of the mass is known."""
    isentropic: ClassVar[bool] = False
    """Whether matter of one entropy fills its profile where it has the exponent of that."""
    solid: ClassVar[bool] = False
    """Whether it keeps its shape, whatever acts on it."""
    composite: ClassVar[bool] = False
    """Whether matter of different kinds meets in it."""
    boxed: ClassVar[bool] = False
    """Whether it can fill a periodic box."""
    laid_out: ClassVar[bool] = True
    """Whether particles are laid out by its `placement`."""
    homologous: ClassVar[bool] = False
    """Whether it falls homologously, with a flow and a pressure of its own."""
    turns_with_axis: ClassVar[bool] = True
    """Whether an obliquity can turn it: particles that are the user's own are where they are."""
    rotates_itself: ClassVar[bool] = False
    """Whether it turns without a table `rotation`."""

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
    pressure_fraction: Annotated[Real, Field(gt=0.0, le=100.0)] | None = Field(
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
        return checked(dimensional(value, pressure_constant_dimension(gamma), code), "not negative", value)

    @model_validator(mode="after")
    def _one_thermal_choice(self) -> Self:
        names = ("specific_internal_energy", "entropy", "pressure_fraction")
        keys = [name for name in names if getattr(self, name) is not None]
        if len(keys) > 1:
            raise ValueError(f"may have only one of {', '.join(names)}, but has {' and '.join(keys)}.")
        return self

    @model_validator(mode="after")
    def _can_break_up(self) -> Self:
        spin, index = self.rotation, self.polytropic_index
        if spin is not None and spin.breakup_fraction is not None and not (index and index < 3.0):
            raise ValueError(
                "has rotation.breakup_fraction, which is of polytropes of an index between 0 and 3 (others: a body of "
                "the kind rotating_star, or rotation.rate)."
            )
        return self

    @property
    def title(self) -> str:
        """What its kind is called."""
        me: Any = self
        return me.kind

    @property
    def unit_length(self) -> float:
        """The unit of length of a run that is given none."""
        me: Any = self
        return me.radius

    @property
    def homogeneous(self) -> bool:
        """Whether its density is uniform."""
        return False

    @property
    def polytropic_index(self) -> float | None:
        """The index of the polytrope that it is before axes stretch it; None for others."""
        return None

    @property
    def settles(self) -> bool:
        """Whether there is an equilibrium that particles can be settled to."""
        return False

    @property
    def spin(self) -> Any:
        """What says how it turns: its rotation, or the body itself."""
        return self.rotation

    @property
    def rows_at_start(self) -> np.ndarray:
        """Directions of its own axes, unit vectors, one a row (3, 3), turned by an obliquity."""
        rows = unit_rows(getattr(self, "axes_at_start", np.eye(3)))
        return rows if self.rotation is None or self.rotation.obliquity is None else rows @ self.rotation.tilt.T

    @property
    def volume_ratio(self) -> float:
        """Its volume over that of a sphere of its radius, about."""
        return math.prod(getattr(self, "axes", (1.0,)))

    @property
    def without_heat(self) -> str:
        """What it is, in messages, where it has neither a structure nor energies of its own."""
        return f"of the kind {self.title}"

    def profile(self) -> Any:
        """The profile of the sphere that it is before axes stretch it (sph.profiles.Profile); None: unknown here."""
        return None

    @property
    def quickly_known(self) -> bool:
        """Whether a plan can tell at once how it turns in equilibrium."""
        return False

    def equilibrium(self, gravitational_constant: float) -> Any:
        """The rotating star in equilibrium that it is (bodies.rotating_star); None for others."""
        return None

    def central(self, mass: float, radius: float) -> tuple[float, float] | None:
        """Pressure and density at the centre where they have a closed form (G = 1)."""
        return None

    def expansion(self, mass: float, radius: float, gravitational_constant: float = 1.0) -> float:
        """The rate of a flow away from its centre that it has by itself, v/r."""
        return 0.0

    @property
    def support(self) -> float:
        """Its pressure over that of equilibrium, before any pressure_fraction."""
        return 1.0

    def check(self, scene: Any) -> None:
        """ValueError, in a sentence, where its scene does not go with it."""
        if self._wobble is not None and scene.model != "rigid":
            raise ValueError(
                f"[body.rotation] wobble is for the model rigid, not for {scene.model}: only a rigid body turns about "
                "another axis than a principal one and keeps its shape."
            )
        if self.rotation is not None and self.rotation.obliquity is not None and not self.turns_with_axis:
            raise ValueError(
                f"[body.rotation] obliquity would turn the body, and one of the kind {self.title} stays where its "
                "particles are: turn these, and give rotation.axis."
            )
        if scene.model not in self.models:
            raise ValueError(
                f"[body] of the kind {self.title} is for the model{'s' * (len(self.models) > 1)} "
                f"{' and '.join(self.models)}, not for {scene.model}."
            )
        me: Any = self
        if scene.model == "sph" and "particles" in type(self).model_fields and me.particles is None:
            raise ValueError("[body] particles is missing (number of particles), which the model sph needs.")

    def characteristic(self) -> dict[str, Any]:
        """Numbers of effects.characteristic that it states itself, without a profile."""
        return {}

    def turning(self, tensor: np.ndarray, gravitational: float | None) -> dict[str, Any]:
        """How it turns with that inertia tensor and |W|: the rate, the axis and how far that is from the axis of the
        largest moment.
        """
        axis = unit((0.0, 0.0, 1.0) if self.rotation is None else self.rotation.direction)
        along = np.array(axis)
        values, vectors = np.linalg.eigh(tensor)
        if self._wobble is not None:
            # In the axes that the body has before it is turned to its angular momentum.
            along = vectors @ wobbling(values, self._wobble)[1]
        moment = float(along @ tensor @ along)
        spin = 0.0 if self.rotation is None else spin_of(self.rotation, moment, gravitational)
        if self.rotation is not None and self.rotation.breakup_fraction is not None:
            spin = self._spin_of_fraction(self.rotation.breakup_fraction, gravitational)
        largest = vectors[:, values > values[2] * (1.0 - EQUAL_MOMENTS)]
        wobble = math.sqrt(max(0.0, 1.0 - float(np.sum((along @ largest) ** 2))))
        turning = {"spin": spin, "spin_axis": axis, "wobble": wobble if spin and wobble > 1e-8 else 0.0}
        momentum = tensor @ along
        if spin and moment > 0.0:
            turning["momentum_axis"] = unit(self._sense * (momentum if self._wobble is None else np.array(axis)))
            share = float(np.linalg.norm(momentum @ largest) / np.linalg.norm(momentum))
            across = np.linalg.norm(momentum - largest @ (largest.T @ momentum)) / np.linalg.norm(momentum)
            turning["momentum_wobble"] = math.atan2(float(across), share)
        return turning if spin is None else {**turning, "rotational": 0.5 * moment * spin**2}

    @property
    def _wobble(self) -> float | None:
        return None if self.rotation is None else self.rotation.wobble

    @property
    def _sense(self) -> float:
        """-1 where it turns the other way about its axis."""
        spin = self.rotation
        backwards = spin is not None and min(spin.rate or 0.0, spin.angular_momentum or 0.0) < 0.0
        return -1.0 if backwards else 1.0

    def _spin_of_fraction(self, fraction: float, gravitational: float | None) -> float:
        from astroinertia.bodies.break_up import polytropic_rate

        me: Any = self
        assert me.polytropic_index is not None and gravitational is not None  # _can_break_up has seen to it
        # |W| = 3/(5 - n) G M^2/R of a polytrope says G
        orbit = gravitational * (5.0 - me.polytropic_index) / (3.0 * me.mass * me.radius**2)
        return polytropic_rate(me.polytropic_index, fraction) * math.sqrt(orbit)

    def placed(self, scene: Any, asked: float) -> float:
        """How many particles there are where so many are asked for."""
        return asked

    def describe(self, scene: Any) -> list[PlanLine]:
        """What it is, as lines of the plan."""
        me: Any = self
        shape = f" of {self.shape} {getattr(self, self.shape):g}" if self.shape else ""
        axes = getattr(self, "axes", (1.0, 1.0, 1.0))
        density = me.mass / (4.0 / 3.0 * math.pi * me.radius**3 * math.prod(axes))
        fall = math.sqrt(3.0 * math.pi / (32.0 * scene.gravitational_constant * density))
        equatorial = self.spin is self
        stretched = "" if axes == (1.0, 1.0, 1.0) else f"axes {numbers(axes)}"
        lines: list[PlanLine] = [("kind", self.title.replace("_", " ") + shape, stretched)]
        if scene.model == "sph":
            lines.append(("particles", f"{me.particles}", f"of {scene.shown(me.mass / me.particles, 'mass')} each"))
        lines += [
            ("mass", scene.shown(me.mass, "mass")),
            ("equatorial radius" if equatorial else "radius", scene.shown(me.radius, "length")),
            ("mean density", scene.shown(density, "density"), "in the equatorial sphere" * equatorial),
            ("free-fall time", scene.shown(fall, "time"), "of the mean density"),
        ]
        if scene.model == "sph":
            settles = self.relax and scene.has_equilibrium
            to = "its collapse" if self.homologous else "equilibrium"
            why = f"settled to {to} first" if settles else "not settled first"
            lines.append(("placement", self.placement, f"seed {self.seed}, {why}"))
        return lines
