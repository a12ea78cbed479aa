"""The kinds of bodies that a scene may ask for, validated and frozen, in SI (or code units).

A kind is a class of a module of scene.body_kinds, which nothing else names. Tests: tests/unit/scene/test_kinds.py.
"""

from typing import TYPE_CHECKING, Annotated, Any, Union

from pydantic import Field

from astroinertia.scene.initial_body import Body
from astroinertia.scene.kinds import kinds_of
from astroinertia.scene.own_body import OwnBody

KINDS: dict[str, type[Body]] = kinds_of("body_kinds", Body)
if TYPE_CHECKING:
    AnyBody = Any
else:
    AnyBody = Annotated[Union[*KINDS.values(), OwnBody], Field(discriminator="kind")]
