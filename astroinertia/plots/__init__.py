"""Pictures of a dataset, one module for a family of figures, and a summary in words.

What is named here is imported when it is first used, so that one figure does not wait for all others.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from astroinertia.plots.density import density_figure, projection_figure
    from astroinertia.plots.in_words import summary
    from astroinertia.plots.pictures import FIGURES, figures, write_all

_ELSEWHERE = {"summary": "in_words", "density_figure": "density", "projection_figure": "density"}
__all__ = ["FIGURES", "density_figure", "figures", "projection_figure", "summary", "write_all"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_ELSEWHERE.get(name, 'pictures')}"), name)
