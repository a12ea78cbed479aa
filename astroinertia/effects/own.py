"""Effects that are not of this package: classes that are given from Python, or that installed packages offer.

A package offers an effect by an entry point of the group `astroinertia.effects`, named as the effect's kind:

    [project.entry-points."astroinertia.effects"]
    cubic_drag = "cubic_drag:CubicDrag"

A scene names a kind and never code (effects.doors). The class says of itself what the catalogue says of built-in
effects (effects.effect.Effect). Tests: tests/unit/test_effects_door.py.
"""

from collections.abc import Iterable, Mapping, Sequence
from types import FunctionType
from typing import Any

from astroinertia.effects.affine_parts import AffineParts
from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.effects.doors import Door, made_of
from astroinertia.effects.effect import Effect
from astroinertia.effects.entries import Cost, Entry
from astroinertia.effects.particle_parts import ParticleParts
from astroinertia.effects.rigid_parts import RigidParts
from astroinertia.errors import SceneError
from astroinertia.units import ALL_MODELS

TAKEN = ("common", "motion", "rigidity")  # names of what belongs to no effect, in audits, ledgers and figures
EFFECTS = Door(
    "astroinertia.effects", "effect", "astroinertia.effects.Effect", "@dataclass(frozen=True, eq=False)",
    (*CATALOGUE, *TAKEN),
)  # fmt: skip

_PARTS_OF = {
    model: [name for name, part in vars(parts).items() if isinstance(part, FunctionType | property)]
    for model, parts in (("sph", ParticleParts), ("ellipsoid", AffineParts), ("rigid", RigidParts))
}


def entry_of(made: Any, package: str = "") -> Entry:
    """What a class says of itself as an effect; SceneError, in a sentence, where it is none.

    package: name and version of the package that offers it; empty for a class that is given from Python.
    """
    text = EFFECTS.check(made, Effect, package)
    if not made.models or not set(made.models) <= set(ALL_MODELS):
        raise EFFECTS.refused(made, package, f"its `models` must be some of {', '.join(ALL_MODELS)}")
    having = [model for model, parts in _PARTS_OF.items() if _has(made, *parts)]
    if having and (without := [model for model in made.models if model in _PARTS_OF and model not in having]):
        what = f"it has parts for {' and '.join(having)} and none for {without[0]}, which its `models` name"
        raise EFFECTS.refused(made, package, f"{what}; say `models: ClassVar = {tuple(having)}`".replace("'", '"'))
    return Entry(
        text, made.options, _loop(made), made.source, tuple(made.models), made.numerical, size=made.size,
        gradients=(lambda options: True) if _has(made, "gradient_terms") else None,
        presses=_has(made, "further_pressure"), made=made, package=package,
    )  # fmt: skip


def _loop(made: Any) -> Cost:
    """The loop that it needs, by the parts that it has."""
    if _has(made, "all_pair_terms"):
        return "all pairs"
    near = _has(made, "neighbour_terms", "gradient_terms")
    return "neighbours" if near else "body" if made.whole_body else "particles"


def _has(made: Any, *names: str) -> bool:
    return any(getattr(made, name) is not getattr(Effect, name) for name in names)


def with_functions(effects: Sequence[Any]) -> tuple[Any, ...]:
    """Effects, with those that functions serve for in the place of the functions."""
    return tuple(_of_function(effect) if _is_function(effect) else effect for effect in effects)


def _is_function(effect: Any) -> bool:
    return callable(effect) and not isinstance(effect, type) and not hasattr(effect, "kind")


def _of_function(function: Any) -> Any:
    from astroinertia.effects.by_function import of_function  # with JAX

    return of_function(function)


def classes(effects: Sequence[Any]) -> dict[str, Entry]:
    """Of effects that are given from Python, or their classes, what they say of themselves, by kind."""
    entries: dict[str, Entry] = {}
    for effect in effects:
        made = made_of(effect)
        entry = entry_of(made)
        if made.kind in entries:
            raise SceneError(f"two effects of the kind '{made.kind}' are given; give one.")
        entries[made.kind] = entry
    return entries


def own_entries(kinds: Iterable[str], own: Mapping[str, Entry]) -> dict[str, Entry]:
    """Of the kinds that a scene lists, those that are not built in and known: given from Python, or installed."""
    entries = {kind: own[kind] if kind in own else EFFECTS.installed(kind, entry_of) for kind in kinds}
    return {kind: entry for kind, entry in entries.items() if entry is not None}
