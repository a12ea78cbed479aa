"""Every scene of sims runs for a few steps from the command line: with its own engine, precision and method of gravity.

Gravity of some 3500 particles and more is by multipoles where a scene does not say otherwise.
"""

import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import astroinertia
from astroinertia import dataset
from astroinertia.scene import load
from astroinertia.scene.sweep import load_file
from tests.sims import SIMS

STEPS = 3
LARGE = 10_000
# The fewest scenes that together use every kind of sum over pairs, with every effect that any scene has in it, and all
# orders of multipoles, in both precisions: float32 pairs with time steps of their own, float64 pairs with them, shear,
# and conduction in a box. Others fuse fewer effects in one loop.
ALWAYS = {"boss_bodenheimer": 4000, "collapse_to_sink": 4000, "jacobi_by_viscosity": 4000, "gresho": 2500}


def sizes() -> list:
    """Each scene as it stands (None), and those of particles at 10,000, too; a few small ones that always run."""
    cases = [pytest.param(name, count, id=f"{name}-{count}") for name, count in ALWAYS.items()]
    for path in sorted(SIMS.glob("*.toml")):
        table = tomllib.loads(path.read_text()).get("body", {}).get("file")  # from where the scene lies
        named = [] if table is None else [str((SIMS / table).resolve().relative_to(SIMS.parent))]
        marks = pytest.mark.full(inputs=[f"sims/{path.name}", *named])
        cases.append(pytest.param(path.stem, None, id=path.stem, marks=marks))
        if load_file(path) is None and load.load_file(path).particles not in (None, LARGE):
            cases.append(pytest.param(path.stem, LARGE, id=f"{path.stem}-{LARGE}", marks=marks))
    return cases


def settings(path: Path, particles: int | None) -> list[str]:
    """What makes it short, and its bodies of so many particles in all, in the same proportions."""
    chosen = [f"time.max_steps={STEPS}"]
    if particles is None:
        return chosen
    scene: Any = load.load_file(path)
    if not scene.bodies:
        return [*chosen, f"body.particles={particles}"]
    shares = [body.particles / scene.particles for body in scene.bodies]
    return [*chosen, *(f"bodies.{k}.particles={round(share * particles)}" for k, share in enumerate(shares))]


@pytest.mark.parametrize(("name", "particles"), sizes())
def test_a_scene_runs_from_the_command_line(name, particles, tmp_path, result):
    path = SIMS / f"{name}.toml"
    words = [word for each in settings(path, particles) for word in ("--set", each)]
    done = subprocess.run(
        [sys.executable, "-m", "astroinertia", "run", str(path), "--output", str(tmp_path / "run"), *words],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    assert "Traceback" not in done.stderr
    if load_file(path) is not None:
        assert all(member.sizes["time"] >= 2 for member in astroinertia.open_sweep(tmp_path / "run").values())
        return
    found = dataset.open(tmp_path / "run")
    assert found.sizes["time"] >= 2
    for variable in ("second_moment", "mixed_moment", "kinetic_tensor", "virial_tensor", "total_energy"):
        values = found[variable].values
        assert np.isfinite(values).all() or "reason" in found[variable].attrs, variable
    closure = float(np.abs(found["ledger_closure"]).max())
    result(ledger_closure=closure, steps=STEPS)
    assert not closure > 1e-12
