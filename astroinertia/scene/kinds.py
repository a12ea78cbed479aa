"""The kinds that a table of a scene may be of: every class with a `kind` in the modules of a folder of this room."""

import pkgutil
from importlib import import_module
from typing import Any, TypeVar, get_args

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
