"""Core collapse by the name of a model: names, initial stars, scenes, and what is said of a bounce."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from astroinertia import dataset as datasets
from astroinertia.bodies.rotating_star import rotating_star
from astroinertia.bodies.rotation_laws import RotationLaw
from astroinertia.errors import SceneError
from astroinertia.matter.barotropes import polytropic_matter
from astroinertia.scene.load import loads
from astroinertia.studies import core_collapse
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS, SPEED_OF_LIGHT

OLD_RUN = Path(__file__).parents[2] / "data" / "format_1.nc"


@pytest.mark.parametrize("name", ["", "A1B3", "A5B1G1", "A1B3G6", "B3G1", "A1G1", "a1b3g1", "A1B3G1 ", "N1", "G13"])
def test_other_names_are_refused(name):
    with pytest.raises(SceneError, match="a core has a name such as A1B3G3"):
        core_collapse.core_model(name)


def test_a_core_at_rest_has_the_mass_and_radius_of_its_constant_and_density():
    """M = 4 pi (K/(pi G))^(3/2) 2.01824, R = 6.89685 (K/(pi G))^(1/2) rho^(-1/3) of the n = 3 polytrope (Chandrasekhar
    1939), with K = 4.897e14 and rho = 1e10 in cgs.
    """
    mass, radius, ratio = core_collapse.initial_star(core_collapse.core_model("G1"))
    unit = 4.897e14 / (math.pi * GRAVITATIONAL_CONSTANT * 1e3)  # K/(pi G) in cgs
    assert mass * 1e3 == pytest.approx(4 * math.pi * unit**1.5 * 2.018236, rel=1e-6)
    assert radius * 1e2 == pytest.approx(6.896849 * math.sqrt(unit) * 1e10 ** (-1 / 3), rel=1e-6)
    assert ratio == 1.0
    assert mass / SOLAR_MASS == pytest.approx(1.4396, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["A3B2G1"])
def test_a_turning_core_has_its_constant_its_density_and_its_rotation(name):
    """From the scene's star itself: K and the central density, which decide mass and radius with the rotation."""
    scene = loads(core_collapse.core_scene(name))
    body: Any = scene.body
    law = RotationLaw("j_constant", body.scale / body.radius)
    star = rotating_star(polytropic_matter(3.0), body.axis_ratio, law, body.mass, body.radius, GRAVITATIONAL_CONSTANT)
    assert star.rotational_to_gravitational == pytest.approx(core_collapse.ROTATIONS[name[2:4]], rel=1e-5)
    assert star.max_pressure / star.max_density ** (4 / 3) == pytest.approx(4.897e13 / 1e3 ** (4 / 3), rel=1e-4)
    assert float(star.density(0.0, 0.0)) == pytest.approx(1e13, rel=1e-4)


def test_the_scene_keeps_the_constant_in_cgs_whatever_the_exponent():
    for name, gamma in (("G1", 1.325), ("G5", 1.28)):
        fluid: Any = loads(core_collapse.core_scene(name)).equation_of_state
        assert fluid.gamma_1 == gamma
        assert fluid.constant * 1e3**gamma == pytest.approx(4.897e13, rel=1e-12)


@pytest.mark.parametrize(("name", "effects"), [("G15", {"relativistic_potential"}), ("N13", set()), ("G3", None)])
def test_a_core_that_loses_electrons_has_the_exponent_of_electrons_and_its_fit(name, effects):
    scene = loads(core_collapse.core_scene(name))
    others = {"gravity", "pressure", "viscosity"}
    assert set(scene.effects) == others | (set() if effects is None else effects | {"deleptonisation"})
    if effects is not None:
        fluid: Any = scene.equation_of_state
        assert scene.effects["deleptonisation"]["fit"] == name
        assert fluid.gamma_1 == pytest.approx(4 / 3, rel=1e-15)
        assert fluid.constant * 1e3 ** (4 / 3) == pytest.approx(4.897e13, rel=1e-12)


def series(*turning_points):
    """Density along time through turning points (ms, 1e14 g/cm^3), smooth in between."""
    times, values = np.array(turning_points, dtype=float).T
    time = np.linspace(0, times[-1], 4001)
    share = np.interp(time, times, np.arange(len(times)))
    whole = np.minimum(share.astype(int), len(times) - 2)
    smooth = 0.5 - 0.5 * np.cos(np.pi * (share - whole))
    return 1e-3 * time, 1e17 * (values[whole] + smooth * (values[whole + 1] - values[whole]))


def test_the_type_of_a_collapse_follows_its_density_and_its_signal():
    """One bounce with ringing, several coherent ones, a signal without a negative peak, and no bounce at all."""
    time, density = series((0, 0), (40, 4), (42, 2.5), (44, 3), (60, 2.8))
    spike = np.exp(-(((time - 0.04) / 5e-4) ** 2))
    assert core_collapse.dynamics(time, density, -3 * spike)[0] == "regular"
    assert core_collapse.dynamics(time, density, 3 * spike)[0] == "rapid"
    _, at = core_collapse.dynamics(time, density, -3 * spike)
    assert time[at] == pytest.approx(0.04, abs=2e-5)
    time, density = series((0, 0), (80, 1), (95, 0.05), (110, 0.8), (125, 0.06), (140, 0.6), (150, 0.3))
    assert core_collapse.dynamics(time, density, 0 * time)[0] == "multiple bounce"
    time, density = series((0, 0), (80, 1), (120, 0.05), (150, 0.3))  # falls again, and the run ends
    assert core_collapse.dynamics(time, density, 0 * time)[0] == "multiple bounce"
    time, density = series((0, 0), (80, 1), (140, 0.05))  # torn apart: it never falls again
    assert core_collapse.dynamics(time, density, -time)[0] == "regular"
    assert core_collapse.dynamics(time, 1e13 + time, 0 * time) == ("no bounce", None)


def test_the_wave_amplitude_is_that_of_the_quadrupole_formula():
    """A20 = 8 (pi/15)^(1/2) G/c^4 (d2Q_zz/dt2 - d2Q_yy/dt2) seen along the x axis, from a run's own tensors."""
    found = core_collapse.with_bounce(datasets.open(OLD_RUN).load())
    bent = found.inertia_acceleration.transpose("time", "i", "j").values
    # d2I = tr(d2Q) - d2Q, so differences of the diagonal change sign.
    wanted = 8 * math.sqrt(math.pi / 15) * GRAVITATIONAL_CONSTANT / SPEED_OF_LIGHT**4 * (bent[:, 1, 1] - bent[:, 2, 2])
    np.testing.assert_allclose(found.gw_amplitude, wanted, rtol=1e-6, atol=1e-9 * abs(wanted).max())
    assert found.rotational_share.attrs["units"] == "1"
