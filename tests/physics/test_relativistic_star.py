"""A cold neutron star of particles under the effective relativistic potential, beside the star of its equations."""

from pathlib import Path

import numpy as np
import pytest

from tests.effective_star import effective_star
from tests.evolve import evolve, prepared
from tests.unit.effects.test_relativistic_potential import SLY

SCENE = (Path(__file__).parents[2] / "sims" / "neutron_star.toml").read_text()
SOLAR, UNIT = 1.98841e30, 1476.625  # kg, and G Msun/c^2 in m
MASS, RADIUS = 1.54624, 12400.0  # of the scene: solar masses of rest mass, m


def settled(count: int, *settings: str) -> tuple[float, float]:
    """Greatest density and rms radius at the end of the scene, over those of the star of its equations."""
    star = effective_star(SLY, MASS)
    middle = 0.5 * (star.radius[1:] ** 2 + star.radius[:-1] ** 2)
    size = np.sqrt(np.diff(star.rest_mass) @ middle / star.rest_mass[-1]) * UNIT / RADIUS
    density = star.density[0] / MASS * (RADIUS / UNIT) ** 3
    body = prepared(SCENE, f"body.particles={count}", *settings)
    (last,) = evolve(body, [0.6e-3 / 9.63914e-05])
    spread = np.trace(last["inertia_tensor"]) / 2.0
    return float(last["density_max"]) / density, float(np.sqrt(spread)) / size


def test_five_hundred_particles_have_its_density_and_size() -> None:
    dense, wide = settled(500)
    assert dense == pytest.approx(1.0, abs=0.04)
    assert wide == pytest.approx(1.0, abs=0.02)


@pytest.mark.full(inputs=["sims/neutron_star.toml"])
def test_ten_thousand_particles_have_its_density_and_size(result) -> None:
    dense, wide = settled(10_000)
    result(density=dense, size=wide)
    assert dense == pytest.approx(1.0, abs=0.03)
    assert wide == pytest.approx(1.0, abs=0.01)
