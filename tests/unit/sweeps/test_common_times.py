"""Times that members of a sweep have in common, and what of a member stands at those it did not record at."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.sweeps.common_times import MOST, at_times, common


def test_members_of_one_cadence_share_their_times_and_add_their_ends() -> None:
    long, short = np.append(np.arange(0.0, 1.0, 0.1), 1.0), np.array([0.0, 0.1, 0.2, 0.25])
    found = common([short * (1.0 + 1e-14), long])
    np.testing.assert_allclose(found, np.sort(np.append(long, 0.25)), rtol=1e-13)


def test_members_whose_times_are_all_different_have_equal_parts_and_their_ends_in_common() -> None:
    ends = np.linspace(1.0, 2.0, 101)
    found = common([np.linspace(0.0, end, 11) for end in ends])
    assert len(found) <= MOST * 11 + 1 + len(ends)
    assert np.isin(ends, found).all() and found[0] == 0.0
    assert np.diff(found).max() <= 0.1 + 1e-12  # the finest cadence


def test_values_between_records_are_linear_and_directions_those_of_the_nearest() -> None:
    own = np.array([0.0, 1.0, 3.0])
    phase = np.array([3.1, -3.1, -3.0])
    data = xr.Dataset(
        {"mass": ("time", own**2), "bar_phase": ("time", phase), "torque": (("effect", "time"), [own, -own])},
        {"time": own},
    )
    found, interpolated = at_times(data, np.array([0.0, 0.4, 0.6, 1.0, 2.0, 3.0, 4.0]))
    assert interpolated
    np.testing.assert_array_equal(found["time"], [0.0, 0.4, 0.6, 1.0, 2.0, 3.0])  # nothing after its end
    np.testing.assert_allclose(found["mass"], [0.0, 0.4, 0.6, 1.0, 5.0, 9.0], rtol=1e-15)
    np.testing.assert_array_equal(found["bar_phase"], [3.1, 3.1, -3.1, -3.1, -3.0, -3.0])
    np.testing.assert_allclose(found["torque"].sel(effect=1), [0.0, -0.4, -0.6, -1.0, -2.0, -3.0], rtol=1e-15)


@pytest.mark.parametrize("count", [1, 4])
def test_times_that_are_the_same_to_round_off_leave_every_bit(count: int) -> None:
    own = np.linspace(0.0, 1.0, count)
    data = xr.Dataset({"mass": ("time", np.sin(own) / 3.0)}, {"time": own})
    found, interpolated = at_times(data, own * (1.0 + 2e-16) + (own > 0.0) * 1e-16)
    assert not interpolated
    np.testing.assert_array_equal(found["mass"], data["mass"])
