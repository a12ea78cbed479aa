"""What of a text may reach a terminal: names, attributes and errors come from files of strangers."""

import unicodedata
from typing import Any

from rich import box
from rich.table import Table

_ACT = frozenset(
    {"Cc", "Cf", "Cs", "Zl", "Zp"}
)  # controls, escapes, what turns the direction of writing, half characters


def visible(text: str, lines: bool = True) -> str:
    """The text with a ? for every character that does something to a terminal; with `lines`, lines and tabs stay.

    >>> print(visible("\\x1b]0;title\\x07star"))
    ?]0;title?star
    """
    if text.isascii() and text.isprintable():
        return text
    kept = "\n\t" if lines else ""
    return "".join(sign if sign in kept or unicodedata.category(sign) not in _ACT else "?" for sign in text)


def titled(title: str, **layout: Any) -> Table:
    """A table below its title, without lines between its rows."""
    look = {"box": box.SIMPLE_HEAD, "title_justify": "left", "title_style": "bold", "padding": (0, 1)}
    return Table(title=title, **(look | layout))
