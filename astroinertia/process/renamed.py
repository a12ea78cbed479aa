"""Names of before, accepted with a warning for one release. Tests: tests/unit/test_words.py."""

import warnings
from collections.abc import Callable
from functools import wraps
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
