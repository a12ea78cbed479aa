"""The kinds of equations of state that a scene may ask for.

A kind is a class of a module of scene.fluid_kinds, which nothing else names. Tests: tests/unit/scene/test_kinds.py.
"""

from typing import TYPE_CHECKING, Annotated, Any, Union

from pydantic import Field

from astroinertia.scene.fluids import Fluid, OwnFluid
from astroinertia.scene.kinds import kinds_of

KINDS: dict[str, type[Fluid]] = kinds_of("fluid_kinds", Fluid)
if TYPE_CHECKING:
    AnyEquationOfState = Any
else:
    AnyEquationOfState = Annotated[Union[*KINDS.values(), OwnFluid], Field(discriminator="kind")]
