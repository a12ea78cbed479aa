"""The kinds of bodies and of equations of state that a scene may ask for, validated and frozen, in SI (or code units).

A kind is a class of a module of scene.body_kinds or scene.fluid_kinds, which nothing else names.
"""

import pkgutil
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, Union, get_args

from pydantic import Field

from astroinertia.scene.fluids import Fluid, OwnFluid
from astroinertia.scene.initial_body import Body
from astroinertia.scene.own_body import OwnBody

Kind = TypeVar("Kind", bound=Any)


def kinds_of(folder: str, base: type[Kind]) -> dict[str, type[Kind]]:
    """Subclasses of `base`, by kind, in the order of their `rank` and then of their names; it imports the modules."""
    package = import_module(f"astroinertia.scene.{folder}")
    names = [f"astroinertia.scene.{folder}.{module.name}" for module in pkgutil.iter_modules(package.__path__)]
    classes = [
        made
        for name in names
        for made in vars(import_module(name)).values()
        if isinstance(made, type) and issubclass(made, base) and made.__module__ == name
    ]
    kinds = {get_args(made.model_fields["kind"].annotation)[0]: made for made in classes if "kind" in made.model_fields}
    return dict(sorted(kinds.items(), key=lambda item: (item[1].rank, item[0])))


BODY_KINDS, FLUID_KINDS = kinds_of("body_kinds", Body), kinds_of("fluid_kinds", Fluid)
if TYPE_CHECKING:
    AnyBody = AnyEquationOfState = Any
else:
    AnyBody = Annotated[Union[*BODY_KINDS.values(), OwnBody], Field(discriminator="kind")]
    AnyEquationOfState = Annotated[Union[*FLUID_KINDS.values(), OwnFluid], Field(discriminator="kind")]
