"""Datasets of runs: their table of quantities, what follows from the recorded ones, and the accessor `.inertia`."""

from astroinertia.dataset.series import (
    NOT_OF_A_RUN,
    Chunks,
    finish,
    frame_of,
    gap_tolerance,
    global_attributes,
    headline,
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
    "open",
    "open_snapshots",
    "open_tree",
]
