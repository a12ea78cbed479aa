"""What a run without particles is predicted to take."""

import math

import numpy as np
import pytest

from astroinertia.costs import machine, smooth
from astroinertia.costs.prediction import predict
from astroinertia.costs.probe_scenes import COMPANION, RIGID
from astroinertia.models.rigid.splitting import COMPOSITIONS
from astroinertia.scene import load


@pytest.mark.full
def test_a_top_is_fastest_where_its_polhode_says():
    text = """
name = "top"
model = "rigid"
units = "code"
[body]
kind = "rigid"
mass = 1.0
moments = [1.0, 2.0, 2.5]
[body.rotation]
rate = 1.0
axis = [0.1, 1.0, 0.1]
[effects]
[time]
end = 10.0
"""
    inertia, spin = np.array([1.0, 2.0, 2.5]), np.array([0.1, 1.0, 0.1]) / math.sqrt(1.02)
    fastest = 0.0
    for _ in range(40_000):  # Euler's equations, by a step of the midpoint
        middle = spin + 5e-4 * np.cross(inertia * spin, spin) / inertia
        spin = spin + 1e-3 * np.cross(inertia * middle, middle) / inertia
        fastest = max(fastest, float(np.linalg.norm(spin)))
    assert smooth.fastest_spin(load.loads(text)) == pytest.approx(fastest, rel=1e-3)


@pytest.mark.parametrize("order", COMPOSITIONS)
def test_steps_of_a_splitting_take_as_long_as_their_stages(order):
    """Measured for orders 2, 4, 6 and 8: 0.2, 1.9, 3.4 and 6.4 us a step, of 1, 5, 9 and 17 stages."""
    own, default = (
        predict(load.loads(RIGID, ["numerics.integrator='splitting'", f"numerics.order={each}"]), machine.shipped())
        for each in (order, 8)
    )
    assert own is not None and default is not None
    stages = len(COMPOSITIONS[order]) / len(COMPOSITIONS[8])
    assert own.parts["steps"].processor == pytest.approx(stages * default.parts["steps"].processor)


@pytest.mark.parametrize(("integrator", "times"), [("splitting", 10.0), ("adaptive", 2.6)])
def test_steps_of_a_rigid_body_with_companions_take_longer(integrator, times):
    """As measured of the Earth: 73.7 in place of 7.3 us, and 56.0 in place of 21.4."""
    free = load.loads(RIGID, (f"numerics.integrator='{integrator}'",))
    moon = load.loads(RIGID + COMPANION.replace("splitting", integrator))
    one, other = (predict(scene, machine.shipped()) for scene in (free, moon))
    assert other.steps == one.steps
    assert other.parts["steps"].processor == pytest.approx(times * one.parts["steps"].processor)


@pytest.mark.parametrize("integrator", ["splitting", "adaptive"])
def test_a_top_takes_as_many_steps_however_its_spin_is_said(integrator):
    """About its largest moment, 2.5, at a rate of 0.5."""
    settings = (f"numerics.integrator='{integrator}'", "body.rotation.axis=[0.0, 0.0, 1.0]")
    said = (RIGID.replace("rate = 1.0", text) for text in ("rate = 0.5", "angular_momentum = 1.25"))
    one, other = (predict(load.loads(text, settings), machine.shipped()) for text in said)
    assert other.steps == one.steps


FRICTION = "[effects.internal_dissipation]\ntime_scale = 1e5\n"
TIDE = "[effects.tidal_torque]\nlove_number = 0.3\nradius = 1.0\ntime_lag = 0.01\n"


@pytest.mark.parametrize(
    ("integrator", "more", "measured"),
    [
        ("splitting", FRICTION, (14.6, 15.9)),
        ("splitting", COMPANION + TIDE, (26.3, 27.6)),
        ("adaptive", FRICTION, (2.7, 3.5)),
    ],
)
def test_steps_with_what_follows_the_spin_take_as_long_as_measured(integrator, more, measured):
    """Over those of a free top, twice; a torque that does not follow the spin takes no such step."""
    setting = (f"numerics.integrator='{integrator}'",)
    plain = RIGID.replace("[effects]\n", "")
    free, found = (predict(load.loads(text, setting), machine.shipped()) for text in (RIGID, plain + more))
    assert found.steps == free.steps
    assert measured[0] / 1.25 < found.parts["steps"].processor / free.parts["steps"].processor < 1.25 * measured[1]
    pushed = plain + "[effects.constant_torque]\nvector = [0.0, 0.0, 1e-6]\n"
    assert predict(load.loads(pushed, setting), machine.shipped()).parts["steps"] == free.parts["steps"]
