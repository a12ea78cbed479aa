"""The example package of sims/plugin_example, installed in a folder, and commands that find it there."""

import os
import subprocess
import sys
import zipfile
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from hatchling.builders.wheel import WheelBuilder

from astroinertia.models.sph.evolution import Particles

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "sims" / "plugin_example"
# What stops a command after 20 steps, with all of them kept.
STOP = """
import os
from astroinertia.models.sph.evolution import Particles
plain = Particles.advance
def advance(self, *towards):
    plain(self, *towards)
    if self.steps == 20:
        os.kill(os.getpid(), 15)
Particles.advance = advance
"""


def installed_in(place: Path) -> Path:
    """A folder in that place with the example package installed in it."""
    (wheel,) = WheelBuilder(str(EXAMPLE)).build(directory=str(place / "wheels"), versions=["standard"])
    zipfile.ZipFile(wheel).extractall(place / "site")
    return place / "site"


def example(monkeypatch: pytest.MonkeyPatch, module: str, name: str) -> Any:
    """A class of the example, by its file alone: without its package the kind means nothing in a scene."""
    monkeypatch.syspath_prepend(EXAMPLE)
    monkeypatch.delitem(sys.modules, module, raising=False)
    return getattr(import_module(module), name)


def commands(installed: Path, folder: Path, *steps: str | tuple[str, ...], code: int = 0) -> str:
    """What commands print where the example is installed, all in one process, of which the last ends with the code.

    steps: the words of a command each, or a program that is run between two commands.
    """
    *before, last = [each if isinstance(each, str) else f"main({list(each)})" for each in steps]
    before = [f"assert {each} == 0" if each.startswith("main(") else each for each in before]
    program = "\n".join(["import sys", "from astroinertia.cli.main import main", *before, f"sys.exit({last})"])
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": os.pathsep.join((str(ROOT), str(installed))), "COLUMNS": "200"},
    )  # fmt: skip
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def stopped_at(monkeypatch: pytest.MonkeyPatch, step: int) -> None:
    """Runs stop, with all of them kept, once they have taken so many steps."""
    plain = Particles.advance

    def advance(self: Particles, *towards: float) -> None:
        plain(self, *towards)
        if self.steps == step:
            os.kill(os.getpid(), 15)

    monkeypatch.setattr(Particles, "advance", advance)


def distribution(place: Path, points: str, name: str = "stranger", group: str = "effects") -> None:
    """The metadata of an installed package with those entry points."""
    folder = place / f"{name}-2.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 2.0\n")
    (folder / "entry_points.txt").write_text(f"[astroinertia.{group}]\n{points}\n")
