"""Orders of convergence: from errors, from differences, and what they extrapolate to."""

import numpy as np
import pytest

from astroinertia.accuracy.convergence import NONE, PowerLaw, converging, extrapolated, power_law, self_convergence

STEPS = np.array([1.0, 0.5, 0.25, 0.125])


def test_a_power_law_is_found_and_what_is_below_the_floor_is_left_out():
    errors = 3.0 * STEPS**2
    errors[-1] = 0.2  # another source of error takes over there
    law = power_law(STEPS, np.where(errors == 0.2, 1e-9, errors), floor=1e-6)
    assert (law.order, law.factor, law.points) == pytest.approx((2.0, 3.0, 3))
    assert law.at(0.1) == pytest.approx(0.03)
    assert law.uncertainty < 1e-12


def test_the_uncertainty_of_an_order_is_that_of_the_scatter():
    """Over many sets of noisy errors the spread of the orders is the standard error that each of them tells."""
    rng = np.random.default_rng(1)
    laws = [power_law(STEPS, STEPS**2 * np.exp(0.1 * rng.normal(size=4))) for _ in range(2000)]
    uncertainty = np.sqrt(np.mean([law.uncertainty**2 for law in laws]))
    assert np.std([law.order for law in laws]) == pytest.approx(uncertainty, rel=0.1)
    assert np.mean([law.order for law in laws]) == pytest.approx(2.0, abs=0.01)


def test_the_uncertainty_of_an_order_from_differences_is_that_of_the_scatter():
    """As above, where the logarithm of each difference from the finest value scatters by a twentieth."""
    rng, order = np.random.default_rng(4), 2.0
    coarser = STEPS[:-1] ** order - STEPS[-1] ** order
    noisy = [np.append(coarser * np.exp(0.05 * rng.normal(size=3)), 0.0)[:, None] for _ in range(1000)]
    laws = [self_convergence(STEPS, values, 1.0) for values in noisy]
    assert np.std([law.order for law in laws]) == pytest.approx(
        np.sqrt(np.mean([law.uncertainty**2 for law in laws])), rel=0.1
    )


@pytest.mark.parametrize("order", [0.7, 1.0, 2.0, 4.0, 8.0])
def test_differences_tell_the_order_whatever_else_errs(order):
    """A constant error twenty times as large hides the knob's own from errors, and not from differences."""
    values = np.array([[1.0, 2.0]]) + 0.2 + np.outer(STEPS**order, [0.01, -0.02])
    law = self_convergence(STEPS, values, size=1.0)
    assert law.order == pytest.approx(order, rel=1e-4)
    assert law.factor == pytest.approx(np.hypot(0.01, 0.02), rel=1e-3)
    assert self_convergence(STEPS, values, size=4.0).factor == pytest.approx(law.factor / 4, rel=1e-12)
    hidden = power_law(STEPS, np.linalg.norm(values - [1.0, 2.0], axis=1))
    assert hidden.order < 0.2


def test_differences_up_to_the_floor_are_left_out():
    values = STEPS[:, None] ** 2
    values[2] = values[3] + 1e-9  # as near to the finest as round-off
    assert self_convergence(STEPS, values, 1.0, floor=1e-6).points == 2
    assert self_convergence(STEPS, values, 1.0, floor=1e-6).order == pytest.approx(2.0, rel=1e-6)
    assert self_convergence(STEPS, values, 2.0, floor=0.4e-9).points == 3


def test_errors_count_until_something_else_takes_over():
    errors = 1e-2 * STEPS**4 + 1e-5 * np.array([1.0, 0.5, 2.0, 1.5])
    assert converging(STEPS, errors, 4.0).tolist() == [True, True, True, False]
    assert converging(STEPS[::-1], errors[::-1], 4.0).tolist() == [False, True, True, True]
    assert converging(STEPS, np.array([np.nan, 1e-2, 1e-3, 1e-4]), 2.0).tolist() == [False, True, True, True]
    assert converging(STEPS, np.array([1e-2, 1e-2, 1e-3, 0.0]), 2.0).tolist() == [True, False, False, False]
    assert converging(STEPS, np.array([1e-2, 1e-3, 0.0, 1e-4]), 2.0).tolist() == [True, True, False, True]


def test_scatter_is_no_order():
    scattered = 1.0 + 1e-4 * np.random.default_rng(2).normal(size=(4, 2))
    assert not self_convergence(STEPS, scattered, 1.0).credible
    assert not NONE.credible
    assert power_law(STEPS, STEPS**2).credible
    assert not power_law(STEPS, STEPS**0.2).credible  # hardly falls
    assert PowerLaw(2.0, 0.99, 1.0, 4).credible and not PowerLaw(2.0, 1.01, 1.0, 4).credible  # known to half of it
    assert power_law(STEPS[:2], STEPS[:2] ** 2).credible  # two points: nothing speaks against it


def test_too_little_is_no_order():
    assert power_law(STEPS[:1], STEPS[:1]) == NONE
    assert np.isnan(power_law(np.array([1.0, 1.1]), np.array([1.0, 1.1])).order)  # hardly different steps
    assert np.isnan(self_convergence(STEPS[:2], STEPS[:2, None], 1.0).order)
    near = np.array([1.1, 1.0, 0.5])  # both coarser steps are nearly the same
    assert self_convergence(near, near[:, None], 1.0) == NONE
    assert np.isnan(power_law(STEPS[:2], STEPS[:2] ** 2).uncertainty)  # two points fix the line


def test_richardson_takes_the_leading_error_away_and_distrusts_other_orders():
    values = 5.0 + np.outer(2.0 * STEPS**2 + 0.3 * STEPS**4, [1.0, -1.0])
    limit = extrapolated(STEPS, values, 2.0)
    assert limit is not None
    assert np.abs(limit - 5.0).max() < 0.01 * np.abs(values[-1] - 5.0).max()
    assert extrapolated(STEPS, values, 8.0) is None
    noisy = 5.0 + np.array([[0.1], [-0.2], [0.15], [-0.1]])
    assert extrapolated(STEPS, noisy, 2.0) is None


def test_richardson_trusts_changes_whose_ratio_is_that_of_the_order_within_two():
    """At steps 1, 2 and 4 an error of order 2 grows by 3 and by 12, and at 1, 2 and 3 by 3 and by 5."""
    for steps, ratio in (([4.0, 2.0, 1.0], 4.0), ([3.0, 2.0, 1.0], 5.0 / 3.0)):
        for factor, trusted in ((0.49, False), (0.51, True), (1.0, True), (1.99, True), (2.01, False)):
            values = np.array([[4.0 + 3.0 * ratio * factor], [4.0], [1.0]])
            assert (extrapolated(np.array(steps), values, 2.0) is not None) == trusted
    steps, known = np.array([4.0, np.nan, 1.0, 0.5, 2.0]), np.array([[17.0], [9.0], [2.0], [np.nan], [5.0]])
    assert extrapolated(steps, known, 2.0) == pytest.approx([1.0], rel=1e-14)  # 1 + step^2, in any order
