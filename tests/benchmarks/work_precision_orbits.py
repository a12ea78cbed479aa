"""What accuracy of orbits costs: in tables of positions, and where body and companion act on each other."""

import sys
from pathlib import Path

import jax
import numpy as np
from precision_table import publish, table

from astroinertia.models.rigid.evolution import Settings
from astroinertia.orbits.rigid_ode import TOLERANCE, RigidBodyOde
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.rotation.ephemeris import ephemeris

sys.path.insert(0, str(Path(__file__).parents[2]))  # run as a script: the tests' own bodies are beside it

from tests.coupled import coupled, places

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


def together(settings):
    motion = coupled(pair(0.1), MOMENTS, QUATERNION, MOMENTUM, settings)
    motion.advance(LENGTH)
    return places(motion)[0]


def split(order, steps_per_rotation):
    return together(Settings("splitting", 1e-12, steps_per_rotation, order))


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
        exact = split(8, 60.0)

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
                        (5.0, 10.0, 20.0, 40.0),
                        lambda steps, order=order: split(order, steps),
                        error,
                        40.0 if order == 8 else None,
                    )
                    for order in (2, 4, 6, 8)
                ),
                table(
                    "Orbit and spin acting on each other, five orbits: adaptively",
                    "tolerance",
                    (1e-8, 1e-10, 1e-12, 1e-14),
                    lambda tolerance: together(Settings("adaptive", tolerance)),
                    error,
                    1e-12,
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
