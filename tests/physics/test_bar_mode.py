"""Stars turn into bars above T/|W| = 0.27, as fast as liquids do, and stay round below."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from astroinertia.bodies.maclaurin_momentum import maclaurin_momentum_star_with
from astroinertia.bodies.scf_matter import polytropic_matter
from astroinertia.studies.bar_mode import bar_growth
from astroinertia.studies.spinup import spin_up

SCENE = Path(__file__).parents[2] / "sims" / "bar_mode.toml"


def central_period(t_over_w: float) -> float:
    """2 pi/Omega on the axis, in units of the scene (M = R_equatorial = 1)."""
    star = maclaurin_momentum_star_with("rotational_to_gravitational", t_over_w, polytropic_matter(0.5))
    return 2 * math.pi / star.angular_velocity


def test_rates_are_those_of_the_lines_they_are_fitted_to() -> None:
    """A made-up bar of known growth and pattern speed; the liquid with T/|W| = 0.29 grows at 0.1842 (|W|/I)^(1/2)."""
    time = np.linspace(0, 10, 101)
    strength, one = 0.02 * np.exp(0.3 * time), np.ones_like(time)
    series = xr.Dataset(
        {
            "bar_strength": ("time", strength),
            "bar_phase": ("time", np.angle(np.exp(2j * (0.6 * time + 1.0))) / 2),
            "gravitational_energy": ("time", -0.9 * one),
            "kinetic_energy": ("time", 0.9 * 0.29 * one),
            "inertia_tensor": (("time", "i", "j"), 0.4 * np.eye(3) * one[:, None, None]),
        },
        {"time": time, "i": list("xyz"), "j": list("xyz")},
    )
    found = bar_growth(series)
    assert found.growth_rate == pytest.approx(0.3)
    assert found.pattern_speed == pytest.approx(0.6)
    assert found.maclaurin_growth_rate == pytest.approx(0.18423 * 1.5, rel=1e-4)
    assert found.maclaurin_pattern_speed == pytest.approx(0.5 * math.sqrt(2 * 0.29) * 1.5)  # T = I Omega^2/2
    assert 0.05 <= 0.02 * math.exp(0.3 * found.begin) < 0.052
    with pytest.raises(ValueError, match=r"never came to a distortion of 0\.9"):
        bar_growth(series, high=0.9)


@pytest.mark.full(inputs=["sims/bar_mode.toml"])
@pytest.mark.parametrize("particles", [1000, 3000, 10_000, 30_000])
@pytest.mark.parametrize("t_over_w", [0.28, 0.29])
def test_a_bar_grows_and_turns_as_a_liquids(t_over_w: float, particles: int, result: Any) -> None:
    """Growth rate and pattern speed within 10 % of the Maclaurin spheroid's with the same T/|W|."""
    chosen = [f"body.particles={particles}", f"body.t_over_w={t_over_w}", "time.end=24"]
    found = bar_growth(spin_up(SCENE, settings=chosen))
    growth = found.growth_rate / found.maclaurin_growth_rate - 1
    pattern = found.pattern_speed / found.maclaurin_pattern_speed - 1
    result(**found._asdict(), growth_rate_error=growth, pattern_speed_error=pattern)
    assert abs(pattern) <= 0.1
    assert abs(growth) <= (0.1 if particles >= 3000 else 0.25)


@pytest.mark.full(inputs=["sims/bar_mode.toml"])
@pytest.mark.parametrize("particles", [3000, 10_000])
def test_a_slower_star_stays_round(particles: int, result: Any) -> None:
    """T/|W| = 0.20: over ten central periods the m = 2 amplitude stays below 3 times that at the start."""
    end = 10 * central_period(0.2)
    chosen = [f"body.particles={particles}", "body.t_over_w=0.2", f"time.end={end}"]
    strength = spin_up(SCENE, settings=chosen)["bar_strength"].values
    result(largest_over_first=strength.max() / strength[0], last_over_first=strength[-1] / strength[0])
    assert strength.max() < 3 * strength[0]
