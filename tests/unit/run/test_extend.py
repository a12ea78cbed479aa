"""A run that goes on with a later end or other outputs: the bits of one that was meant to, and what is refused."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import astroinertia
from astroinertia.errors import RunInterrupted, SceneError
from astroinertia.scene.load import loads
from tests.plugin_example import stopped_at

pytestmark = pytest.mark.usefixtures("steps_differ")

STAR = """
name = "star"
units = "code"
[body]
kind = "polytrope"
index = 1.5
mass = 1.0
radius = 1.0
particles = 100
relax = false
[body.rotation]
rate = 0.3
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[effects.viscosity]
[time]
end = 0.4
[output]
series_every = 0.1
snapshot_every = 0.2
checkpoint_seconds = 0.0
align = true
[numerics]
max_timestep = 0.01
"""
WHEEL = """
name = "wheel"
model = "rigid"
[body]
kind = "rigid"
mass = "2 kg"
moments = ["1 kg m2", "2 kg m2", "2.5 kg m2"]
[body.rotation]
rate = "3 rad/s"
axis = [0.2, 0.1, 1.0]
[effects.constant_torque]
vector = ["0.1 N m", "0 N m", "0 N m"]
[time]
end = "2 s"
[output]
series_every = "0.25 s"
"""
DROP = """
name = "drop"
model = "ellipsoid"
units = "code"
[body]
kind = "uniform"
mass = 1.0
radius = 1.0
axes = [1.0, 1.0, 0.8]
[equation_of_state]
kind = "incompressible"
[effects.gravity]
[effects.pressure]
[effects.shear_viscosity]
kinematic_viscosity = 0.01
[time]
end = 2.0
[output]
series_every = 0.5
"""
MOON = """
[effects.companions]
[[companions]]
name = "moon"
mass = 0.1
semi_major_axis = 8.0
eccentricity = 0.2
"""


ROOT = Path(__file__).parents[3]


def opened(path: Any) -> Any:
    return astroinertia.open(path).drop_vars("wall_time")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "settings", "end"),
    [
        pytest.param(STAR, [], "time.end=0.8", marks=pytest.mark.full),
        pytest.param(STAR, ['numerics.timesteps="individual"'], "time.end=0.8", marks=pytest.mark.full),
        pytest.param(WHEEL, [], 'time.end="4 s"', marks=pytest.mark.full),
        (WHEEL, ['numerics.integrator="splitting"'], 'time.end="4 s"'),
        pytest.param(DROP, [], "time.end=4.0", marks=pytest.mark.full),
        (STAR + MOON, [], "time.end=0.8"),
    ],
    ids=["global", "individual", "adaptive", "splitting", "ellipsoid", "star and moon"],
)
def test_a_run_that_goes_further_has_the_bits_of_one_that_was_to_go_so_far(tmp_path, text, settings, end) -> None:
    whole = opened(astroinertia.run_scene(loads(text, [*settings, end]), tmp_path / "whole"))
    astroinertia.run_scene(loads(text, settings), tmp_path / "parts")
    parts = opened(astroinertia.resume(tmp_path / "parts", settings=[end]))
    assert parts.time[-1] == whole.time[-1] and parts.equals(whole)
    if "snapshots" in (tree := astroinertia.open_tree(tmp_path / "parts")):
        other = astroinertia.open_tree(tmp_path / "whole")
        assert tree["snapshots"].to_dataset().equals(other["snapshots"].to_dataset())
    line = parts.attrs["history"].splitlines()[-1]
    assert "went on from time " in line and line.endswith(f" with {end}")
    assert opened(astroinertia.resume(tmp_path / "parts")).equals(whole)  # it is finished, as any other


@pytest.mark.slow
def test_a_run_that_was_stopped_goes_further_too_and_can_be_stopped_again(tmp_path, monkeypatch) -> None:
    whole = opened(astroinertia.run_scene(loads(STAR, ["time.end=0.8"]), tmp_path / "whole"))
    with monkeypatch.context() as patch:
        stopped_at(patch, 32)
        with pytest.raises(RunInterrupted):
            astroinertia.run_scene(loads(STAR), tmp_path / "parts")
    with monkeypatch.context() as patch:
        stopped_at(patch, 64)
        with pytest.raises(RunInterrupted):
            astroinertia.resume(tmp_path / "parts", settings=["time.end=0.8"])
    assert opened(astroinertia.resume(tmp_path / "parts")).equals(whole)


@pytest.mark.slow
def test_outputs_are_as_often_as_before_unless_they_are_set(tmp_path) -> None:
    text = WHEEL.replace('[output]\nseries_every = "0.25 s"\n', "")
    astroinertia.run_scene(loads(text, ['numerics.integrator="splitting"']), tmp_path / "run")
    ds = opened(astroinertia.resume(tmp_path / "run", settings=['time.end="3 s"']))
    assert ds.time.values == pytest.approx(np.arange(301) * 0.01, abs=1e-12)
    ds = opened(astroinertia.resume(tmp_path / "run", settings=['time.end="4 s"', 'output.series_every="0.25 s"']))
    assert np.diff(ds.time.values) == pytest.approx([0.01] * 300 + [0.25] * 4)
    assert ds.attrs["history"].count("went on from") == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("effects.damping.time_scale=1.0", r"damping.time_scale stays .* time.end, time.max.*`astroinertia branch`"),
        ("time=1.0", "time stays as it is in a run that goes on"),
        ("time.end=1.5", "the run has reached time 2: its end must be later"),
        ("output.series_every=0.1", "the run has reached time 2: its end must be later"),
        ("time.end=much", r"\[time\] end: must be a plain number, not 'much'"),
        ("time.end", "stays as it is|write key=value"),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_is_changed(tmp_path, setting, sentence) -> None:
    astroinertia.run_scene(loads(DROP), tmp_path / "run")
    before = {path: path.read_bytes() for path in (tmp_path / "run").iterdir()}
    with pytest.raises(SceneError, match=sentence):
        astroinertia.resume(tmp_path / "run", settings=[setting])
    assert {path: path.read_bytes() for path in (tmp_path / "run").iterdir()} == before


@pytest.mark.full
def test_error_bars_and_sweeps_go_on_as_they_began(tmp_path) -> None:
    astroinertia.run_scene(loads(DROP, ["output.error_bars=true"]), tmp_path / "run")
    with pytest.raises(SceneError, match="a run with error bars goes on with no other settings"):
        astroinertia.resume(tmp_path / "run", settings=["time.end=3.0"])
    (tmp_path / "sweep.toml").write_text(DROP + '[sweep]\n"time.end" = [1.0, 2.0]\n')
    astroinertia.run_scene(tmp_path / "sweep.toml", tmp_path / "sweep")
    with pytest.raises(SceneError, match="a sweep goes on as it began"):
        astroinertia.resume(tmp_path / "sweep", settings=["time.end=3.0"])
