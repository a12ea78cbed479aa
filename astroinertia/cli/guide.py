"""The command `guide`: its argument, the list of topics, and a page on a terminal. Printing is left to main.py."""

import os
import shlex
import subprocess
from contextlib import suppress

from astroinertia.cli.parser import Add
from astroinertia.guide import pages
from astroinertia.process import interrupts

WIDEST = 110  # columns, that lines are read comfortably in


def add_arguments(add: Add) -> None:
    """Add the topic."""
    add("topic", nargs="?", metavar="TOPIC", help="page to read, such as ledger; without it, the list of topics")


def topics() -> str:
    """The list of topics, one a line, and how one is read."""
    width = max(map(len, pages.TOPICS))
    lines = [f"  {topic:<{width}}  {text}" for topic, text in pages.TOPICS.items()]
    return "\n".join(["topics:", *lines, "", "read one with: astroinertia guide TOPIC"])


def rendered(text: str, width: int, colours: bool) -> str:
    """A page of Markdown as a terminal of so many columns shows it."""
    import io

    from rich.console import Console
    from rich.markdown import Markdown

    stream = io.StringIO()
    console = Console(file=stream, width=min(width, WIDEST), force_terminal=colours, highlight=False)
    console.print(Markdown(text, code_theme="ansi_dark", hyperlinks=False))
    return stream.getvalue()


def paged(text: str) -> bool:
    """Show a text in the pager that $PAGER names, or `less`; False if there is none."""
    environment = {"LESS": "FRX", **os.environ}  # as git has it: colours stay, and what fits on a screen needs no key
    try:
        command = shlex.split(os.environ.get("PAGER") or "less")
        pager = subprocess.Popen(command, stdin=subprocess.PIPE, env=environment, text=True, errors="replace")
    except (OSError, ValueError, IndexError):
        return False
    with interrupts.leaving(pager.terminate), suppress(BrokenPipeError):
        pager.communicate(text)
    return True
