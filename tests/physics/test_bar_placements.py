"""How fast bars grow from several placements of the particles, with somewhat more neighbours than the kernel's own."""

from typing import Any

import numpy as np
import pytest

from astroinertia.bodies.rotating_modes import bar_mode
from astroinertia.studies.bar_mode import bar_growth
from astroinertia.studies.spinup import spin_up
from tests.physics.test_bar_mode import SCENE, star

SEEDS = (0, 1, 2, 3)


@pytest.mark.full(inputs=["sims/bar_mode.toml"])
@pytest.mark.parametrize(("t_over_w", "end"), [(0.28, 22.0), (0.29, 14.0)])
def test_with_100_neighbours_bars_grow_at_their_stars_rate_however_particles_are_placed(
    t_over_w: float, end: float, result: Any
) -> None:
    """n = 0.5, 3000 particles: each within 5 % of the exact mode (7 % too slow with the kernel's own 74 at 0.28)."""
    exact, errors = bar_mode(star(0.5, t_over_w), 3.0), []
    for seed in SEEDS:
        chosen = {"body.t_over_w": t_over_w, "time.end": end, "body.seed": seed, "numerics.neighbours": 100}
        found = bar_growth(spin_up(SCENE, settings=[f"{key}={value}" for key, value in chosen.items()]))
        errors.append(found.growth_rate / exact.growth_rate - 1)
        assert abs(found.pattern_speed / exact.pattern_speed - 1) <= 0.02
    result(growth_rate_errors=errors, mean=float(np.mean(errors)), scatter=float(np.std(errors, ddof=1)))
    assert max(map(abs, errors)) <= 0.05
