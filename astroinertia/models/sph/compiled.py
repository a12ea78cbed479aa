"""Parts of a step as their engine has them."""

from collections.abc import Callable
from functools import wraps
from typing import Any


def compiled(part: Callable[..., Any]) -> Callable[..., Any]:
    """A function of a problem and further arguments, compiled where the engine is xla; numba's runs it as it stands."""

    @wraps(part)
    def by_engine(problem: Any, *arguments: Any) -> Any:
        if problem.engine.name != "xla":
            return part(problem, *arguments)
        from astroinertia.engines.xla_pieces import in_pieces  # only here: numba's engine does without JAX

        return in_pieces(part)(problem, *arguments)

    return by_engine
