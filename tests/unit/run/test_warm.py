"""What is compiled ahead: all that a run of the scene compiles; and nothing else is left of it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from astroinertia.cli.main import main
from astroinertia.run.warm import Compiled
from tests.sims import SIMS

PASSES = ("neighbour", "density", "all_pairs", "gradient", "multipole")
SETTINGS = ["body.particles=100", "body.placement=random", "numerics.precision=float64", "time.end=0.5"]
PROGRAM = """
import sys
from pathlib import Path
from numba.core import event
from astroinertia.run.loop import run_scene
from astroinertia.run.warm import warm
from astroinertia.scene.load import load_file

what, folder, file, *settings = sys.argv[1:]
scene = load_file(file, settings)
if what == "warm":
    print(*warm(scene).programs)
else:
    with event.install_recorder("numba:compile") as recorder:
        run_scene(scene, Path(folder))
    print(*(happened.data["dispatcher"].py_func.__name__ for _, happened in recorder.buffer if happened.is_start))
"""


@pytest.mark.full(inputs=["sims/evrard.toml"])
@pytest.mark.parametrize(("timesteps", "later"), [("global", 0), ("individual", 1)])
def test_a_run_after_it_compiles_no_pass_over_neighbours(timesteps: str, later: int, tmp_path: Path) -> None:
    """What only later steps need is one loop: the limit by contact of matter that has become fast."""
    kept = {"NUMBA_CACHE_DIR": str(tmp_path / "numba"), "ASTROINERTIA_CACHE": str(tmp_path / "kernels")}
    scene = [str(SIMS / "evrard.toml"), *SETTINGS, f"numerics.timesteps={timesteps}"]

    def compiled(what: str) -> list[str]:
        command = [sys.executable, "-c", PROGRAM, what, str(tmp_path / "run"), *scene]
        return subprocess.run(command, env=os.environ | kept, capture_output=True, text=True, check=True).stdout.split()

    assert any("neighbour_pass" in name for name in compiled("warm"))
    assert not (tmp_path / "run").exists()
    left = compiled("run")
    assert left.count("loop") <= later
    assert later or left == []
    assert not [name for name in left if name.removeprefix("few_").startswith(PASSES)]


@pytest.mark.slow
def test_it_says_what_it_took_and_leaves_no_run(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["warm", str(SIMS / "tennis_racket.toml"), "--set", "time.max_steps=1"]) == 0
    assert capsys.readouterr().out.startswith("compiled 0 programs\ntook ")
    assert list(tmp_path.iterdir()) == []


def test_it_refuses_settings_as_a_run_does(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["warm", str(SIMS / "tennis_racket.toml"), "--set", "body.mass=-1 kg"]) == 2
    assert "body.mass" in capsys.readouterr().err


def test_it_says_that_a_second_process_compiled_others(monkeypatch, capsys) -> None:
    for beside, said in ((True, "compiled 2 programs, and others by a second process: density, forces\n"), (False, "")):
        compiled = Compiled(("density", "forces"), 1.0, 2.0, 2.5, beside)
        monkeypatch.setattr("astroinertia.run.warm.warm", lambda _, answer=compiled: answer)
        assert main(["warm", str(SIMS / "evrard.toml")]) == 0
        assert capsys.readouterr().out.startswith(said or "compiled 2 programs: density, forces\n")
