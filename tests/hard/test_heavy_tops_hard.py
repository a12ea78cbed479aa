"""Heavy tops of every shape and speed, next to the vertical and to the limit of sleep: what gravity keeps is kept."""

import numpy as np
import pytest

from astroinertia.rotation import heavy_top


def random_tops(count):
    generator = np.random.default_rng(4)
    for _ in range(count):
        transverse, torque = 10 ** generator.uniform(-3, 3), 10 ** generator.uniform(-4, 4)
        axial = transverse * 10 ** generator.uniform(-4, 0.3)
        near = 10 ** generator.uniform(-12, 0)
        tilt = generator.choice([generator.uniform(0, np.pi), near, np.pi - near])
        rates = generator.normal(size=3) * 10 ** generator.uniform(-3, 3) * 10 ** generator.uniform(-5, 0, 3)
        if generator.random() < 0.3:
            rates[generator.integers(3)] = 0.0
        if generator.random() < 0.3:  # next to the limit of sleep
            limit = heavy_top.least_sleeping_spin(transverse, axial, torque)
            rates[2] = limit * (1.0 + generator.choice([-1, 1]) * 10 ** generator.uniform(-12, 0))
        yield transverse, axial, torque, tilt, rates


def test_any_top_keeps_energy_and_angular_momentum_for_a_million_nutations():
    for transverse, axial, torque, tilt, rates in random_tops(300):
        with np.errstate(all="raise", under="ignore"):
            top = heavy_top.heavy_top(transverse, axial, torque, tilt, rates)
            times = heavy_top.nutation_period(top) * np.array([0.0, 0.1, 0.25, 0.5, 0.77, 3.3, 1e6 + 0.2])
            turned, attitude = heavy_top.body_angular_velocity(top, times), heavy_top.attitude(top, times)
        momentum = turned * np.array([transverse, transverse, axial])
        energy = 0.5 * (momentum * turned).sum(-1) + torque * attitude[:, 2, 2]
        upwards = (momentum * attitude[:, :, 2]).sum(-1)
        largest = abs(momentum).max()
        np.testing.assert_allclose(turned[0], rates, rtol=0, atol=1e-14 * abs(rates).max())
        np.testing.assert_allclose(
            energy, energy[0], rtol=0, atol=1e-14 * (abs(momentum * turned).sum(-1).max() + torque)
        )
        np.testing.assert_allclose(upwards, upwards[0], rtol=0, atol=1e-14 * largest)
        assert heavy_top.tilt(top, 0.0) == pytest.approx(tilt, rel=1e-14)
