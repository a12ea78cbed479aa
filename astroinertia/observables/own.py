"""Observables that are not of this package: what a class must say, and its values, checked as they are recorded.

Tests: tests/unit/test_observables_door.py.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.effects.doors import Door
from astroinertia.effects.entries import Entry
from astroinertia.errors import SceneError
from astroinertia.observables.observable import Observable
from astroinertia.observables.quantities import (
    DERIVED,
    LABELS,
    OF_ATTITUDE,
    OF_EFFECTS,
    RECORDED,
    SAID,
    BodyState,
    Quantity,
)
from astroinertia.units import DIMENSIONS, Dimension, failure, si_unit

SIZES = {name: len(LABELS[name][0]) for name in ("i", "j", "principal", "mode")}
PARTICLES = ("sph",)  # models of an observable that is given the particles
_COORDINATES = (*LABELS, "time", "effect", "radius_bin", "frequency", "sink", "companion", "region")


def _besides(made: Any) -> dict[str, Any]:
    """That it is of the whole body; ValueError where a dataset cannot have what its class says."""
    if made.kind.startswith("region_"):
        raise ValueError("a kind that begins with region_ is of regions")
    if not isinstance(getattr(made, "long_name", None), str) or not made.long_name.strip():
        raise ValueError("its `long_name` must say what it is")
    dims = made.dims
    named = isinstance(dims, tuple) and all(dim in ("effect", *SIZES) for dim in dims)
    if not named or len(set(dims)) < len(dims) or "effect" in dims[1:]:
        raise ValueError(
            f"its `dims` must be a tuple of some of effect, {', '.join(SIZES)}, each once and effect first"
        )
    try:
        dimension_of(made)
    except (KeyError, TypeError):
        raise ValueError("its `dimension` must be a name or Dimension(mass, length, time)") from None
    return {"cost": "body"}


OBSERVABLES = Door(
    "observables", "observable", "astroinertia.observables.Observable", "observables", "observables=[...]",
    (*RECORDED, *DERIVED, *OF_EFFECTS, *OF_ATTITUDE, *_COORDINATES), _besides, traced=False,
)  # fmt: skip


def dimension_of(made: type[Observable]) -> Dimension:
    """Exponents of mass, length and time of its value."""
    named = made.dimension
    return Dimension(*map(float, DIMENSIONS[named] if isinstance(named, str) else named))


def quantity_of(entry: Entry) -> Quantity:
    """The variable of the dataset that it is recorded as."""
    made: Any = entry.made
    dimension = dimension_of(made)
    plain = "rad" if made.dimension == "angle" else "1"
    comment = f"{entry.text}; {entry.source}" if entry.source else entry.text
    unit = si_unit(dimension) if any(dimension) else plain
    return Quantity(("time", *made.dims), dimension if any(dimension) else None, unit, made.long_name, comment)


def recorded(
    observables: Sequence[Observable], row: Mapping[str, Any], particles: Callable[[], Mapping[str, Any] | None]
) -> dict[str, np.ndarray]:
    """The values of observables for a row of the headline series, in float64 and code units.

    particles: what a snapshot has of particles, called where an observable is given them. SceneError, in a sentence,
    names an observable that fails or whose value is not what it says.
    """
    if not observables:
        return {}
    body = BodyState(**{name: _kept(row[name]) for name in SAID})
    snapshot = particles() if any(tuple(own.models) == PARTICLES for own in observables) else None
    if snapshot is not None:  # which has NaN for particles that sinks have accreted
        present = np.isfinite(snapshot["mass"])
        snapshot = {name: array[present] for name, array in snapshot.items() if name != "time"}
    fluid = replace(body, particles=snapshot)
    return {own.kind: _value(own, fluid if tuple(own.models) == PARTICLES else body) for own in observables}


def _kept(value: Any) -> Any:
    if not np.ndim(value):
        return value
    view = np.asarray(value).view()
    view.flags.writeable = False
    return view


def _value(observable: Observable, body: BodyState) -> np.ndarray:
    name = f"the observable '{observable.kind}'"
    sizes = {**SIZES, "effect": len(body.force)}
    shape = tuple(sizes[dim] for dim in observable.dims)
    try:
        with np.errstate(all="ignore"):  # NaN is a value
            value = np.asarray(observable.value(body))
    except Exception as error:  # whatever a class of the user's own does
        raise SceneError(f"{name} failed at step {body.step} ({failure(error)}).") from error
    if value.dtype.kind not in "fiub":
        raise SceneError(f"{name} gave no real numbers at step {body.step}, but {value.dtype.name}.")
    if value.shape != shape:
        dims = f"of its dims ({', '.join(observable.dims)}), {shape}" if shape else "a number, ()"
        raise SceneError(f"{name} gave an array of the shape {value.shape} at step {body.step}; it must be {dims}.")
    return value.astype(float)
