"""The scenes of sims/ that make one run each; those with [sweep] make several."""

from pathlib import Path

from astroinertia.scene.sweep import load_file

SIMS = Path(__file__).parents[1] / "sims"


def single_scenes() -> list[Path]:
    """Files of scenes of one run, by name."""
    return sorted(path for path in SIMS.glob("*.toml") if load_file(path) is None)
