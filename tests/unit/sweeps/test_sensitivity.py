"""Sensitivities against laws of conservation and of scaling, and what is refused."""

import numpy as np
import pytest

import astroinertia
from astroinertia.cli.main import main
from astroinertia.errors import SceneError
from astroinertia.sweeps.ensemble import run_sweep
from astroinertia.sweeps.sensitivity import sensitivity, sensitivity_sweep
from tests.plugin_example import EXAMPLE, distribution
from tests.sims import SIMS

FILE = SIMS / "core_to_pulsar_scaling.toml"
CORE = astroinertia.load(FILE, ["output.series_every=10 ms"])
TURNING = """
name = "turning"
model = "rigid"
units = "code"
[body]
kind = "rigid"
mass = 1.0
moments = [1.0, 2.0, 2.5]
rotation = { rate = 0.7 }
[effects]
[observables.quadrupole_phase]
[time]
end = 1.0
[output]
series_every = 0.5
"""


@pytest.fixture(scope="module")
def core(tmp_path_factory):
    """The result of a sweep about the core, of two keys."""
    sweep = sensitivity_sweep(CORE, ["body.rotation.period", "body.radius"])
    return astroinertia.open(run_sweep(sweep, tmp_path_factory.mktemp("core")).file).load()


def answers(scene, by, folder, step):
    data = astroinertia.open(run_sweep(sensitivity_sweep(scene, by, step), folder).file).load()
    return data.isel(member=0), sensitivity(data)


@pytest.mark.full
def test_a_core_that_shrinks_answers_as_its_conserved_momentum_says(core):
    base, slopes = core.isel(member=0), sensitivity(core)
    assert list(slopes.parameter.values) == ["body.rotation.period", "body.radius"]
    assert slopes.value.values.tolist() == [30.0, 1.5e6] and list(slopes.value_units.values) == ["s", "m"]
    for series, powers in (
        ("angular_velocity", (-1.0, 0.0)),
        ("inertia_tensor", (0.0, 2.0)),
        ("rotational_to_gravitational", (-2.0, 3.0)),
    ):
        pick = {"i": "z", "j": "z"}
        here, slope, error = (
            variable.sel({dim: label for dim, label in pick.items() if dim in variable.dims})
            for variable in (base[series], slopes[series], slopes[f"{series}_error"])
        )
        expected = np.array(powers)[:, None] * here.values
        assert slopes[series].attrs["units"] == base[series].attrs.get("units", "1")
        np.testing.assert_allclose(slope.values, expected, atol=1e-6 * abs(here.values).max())
        assert (abs(slope.values - expected) <= error.values + 1e-9 * abs(here.values).max()).all()


@pytest.mark.full
def test_a_self_gravitating_ellipsoid_scales_as_dimensions_say(tmp_path):
    """I = M R^2 f(t (G M/R^3)^(1/2)) of dust: 3 d ln I/d ln M + d ln I/d ln R = 5."""
    tables = {
        "name": "dust",
        "model": "ellipsoid",
        "body": {"kind": "uniform", "radius": "900 km", "mass": "1 Msun"},
        "equation_of_state": {"kind": "ideal", "gamma": "5/3"},
        "effects": ["gravity"],
        "time": "40 ms",
        "output": {"series_every": "4 ms"},
    }
    base, slopes = answers(tables, ["body.mass", "body.radius"], tmp_path, step=0.02)
    inertia, rate = (base[name].sel(i="z", j="z").values[1:] for name in ("inertia_tensor", "inertia_rate"))
    by_mass, by_radius = slopes.inertia_tensor.sel(i="z", j="z").values[:, 1:] / inertia
    assert abs(by_mass[-1] - 1) > 0.2  # it falls
    np.testing.assert_allclose(3 * by_mass + by_radius, 5.0, atol=1e-5)
    time = base.time.values[1:]
    np.testing.assert_allclose(by_mass, 1 + 0.5 * time * rate / inertia, atol=1e-5)


