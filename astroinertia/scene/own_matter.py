"""Equations of state that are not of this package: given from Python, or offered by installed packages.

A package offers one by an entry point of the group `astroinertia.matter`, named as its kind, which is then a kind of
[equation_of_state]:

    [project.entry-points."astroinertia.matter"]
    logotrope = "logotrope:Logotrope"

Tests: tests/unit/test_matter_door.py.
"""

from collections.abc import Sequence
from typing import Any

from astroinertia.effects import own
from astroinertia.effects.doors import Door, made_of
from astroinertia.effects.entries import Entry
from astroinertia.errors import SceneError
from astroinertia.scene.equations_of_state import KINDS

MATTER = Door(
    "astroinertia.matter", "equation of state", "astroinertia.matter.Matter", "@dataclass(frozen=True)",
    (*KINDS, "own"),
)  # fmt: skip


def entry_of(made: Any, package: str = "") -> Entry:
    """What a class says of itself as an equation of state; SceneError, in a sentence, where it is none.

    package: name and version of the package that offers it; empty for a class that is given from Python.
    """
    from astroinertia.matter.equation import Matter  # with JAX, which other scenes do without here

    text = MATTER.check(made, Matter, package)
    if made.curved:
        raise MATTER.refused(made, package, "its internal energy must be linear in A, without `curved`")
    if made.thermal and (made.entropy is Matter.entropy or made.entropy_rate is Matter.entropy_rate):
        raise MATTER.refused(made, package, "with `thermal` it must have `entropy` and `entropy_rate`")
    models = ("sph", "scaling") if made.thermal else ("sph", "ellipsoid", "scaling")
    return Entry(text, made.options, "particles", made.source, models, made=made, package=package)


def installed(kind: str) -> Entry | None:
    """The equation of state of that kind that an installed package offers; None where there is none."""
    return MATTER.installed(kind, entry_of)


def entries_of(own_things: Sequence[Any]) -> tuple[dict[str, Entry], Entry | None]:
    """Of effects, and at most one equation of state, of the user's own: the entries of effects by kind, and the other.

    Each is an object or its class; SceneError where one is not as it must be, or where two are of one kind.
    """
    if not own_things:
        return {}, None
    from astroinertia.matter.equation import Matter

    fluids = [made for made in map(made_of, own_things) if isinstance(made, type) and issubclass(made, Matter)]
    if len(fluids) > 1:
        raise SceneError("two equations of state are given; a scene has one.")
    effects = own.classes([thing for thing in own_things if made_of(thing) not in fluids])
    return effects, entry_of(fluids[0]) if fluids else None


def with_matter(effects: Sequence[Any], matter: Any) -> tuple[Any, ...]:
    """Effects, or functions that serve for them, with an equation of state, or its class, beside them.

    SceneError where it is none, None where absent.
    """
    effects = own.with_functions(effects)
    if matter is None:
        return effects
    try:
        entry_of(made_of(matter))
    except SceneError as error:
        raise SceneError(f"matter: {error}") from None
    return (*effects, matter)
