"""What an effect is: the parts of the equations of motion that a scene can call for, one at a time."""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import FunctionType
from typing import Any, ClassVar, Self

import numpy as np

from astroinertia.effects.measure import Measure
from astroinertia.effects.parts import AffineParts, ParticleParts, RigidParts
from astroinertia.errors import AstroinertiaError, NumericalError, SceneError
from astroinertia.inertia.tensor import namespace
from astroinertia.process.known import is_known
from astroinertia.rotation.attitude import cross_matrix
from astroinertia.units import CodeUnits, Option, failure, shown

PARTS = (
    "breaks",
    "during",
    *(
        name
        for parts in (ParticleParts, AffineParts, RigidParts)
        for name, part in vars(parts).items()
        if isinstance(part, FunctionType)
    ),
)
_SHAPES = {
    "torque": (3,), "relative_rotation": (3,), "impulse": (3,), "potential": (), "frequency": (),
    "rigid_virial": (3, 3), "affine_force": (3, 3), "affine_push": (3,), "affine_virial": (3, 3),
    "affine_potential": (), "affine_heating": (), "drag": (3, 3), "virial": (3, 3), "potential_energy": (),
}  # fmt: skip
_MOMENT = 8.0  # spacings of a time, which is no time, and in which middles differ from ends
_OF_PARTICLES = ("acceleration", "timestep", "exchange")
_OF_EACH = ("timestep", "exchange")  # a number for each particle, or one for all; two of them for what is exchanged


def scoped(kind: str, name: str, part: Callable) -> Callable:
    """A part of an effect whose operations carry its name in compiled programs, so that its absence can be shown."""
    part = part if part.__module__.startswith("astroinertia.") else _checked(kind, name, part)

    @functools.wraps(part)
    def named(*arguments: Any) -> Any:
        if (jax := sys.modules.get("jax")) is None:  # then nothing is traced
            return part(*arguments)
        with jax.named_scope(f"effect:{kind}"):
            return part(*arguments)

    return named


def _checked(kind: str, name: str, part: Callable) -> Callable:
    """A part of a user's own effect, of which SceneError says what it fails with."""

    given = f"gave {'an' if name[0] in 'aeiou' else 'a'} {name}"

    @functools.wraps(part)
    def checked(*arguments: Any) -> Any:
        try:
            with _kept(arguments):
                value = part(*arguments)
        except AstroinertiaError:
            raise
        except Exception as error:  # whatever a class of the user's own does
            raise SceneError(f"the part {name} of the effect '{kind}' failed ({failure(error)}).") from error
        if value is None:
            return value
        if name == "breaks":
            return _between(kind, value, *arguments[-2:])
        if isinstance(value, dict):
            return {key: _writeable(array) for key, array in value.items()}
        needed = _SHAPES.get(name)
        if needed is None and name not in _OF_PARTICLES:
            return value
        numbers = _real_numbers(value, name, f"the effect '{kind}' {given}")
        acted_on = arguments[-1]
        needed = np.shape(acted_on.position) if name == "acceleration" else needed
        allowed = [needed] if name not in _OF_EACH else [np.shape(acted_on.mass), ()]
        for each in numbers:
            if (shape := np.shape(each)) not in allowed:
                raise SceneError(f"the effect '{kind}' {given} of the shape {shape}, not {allowed[0]}.")
        # Plans ask for time steps outside a run.
        in_a_run = name in _OF_PARTICLES and hasattr(acted_on, "time") and is_known(acted_on.time)
        if in_a_run and not _finite(name, numbers) and _is_well(acted_on):
            raise NumericalError(
                f"the effect '{kind}' {given} that is not finite", effect=kind, time=float(acted_on.time)
            )
        return tuple(numbers) if name == "exchange" else numbers[0]

    return checked


