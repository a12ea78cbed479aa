"""Particles of a fluid in REBOUND: its own sums of their gravity, and simulations that start from a snapshot."""

from ctypes import byref
from typing import Any

import numpy as np
import rebound

from astroinertia.process.quantities import with_quantities
from astroinertia.units import GRAVITATIONAL_CONSTANT

Array = Any


@with_quantities()
def of_particles(
    mass: Array, position: Array, velocity: Array | None = None, gravitational_constant: float = 1.0,
    softening: float = 0.0,
) -> rebound.Simulation:  # fmt: skip
    """Masses (N,) at positions (N, 3) with velocities (N, 3), at rest without them, in any consistent units.

    softening is Plummer's, the same for all. ValueError where the numbers of particles differ or anything is not
    finite. Checked by tests/unit/orbits/test_particles.py.

    >>> print(of_particles(np.ones(3), np.eye(3)).N)
    3
    """
    masses, places = np.array(mass, dtype=float), np.array(position, dtype=float)
    speeds = np.zeros_like(places) if velocity is None else np.array(velocity, dtype=float)
    if masses.ndim != 1 or places.shape != (len(masses), 3) or speeds.shape != places.shape:
        raise ValueError(
            f"masses {masses.shape} do not go with positions {places.shape} and velocities {speeds.shape}: they are "
            "(N,), (N, 3) and (N, 3)"
        )
    if not all(np.isfinite(part).all() for part in (masses, places, speeds)):
        raise ValueError("a particle has a mass, a position or a velocity that is not finite")
    bodies = rebound.Simulation()
    bodies.G, bodies.softening = gravitational_constant, softening
    for particle_mass in masses:
        bodies.add(m=particle_mass)
    bodies.set_serialized_particle_data(xyz=places, vxvyvz=speeds)
    return bodies


@with_quantities()
def of_snapshot(snapshot: Any, gravitational_constant: float = GRAVITATIONAL_CONSTANT) -> rebound.Simulation:
    """The particles of one snapshot: a `dataset.open_snapshots` Dataset at one snapshot_time, in SI and at its time.

    A dimensionless run is in code units, and wants a gravitational constant of 1.

    >>> print(of_snapshot(ds.inertia.snapshots.isel(snapshot_time=-1)).N)
    100
    """
    if "snapshot_time" in snapshot["mass"].dims:
        raise ValueError("several snapshots are given: choose one, as by snapshots.isel(snapshot_time=-1)")
    there = np.isfinite(snapshot["mass"].values)  # what sinks have accreted is NaN
    mass, position, velocity = (snapshot[name].values[there] for name in ("mass", "position", "velocity"))
    bodies = of_particles(mass, position, velocity, gravitational_constant)
    bodies.t = float(snapshot["snapshot_time"])
    return bodies


def accelerations(bodies: rebound.Simulation, gravity: str = "compensated") -> np.ndarray:
    """REBOUND's own direct sum of the gravity on every particle, (N, 3): "compensated" or "basic".

    >>> print(accelerations(of_particles(np.ones(2), np.array([[0.0, 0, 0], [2.0, 0, 0]])))[0])  # 1/r^2
    [0.25 0.   0.  ]
    """
    bodies.gravity = gravity
    rebound.clibrebound.reb_simulation_update_acceleration(byref(bodies))
    return np.array([[particle.ax, particle.ay, particle.az] for particle in bodies.particles])
