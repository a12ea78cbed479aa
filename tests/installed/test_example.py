"""An installed package's effect, equation of state, initial body and observable: one scene with all four, by commands.

What each of them does, and what is refused, is in the tests of their doors.
"""

import shutil

import numpy as np
import pytest

import astroinertia
from astroinertia.cli.main import main
from astroinertia.errors import ArchiveError
from tests.plugin_example import STOP, commands, installed_in

K, SPEED = 0.3, 1.5
SCENE = f"""
name = "ring_through_a_medium"
units = "code"
[body]
kind = "torus"
mass = 0.02
major_radius = 1.0
minor_radius = 0.3
velocity = [{SPEED}, 0.0, 0.0]
particles = 200
[equation_of_state]
kind = "logotrope"
reference_pressure = 1e-5
reference_density = 0.01
[effects.pressure]
[effects.gravity]
[effects.cubic_drag]
k = {K}
[observables.quadrupole_phase]
[time]
end = 0.4
[output]
series_every = 0.05
checkpoint_seconds = 0.0
[numerics]
max_timestep = 0.01
"""
# An audit compiles every program for itself: of an effect less it takes less time.
AUDITED = SCENE.replace("[effects.gravity]\n", "")
SWEEP = SCENE.replace("end = 0.4", "end = 0.1") + '[sweep]\n"body.minor_radius" = [0.2, 0.3]\n'
PACKAGE = "astroinertia-plugin-example 0.1"
THINGS = {
    "effect 'cubic_drag'": "cubic_drag = cubic_drag:CubicDrag",
    "equation of state 'logotrope'": "logotrope = logotrope:Logotrope",
    "initial body 'torus'": "torus = torus:Torus",
    "observable 'quadrupole_phase'": "quadrupole_phase = quadrupole_phase:QuadrupolePhase",
}


@pytest.mark.full
def test_it_is_planned_run_stopped_resumed_shown_and_reported(tmp_path, monkeypatch, capsys) -> None:
    installed = installed_in(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    monkeypatch.chdir(tmp_path)

    def without(*arguments: str, code: int = 0) -> str:
        """What a command says in this process, which does not have the package."""
        assert main(list(arguments)) == code
        return "".join(capsys.readouterr())

    said = commands(
        installed, tmp_path, ("plan", "scene.toml"), ("run", "scene.toml", "--output", "whole"), STOP,
        ("run", "scene.toml", "--output", "parts"), code=130,
    )  # fmt: skip
    assert said.count(f"from {PACKAGE}") >= len(THINGS)
    assert "k 0.3" in said and "the effect states no size" in said
    assert "McLaughlin" in said and "Papaloizou" in said and "phase of the quadrupole about z (rad)" in said
    assert "cubic_drag is not a known effect" in without("plan", "scene.toml", code=2)

    assert "which is not here: install its package" in without("resume", "parts", code=2)
    for thing, point in THINGS.items():  # nothing but that one is missing
        place = tmp_path / f"without {thing}"
        shutil.copytree(installed, place)
        (points,) = place.glob("*.dist-info/entry_points.txt")
        points.write_text(points.read_text().replace(point, ""))
        with monkeypatch.context() as patch:
            patch.syspath_prepend(place)
            with pytest.raises(ArchiveError, match=rf"with the {thing} \({PACKAGE}\), which is not here: install its"):
                astroinertia.resume(tmp_path / "parts")
    commands(installed, tmp_path, ("resume", "parts"))

    whole, parts = (astroinertia.open(tmp_path / name) for name in ("whole", "parts"))
    assert parts.drop_vars("wall_time").equals(whole.drop_vars("wall_time"))
    assert '"astroinertia-plugin-example": "0.1"' in whole.attrs["versions"]
    for name in ("own_effects", "own_matter", "own_bodies"):
        assert PACKAGE in whole.attrs[name], name
    assert parts.quadrupole_phase.attrs["origin"] == PACKAGE
    assert np.isfinite(whole.quadrupole_phase).any()
    # Pressure and gravity spread the speeds by a hundredth, which changes that of the whole by the square of that.
    expected = SPEED / np.sqrt(1.0 + 2.0 * K * SPEED**2 * whole.time.values)
    assert whole.momentum.sel(i="x").values / 0.02 == pytest.approx(expected, rel=1e-3)
    assert float(abs(whole.impulse.sel(i="x", effect="pressure")).max()) < 1e-12
    assert float(abs(whole.work.sel(effect="pressure")[-1])) > 0.0
    assert float(abs(whole.ledger_closure).max()) < 1e-13

    assert "quadrupole phase (rad)" in without("show", "parts")
    without("report", "parts", "--output", "report.html")
    report = (tmp_path / "report.html").read_text()
    for words in ("cubic drag", "logotrope", "torus", "quadrupole phase (rad)"):
        assert words in report.replace("_", " "), words


@pytest.mark.full
def test_it_is_audited_and_swept(tmp_path) -> None:
    installed = installed_in(tmp_path)
    for name, text in (("audited", AUDITED), ("sweep", SWEEP)):
        (tmp_path / f"{name}.toml").write_text(text)
    said = commands(
        installed, tmp_path, ("plan", "audited.toml", "--audit"), ("run", "sweep.toml", "--output", "sweep")
    )
    (row,) = (line for line in said.splitlines() if line.strip().startswith("cubic_drag") and "yes" in line)
    assert any(part.isdigit() and int(part) > 0 for part in row.split())
    assert astroinertia.open_sweep(tmp_path / "sweep").sizes["member"] == 2