def _real_numbers(value: Any, name: str, whose: str) -> list[Any]:
    """What a part of that name gave, two of what is exchanged; SceneError where it is not of real numbers."""
    if name == "exchange" and not (isinstance(value, tuple) and len(value) == 2):
        raise SceneError(f"{whose} that is not a tuple of two, gain and decay.")
    try:
        return [_real(each) for each in (value if name == "exchange" else (value,))]
    except (TypeError, ValueError) as error:
        raise SceneError(f"{whose} of {error}, not of real numbers.") from None


@contextmanager
def _kept(arguments: Sequence[Any]) -> Iterator[None]:
    """While a part of the user's own works, arrays of the fluid cannot be written to: they are those of the run."""
    arrays, within = [], [vars(given) for given in arguments if hasattr(given, "position")]
    while within:
        for value in within.pop().values():
            if isinstance(value, dict):
                within.append(value)
            elif isinstance(value, np.ndarray) and value.flags.writeable:
                arrays.append(value)
    for array in arrays:
        array.flags.writeable = False
    try:
        yield
    finally:
        for array in arrays:
            array.flags.writeable = True


def _writeable(array: Any) -> Any:
    """An array as engines take it, which compile for what can be written to: a copy of one that cannot."""
    return array.copy() if isinstance(array, np.ndarray) and not array.flags.writeable else array


def _between(kind: str, times: Any, start: float, end: float) -> tuple[float, ...]:
    """Of the times that an effect of the user's own gives as its breaks, those that are to come."""
    try:
        found = [float(time) for time in times]
    except (TypeError, ValueError):
        found = [math.nan]
    if any(map(math.isnan, found)):
        raise SceneError(f"the effect '{kind}' gave breaks that are no list of times: {shown(repr(times), 60)}.")
    return tuple(time for time in found if start < time <= end)


def _real(value: Any) -> Any:
    """A number, or an array of floating-point numbers, from these or lists of them.

    TypeError, which names the type, for what is not real; ValueError for lists of different lengths.
    """
    if hasattr(value, "unit"):
        raise TypeError(f"quantities in {value.unit}")
    if isinstance(value, list | tuple):
        rows = [_real(row) for row in value]
        xp = namespace(*rows)
        if len({np.shape(row) for row in rows}) != 1:
            raise ValueError("lists of different lengths")
        value = xp.stack([xp.asarray(row) for row in rows])
    dtype = np.dtype(getattr(value, "dtype", type(value)))
    if dtype.kind not in "fiu":
        raise TypeError(dtype.name)
    return value.astype(float) if dtype.kind in "iu" and hasattr(value, "astype") else _writeable(value)


def _finite(name: str, numbers: list[Any]) -> bool:
    """Whether they can be gone on with; a time step may be infinite."""
    if name == "timestep":
        return not np.isnan(numbers[0]).any()
    return all(np.isfinite(each).all() for each in numbers)


def _is_well(fluid: Any) -> bool:
    """Whether what an effect was given is finite, so that what is not is its own."""
    return all(np.isfinite(array).all() for array in (fluid.position, fluid.velocity, fluid.internal_energy))


