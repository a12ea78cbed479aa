"""Initial bodies that are not of this package: given from Python, or offered by installed packages.

A package offers one by an entry point of the group `astroinertia.bodies`, named as its kind, which is then a kind of
[body]:

    [project.entry-points."astroinertia.bodies"]
    torus = "torus:Torus"

Tests: tests/unit/test_body_door.py.
"""

from collections.abc import Sequence
from typing import Any

from astroinertia.effects.doors import Door, made_of
from astroinertia.effects.entries import Entry
from astroinertia.errors import SceneError
from astroinertia.scene import own_matter
from astroinertia.scene.bodies import KINDS
from astroinertia.scene.own_body import OwnBody

BODIES = Door(
    "astroinertia.bodies", "initial body", "astroinertia.initial.Body", "@dataclass(frozen=True)", (*KINDS, "own"),
    traced=False,
)  # fmt: skip
MODELS = ("sph", "rigid")
KEYS = tuple(name for name in OwnBody.model_fields if name not in ("name", "options", "entry"))  # of any kind


def entry_of(made: Any, package: str = "") -> Entry:
    """What a class says of itself as an initial body; SceneError, in a sentence, where it is none.

    package: name and version of the package that offers it; empty for a class that is given from Python.
    """
    from astroinertia.sph.placed import Body  # only where one is asked for

    text = BODIES.check(made, Body, package)
    by_density = made.density is not Body.density and made.extent is not Body.extent
    if made.particles is Body.particles and not by_density:
        raise BODIES.refused(made, package, "it must have `density` and `extent`, or `particles`")
    if not made.models or not set(made.models) <= set(MODELS):
        raise BODIES.refused(made, package, f"its `models` must be some of {', '.join(MODELS)}")
    if clash := sorted(set(KEYS) & set(made.options)):
        raise BODIES.refused(made, package, f"its option {clash[0]} is a key that every [body] has")
    return Entry(text, made.options, "particles", made.source, tuple(made.models), made=made, package=package)


def installed(kind: str) -> Entry | None:
    """The body of that kind that an installed package offers; None where there is none."""
    return BODIES.installed(kind, entry_of)


def is_body(thing: Any) -> bool:
    """Whether what is given from Python is an initial body, or the class of one."""
    made: Any = made_of(thing)
    return any(f"{base.__module__}.{base.__name__}" == "astroinertia.sph.placed.Body" for base in made.__mro__)


def entries(own_things: Sequence[Any]) -> tuple[dict[str, Entry], Entry | None, Entry | None]:
    """Of things of the user's own: the entries of effects by kind, of an equation of state, and of an initial body."""
    bodies = [made_of(own) for own in own_things if is_body(own)]
    if len(bodies) > 1:
        raise SceneError("two initial bodies are given; give one.")
    effects, fluid = own_matter.entries_of([own for own in own_things if not is_body(own)])
    return effects, fluid, entry_of(bodies[0]) if bodies else None


def with_body(own_things: Sequence[Any], body: Any) -> tuple[Any, ...]:
    """Things of the user's own with a body, or its class, beside them; SceneError where it is none."""
    if body is None:
        return tuple(own_things)
    try:
        entry_of(made_of(body))
    except SceneError as error:
        raise SceneError(f"body: {error}") from None
    return (*own_things, body)
