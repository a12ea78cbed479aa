"""What accuracy of orbits costs: in tables of positions, and where body and companion act on each other."""

import jax
import numpy as np
from precision_table import publish, table

from astroinertia.effects.kinds.gravity_gradient import GravityGradient
from astroinertia.models.rigid import body as rigid
from astroinertia.models.rigid.evolution import Settings
from astroinertia.models.rigid.two_way import CoupledRigidBody
from astroinertia.orbits.rigid_ode import TOLERANCE, RigidBodyOde
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.orbits.states import present
from astroinertia.rotation.ephemeris import ephemeris

MOMENTS = np.array([0.95, 1.0, 1.1]) * 4e-4
MOMENTUM = np.array([0.2, 0.5, 3.5]) * 4e-4
QUATERNION = np.array([0.9, 0.1, 0.3, 0.2]) / np.sqrt(0.95)
LENGTH = 30.0  # five orbits


def pair(eccentricity):
    moon = Companion("moon", 0.3, semi_major_axis=1.0, eccentricity=eccentricity, inclination=0.3, mean_anomaly=0.1)
    return simulation(1.0, [moon])


def tabulated(eccentricity):
    """Error of the table over the distance, at the points that its fit does not see, by the tolerance asked for."""
    return table(
        f"Table of an orbit of eccentricity {eccentricity}, fifty times round",
        "tolerance",
        (1e-6, 1e-8, 1e-10, 1e-12, 1e-13),
        lambda tolerance: ephemeris(pair(eccentricity), 10.0 * LENGTH, tolerance),
        lambda found: float(found.error),
        1e-13,
    )


def coupled(order, steps_per_rotation):
    body = rigid.body(1.0, MOMENTS, effects=(GravityGradient(),))
    settings = Settings("splitting", 1e-12, steps_per_rotation, order)
    motion = CoupledRigidBody(body, QUATERNION, MOMENTUM, settings, pair(0.1))
    motion.advance(LENGTH)
    return present(motion.bodies)[0][0]


def inside_rebound(tolerance):
    state = np.empty((2, 6))
    pair(0.1).serialize_particle_data(xyzvxvyvz=state)
    motion = RigidBodyOde(
        np.array([1.0, 0.3]), state[:, :3], state[:, 3:], MOMENTS, QUATERNION, MOMENTUM / MOMENTS, tolerance=tolerance
    )
    motion.integrate(LENGTH)
    return motion.position[1] - motion.position[0]


if __name__ == "__main__":
    with jax.enable_x64(True):
        exact = coupled(8, 30.0)

        def error(place):
            return float(np.linalg.norm(place - exact))

        publish(
            "orbits",
            [
                tabulated(0.05),
                tabulated(0.6),
                *(
                    table(
                        f"Orbit and spin acting on each other, five orbits: order {order}",
                        "steps a rotation",
                        (5.0, 10.0, 20.0),
                        lambda steps, order=order: coupled(order, steps),
                        error,
                        None,
                    )
                    for order in (2, 4, 6, 8)
                ),
                table(
                    "Orbit and spin acting on each other, five orbits: inside REBOUND's interface",
                    "tolerance",
                    (1e-8, 1e-10, 1e-12, TOLERANCE),
                    inside_rebound,
                    error,
                    TOLERANCE,
                ),
            ],
        )