@dataclass(frozen=True, eq=False)
class Effect(ParticleParts, AffineParts, RigidParts):
    """One force or energy exchange, with an acceleration of its own, so that its virial tensor can be taken (G = 1).

    A subclass is a frozen dataclass registered as a pytree; numbers are leaves, choices are static, and an option that
    is None is absent from what is compiled. It overrides the parts that it has, for one model or several, and leaves
    the rest.

    An effect that is not of this package (effects.own) says of itself what the catalogue says of the others: `options`,
    `source`, `models`, `numerical` and `size`; the first paragraph of its docstring says in plans what it is.
    """

    kind: ClassVar[str]
    options: ClassVar[Mapping[str, Option]] = {}
    """Each field: its dimension, default, limits and meaning."""
    source: ClassVar[str] = "no source is stated"
    """Where its equations come from."""
    models: ClassVar[tuple[str, ...]] = ("sph",)
    """Those that it has parts for."""
    numerical: ClassVar[bool] = False
    """A device of particles and no physics: other models do without."""
    size: ClassVar[Measure | None] = None
    """How large it is in a scene, and what leaving it out would change; None where it does not say."""
    external: ClassVar[bool] = False
    """Exchanges momentum or energy with the outside of the fluid."""
    turns_frame: ClassVar[bool] = False
    """Makes the frame of the scene a rotating one, which velocities are relative to."""
    not_finite: ClassVar[str] = ""
    """What has happened where its acceleration is no longer finite, if something particular has."""

    def __init_subclass__(cls) -> None:
        for name in PARTS:
            if name in vars(cls):
                setattr(cls, name, scoped(cls.kind, name, vars(cls)[name]))
        if vars(cls).keys() & {"torque", "relative_rotation"}:
            cls.follows_spin = vars(cls).get("follows_spin", True)

    @classmethod
    def from_options(cls, options: dict[str, Any]) -> Self:
        """The effect from its options in code units; raises ValueError, in one sentence, where they contradict."""
        return cls(**options)

    def breaks(self, start: float, end: float) -> tuple[float, ...]:
        """Times after the start, up to the end, at which it begins or ends, or an impulse comes; steps end there."""
        return ()

    def during(self, start: float, end: float) -> Self:
        """The effect as it is from a time to another, without breaks in between, the ends included: with other numbers.

        Asked for whatever is evolved and recorded, so that it may say alone whether the effect acts.
        """
        return self

    def in_units(self, units: CodeUnits) -> Self:
        """The effect in a scene with those code units: itself, where its numbers are all that has a unit."""
        return self

    @property
    def electron_fractions(self) -> tuple[float, float] | None:
        """Between which it takes electrons from matter; None where it takes none."""
        return None

    def on_axis(self, axis: Any, units: CodeUnits) -> Self:
        """The effect in matter whose table goes on along electron fractions: axis is a matter.electron_axis, in SI."""
        return self

    def further_pressure(self, xp: Any, density: Any) -> Any:
        """What it adds to the equation of state's pressure at those densities, (K,), as matter first comes there."""
        return 0.0 * density

    @property
    def inertial(self) -> str:
        """Why it is right in inertial axes alone, in words; empty where it is right in a rotating frame, too."""
        return ""

    @property
    def potential_moves(self) -> bool:
        """Whether the potential changes by itself with time, so that it exchanges energy with what is outside."""
        return False


def moments(fluid: Any) -> tuple[Any, Any]:
    """Second moment Q = sum m x (x) x and mixed moment P = sum m x (x) v about the centre of mass, each (3, 3)."""
    position = fluid.position - fluid.centre
    weighted = (fluid.mass[:, None] * position).T
    return weighted @ position, weighted @ (fluid.velocity - fluid.centre_velocity)


def affine_moments(body: Any) -> tuple[Any, Any]:
    """The same of an affine body: q F F^T and q F (dF/dt)^T."""
    spread = body.second_moment * body.deformation
    return spread @ body.deformation.T, spread @ body.rate.T


def angular_velocity_matrix(rate: Any, axis: Any) -> Any:
    """The matrix [w] with [w] x = w cross x for w = rate * axis/|axis|, shape (3, 3)."""
    x, y, z = axis
    size = rate / (x * x + y * y + z * z) ** 0.5
    return cross_matrix(namespace(size).asarray([x * size, y * size, z * size]))


def rate_at(effect: Any, time: Any) -> Any:
    """The rate of rotation of an effect at a time: its rate + time rate_change, where it has that."""
    return effect.rate if effect.rate_change is None else effect.rate + effect.rate_change * time


def acting(problem: Any, start: float, end: float | None = None) -> Any:
    """The problem with effects as they are from a time to another, with no break in between, or right after a time."""
    end = start + _MOMENT * float(np.spacing(start)) if end is None else end
    effects = tuple(effect.during(start, end) for effect in problem.effects)
    same = all(one is other for one, other in zip(effects, problem.effects, strict=True))
    return problem if same else replace(problem, effects=effects)
