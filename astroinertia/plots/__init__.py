"""Pictures of a dataset, one module for a family of figures, and a summary in words.

What is named here is imported when it is first used, so that one figure does not wait for all others.
"""

from typing import TYPE_CHECKING

from astroinertia.process.lazy import exported

if TYPE_CHECKING:
    from astroinertia.plots.density import density_figure, projection_figure
    from astroinertia.plots.in_words import summary
    from astroinertia.plots.pictures import FIGURES, figures, write_all

__all__ = ["FIGURES", "density_figure", "figures", "projection_figure", "summary", "write_all"]
__getattr__ = exported(__name__, {
    f"{__name__}.in_words": ("summary",),
    f"{__name__}.density": ("density_figure", "projection_figure"),
    f"{__name__}.pictures": ("FIGURES", "figures", "write_all"),
})  # fmt: skip
