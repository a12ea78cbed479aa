"""Docstrings as Markdown: examples become blocks of code, and what Markdown would take for its own is left as it is."""

import re

from griffe import Extension

SPECIAL = re.compile(r"[\\*\[\]#]")


def as_markdown(text: str) -> str:
    """A docstring of this package in Markdown: prose, indented formulas and examples with prompts."""
    lines: list[str] = []
    example = False
    for line in text.splitlines():
        begins = line.lstrip().startswith(">>> ")
        if begins and not example:
            lines += ["", "```pycon"]
        elif example and not line.strip():
            lines.append("```")
        example = (example or begins) and bool(line.strip())
        lines.append(line if example or line.startswith("    ") else escaped(line))
    return "\n".join([*lines, "```"] if example else lines)


def escaped(line: str) -> str:
    """A line of prose, in which only code within backticks means something."""
    pieces = re.split(r"(`[^`]*`)", line)
    return "".join(piece if piece.startswith("`") else _as_it_is(piece) for piece in pieces)


def _as_it_is(prose: str) -> str:
    return SPECIAL.sub(r"\\\g<0>", prose).replace("<", "&lt;")


class Docstrings(Extension):
    """Rewrites every docstring before it is shown."""

    def on_object(self, *, obj, **_) -> None:
        """Rewrite the docstring of a module, a class or a function."""
        if obj.docstring is not None:
            obj.docstring.value = as_markdown(obj.docstring.value)
