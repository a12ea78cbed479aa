"""Sizes that change homologously: closed forms against the cycloid, conservation and independent integration."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.errors import NumericalError
from astroinertia.inertia.prescribed import change
from astroinertia.models.scaling.homology import Dynamic, Kepler, Prescribed

KINDS = {
    "pulsation": (0.3, 1.0, 1.0, 0.0),
    "flung out": (0.3, 1.0, 1.0, 2.0),
    "thrown up": (0.0, 1.0, 1.0, 1.2),
    "thrown down": (0.0, 1.0, 1.0, -2.0),
    "at escape": (0.0, 1.0, 1.0, math.sqrt(2.0)),
    "repelled": (0.2, -0.5, 1.0, -1.0),
    "no gravity": (0.2, 0.0, 0.7, -1.0),
    "coasting": (0.0, 0.0, 1.3, -0.2),
    "hard bounce": (1e-3, 1.0, 1.0, 0.0),
    "large": (3.0e4, 2.0, 5.0e3, -0.01),
}


@pytest.mark.parametrize("kind", KINDS)
def test_keplers_problem_against_integration(kind):
    law = Kepler(*KINDS[kind])
    end = 0.9 * min(law.collapse_time, 4.0 if law.scale < 10 else 3e5)

    def slope(_, y):
        return [y[1], law.repulsion / y[0] ** 3 - law.attraction / y[0] ** 2]

    found = solve_ivp(slope, (0.0, end), [law.scale, law.rate], "DOP853", rtol=1e-13, atol=1e-15)
    size = law.at(end)
    assert size.scale == pytest.approx(found.y[0, -1], rel=1e-9)
    assert size.rate == pytest.approx(found.y[1, -1], rel=1e-8, abs=1e-12)
    assert size.acceleration == pytest.approx(slope(0.0, size)[1], rel=1e-13)
    # Its own energy, to round-off of the larger parts.
    parts = (0.5 * size.rate**2, 0.5 * law.repulsion / size.scale**2, -law.attraction / size.scale)
    assert sum(parts) == pytest.approx(law.energy, abs=1e-13 * max(map(abs, (*parts, law.energy, 1e-300))))
    assert law.at(0.0) == pytest.approx((law.scale, law.rate, slope(0.0, law.at(0.0))[1]))


def test_free_fall_is_the_cycloid():
    law = Kepler(0.0, 1.0)
    assert law.collapse_time == pytest.approx(math.pi / (2 * math.sqrt(2)), rel=1e-15)
    for angle in (1e-4, 0.1, 1.0, 2.0, 3.0):
        size = law.at((angle + math.sin(angle)) / (2 * math.sqrt(2)))
        assert size.scale == pytest.approx(0.5 * (1 + math.cos(angle)), rel=1e-13)
        assert size.rate == pytest.approx(-math.sqrt(2) * math.tan(angle / 2), rel=1e-11)
    with pytest.raises(NumericalError, match=r"collapses to a point: .* \(time 1\.11072"):
        law.at(1.2)
    # Thrown up, it comes down: the whole cycloid through its top.
    thrown = Kepler(0.0, 1.0, 1.0, 1.0)
    up = math.pi / 2 + 1  # of the cycloid of s_max = 2
    assert thrown.collapse_time == pytest.approx(math.pi + up, rel=1e-13)


def test_pulsation_repeats_for_ever():
    law = Kepler(0.3, 1.0)
    moment = law.at(0.3 * law.period)
    later = law.at(1e6 * law.period + 0.3 * law.period)
    assert later.scale == pytest.approx(moment.scale, rel=1e-8)  # the time itself has no more digits
    assert law.at(0.5 * law.period).scale == pytest.approx(0.3 / 1.7, rel=1e-13)  # the other turning point
    assert law.at(0.5 * law.period).rate == pytest.approx(0.0, abs=1e-7)


def _slope(_, y):
    return np.array([y[1], 0.3 / y[0] ** 3 - 1.0 / y[0] ** 2])


def test_integration_agrees_with_the_closed_form_and_repeats():
    law, found = Kepler(0.3, 1.0), Dynamic(_slope, np.array([1.0, 0.0]), 1e5, pulsates=True)
    for time in (0.1, 1.0, 0.77 * law.period, 1.3 * law.period, 5e3, 8e4):
        size = law.at(time)
        state = found.state(time)
        tolerance = 1e-12 * (1 + time)
        assert state[0] == pytest.approx(size.scale, abs=tolerance)
        assert state[1] == pytest.approx(size.rate, abs=5 * tolerance)
    assert len(found._knots) < 300  # one period and a bit, whatever the time


def test_a_run_that_ends_within_its_first_pulsation_comes_to_its_end():
    """Both turning points are passed, of a body that began between them, before the period is over."""
    law = Kepler(0.3, 1.0, 1.0, 0.3)
    turns = np.diff(np.sign([law.at(time).rate for time in np.linspace(0.0, 12.0, 2000)])).nonzero()[0] * 12.0 / 1999
    end = float(turns[1]) + 0.1
    assert end < 2.0 * (turns[1] - turns[0])
    found = Dynamic(_slope, np.array([1.0, 0.3]), end, pulsates=True)
    assert found.reached(end) == end
    assert found.state(end)[0] == pytest.approx(law.at(end).scale, rel=1e-11)


def test_states_do_not_depend_on_what_was_asked_before():
    one = Dynamic(_slope, np.array([1.0, 0.1]), 50.0)
    other = Dynamic(_slope, np.array([1.0, 0.1]), 50.0)
    for time in np.linspace(0.0, 40.0, 33):
        one.state(float(time))
    np.testing.assert_array_equal(one.state(41.0), other.state(41.0))
    np.testing.assert_array_equal(one.state(3.3), other.state(3.3))


def test_a_force_that_begins_and_ends_is_met():
    def slope(time, y):
        return np.array([y[1], 1.0 if 1.0 <= time < 1.5 else 0.0])

    found = Dynamic(slope, np.array([1.0, 0.0]), 10.0, breaks=(1.0, 1.5))
    assert found.state(10.0) == pytest.approx([1.0 + 0.125 + 0.5 * 8.5, 0.5], rel=1e-14)
    assert found.state(1.25) == pytest.approx([1.03125, 0.25], rel=1e-14)


def test_a_state_from_before_a_force_began_leaves_the_force_on():
    """A spring whose rest moves at time 1: the solver is under way after that when an early size is asked for."""

    def slope(time, y):
        return np.array([y[1], (3.0 if time < 1.0 else 4.0) - y[0]])

    found = Dynamic(slope, np.array([1.0, 0.0]), 20.0, breaks=(1.0,))
    found.state(3.0)
    assert found.state(0.5)[0] == pytest.approx(3.0 - 2.0 * math.cos(0.5), rel=1e-13)
    late = 4.0 - (1.0 + 2.0 * math.cos(1.0)) * math.cos(18.0) + 2.0 * math.sin(1.0) * math.sin(18.0)
    assert found.state(19.0)[0] == pytest.approx(late, rel=1e-12)


def test_forces_that_are_no_numbers_are_reported():
    """The solver would look for a first step for ever."""
    with pytest.raises(NumericalError, match="beyond what numbers hold"):
        Dynamic(lambda _, y: np.array([y[1], np.nan]), np.array([1.0, 0.0]), 10.0)


def test_a_size_whose_square_no_number_holds_is_reported():
    found = Dynamic(lambda _, y: np.array([float(y[0]) ** 40, 0.0]), np.array([10.0, 0.0]), 1e300)
    with pytest.raises(NumericalError, match="cannot be followed any further"):
        found.state(1e299)


def test_a_cold_collapse_is_reported():
    found = Dynamic(lambda _, y: np.array([y[1], -1.0 / y[0] ** 2]), np.array([1.0, 0.0]), 10.0)
    with pytest.raises(NumericalError, match=r"collapses to a point|cannot be followed"):
        found.state(2.0)
    assert found.state(1.0)[0] == pytest.approx(Kepler(0.0, 1.0).at(1.0).scale, rel=1e-10)


def test_a_prescribed_size_has_its_derivatives():
    law = Prescribed(change([1.0, 2.0, 4.0], [0.9, 0.5, 0.1]), 2.0)
    assert law.at(0.0) == (2.0, 0.0, 0.0)
    assert law.at(9.0) == pytest.approx((2.0 * math.sqrt(0.1), 0.0, 0.0))
    for time in (0.3, 1.7, 3.0):
        step = 1e-4
        below, size, above = (law.at(time + k * step) for k in (-1, 0, 1))
        assert (above.scale - below.scale) / (2 * step) == pytest.approx(size.rate, rel=1e-6)
        assert (above.rate - below.rate) / (2 * step) == pytest.approx(size.acceleration, rel=1e-5, abs=1e-8)
    assert law.at(1.0 - 1e-9).rate == pytest.approx(law.at(1.0 + 1e-9).rate, rel=1e-6)
