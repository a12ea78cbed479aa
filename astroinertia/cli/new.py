"""The command `new`: a commented scene, or a copy of one that runs as it stands. Printing is left to main.py."""

import textwrap
from pathlib import Path

from astroinertia.cli.parser import Add, Options
from astroinertia.errors import SceneError
from astroinertia.storage.ready_made import scenes


def help_text() -> str:
    """The end of its help: examples, and the scenes that there are."""
    names = textwrap.wrap(", ".join(scenes()), 100, initial_indent="  ", subsequent_indent="  ")
    return "\n".join([
        "example: astroinertia new star.toml",
        "         astroinertia new --from pulsar_collapse core.toml",
        "",
        "scenes that run as they stand, of which sims/README.md of the source says what they show:",
        *names,
    ])  # fmt: skip


def add_arguments(add: Add) -> None:
    """Add where to write, and which scene."""
    add("file", nargs="?", metavar="FILE", type=Path, help="where to write it; to the screen without it")
    add("--from", dest="ready_made", metavar="NAME", help="copy the scene of that name, which runs as it stands, "
        "in place of one that lists every key")  # fmt: skip


def text(options: Options) -> str:
    """The text of the scene that is asked for; SceneError where there is none of that name."""
    if options.ready_made is None:
        from astroinertia.scene.example import example_text

        return example_text()
    known = scenes()
    if options.ready_made not in known:
        from astroinertia.scene.problems import nearest

        raise SceneError(
            f"there is no scene {options.ready_made[:64]!r} to copy; {nearest(options.ready_made, known)}."
        )
    return known[options.ready_made].read_text(encoding="utf-8")
