"""A prescribed size: through its points, never past them, smooth, the same in numpy and jax."""

import jax
import numpy as np
import pytest

from astroinertia.inertia.prescribed import change

pytestmark = pytest.mark.usefixtures("float64")

TIMES, FACTORS = [1.0, 2.0, 2.5, 6.0], [1.0, 0.2, 0.2, 3.0]


def test_it_meets_its_points_and_stays_between_them():
    curve = change(TIMES, FACTORS)
    assert curve.factor(np.array(TIMES)) == pytest.approx(FACTORS, rel=1e-15)
    outside = curve.factor(np.array([-1.0, 0.0, 6.0, 99.0]))
    assert outside == pytest.approx([1.0, 1.0, 3.0, 3.0], rel=1e-15)
    for low, high in ((0.0, 1.0), (1.0, 2.0), (2.0, 2.5), (2.5, 6.0)):
        piece = curve.factor(np.linspace(low, high, 200))
        ends = np.sort(piece[[0, -1]])
        assert piece.min() >= ends[0] * (1 - 1e-15) and piece.max() <= ends[1] * (1 + 1e-15)
        assert (np.diff(piece) * (piece[-1] - piece[0]) >= -1e-15).all()


@pytest.mark.full
def test_its_rate_has_no_jumps_and_is_zero_at_both_ends():
    curve = change([1.0, 2.0, 4.0], [0.9, 0.5, 0.1])

    def rate(times):
        return np.asarray(jax.vmap(jax.grad(curve.factor))(times))

    for time in (0.0, 1.0, 2.0, 4.0):
        left, right = rate(np.array([time - 1e-9, time + 1e-9]))
        assert left == pytest.approx(right, abs=1e-7)
    assert rate(np.array([0.0, 4.0, 5.0])) == pytest.approx(0.0, abs=1e-15)
    assert (rate(np.array([1.0, 2.0])) < -0.05).all()


def test_derivatives_are_those_of_the_factor():
    curve = change(TIMES, FACTORS)
    for time in (0.4, 1.3, 2.2, 5.0):
        before, now, after = curve.factor(time + 1e-4 * np.array([-1.0, 0.0, 1.0]))
        value, first, second = curve.derivatives(time)
        assert value == now
        assert first == pytest.approx((after - before) / 2e-4, rel=1e-6, abs=1e-9)
        assert second == pytest.approx((after - 2 * now + before) / 1e-8, rel=1e-6, abs=1e-6)
    assert curve.derivatives(7.0) == (pytest.approx(3.0, rel=1e-15), 0.0, 0.0)
    assert change([2.0], [0.5]).derivatives(0.0) == (1.0, 0.0, 0.0)


def test_a_first_factor_may_be_given_at_time_0():
    assert change([0.0, 2.0], [1.0, 0.5]).factor(1.0) == change([2.0], [0.5]).factor(1.0)


@pytest.mark.parametrize(
    ("times", "factors"),
    [([0.0], [1.0]), ([0.0, 1.0], [2.0, 1.0]), ([2.0, 1.0], [1.0, 1.0]), ([1.0], [0.0]), ([1.0, 2.0], [1.0]),
     ([1.0], [np.nan]), ([np.inf], [1.0])],
)  # fmt: skip
def test_what_is_no_change_is_refused(times, factors):
    with pytest.raises(ValueError, match="a change of size needs"):
        change(times, factors)
