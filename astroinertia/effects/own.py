"""Effects that are not of this package, and functions that serve for them.

The class says of itself what the catalogue says of built-in effects (effects.effect.Effect). Tests:
tests/unit/test_effects_door.py.
"""

from collections.abc import Sequence
from difflib import get_close_matches
from types import FunctionType
from typing import Any

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.effects.doors import Door
from astroinertia.effects.effect import PARTS, Effect
from astroinertia.effects.entries import Cost
from astroinertia.effects.measure import Measure
from astroinertia.effects.parts import AffineParts, ParticleParts, RigidParts

TAKEN = ("common", "motion", "rigidity")  # names of what belongs to no effect, in audits, ledgers and figures

_MEANT = {"heating": "exchange"}  # a part by the name of what it does, which is that of an output of pair terms

_PARTS_OF = {
    model: [name for name, part in vars(parts).items() if isinstance(part, FunctionType | property)]
    for model, parts in (("sph", ParticleParts), ("ellipsoid", AffineParts), ("rigid", RigidParts))
}


def _besides(made: Any) -> dict[str, Any]:
    """What the parts of a class say of it; ValueError where a model that it names has none."""
    if not isinstance(made.size, Measure | None):
        raise ValueError("its `size` must be a Measure")
    having = [model for model, parts in _PARTS_OF.items() if _has(made, *parts)]
    if not having and not _has(made, "further_pressure"):
        near = _misspelt(made, 0.75)
        raise ValueError(f"it has none of the parts of an effect, such as acceleration or torque{near}")
    if near := _misspelt(made, 0.85):  # functions for the class itself may have any other name
        raise ValueError(f"nothing would call one of its functions{near}")
    if having and (without := [model for model in made.models if model in _PARTS_OF and model not in having]):
        what = f"it has parts for {' and '.join(having)} and none for {without[0]}, which its `models` name"
        raise ValueError(f"{what}; say `models: ClassVar = {tuple(having)}`".replace("'", '"'))
    return {
        "cost": _loop(made), "numerical": made.numerical, "size": made.size,
        "gradients": (lambda options: True) if _has(made, "gradient_terms") else None,
        "presses": _has(made, "further_pressure"),
    }  # fmt: skip


def _misspelt(made: Any, alike: float) -> str:
    """The first method of a class whose name is all but that of a part, in words; empty where there is none."""
    methods = (name for name, part in vars(made).items() if isinstance(part, FunctionType | property))
    for name in methods:
        near = [_MEANT[name]] if name in _MEANT else get_close_matches(name, PARTS, n=1, cutoff=alike)
        if near and not hasattr(Effect, name):
            return f" ({name} is not among them; did you mean '{near[0]}'?)"
    return ""


def _loop(made: Any) -> Cost:
    """The loop that it needs, by the parts that it has."""
    if _has(made, "all_pair_terms"):
        return "all pairs"
    near = _has(made, "neighbour_terms", "gradient_terms")
    return "neighbours" if near else "body" if made.whole_body else "particles"


def _has(made: Any, *names: str) -> bool:
    return any(getattr(made, name) is not getattr(Effect, name) for name in names)


EFFECTS = Door(
    "effects", "effect", "astroinertia.effects.Effect", "effects", "effects=[...]", (*CATALOGUE, *TAKEN), _besides,
    decorated="@dataclass(frozen=True, eq=False)",
)  # fmt: skip


def with_functions(effects: Sequence[Any]) -> tuple[Any, ...]:
    """Effects, with those that functions serve for in the place of the functions."""
    return tuple(_of_function(effect) if _is_function(effect) else effect for effect in effects)


def _is_function(effect: Any) -> bool:
    return callable(effect) and not isinstance(effect, type) and not hasattr(effect, "kind")


def _of_function(function: Any) -> Any:
    from astroinertia.effects.by_function import of_function  # with JAX

    return of_function(function)
