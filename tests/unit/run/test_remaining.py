"""What a run has still to go."""

import math

import numpy as np
import pytest

from astroinertia.run.remaining import LATE, SPACING, TRUSTED, Pace


def seen(times, done) -> Pace:
    pace = Pace()
    for now, share in zip(times, done, strict=True):
        if pace.due(now):
            pace.note(now, share)
    return pace


def test_it_is_as_predicted_at_first_and_by_the_pace_soon():
    assert Pace().left(7.0, 0.0, 100.0) == 100.0
    assert math.isnan(Pace().left(7.0, 0.0, math.nan))
    begun = seen([5.0], [0.02])
    assert begun.left(5.0 + 200.0 * TRUSTED, 0.02 + 0.5 * TRUSTED, 100.0) == pytest.approx(
        (0.98 - 0.5 * TRUSTED) * (0.5 * 400.0 + 0.5 * 100.0)
    )
    assert begun.left(145.0, 0.37, 100.0) == pytest.approx(0.63 * 400.0)  # beyond the share that is trusted
    assert begun.left(9.0, 0.03, math.nan) == pytest.approx(0.97 * 400.0)


def test_at_an_even_pace_it_is_exact_however_long_the_run():
    times = np.arange(0.0, 1e4, 0.5)
    pace = seen(times, times / 3e4)
    assert pace.left(1e4, 1.0 / 3.0, 1.0) == pytest.approx(2e4)
    assert len(pace._marks) < 3.0 + math.log(1e4 / 0.5) / math.log(1.0 + SPACING)


def test_a_pace_that_has_changed_is_the_one_of_late():
    """Half of the work in 10 s, and from then on four times as slowly: the rest takes what it takes from now on."""
    times = np.linspace(0.0, 30.0, 3001)
    done = np.where(times < 10.0, 0.05 * times, 0.5 + 0.0125 * (times - 10.0))
    assert LATE <= 0.5
    assert seen(times, done).left(30.0, 0.75, math.nan) == pytest.approx(0.25 / 0.0125, rel=1e-6)
    # Just after the change most of what is looked back on was quicker.
    assert seen(times[:1001], done[:1001]).left(10.0, 0.5, math.nan) == pytest.approx(10.0, rel=0.01)


def test_where_nothing_was_done_of_late_the_whole_pace_tells():
    pace = seen([0.0, 10.0, 11.0, 20.0, 40.0], [0.0, 0.5, 0.5, 0.5, 0.5])
    assert pace.left(60.0, 0.5, 1.0) == pytest.approx(60.0)
