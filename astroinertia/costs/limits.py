"""What limits the steps of a run in the course of its time."""

from dataclasses import dataclass
from typing import Any

import numpy as np

DEPTH = 0.5  # smoothing lengths that matter may go into other matter in one step, as in models.sph.limits
PARTS = (np.arange(20) + 0.5) / 20  # of the matter: below which its limits are known


@dataclass(frozen=True)
class Limits:
    """At times (K,): the shortest limit of all matter, and the longest step (inf: any).

    below: limits (P, K) that PARTS of the matter are below.
    passing: from which step on it has to be looked at whether matter that is apart may meet in it. crowding: the mean
    number of neighbours over that at the start.
    """

    times: np.ndarray
    shortest: np.ndarray
    below: np.ndarray
    longest: np.ndarray | float = np.inf
    passing: np.ndarray | float = np.inf
    crowding: np.ndarray | float = 1.0


def passed(length: Any, speed: Any) -> Any:
    """The longest step in which nothing, at most that fast about the middle, goes deep into what is apart."""
    with np.errstate(over="ignore"):  # of what rests it is infinite
        return 0.5 * DEPTH * length / np.maximum(speed, 1e-300)


NOT_KNOWN = Limits(np.zeros(1), np.ones(1), np.ones((len(PARTS), 1)))
"""Of what nothing is known: limits up to no time."""
