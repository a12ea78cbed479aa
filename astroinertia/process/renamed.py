"""Names of before, accepted with a warning for one release. Tests: tests/unit/test_words.py."""

import sys
import warnings
from collections.abc import Callable, Mapping
from functools import wraps
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any, ParamSpec, TypeVar

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


def renamed_keyword(before: str, now: str) -> Callable[[Callable[Parameters, Result]], Callable[Parameters, Result]]:
    """A decorator of a function whose keyword argument `before` is called `now`; FutureWarning where it is used."""

    def decorated(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
        @wraps(function)
        def called(*arguments: Parameters.args, **keywords: Parameters.kwargs) -> Result:
            if before in keywords:
                name = getattr(function, "__name__", "the function")
                warnings.warn(f"{name}({before}=...) is now {name}({now}=...).", FutureWarning, stacklevel=2)
                values: dict[str, Any] = keywords
                values[now] = values.pop(before)
            return function(*arguments, **keywords)

        return called

    return decorated


def renamed(module: str, before: str, now: str) -> None:
    """Say that a name of a module is another one now."""
    warnings.warn(f"{module}.{before} is now {module}.{now}.", FutureWarning, stacklevel=3)


class MovedModules(Loader, MetaPathFinder):
    """Modules by their full names of before, with those of now: imported with a FutureWarning, the same objects."""

    def __init__(self, modules: Mapping[str, str]) -> None:
        self.modules = modules
        sys.meta_path.append(self)

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Where a module of before comes from: here."""
        return ModuleSpec(fullname, self) if fullname in self.modules else None

    def exec_module(self, module: ModuleType) -> None:
        """Fill a module of before: its attributes are those of the module of now."""
        now = self.modules[module.__name__]
        warnings.warn(f"{module.__name__} is now {now}.", FutureWarning, stacklevel=2)
        vars(module)["__getattr__"] = lambda name: getattr(import_module(now), name)
