"""Environments that hold the wheel of this package and no more than it asks for, and the scenes that are run there."""

import os
import subprocess
import sys
from importlib.metadata import Distribution, distribution
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]
STAR = ROOT / "sims" / "one_star_three_models.toml"
FEW = ("body.particles=128", "time.max_steps=3")
SCENES = {
    "scaling": (STAR, "model=scaling"),
    "ellipsoid": (STAR, "model=ellipsoid", 'time.end="20 min"'),
    "rigid": (ROOT / "sims" / "tennis_racket.toml", 'time.end="0.5 s"'),
    "sph": (STAR, *FEW),
}
"""By the model that they are run with: a scene and its settings."""


def wheel(folder: Path) -> Path:
    """The wheel of this checkout, built into a folder."""
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        check=True, cwd=ROOT, capture_output=True,
    )  # fmt: skip
    (built,) = folder.glob("astroinertia-*.whl")
    return built


def run(command: list[str | Path], folder: Path, **variables: str) -> str:
    """What a command prints that ends well in a folder, without any path of Python's from here."""
    given = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        list(map(str, command)), cwd=folder, env=given | variables, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def with_the_wheel(built: Path, folder: Path) -> Path:
    """The programs of a new environment: the wheel, and links to what it asks for as far as that is installed here."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
    programs = folder / "bin"
    installing = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        programs / "python",
        "install",
        "-q",
        "--no-deps",
        "--no-index",
        "--no-compile",  # which takes longer than all that is run
    ]
    run([*installing, built], folder)
    (packages,) = folder.glob("lib/python*/site-packages")
    for needed in needs(Distribution.at(next(packages.glob("astroinertia-*.dist-info")))).values():
        for top in {Path(each).parts[0] for each in needed.files or ()} - {".."}:
            place = packages / top
            if not place.exists():
                place.symlink_to(Path(str(needed.locate_file(top))))
    return programs


def needs(package: Distribution, known: dict[str, Distribution] | None = None) -> dict[str, Distribution]:
    """What a package asks for without extras, and what that asks for in turn, by name."""
    known = {} if known is None else known
    for each in map(Requirement, package.requires or ()):
        if each.name not in known and (each.marker is None or each.marker.evaluate({"extra": ""})):
            known[each.name] = distribution(each.name)
            needs(known[each.name], known)
    return known


def run_scenes(programs: Path, folder: Path) -> None:
    """Each model's scene through the installed command, from a plan to a summary, in an empty folder."""
    for model, (scene, *settings) in SCENES.items():
        changed = [part for setting in settings for part in ("--set", setting)]
        output = run([programs / "astroinertia", "run", scene, *changed, "--output", model], folder)
        assert f"look at it with: astroinertia show {model}" in output
    closure = "float(found.get('ledger_closure', found.mass * 0).max())"
    shown = f"print(found.attrs['model'], int(found.time.size > 1), {closure} < 1e-10)"
    opened = f"import astroinertia, sys\nfor name in sys.argv[1:]:\n    found = astroinertia.open(name); {shown}"
    lines = run([programs / "python", "-c", opened, *SCENES], folder).splitlines()
    assert lines == [f"{model} 1 True" for model in SCENES]
