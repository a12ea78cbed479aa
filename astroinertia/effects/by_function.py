"""An effect that is a plain function of the user's own: of a state in SI, to accelerations or to a torque in SI.

The function is called on NumPy arrays, whatever the engine: from compiled programs by a callback to the host. What it
does wrong there is kept until the run looks (effects.failures.failures_said), for JAX would print it with a traceback.
"""

import copyreg
import functools
import inspect
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, fields
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.effects.effect import Effect
from astroinertia.effects.failures import FAILURES
from astroinertia.effects.particle_names import OF_PARTICLES
from astroinertia.engines.elementwise import by_numpy
from astroinertia.engines.pytree import pytree
from astroinertia.errors import AbsentError, AstroinertiaError, NumericalError, SceneError
from astroinertia.units import DIMENSIONLESS, CodeUnits, failure, shown, si_unit, with_unit

Array = Any
_DIMENSIONS = {  # of what a state has that is not named as its dimension is
    "masses": "mass", "positions": "length", "velocities": "velocity", "densities": "density",
    "smoothing_lengths": "length", "internal_energies": "specific_energy", "pressures": "pressure",
    "sound_speeds": "velocity", "centre_of_mass": "length", "centre_of_mass_velocity": "velocity",
    "attitude": "dimensionless", "inertia_tensor": "moment_of_inertia", "principal_moments": "moment_of_inertia",
}  # fmt: skip


class _Named:
    """What says which names it has where another is asked for."""

    def __getattr__(self, name: str) -> Any:
        raise AbsentError(f"a state has no {name!r}, but {', '.join(_names(type(self)))}")


@dataclass(frozen=True)
class FluidState(_Named):
    """The particles that a function gives accelerations to, in no fixed order; in SI, or code units where the scene is.

    time (); masses (N,), positions and velocities (N, 3), densities, smoothing_lengths, internal_energies (of unit
    mass), pressures and sound_speeds (N,); centre_of_mass and centre_of_mass_velocity (3,) of the whole body. These
    are the names that a callback's state has. Velocities are those predicted for this time. With individual time steps
    these are the particles that are due now.
    """

    time: float
    masses: Array
    positions: Array
    velocities: Array
    densities: Array
    smoothing_lengths: Array
    internal_energies: Array
    pressures: Array
    sound_speeds: Array
    centre_of_mass: Array
    centre_of_mass_velocity: Array


@dataclass(frozen=True)
class RigidState(_Named):
    """The rigid body that a function gives a torque on, in inertial axes; in SI, or code units where the scene is.

    time (), mass (); attitude (3, 3), the scene's axes of the body as rows; angular_velocity (3,), angular_momentum
    (3,), inertia_tensor (3, 3) and principal_moments (3,), ascending, about the centre of mass, or about the pivot.
    """

    time: float
    mass: float
    attitude: Array
    angular_velocity: Array
    angular_momentum: Array
    inertia_tensor: Array
    principal_moments: Array


def acceleration(self, xp, fluid):
    """What the function returns, (N, 3); velocities are those predicted for the end of the step: second order."""
    arrays = [fluid.time, *(getattr(fluid, one) for one in OF_PARTICLES.values()), fluid.centre, fluid.centre_velocity]
    call = functools.partial(_on_host, self, FluidState, np.shape(fluid.position), "acceleration")
    return (
        call(*arrays)
        if by_numpy(xp)
        else _called_back(call, np.shape(fluid.position), map(_not_differentiated, arrays))
    )


def virial(self, xp, fluid):
    """sum m (x - c) (x) a, (3, 3), of what the function returns when it is called again."""
    weighted = fluid.mass[:, None] * (fluid.position - fluid.centre)
    return weighted.T @ self.acceleration(xp, fluid)


def torque(self, body):
    """What the function returns, (3,)."""
    arrays = [getattr(body, "inertia" if name == "inertia_tensor" else name) for name in _names(RigidState)]
    # A record differentiates along the motion what does not follow from torques (build.rigid refuses what would).
    return _called_back(functools.partial(_on_host, self, RigidState, (3,), "torque"), (3,), arrays)


def _called_back(call: Callable, shape: tuple[int, ...], arrays: Iterable[Array]) -> Array:
    """What a function of NumPy arrays in float64 gives to a compiled program.

    Its thread knows nothing of jax.enable_x64, and would make float32 of them: they go there and back as their bits.
    """

    def kept(*bits: Array) -> np.ndarray:
        numbers = [np.ascontiguousarray(array).view(np.float64)[..., 0] for array in bits]
        try:
            values = np.ascontiguousarray(call(*numbers))
        except AstroinertiaError as error:
            FAILURES.append(error)
            values = np.full(shape, np.nan)
        return values[..., None].view(np.uint32)

    bits = [jax.lax.bitcast_convert_type(jnp.asarray(array, np.float64), np.uint32) for array in arrays]
    result = jax.ShapeDtypeStruct((*shape, 2), np.uint32)
    returned = jax.pure_callback(kept, result, *bits, vmap_method="sequential")
    return jax.lax.bitcast_convert_type(returned, np.float64)