@pytest.mark.parametrize(
    ("by", "step", "sentence"),
    [
        (["body.spin"], 0.01, "'body.spin' is not set in the scene"),
        (["name"], 0.01, "'name' must go between two numbers or two quantities"),
        (["body.change.times"], 0.01, "'body.change.times' must"),
        (["bdy.radius"], 0.01, "'bdy.radius' is not set in the scene; did you mean 'body.radius'"),
        (["body.raduis"], 0.01, "'body.raduis' is not set in the scene; did you mean 'body.radius'"),
        (["body.change.times.9"], 0.01, "'body.change.times.9' is not set in the scene"),
        ([], 0.01, "needs keys of the scene"),
        (["body.mass", "body.mass"], 0.01, "each once"),
        (["body.mass"], 0.0, "the step must be above 0"),
        (["body.mass"], np.nan, "the step must be above 0"),
    ],
)
def test_what_tells_nothing_is_refused(by, step, sentence):
    with pytest.raises(SceneError, match=sentence):
        sensitivity_sweep(CORE, by, step)


def test_entries_of_lists_are_moved_by_their_number():
    """As --set has them: the Moon is the second companion of the Earth."""
    sweep = sensitivity_sweep(SIMS / "earth_precession.toml", ["companions.1.mass"])
    masses = [[companion.mass for companion in sweep.scene(number).companions] for number in (0, 1)]
    assert [now / first for now, first in zip(masses[1], masses[0], strict=True)] == pytest.approx([1.0, 0.99])


@pytest.mark.slow
def test_a_scene_with_error_bars_answers_without_them(tmp_path):
    """The answers have errors of their own, by the names that error bars have."""
    scene = astroinertia.Scene.from_toml(TURNING.replace("[observables.quadrupole_phase]", "") + "error_bars = true\n")
    base, slopes = answers(scene, ["body.rotation.rate"], tmp_path, step=0.01)
    assert "angular_velocity_error" not in base
    rate, error = (slopes[name].isel(parameter=0).sel(i="z") for name in ("angular_velocity", "angular_velocity_error"))
    np.testing.assert_allclose(rate, 0.7, atol=1e-9)
    assert (error <= 1e-9).all()


def test_a_key_that_is_zero_is_refused():
    scene = astroinertia.load(FILE, ["body.index=0.0"])
    with pytest.raises(SceneError, match=r"'body\.index' is 0"):
        sensitivity_sweep(scene, ["body.index"])


def test_the_command_refuses_the_frequency_of_a_series(tmp_path, capsys):
    """The frequency of a derivative is not the derivative of a frequency."""
    words = ["--by", "body.mass", "--of", "frequency of inertia_tensor z z", "--output", str(tmp_path / "runs")]
    assert main(["sensitivity", str(FILE), *words]) == 2
    assert "a frequency has no sensitivity here" in capsys.readouterr().err
    assert not (tmp_path / "runs").exists()


@pytest.mark.slow
def test_the_command_takes_an_observable_of_an_installed_package(tmp_path, capsys, monkeypatch):
    """Of a body that turns at a rate the phase of the quadrupole is the rate times the time."""
    distribution(tmp_path, "quadrupole_phase = quadrupole_phase:QuadrupolePhase", group="observables")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.syspath_prepend(EXAMPLE)
    (tmp_path / "turning.toml").write_text(TURNING)
    words = ["--by", "body.rotation.rate", "--of", "quadrupole_phase", "--output", str(tmp_path / "runs")]
    assert main(["sensitivity", str(tmp_path / "turning.toml"), *words, "--workers", "1"]) == 0
    (row,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("quadrupole_phase"))
    assert float(row.split()[1]) == pytest.approx(1.0, abs=1e-5)


def test_the_result_of_another_sweep_is_refused(core):
    with pytest.raises(SceneError, match="four members a key"):
        sensitivity(core.isel(member=slice(0, 8)))
    with pytest.raises(SceneError, match=r"members of body\.radius are not those"):
        sensitivity(core.isel(member=[0, 1, 2, 3, 4, 5, 6, 8, 7]))
