"""Friction makes a star beyond the secular limit triaxial: at the rate of its own viscous bar mode, to turn rigidly."""

import math
from pathlib import Path
from typing import Any

import pytest

from astroinertia.bodies import jacobi
from astroinertia.bodies.rotating_modes import bar_mode
from astroinertia.bodies.rotating_star import rotating_star_with
from astroinertia.matter.barotropes import polytropic_matter
from astroinertia.studies.bar_mode import bar_growth
from astroinertia.studies.spinup import spin_up

SCENE = Path(__file__).parents[2] / "sims" / "jacobi_by_viscosity.toml"


@pytest.mark.full(inputs=["sims/jacobi_by_viscosity.toml"])
@pytest.mark.parametrize("particles", [1000, 3000])
def test_viscosity_makes_a_star_triaxial(particles: int, result: Any) -> None:
    """Rates of the star's viscous bar mode; at the end rigid rotation, nearly as the Jacobi ellipsoid of the same L."""
    series = spin_up(SCENE, settings=[f"body.particles={particles}"])
    star = rotating_star_with("rotational_to_gravitational", 0.18, polytropic_matter(0.25))
    found, exact = bar_growth(series, 0.08, 0.2), bar_mode(star, 5.0, 0.02, 5 / 3)
    growth, pattern = found.growth_rate / exact.growth_rate - 1, found.pattern_speed / exact.pattern_speed - 1
    end = series.isel(time=-1)
    spin, turning = float(end["angular_velocity"][2]), float(end["bar_pattern_speed"])
    liquid = jacobi.from_angular_momentum(star.angular_momentum / math.sqrt(star.mean_radius))
    long, across = liquid.axes[0] ** 2, liquid.axes[1] ** 2
    strength = float(end["bar_strength"]) / ((long - across) / (long + across)) - 1
    share = float(end["rotational_to_gravitational"]) / liquid.rotational_to_gravitational - 1
    result(**found._asdict(), growth_rate_error=growth, pattern_speed_error=pattern, spin_over_pattern=spin / turning)
    result(bar_strength_error=strength, t_over_w_error=share)
    # 1000 particles grow 25 % too fast, and end with a longer bar than a liquid's by 12 % (measured)
    assert abs(growth) < 0.35 and abs(pattern) < 0.02
    assert spin == pytest.approx(turning, rel=0.02)
    assert abs(share) < 0.03 and abs(strength) < 0.2
