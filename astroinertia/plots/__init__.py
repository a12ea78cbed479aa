"""Pictures of a dataset, one module for a family of figures, and a summary in words.

What is named here is imported when it is first used, so that one figure does not wait for all others.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from astroinertia.plots.in_words import summary
    from astroinertia.plots.pictures import FIGURES, density_figure, figures, projection_figure, write_all

__all__ = ["FIGURES", "density_figure", "figures", "projection_figure", "summary", "write_all"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from astroinertia.plots import in_words, pictures

    return getattr(in_words if name == "summary" else pictures, name)
