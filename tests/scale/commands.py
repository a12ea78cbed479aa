"""Runs by the command line in processes of their own, as a user starts them."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def started(folder, scene, *options, starter=(), **variables):
    """One process, or one with a starter of several: a run of a scene, or without one what goes on."""
    words = [*starter, sys.executable, "-m", "astroinertia"]
    if scene:
        name, *settings = scene
        words += ["run", str(ROOT / "sims" / f"{name}.toml"), "--output", str(folder)]
        words += [word for setting in settings for word in ("--set", setting)]
    else:
        words += ["resume", str(folder)]
    return begun([*words, *options], **variables)


def begun(words, **variables):
    """A process of these words, whose output is kept."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **variables}
    return subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(process, code=0):
    """What a process printed and complained of, after it ended with this exit code."""
    said, complaints = process.communicate(timeout=1200)
    assert process.returncode == code, complaints
    return said, complaints
