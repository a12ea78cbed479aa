"""What `run` and `plan` do for accuracy: choose settings for the one asked for, tell error bars of the one that is had.

Printing is left to main.py.
"""

import argparse
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from astroinertia.cli.parser import Add, Options, Say
from astroinertia.errors import SceneError

if TYPE_CHECKING:
    from astroinertia.scene.schema import Scene


def minutes(text: str) -> float:
    """The number of an option of minutes, which is above 0."""
    with suppress(ValueError):
        if (number := float(text)) > 0.0:
            return number
    raise argparse.ArgumentTypeError(f"'{text:.40}' is no number above 0")


def add_arguments(add: Add) -> None:
    """Add how long a run may take whose settings are chosen, and whether it has error bars."""
    add("--minutes", type=minutes, metavar="M",
        help="wall time that the run may take where the scene asks for an accuracy (accuracy = 1e-3) and its settings "
        "are chosen; where it would take longer, that is reported with the cost (default: 60)")  # fmt: skip
    add("--error-bars", dest="overrides", action="append_const", const="output.error_bars=true",
        help="estimate errors of the headline series from companion runs, as [output] error_bars = true "
        "does")  # fmt: skip


def refuse_minutes(options: Options, scenes: "Iterable[Scene]") -> None:
    """Raise SceneError where minutes are given, and the command chooses no settings, or no scene has any to choose."""
    if options.minutes is None:
        return
    if not any(scene.wants_choice for scene in scenes):
        raise SceneError(
            "--minutes is for a scene whose settings are chosen, which asks for an accuracy, such as accuracy = 1e-3; "
            "--max-wall stops any run in time."
        )
    if not getattr(options, "pilot", True):
        raise SceneError("--minutes is for the choice of settings, which `run` makes, and `plan` with --pilot alone.")


def chosen(scene: "Scene", folder: Path, minutes: float | None, say: Say) -> "Scene":
    """The scene with settings chosen by pilots, kept beside the run's folder; as it is, if it asks for none."""
    if not scene.wants_choice:
        return scene
    from astroinertia.accuracy.choice import DEFAULT_MINUTES, choose, pilots_beside
    from astroinertia.engines import hosts

    hosts.must_be_alone("the choice of settings for an accuracy")
    say(f"{scene.name}: settings are chosen for an accuracy of {scene.accuracy:g}")
    choice = choose(scene, pilots_beside(folder), minutes or DEFAULT_MINUTES, lambda label: say(f"  pilot: {label}"))
    for text in choice.scene.choice.values():
        say(f"  {text}")
    return choice.scene
