"""Runs of matter without heat: what cannot be derived from it is unknown, and all else of the run can be had."""

import numpy as np
import pytest

import astroinertia
from astroinertia import plots
from astroinertia.cli import show
from astroinertia.cli.main import main
from astroinertia.scene import load

COLD = """
name = "cold"
units = "code"
[body]
kind = "uniform"
particles = 60
mass = 1.0
radius = 1.0
relax = false
ENERGY
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[effects.viscosity]
MORE
[time]
end = 0.2
[output]
series_every = 0.1
snapshot_every = 0.1
"""
pytestmark = pytest.mark.slow
COOLED = '[effects.cooling]\nlaw = "time_scale"\ntime_scale = 1e-6\nlimit = "none"'
CASES = {
    "no energy": ("specific_internal_energy = 0.0", ""),
    "next to none": ("specific_internal_energy = 1e-300", ""),
    "all lost at once": ("specific_internal_energy = 0.1", COOLED),
}


ALWAYS = "next to none"


@pytest.mark.parametrize(
    "name", [name if name == ALWAYS else pytest.param(name, marks=pytest.mark.full) for name in CASES]
)
def test_a_cold_body_is_run_shown_exported_and_resumed(tmp_path, name, monkeypatch):
    energy, more = CASES[name]
    scene = load.loads(COLD.replace("ENERGY", energy).replace("MORE", more))
    folder = tmp_path / "run"
    found = astroinertia.open(astroinertia.run_scene(scene, folder))
    assert np.isfinite(found["inertia_tensor"]).all()
    assert found["time"].values[-1] == 0.2
    if more:
        assert found["internal_energy"].values[-1] < 1e-9 * found["internal_energy"].values[0]
    summary = plots.summary(found)
    assert "cold" in summary and "nan" not in summary
    assert main(["resume", str(folder)]) == 0
    assert main(["export", str(folder), "--to", "csv", "--output", str(tmp_path / "csv")]) == 0
    if not more:
        monkeypatch.setattr(show, "cores", lambda: 1)  # a second process would import all of it again
        assert main(["show", str(folder)]) == 0
