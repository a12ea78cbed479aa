"""A rigid body and the bodies of a `rebound.Simulation` about it, each acting on the other."""

import numpy as np

from astroinertia.effects.kinds.gravity_gradient import GravityGradient
from astroinertia.models.rigid import body as rigid
from astroinertia.models.rigid.evolution import RigidBody
from astroinertia.models.rigid.two_way import Companions
from astroinertia.orbits import states


def coupled(bodies, moments, quaternion, momentum, settings):
    """The first of the bodies with principal moments (3,), an attitude (4,) and L in its axes (3,)."""
    masses = states.masses(bodies)
    beside = Companions(masses[1:], np.stack(states.present(bodies)))
    body = rigid.body(masses[0], moments, effects=(GravityGradient(),), companions=beside)
    return RigidBody(body, quaternion, momentum, settings)


def kept(body):
    """What orbits and spin keep together: L (3,) and the energy."""
    record = body.record(None)
    return np.array(record["system_angular_momentum"]), record["system_energy"]


def places(body):
    """Companions relative to the body, (N, 3)."""
    return np.asarray(body.state.orbits.total[0])
