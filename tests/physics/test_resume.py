"""A run that is stopped goes on as if nothing had happened, bit for bit."""

import os
import signal
from pathlib import Path

import numpy as np
import pytest

import astroinertia
from astroinertia.errors import RunInterrupted
from astroinertia.run.loop import Progress
from astroinertia.scene import load

SETTINGS = ["body.particles=300", "time.end=1.0", "numerics.precision=float64", "output.checkpoint_seconds=0"]
SCENE = Path(__file__).parent.parent.parent / "sims" / "evrard.toml"


# Quicker, with other effects and by a command: tests/installed/test_example.py; with individual steps: tests/crash.
@pytest.mark.full(inputs=["sims/evrard.toml"])
def test_an_interrupted_run_resumes_bit_for_bit(tmp_path: Path) -> None:
    """SIGINT in the middle saves the run; resumed, its series and snapshots equal those of an undisturbed run."""
    scene = load.load_file(SCENE, SETTINGS)
    whole = astroinertia.open_tree(astroinertia.run_scene(scene, tmp_path / "whole"))
    steps = []

    def interrupt(progress: Progress) -> None:
        steps.append(progress.step)
        if progress.time > 0.4 and len([s for s in steps if s < 0]) == 0:
            steps.append(-1)
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(RunInterrupted, match="saved"):
        astroinertia.run_scene(scene, tmp_path / "parts", interrupt)
    assert not list((tmp_path / "parts").glob("*.nc"))
    parts = astroinertia.open_tree(astroinertia.resume(tmp_path / "parts"))
    for group in ("/", "/snapshots"):
        assert set(whole[group].data_vars) == set(parts[group].data_vars)
        for name in whole[group].data_vars:
            if name != "wall_time":
                np.testing.assert_array_equal(whole[group][name].values, parts[group][name].values, err_msg=name)
