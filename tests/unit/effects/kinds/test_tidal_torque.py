"""The torque of tides in a scene against Kaula's sum, by its quality factor and by rheologies."""

from types import SimpleNamespace

import jax
import numpy as np
import pytest

from astroinertia.effects.catalogue import build
from astroinertia.effects.kinds.tidal_torque import TidalTorque
from astroinertia.matter.rheology import andrade, maxwell
from astroinertia.rotation.tides import tides

MASS, RADIUS, DISTANCE, SPIN = 0.2, 0.4, 3.0, 1.1
RATE = (1.2 / DISTANCE**3) ** 0.5
ELASTIC = 0.05


def seen(spin):
    """A body that turns about z below a companion on a circular orbit."""
    companions = SimpleNamespace(
        mass=np.array([MASS]),
        position=lambda time: np.array([[DISTANCE, 0.0, 0.0]]),
        velocity=lambda time: np.array([[0.0, DISTANCE * RATE, 0.0]]),
    )
    return SimpleNamespace(time=0.0, companions=companions, angular_velocity=spin * np.array([0.0, 0.0, 1.0]))


def yielding(law):
    return lambda frequency: 1.5 / (1 + (1.5 / ELASTIC - 1) / law(frequency))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "number"),
    [
        ({"quality": 40.0}, lambda w: ELASTIC * (1 - 1j / 40.0) + 0 * w),
        pytest.param({"time_lag": 0.01}, lambda w: ELASTIC * (1 - 0.01j * w), marks=pytest.mark.full),
        pytest.param({"relaxation_time": 0.3}, yielding(lambda w: maxwell(w, 0.3)), marks=pytest.mark.full),
        ({"relaxation_time": 50.0, "exponent": 0.3}, yielding(lambda w: andrade(w, 50.0, 0.3))),
    ],
)
def test_on_a_circle_it_is_that_of_the_lag_at_its_frequency(options, number):
    effect = TidalTorque(ELASTIC, RADIUS, **options)
    with jax.enable_x64(True):
        for spin in (SPIN, 0.1):  # the tide drags the body, and hurries it
            torque = np.asarray(jax.jit(lambda effect, spin: effect.torque(seen(spin)))(effect, spin))
            exact = tides(number, MASS, RADIUS, DISTANCE, RATE, spin, gravitational_constant=1.0).torque
            assert torque == pytest.approx([0.0, 0.0, exact], rel=1e-12)
        assert np.all(np.asarray(effect.torque(seen(RATE))) == 0)


def test_what_is_no_rheology_is_refused():
    given = {"love_number": ELASTIC, "radius": RADIUS}
    for options, message in (
        ({}, "either time_lag, quality or relaxation_time"),
        ({"quality": 1.0, "relaxation_time": 1.0}, "either time_lag, quality or relaxation_time"),
        ({"quality": 1.0, "exponent": 0.3}, "needs a relaxation_time"),
        ({"relaxation_time": 1.0, "fluid_love_number": 0.04}, "above love_number"),
    ):
        with pytest.raises(ValueError, match=message):
            build("tidal_torque", given | options)
