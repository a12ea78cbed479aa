"""Datasets of runs: their table of quantities, what follows from the recorded ones, and the accessor `.inertia`.

What is named here is imported when it is first used: tables and labels of quantities do not wait for netCDF.
"""

from typing import TYPE_CHECKING

from astroinertia.process.lazy import exported

if TYPE_CHECKING:
    from astroinertia.dataset.series import (
        NOT_OF_A_RUN,
        Chunks,
        finish,
        frame_of,
        gap_tolerance,
        global_attributes,
        headline,
        numbers,
        open,
        open_snapshots,
        open_tree,
    )

__all__ = [
    "NOT_OF_A_RUN",
    "Chunks",
    "finish",
    "frame_of",
    "gap_tolerance",
    "global_attributes",
    "headline",
    "numbers",
    "open",
    "open_snapshots",
    "open_tree",
]
__getattr__ = exported(__name__, {f"{__name__}.series": tuple(__all__)})
