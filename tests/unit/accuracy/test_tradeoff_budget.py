"""What settings will take."""

import math

import pytest

from astroinertia.accuracy.knobs import Knob, Setting
from astroinertia.accuracy.tradeoff import predicted

PARTICLES = Knob(
    "particles", "", (100.0, 1000.0, 10000.0), 1000.0, lambda value: (), cost=lambda value: value ** (4 / 3)
)
STEP = Knob("timestep_factor", "", (2.0, 1.0, 0.5), 1.0, lambda value: (), cost=lambda value: 1.0 / value)


def setting(knob, value):
    return Setting(knob.name, value, ())


def test_a_power_law_of_the_measured_goes_on():
    taken = {("particles", 100.0): 1.0, ("particles", 1000.0): 10.0}  # linear, where the knob's guess has 4/3
    assert predicted(setting(PARTICLES, 10000.0), PARTICLES, math.nan, taken) == pytest.approx(100.0)


def test_one_measured_value_is_scaled_by_the_guess_of_its_knob():
    taken = {("particles", 1000.0): 3.0}
    assert predicted(setting(PARTICLES, 10000.0), PARTICLES, math.nan, taken) == pytest.approx(3.0 * 10 ** (4 / 3))
    assert predicted(setting(PARTICLES, 100.0), PARTICLES, math.nan, taken) == pytest.approx(3.0 * 10 ** (-4 / 3))


def test_another_knob_is_scaled_from_the_base():
    assert predicted(setting(STEP, 0.5), STEP, 7.0, {}) == pytest.approx(14.0)
