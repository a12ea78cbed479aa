"""The study of spin-up: tables of cases, shells, limits of a run; the same scene by more than one model."""

import math

import numpy as np
import pytest

from astroinertia.bodies.bar_limits import DYNAMICAL, SECULAR
from astroinertia.bodies.polytrope import Polytrope
from astroinertia.errors import SceneError
from astroinertia.scene import load
from astroinertia.studies import spinup

SCENE = """
name = "shrinking"
model = "scaling"
[body]
kind = "polytrope"
index = 1.5
mass = "1.4 Msun"
radius = "1500 km"
[body.rotation]
period = "2 s"
[body.change]
times = ["1 s"]
factors = [0.01]
[effects.gravity]
[effects.pressure]
[time]
end = "1 s"
[output]
series_every = "0.1 s"
"""


def test_periods_follow_the_radius():
    dataset = spinup.period_against_radius()
    for number, case in enumerate(spinup.cases()):
        row = dataset.isel(case=number)
        assert float(row["period"][0]) == pytest.approx(case.period, rel=1e-13)
        fall = case.moment_ratio / case.moment_ratio_after * (case.radius / case.radius_after) ** 2
        assert float(row["period"][-1]) == pytest.approx(case.period / fall, rel=1e-12)
        ends = row["period"].values <= row["kepler_period"].values
        np.testing.assert_array_equal(row["beyond_kepler"].values, ends)
    flagged = dict(zip(dataset["case"].values, dataset["beyond_kepler"].values[:, -1], strict=True))
    assert [name for name, value in flagged.items() if value] == ["cloud to a disc"]
    # The cloud stops at some tens of au, the radius of its disc.
    assert float(dataset.sel(case="cloud to a disc")["barrier_radius"]) / 1.495978707e11 == pytest.approx(28.3, abs=0.2)
    with pytest.raises(SceneError, match="no case"):
        spinup.period_against_radius([])


def test_shells_of_a_core():
    dataset = spinup.shell_collapse(period="20 s")
    expected = Polytrope(3.0).moment_of_inertia * 1.4 * 1.988409870698051e30 * 1.5e6**2 * 2 * math.pi / 20
    assert dataset.attrs["angular_momentum"] == pytest.approx(expected, rel=1e-9)
    np.testing.assert_allclose(dataset["spectrum_after"], dataset["spectrum"], rtol=1e-12)
    assert dataset.attrs["rotational_energy_after"] - dataset.attrs["rotational_energy_rigid"] == pytest.approx(
        dataset.attrs["shear_energy"], rel=1e-9
    )
    slow, fast = (bool(spinup.shell_collapse(period=value)["critical"].any()) for value in ("20 s", "0.5 s"))
    assert (slow, fast) == (False, True)
    with pytest.raises(SceneError, match="must be positive"):
        spinup.shell_collapse(period=-1.0)
    with pytest.raises(SceneError, match="not a time"):
        spinup.shell_collapse(period="3 km")


@pytest.mark.slow
def test_a_scene_comes_back_with_its_limits(tmp_path):
    file = tmp_path / "shrinking.toml"
    file.write_text(SCENE)
    dataset = spinup.spin_up(file)
    period = dataset["period"].values
    assert period[0] == pytest.approx(2.0, rel=1e-12) and period[-1] == pytest.approx(0.02, rel=1e-12)
    assert float(dataset["radius"][0]) == pytest.approx(1.5e6) and float(dataset["radius"][-1]) == pytest.approx(1.5e5)
    kepler = 2 * math.pi * math.sqrt(1.5e5**3 / (6.6743e-11 * float(dataset["mass"][0])))
    assert float(dataset["kepler_period"][-1]) == pytest.approx(kepler, rel=1e-12)
    assert float(dataset["kepler_fraction"][-1]) == pytest.approx(kepler / 0.02, rel=1e-12)
    np.testing.assert_array_equal(dataset["beyond_kepler"], dataset["kepler_fraction"] > 1)
    np.testing.assert_array_equal(dataset["sheds_mass"], period < dataset["shedding_period"].values)
    ratio = dataset["rotational_to_gravitational"].values
    np.testing.assert_array_equal(dataset["secularly_unstable"], ratio > SECULAR)
    np.testing.assert_array_equal(dataset["dynamically_unstable"], ratio > DYNAMICAL)
    assert dataset["sheds_mass"].values.any() and not dataset["sheds_mass"].values.all()
    # Kept where it is asked for, and the same from a Scene with a setting.
    kept = spinup.spin_up(load.loads(SCENE), settings=["body.rotation.period=4 s"], folder=tmp_path / "run")
    assert float(kept["period"][0]) == pytest.approx(4.0, rel=1e-12)
    assert (tmp_path / "run" / "shrinking.nc").exists()


@pytest.mark.full
def test_a_core_becomes_a_neutron_star():
    dataset = spinup.core_to_neutron_star(equations_of_state=("SLy",))
    names = [str(name) for name in dataset["remnant"].values]
    period = dict(zip(names, dataset["period"].values, strict=True))
    # 100 s and 1500 km give tens of milliseconds, whatever is assumed of the star.
    assert all(0.02 < value < 0.035 for value in period.values())
    momentum = dataset["moment_of_inertia"] * 2 * math.pi / dataset["period"]
    np.testing.assert_allclose(momentum, float(momentum[0]), rtol=1e-9)
    assert not dataset["sheds_mass"].values.any()
    # The exact rotating figure swells, so that it is slower than its sphere; stars of real matter keep their baryons.
    assert period["polytrope n = 1, rotating figure"] > period["polytrope n = 1"]
    light = dataset.sel(remnant="SLy, TOV and Hartle")
    assert 0.9 < float(light["mass"]) / float(dataset["mass"][0]) < 0.93
    fast = spinup.core_to_neutron_star(core_period="3 s", equations_of_state=())
    flags = dict(zip((str(name) for name in fast["remnant"].values), fast["sheds_mass"].values, strict=True))
    assert flags["polytrope n = 1"] and not flags["polytrope n = 1, rotating figure"]
    faster = spinup.core_to_neutron_star(core_period="1 s", equations_of_state=())
    figure = faster.sel(remnant="polytrope n = 1, rotating figure")
    assert bool(figure["sheds_mass"]) and np.isnan(figure["period"])


@pytest.mark.slow
def test_a_white_dwarf_that_collapses():
    dataset = spinup.core_to_neutron_star("1.4 Msun", None, "1 h", equations_of_state=())
    # Cold electrons at 1.4 solar masses: some 2000 km, and a moment ratio between those of n = 1.5 and n = 3.
    assert dataset.attrs["core_radius"] == pytest.approx(2.0e6, rel=0.25)
    assert Polytrope(3.0).moment_of_inertia < dataset.attrs["core_moment_ratio"] < Polytrope(1.5).moment_of_inertia
    fall = dataset.attrs["core_moment_ratio"] * (dataset.attrs["core_radius"] / 12e3) ** 2 / 0.4
    assert float(dataset["period"][0]) == pytest.approx(3600 / fall, rel=1e-9)
    with pytest.raises(SceneError, match="no such white dwarf"):
        spinup.core_to_neutron_star("1.6 Msun", None, "1 h", equations_of_state=())
