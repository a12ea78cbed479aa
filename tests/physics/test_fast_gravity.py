"""A fluid under gravity by multipoles: what direct sums give, to the force error, with no net force."""

import numpy as np
import pytest

from astroinertia.build import assemble
from astroinertia.models.sph.evaluate import virial_tensors
from astroinertia.scene.load import load_file
from tests.checks_of_effects import net_force, virial_mismatch

COUNT, STEPS, FORCE_ERROR = 3000, 3, 2e-4
SCENE = [
    f"body.particles={COUNT}", 'body.placement="random"', "numerics.precision=float64",
    f"effects.gravity.force_error={FORCE_ERROR}",
]  # fmt: skip


@pytest.mark.full(inputs=["sims/evrard.toml"])
def test_a_few_steps_are_those_of_direct_sums_and_keep_momentum():
    runs = {}
    for method in ("direct", "multipole"):
        evolution = assemble.prepare(
            load_file("sims/evrard.toml", [*SCENE, f'effects.gravity.method="{method}"'])
        ).evolution
        for _ in range(STEPS):
            evolution.advance(1.0)
        runs[method] = evolution
    direct, fast = (evolution.state for evolution in runs.values())
    back = [np.argsort(state.identity) for state in (direct, fast)]
    a, b = (s.rates.fluid.sums["gravity"]["acceleration"][k] for s, k in zip((direct, fast), back, strict=True))
    errors = np.linalg.norm(b - a, axis=1) / np.linalg.norm(a, axis=1)
    assert np.sqrt(np.mean(errors**2)) < 3.0 * FORCE_ERROR
    assert net_force(fast.mass, fast.rates.fluid.sums["gravity"]["acceleration"]) < 1e-13
    evolution = runs["multipole"]
    tensor = virial_tensors(evolution.problem, evolution.arrangement, fast.rates.fluid)["gravity"]
    relative = fast.position - (fast.mass @ fast.position) / fast.mass.sum()
    assert virial_mismatch(fast.mass, relative, fast.rates.fluid.sums["gravity"]["acceleration"], tensor) < FORCE_ERROR
