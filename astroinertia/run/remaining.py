"""What a run has still to go: by the pace of its last steps, and as predicted before there are any.

Its course was predicted: the share of its work that is done by each time. What that takes is seen as the run goes, and
changes where the flow is not the one that was thought of, or neighbours become more: the pace of late says more of what
is to come than that of the whole run. Tests: tests/unit/run/test_remaining.py; measured against runs in
tests/benchmarks/results/remaining_times.md.
"""

import math

# Share of the work from which on the pace that is seen says what is left, whatever was predicted. Until then few steps
# were seen, all in one phase of the flow, whose course may be as wrong as the prediction of the whole: of 16 recorded
# runs 15 are within 1.5 (13 with a tenth), 14 where all is predicted 0.7 or 1.4 times as long (12 and 13).
TRUSTED = 0.3
LATE = 1.0 / 3.0  # of the time that it has taken so far, in which the pace is seen
SPACING = 0.02  # of that time, that marks are apart


class Pace:
    """How far a run was, and when: marks that are closer where it had just begun."""

    def __init__(self) -> None:
        self._marks: list[tuple[float, float]] = []

    def due(self, now: float) -> bool:
        """Whether it is time for another mark."""
        marks = self._marks
        return not marks or now - marks[-1][0] > SPACING * (marks[-1][0] - marks[0][0])

    def note(self, now: float, done: float) -> None:
        """At a time in seconds, on whatever clock, that share of the work was done."""
        self._marks.append((now, done))

    def left(self, now: float, done: float, predicted: float) -> float:
        """Seconds that the rest takes; predicted: those of all of the work, NaN where no longer counted on."""
        first, before = self._marks[0] if self._marks else (now, done)
        rest, worked = 1.0 - done, done - before
        if worked <= 0.0:
            return rest * predicted
        since = now - LATE * (now - first)
        then, at = next(mark for mark in reversed(self._marks) if mark[0] <= since)
        lately = (now - then) / (done - at) if done > at else (now - first) / worked
        trusted = min(1.0, worked / TRUSTED) if math.isfinite(predicted) else 1.0
        return rest * (lately if trusted == 1.0 else trusted * lately + (1.0 - trusted) * predicted)
