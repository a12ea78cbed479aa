"""Observables that are not of this package: given from Python, or offered by installed packages.

A package offers one by an entry point of the group `astroinertia.observables`, named as its kind:

    [project.entry-points."astroinertia.observables"]
    quadrupole_phase = "quadrupole_phase:QuadrupolePhase"

Tests: tests/unit/test_observables_door.py.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.effects.doors import Door, made_of
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
from astroinertia.units import ALL_MODELS, DIMENSIONS, Dimension, shown, si_unit

SIZES = {name: len(LABELS[name][0]) for name in ("i", "j", "principal", "mode")}
PARTICLES = ("sph",)  # models of an observable that is given the particles
_COORDINATES = (*LABELS, "time", "effect", "radius_bin", "frequency", "sink", "companion", "region")
OBSERVABLES = Door(
    "astroinertia.observables", "observable", "astroinertia.observables.Observable", "@dataclass(frozen=True)",
    (*RECORDED, *DERIVED, *OF_EFFECTS, *OF_ATTITUDE, *_COORDINATES), traced=False,
)  # fmt: skip


def entry_of(made: Any, package: str = "") -> Entry:
    """What a class says of itself as an observable; SceneError, in a sentence, where it is none.

    package: name and version of the package that offers it; empty for a class that is given from Python.
    """
    text = OBSERVABLES.check(made, Observable, package)

    def refused(what: str) -> SceneError:
        return OBSERVABLES.refused(made, package, what)

    if made.kind.startswith("region_"):
        raise refused("a kind that begins with region_ is of regions")
    if not isinstance(getattr(made, "long_name", None), str) or not made.long_name.strip():
        raise refused("its `long_name` must say what it is")
    dims = made.dims
    named = isinstance(dims, tuple) and all(dim in ("effect", *SIZES) for dim in dims)
    if not named or len(set(dims)) < len(dims) or "effect" in dims[1:]:
        raise refused(f"its `dims` must be a tuple of some of effect, {', '.join(SIZES)}, each once and effect first")
    if not made.models or not set(made.models) <= set(ALL_MODELS):
        raise refused(f"its `models` must be some of {', '.join(ALL_MODELS)}")
    try:
        dimension_of(made)
    except (KeyError, TypeError):
        raise refused("its `dimension` must be a name or Dimension(mass, length, time)") from None
    return Entry(text, made.options, "body", made.source, tuple(made.models), made=made, package=package)


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


def apart(things: Iterable[Any]) -> tuple[dict[str, Entry], list[Any]]:
    """Of what is given from Python, the entries of observables by kind, and all that is none.

    SceneError where an observable is not as it must be, or where two are of one kind.
    """
    observables: dict[str, Entry] = {}
    others = []
    for thing in things:
        made = made_of(thing)
        if not issubclass(made, Observable):
            others.append(thing)
        elif (entry := entry_of(made)) and made.kind in observables:
            raise SceneError(f"two observables of the kind '{made.kind}' are given; give one.")
        else:
            observables[made.kind] = entry
    return observables, others


def with_observables(things: Sequence[Any], observables: Sequence[Any]) -> tuple[Any, ...]:
    """What is given from Python with observables, or their classes, beside it; SceneError where one is none."""
    for observable in observables:
        entry_of(made_of(observable))
    return (*things, *observables)


def entries_of(kinds: Iterable[str], classes: Mapping[str, Entry]) -> dict[str, Entry]:
    """Of the kinds that a scene lists, those that are known: given from Python, or installed."""
    entries = {kind: classes[kind] if kind in classes else OBSERVABLES.installed(kind, entry_of) for kind in kinds}
    return {kind: entry for kind, entry in entries.items() if entry is not None}


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
        why = f"{type(error).__name__}: {shown(str(error), 200)}"
        raise SceneError(f"{name} failed at step {body.step} ({why}).") from error
    if value.dtype.kind not in "fiub":
        raise SceneError(f"{name} gave no real numbers at step {body.step}, but {value.dtype.name}.")
    if value.shape != shape:
        dims = f"of its dims ({', '.join(observable.dims)}), {shape}" if shape else "a number, ()"
        raise SceneError(f"{name} gave an array of the shape {value.shape} at step {body.step}; it must be {dims}.")
    return value.astype(float)
