"""What the liquid's bar grows by in the window that a star's is measured in, begun by the same seed."""

import math

import pytest

from astroinertia.bodies import maclaurin
from astroinertia.bodies.ellipsoid_stability import spectrum
from astroinertia.studies.bar_mode import bar_growth
from astroinertia.studies.spinup import spin_up

SCENE = """
name = "liquid_bar"
model = "ellipsoid"
units = "code"
[body]
kind = "uniform"
mass = 1.0
radius = 1.0
axes = [{a}, {b}, {c}]
[body.rotation]
angular_momentum = {momentum}
[equation_of_state]
kind = "incompressible"
[effects.gravity]
[effects.pressure]
[time]
end = {end}
[output]
series_every = 0.1
"""


@pytest.mark.full
@pytest.mark.parametrize(("t_over_w", "seed", "end", "early", "late"), [
    (0.28, 0.005, 40.0, 0.053, -0.022), (0.28, 0.0005, 70.0, -0.019, -0.048), (0.29, 0.005, 25.0, 0.018, -0.017),
])  # fmt: skip
def test_a_bar_that_begins_at_rest_grows_as_sinh_and_less_the_larger_it_is(tmp_path, t_over_w, seed, end, early, late):
    """Growth from eta = 0.05 to 0.15 and from 0.1 to 0.2 beside that of the linear mode.

    What is bent but does not move in the turning fluid begins with the decaying mode as large as the growing one.
    """
    liquid = maclaurin.from_energy_ratio(t_over_w)
    wide, bent = liquid.axes[0], 0.5 * seed
    momentum = liquid.polar_moment * liquid.angular_velocity * (1 + bent**2)
    path = tmp_path / "liquid.toml"
    path.write_text(
        SCENE.format(a=wide * (1 + bent), b=wide * (1 - bent), c=liquid.axes[2], momentum=momentum, end=end)
    )
    series, linear = spin_up(path), spectrum(liquid).growth_rate
    found = [bar_growth(series, *window).growth_rate / linear - 1 for window in ((0.05, 0.15), (0.1, 0.2))]
    assert found == pytest.approx([early, late], abs=0.004)
    assert math.isclose(float(series["bar_strength"][0]), seed, rel_tol=2e-3)
