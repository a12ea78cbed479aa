"""A million rotations of a free asymmetric body by the splitting: what is kept, and that nothing drifts."""

import jax
import numpy as np
import pytest

from astroinertia.models.rigid.evolution import Settings
from tests.rigid import attitude, under_way

MOMENTS, SPIN = np.array([1.0, 2.0, 3.0]), np.array([0.1, 1.0, 0.1])
LOOKS = 200


@pytest.mark.full
def test_a_million_rotations_leave_energy_and_angular_momentum(result):
    with jax.enable_x64(True):
        run = under_way(MOMENTS, SPIN, settings=Settings("splitting", order=8, steps_per_rotation=30.0))
        start = MOMENTS * SPIN
        size, opening = np.linalg.norm(start), 0.5 * start @ SPIN
        end = 1e6 * 2.0 * np.pi / np.linalg.norm(SPIN)
        energy, momentum, orthogonality = [], [], []
        for look in range(1, LOOKS + 1):
            run.advance(end * look / LOOKS)
            axes, m = attitude(run), np.asarray(run.state.momentum_in_body)
            rates = m / MOMENTS
            energy.append(0.5 * (MOMENTS * rates**2).sum() / opening - 1.0)
            momentum.append(np.abs(axes.T @ (MOMENTS * rates) - start).max() / size)
            orthogonality.append(abs(float((run.state.quaternion**2).sum()) - 1.0))
    first, last = np.mean(energy[: LOOKS // 4]), np.mean(energy[-LOOKS // 4 :])
    result(
        steps=run.steps, largest_energy_error=max(map(abs, energy)), energy_drift=last - first,
        largest_momentum_error=max(momentum), largest_norm_error=max(orthogonality), energy_error=energy,
        momentum_error=momentum,
    )  # fmt: skip
    assert max(map(abs, energy)) < 1e-12
    assert abs(last - first) < 2e-13
    assert max(momentum) < 1e-12
    assert max(orthogonality) < 1e-15