@jax.custom_jvp
def _not_differentiated(array: Array) -> Array:
    return array


@_not_differentiated.defjvp
def _refused(primals: Any, tangents: Any) -> Any:
    raise SceneError("a plain function has no derivative: write it as the class of an effect.")


def _on_host(effect: Any, state: type, shape: tuple[int, ...], returns: str, *arrays: Array) -> np.ndarray:
    """The function's answer to a state in code units, in code units; all arrays that it gets are its own."""
    units: CodeUnits = effect.units
    inside = dict(zip(_names(state), map(np.asarray, arrays), strict=True))
    seen = state(**{name: units.to_si(array, _DIMENSIONS.get(name, name)) for name, array in inside.items()})
    code = units == DIMENSIONLESS
    where = f"the function '{effect.kind}', at time {seen.time:.6g}{'' if code else ' s'},"
    try:
        with np.errstate(all="ignore"):
            values = effect.function(seen)
            if (quantity := with_unit(values)) is not None:
                values = quantity.to_value("" if code else si_unit(returns))
            values = np.asarray(values)
    except Exception as error:  # whatever a function of the user's own does
        why = failure(error)
        plain = f"; its state has plain numbers in {'code units' if code else 'SI'}" if "Unit" in why else ""
        raise SceneError(f"{where} failed ({why}){plain}.") from error
    if values.dtype.kind not in "fiu":
        raise SceneError(f"{where} gave no real numbers, but {values.dtype.name}.")
    if values.shape != shape:
        raise SceneError(f"{where} gave an array of the shape {values.shape}; {returns} must have {shape}.")
    if not np.isfinite(values).all():
        raise NumericalError(
            f"the function '{effect.kind}' gave {'an' if returns[0] == 'a' else 'a'} {returns} that is not finite",
            effect=effect.kind, time=float(inside["time"]),
        )  # fmt: skip
    return units.to_code(values.astype(float), returns)


def of_function(function: Callable) -> Effect:
    """The effect that a function of a state serves for, named after it.

    SceneError where its name says nothing, or where it cannot be called with a state alone.

    function: of a FluidState to accelerations (N, 3), or of a RigidState to a torque (3,): arrays in SI, in code units
    where the scene is, or astropy quantities.
    """
    try:
        inspect.signature(function).bind(None)
    except TypeError as error:
        name = getattr(function, "__name__", type(function).__name__)
        raise SceneError(f"the function {name} of effects must take one argument, the state: {error}.") from None
    except ValueError:  # of one that is compiled, which says nothing of itself
        pass
    try:
        return _kept_class(function)()
    except TypeError:  # one that cannot be hashed
        return _class_of(function)()


class _OfFunction(type):
    """The kind of class that is made of a function: in pickles, the function stands for it."""


def _again(function: Callable, acts: bool) -> Any:
    effect = of_function(function)
    return type(effect.in_units(DIMENSIONLESS) if acts else effect)


def _pickled(made: Any) -> Any:
    return _again, (made.function, bool(fields(made)))  # the one that acts has units


copyreg.pickle(_OfFunction, _pickled)


def _class_of(function: Callable) -> type[Effect]:
    named = getattr(function, "func", function)  # of a functools.partial
    name = str(getattr(named, "__name__", type(named).__name__))
    kind = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,63}", kind):
        raise SceneError(f"the function {shown(name)} is to be named by a letter and letters, digits and _ after it.")
    shared = {"kind": kind, "acceleration": acceleration, "virial": virial, "torque": torque}
    said = {
        "__doc__": getattr(named, "__doc__", None) or "a function of the user's own",
        "__module__": getattr(named, "__module__", None) or "",
        "__qualname__": str(getattr(named, "__qualname__", name)),
        "function": staticmethod(function),
        "in_units": lambda self, units: acting(units),
        "external": True,
        "models": ("sph", "rigid"),
        "source": "a function of the user's own",
    }
    made = _dataclass(_OfFunction(name, (Effect,), {**shared, **said}))
    # What acts knows the units, which are those of a scene.
    acting = _dataclass(
        _OfFunction(name, (made,), {"__annotations__": {"units": Any}, "units": field(metadata={"static": True})})
    )
    return made


def _dataclass(made: type) -> Any:
    return pytree(dataclass(frozen=True, eq=False)(made))


_kept_class = functools.lru_cache(maxsize=32)(_class_of)  # so that the programs of its runs are compiled once


def _names(state: type) -> tuple[str, ...]:
    return tuple(part.name for part in fields(state))
