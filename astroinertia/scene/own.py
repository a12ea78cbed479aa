"""What of a scene is not of this package: equations of state and initial bodies, and all four doors together.

Tests: tests/unit/test_matter_door.py, tests/unit/test_body_door.py.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from astroinertia.effects.doors import Door, made_of
from astroinertia.effects.entries import Entry
from astroinertia.effects.own import EFFECTS, with_functions
from astroinertia.errors import SceneError
from astroinertia.observables.own import OBSERVABLES
from astroinertia.scene.kinds import BODY_KINDS, FLUID_KINDS
from astroinertia.scene.own_body import KEYS

Given = Mapping[Door, Mapping[str, Entry]]  # what is given from Python, by door and kind


def _of_matter(made: Any) -> dict[str, Any]:
    """The models that matter is for; ValueError where its functions are not all there."""
    from astroinertia.matter.equation import Matter  # only here: most scenes have no matter from outside

    if made.curved:
        raise ValueError("its internal energy must be linear in A, without `curved`")
    if made.thermal and (made.entropy is Matter.entropy or made.entropy_rate is Matter.entropy_rate):
        raise ValueError("with `thermal` it must have `entropy` and `entropy_rate`")
    return {"cost": "particles", "models": ("sph", "scaling") if made.thermal else ("sph", "ellipsoid", "scaling")}


def _of_body(made: Any) -> dict[str, Any]:
    """That it is of particles; ValueError where it says too little to place them."""
    from astroinertia.sph.placed import Body  # only here: most scenes have no body from outside

    by_density = made.density is not Body.density and made.extent is not Body.extent
    if made.particles is Body.particles and not by_density:
        raise ValueError("it must have `density` and `extent`, or `particles`")
    if clash := sorted(set(KEYS) & set(made.options)):
        raise ValueError(f"its option {clash[0]} is a key that every [body] has")
    return {"cost": "particles"}


MATTER = Door(
    "matter", "equation of state", "astroinertia.matter.Matter", "equation_of_state", "matter=...",
    (*FLUID_KINDS, "own"), _of_matter, models=(), single=True,
)  # fmt: skip
BODIES = Door(
    "bodies", "initial body", "astroinertia.initial.Body", "body", "body=...", (*BODY_KINDS, "own"), _of_body,
    models=("sph", "rigid"), single=True, traced=False,
)  # fmt: skip
DOORS = (EFFECTS, MATTER, BODIES, OBSERVABLES)


def door_of(thing: Any) -> Door:
    """The door by which something, or a class, comes in; that of effects where it is none of what others take."""
    return next((door for door in DOORS if door.takes(made_of(thing))), EFFECTS)


def by_door(things: Iterable[Any]) -> Given:
    """What things, or classes, that are given from Python say of themselves.

    SceneError where one is not as it must be, or where two are given of which a scene has one.
    """
    given: dict[Door, dict[str, Entry]] = {door: {} for door in DOORS}
    for thing in things:
        door = door_of(thing)
        entry, others = door.entry_of(thing), given[door]
        if others if door.single else entry.made.kind in others:
            which = door.thing if door.single else f"{door.thing} '{entry.made.kind}'"
            raise SceneError(f"the {which} is given twice; give one.")
        others[entry.made.kind] = entry
    return given


def given_from_python(effects: Sequence[Any], matter: Any, observables: Sequence[Any], body: Any) -> tuple[Any, ...]:
    """All that these arguments give, with effects in place of functions; SceneError where one is no such thing."""
    matters, bodies_given = ([each] if each is not None else [] for each in (matter, body))
    for door, things in ((MATTER, matters), (OBSERVABLES, observables), (BODIES, bodies_given)):
        for thing in things:
            door.entry_of(thing)
    return (*with_functions(effects), *matters, *observables, *bodies_given)
