"""REBOUND's direct sums against the engines' own, and snapshots of a fluid in REBOUND."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.engines import numba_cpu
from astroinertia.gravity.direct import DIRECT_GRAVITY
from astroinertia.orbits.particles import accelerations, of_particles, of_snapshot
from astroinertia.units import GRAVITATIONAL_CONSTANT

COUNT = 1000
POINT = 1e-9  # smoothing length: kernels overlap nowhere, so that gravity is that of points


@pytest.fixture(scope="module")
def particles():
    random = np.random.default_rng(5)
    return random.uniform(0.5, 1.5, COUNT) / COUNT, random.normal(size=(COUNT, 3))


@pytest.mark.parametrize(("gravity", "bound"), [("basic", 5e-15), ("compensated", 2e-15)])
def test_direct_gravity_is_rebounds(particles, gravity, bound):
    mass, position = particles
    engine = numba_cpu.Engine(precision="float64")
    order, arrangement = engine.arrange(position, np.full(COUNT, POINT))
    fields = {
        "mass": mass[order], "position": position[order], "velocity": np.zeros((COUNT, 3)),
        "smoothing_length": np.full(COUNT, POINT),
    }  # fmt: skip
    sums = engine.all_pair_sums(arrangement, "wendland_c2", (DIRECT_GRAVITY,), fields)
    here = np.empty((COUNT, 3))
    here[order] = sums["gravity"]["acceleration"]
    separation = np.linalg.norm(position[:, None] - position[None], axis=-1) + np.diag(np.full(COUNT, np.inf))
    scale = (mass / separation**2).sum(axis=1)  # sum of |a_ij|
    there = accelerations(of_particles(mass, position), gravity)
    # Measured: 1.6e-15 by REBOUND's plain sums, 4e-16 by its compensated ones.
    assert (np.linalg.norm(there - here, axis=1) / scale).max() < bound


def test_a_snapshot_becomes_a_simulation():
    place = [[[0.0, 0.0, 0.0], [1.5e11, 0.0, 0.0]], [[0.0, 0.0, 0.0], [0.0, 1.5e11, 0.0]]]
    speed = [[[0.0, 0.0, 0.0], [0.0, 3e4, 0.0]], [[0.0, 0.0, 0.0], [-3e4, 0.0, 0.0]]]
    each = ("snapshot_time", "particle")
    snapshots = xr.Dataset(
        {"mass": (each, [[2e30, 6e24]] * 2), "position": ((*each, "i"), place), "velocity": ((*each, "i"), speed)},
        coords={"snapshot_time": [0.0, 8e6]},
    )
    bodies = of_snapshot(snapshots.isel(snapshot_time=1))
    assert (bodies.t, bodies.G, bodies.N) == (8e6, GRAVITATIONAL_CONSTANT, 2)
    assert bodies.particles[1].xyz == [0.0, 1.5e11, 0.0]
    assert bodies.particles[1].vxyz == [-3e4, 0.0, 0.0]
    year = bodies.particles[1].orbit(primary=bodies.particles[0]).P
    assert year == pytest.approx(3.156e7, rel=0.05)
    with pytest.raises(ValueError, match="choose one"):
        of_snapshot(snapshots)


def test_particles_that_do_not_fit_together_are_refused():
    with pytest.raises(ValueError, match="do not go with"):
        of_particles(np.ones(3), np.zeros((2, 3)))
    with pytest.raises(ValueError, match=r"masses \(\) do not go with positions \(3, 3\)"):
        of_particles(1.0, np.eye(3))
    with pytest.raises(ValueError, match="not finite"):
        of_particles(np.ones(2), np.array([[0.0, 0.0, np.nan], [1.0, 0.0, 0.0]]))
