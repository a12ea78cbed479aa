"""What a ladder of runs says of its own errors, on ladders whose errors are known."""

import math

import numpy as np
import pytest

from astroinertia.accuracy.convergence import self_convergence
from astroinertia.accuracy.estimates import UNKNOWN, Estimate, estimate, worst

STEPS = np.array([250, 500, 1000, 2000]) ** (-1 / 3)


def ladder(order, factor=0.5, exact=(2.0, 1.0), steps=STEPS):
    exact = np.array(exact)
    return exact + factor * steps[:, None] ** order * np.array([1.0, -0.5])


@pytest.mark.parametrize("order", [1.4, 2.0, 2.3])
def test_the_error_of_a_power_law_is_found(order):
    values = ladder(order)
    truth = np.linalg.norm(values[-1] - [2.0, 1.0]) / np.linalg.norm(values[-1])
    found = estimate(STEPS, values, 2.0, (1.2, 2.4))
    assert found.order == pytest.approx(order, rel=1e-3)
    assert found.error == pytest.approx(truth, rel=1e-3)
    assert estimate(STEPS, ladder(order, factor=1e-7), 2.0, (1.2, 2.4)).order == pytest.approx(order, rel=1e-3)


def test_orders_that_are_not_believed_are_not_used():
    steep = estimate(STEPS, ladder(5.0), 2.0, (1.2, 2.4))
    assert steep.order == 2.4
    assert estimate(STEPS, ladder(0.5), 2.0, (1.2, 2.4)).order == 1.2
    scatter = estimate(STEPS, np.array([[1.0], [1.02], [1.0], [1.01]]), 2.0, (1.2, 2.4))
    assert scatter.order == 2.0


def test_the_order_of_a_ladder_and_that_of_theory_are_weighed_by_their_variances():
    """Inverse-variance means of 1.4 and 2: a ladder of four runs tells its order to 0.3, however well a law fits."""
    for trust, mean in ((0.3, 1.7), (0.6, 0.8 * 1.4 + 0.2 * 2.0)):
        assert estimate(STEPS, ladder(1.4), 2.0, (0.5, 4.0), trust).order == pytest.approx(mean, rel=1e-3)
    uneven = ladder(1.4) + 0.002 * np.array([0.0, 1.0, 0.0, 0.0])[:, None] * np.array([1.0, -0.5])
    law = self_convergence(STEPS, uneven, float(np.linalg.norm(uneven[-1])))
    share = 1.0 / (1.0 + law.uncertainty**2)  # of a law that is less certain than that
    assert 0.3 < law.uncertainty < 0.5 * law.order
    assert estimate(STEPS, uneven, 2.0, (0.5, 4.0), 1.0).order == pytest.approx(share * law.order + (1 - share) * 2.0)


def test_two_runs_have_the_order_of_theory_less_its_deviation():
    """Richardson: |v - v'|/(2^p - 1), p = 2 less its deviation, or half of it."""
    for trust, order in ((0.5, 1.5), (1.5, 1.0)):
        found = estimate([0.2, 0.1], np.array([[1.3], [1.1]]), 2.0, (0.2, 4.0), trust)
        assert found == (pytest.approx(0.2 / 1.1 / (2**order - 1), rel=1e-12), order)


def test_two_runs_that_agree_by_chance_do_not_hide_an_error():
    """The two finest are the same; the third is not."""
    found = estimate(STEPS, np.array([[1.1], [1.04], [1.01], [1.01]]), 2.0, (1.2, 2.4))
    assert found.error > 0.01


def test_an_error_goes_on_as_its_order():
    found = Estimate(1e-2, 2.0)
    assert found.at(0.5) == pytest.approx(2.5e-3)
    assert found.ratio_for(2.5e-3) == pytest.approx(0.5)
    assert found.at(found.ratio_for(1e-4)) == pytest.approx(1e-4)
    assert Estimate(0.0, 2.0).ratio_for(1e-3) == math.inf


def test_of_several_observables_the_worst_counts():
    assert worst([Estimate(1e-3, 2.0), Estimate(1e-2, 2.2)]) == (1e-2, 2.0)
    assert math.isnan(worst([Estimate(1e-3, 2.0), UNKNOWN]).error)
    assert math.isnan(estimate([0.2, 0.1], np.array([[1.0], [0.0]]), 2.0, (1.0, 3.0)).error)  # relative to nothing
    assert math.isnan(estimate([0.1], np.array([[1.0]]), 2.0, (1.0, 3.0)).error)
