"""What limits the steps of a run in the course of its time."""

from dataclasses import dataclass

import numpy as np

USUAL = 0.95  # of the matter, whose limits a base step is longer than: 1.8/1.9, of the costs in models.sph.intervals


@dataclass(frozen=True)
class Limits:
    """At times (K,): the shortest limit of all matter, what most of it is below, and the longest step (inf: any)."""

    times: np.ndarray
    shortest: np.ndarray
    usual: np.ndarray
    longest: np.ndarray | float = np.inf


NOT_KNOWN = Limits(np.zeros(1), np.ones(1), np.ones(1))
"""Of what nothing is known: limits up to no time."""
