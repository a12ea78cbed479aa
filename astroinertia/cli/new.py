"""The command `new`: a commented scene, or a copy of one that runs as it stands. Printing is left to main.py."""

import re
import textwrap
from pathlib import Path

from astroinertia.cli.parser import Add, Options
from astroinertia.errors import SceneError
from astroinertia.storage.data_tables import scenes

# The first is the scene's own, for tables come later; with the room before a comment, which stays in its column.
_NAME = re.compile(r'^name = "[^"]*"( *(?=  #))?', re.MULTILINE)
_LONGEST = 64  # letters of a name


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
    """The text of the scene that is asked for, named as its file is; SceneError where there is none of that name."""
    whole = _example() if options.ready_made is None else _copied(options.ready_made)
    return whole if options.file is None else _named(whole, options.file.stem)


def _named(whole: str, stem: str) -> str:
    """A scene with the name of its file, so that its run is not taken for that of the scene it was copied from."""
    name = re.sub(r"[^A-Za-z0-9_-]", "_", stem).lstrip("_-")[:_LONGEST]

    def renamed(old: re.Match[str]) -> str:
        return f'name = "{name}"'.ljust(0 if old[1] is None else len(old[0]))

    return _NAME.sub(renamed, whole, count=1) if name else whole


def _example() -> str:
    from astroinertia.scene.example import example_text

    return example_text()


def _copied(name: str) -> str:
    known = scenes()
    if name not in known:
        from astroinertia.scene.problems import nearest

        raise SceneError(f"there is no scene {name[:64]!r} to copy; {nearest(name, known)}")
    return known[name].read_text(encoding="utf-8")
