"""Rigid bodies under way, for tests: a body, how it turns at the start, how it is integrated."""

import numpy as np
import pytest

from astroinertia.effects import catalogue
from astroinertia.models.rigid import body as rigid
from astroinertia.models.rigid.evolution import RigidBody, Settings
from astroinertia.rotation.attitude import attitude_of_quaternion

AT_REST = (1.0, 0.0, 0.0, 0.0)
SPLITTING = Settings("splitting", order=8, steps_per_rotation=60.0)
ADAPTIVE = Settings("adaptive", tolerance=1e-13)
BEST = {"splitting": SPLITTING, "adaptive": Settings("adaptive", tolerance=1e-14)}
both = pytest.mark.parametrize("settings", BEST.values(), ids=BEST)


def effect(kind, **options):
    return catalogue.build(kind, options)


def under_way(moments, turning, *effects, settings=SPLITTING, quaternion=AT_REST, mass=1.0, **rest):
    """A body with ascending moments and an angular velocity in its principal axes."""
    moments, turning = np.asarray(moments, dtype=float), np.asarray(turning, dtype=float)
    body = rigid.body(mass, moments, effects=effects, **rest)
    return RigidBody(body, quaternion, moments * turning, settings)


def attitude(run):
    return np.asarray(attitude_of_quaternion(run.state.quaternion))


def momentum(run):
    """L in inertial axes."""
    return np.asarray(run.state.angular_momentum.total)


def spin(run):
    """omega in the principal axes."""
    return np.asarray(rigid.spin_in_body(run.body, np.float64(run.time), run.state.momentum_in_body))
