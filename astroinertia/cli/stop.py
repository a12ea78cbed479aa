"""What ends `run` and `resume` before the scene's end, and how that is reported. Printing is left to main.py."""

import argparse
import math
import shlex
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from astroinertia.cli.parser import Add, Options
from astroinertia.errors import ArchiveWarning, RunInterrupted, SceneError, SceneWarning
from astroinertia.process import interrupts
from astroinertia.process.interrupts import LIMIT, Ended

INTERRUPTED = 130

EXIT_CODES = """\
exit codes:
  0        the run has ended, and its file is written
  1        it failed
  2        bad input
  3        it has ended, and its file is written, but its ledger or its energy does not close within bounds
  130      Ctrl-C, SIGTERM, SIGUSR1 or --max-wall stopped it; all is saved, and `astroinertia resume` goes on
  128 + N  signal N ended it at once: before the run had begun, or by another signal a second after the first
"""


def add_arguments(add: Add) -> None:
    """Add the limit of wall time."""
    add("--max-wall", type=_seconds, default=math.inf, metavar="TIME",
        help='save the run and stop before it has taken this long, in seconds or as "2 h"; `resume` goes '
        "on with it")  # fmt: skip


def deadline(options: Options, begun: float | None = None) -> float:
    """The instant of time.monotonic() by which the run is to be stopped; what began now unless it is said.

    Whatever the run does then, such as compile, and has nothing to save, it is ended; but for one of several processes
    of JAX, for which the others wait: these stop after the same step.
    """
    instant = (time.monotonic() if begun is None else begun) + options.max_wall
    if instant < math.inf and getattr(options, "coordinator", None) is None:
        interrupts.end_by(instant, LIMIT, INTERRUPTED)
    return instant


def interruption_message(stopped: RunInterrupted) -> str:
    """How to go on."""
    return f"{stopped}; go on with: astroinertia resume {shlex.quote(str(stopped.folder))}"


def ended(how: Ended) -> tuple[int, str]:
    """The exit code of a command that a signal has ended at once, and what is said."""
    if isinstance(how.said, RunInterrupted) and how.saved:
        return INTERRUPTED, interruption_message(how.said)
    if isinstance(how.said, RunInterrupted):
        again = f"what was saved before is kept; go on with: astroinertia resume {shlex.quote(str(how.said.folder))}"
        return how.code, f"ended at once by {how.name}; {again}"
    if how.said is None and how.name == LIMIT:
        return how.code, "the run was stopped by its limit of wall time before its first step; nothing is lost."
    return how.code, how.said or "interrupted."


@contextmanager
def warnings_as_sentences(tell: Callable[[str], None]) -> Iterator[None]:
    """Show what a disk has damaged, and what a scene leaves out, as a sentence without the line of the code.

    Once, however often a command comes upon it.
    """
    usual, shown = warnings.showwarning, set()

    def show(message, category, *where) -> None:
        if not issubclass(category, ArchiveWarning | SceneWarning):
            usual(message, category, *where)
        elif (sentence := str(message)) not in shown:
            shown.add(sentence)
            tell(sentence)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def _seconds(text: str) -> float:
    from astroinertia.units import quantity

    try:
        seconds = float(text)
    except ValueError:
        try:
            seconds = quantity(text, "time")
        except SceneError as error:
            raise argparse.ArgumentTypeError(str(error).rstrip(".")) from None
    if not 0.0 < seconds < math.inf:
        raise argparse.ArgumentTypeError(f"'{text}' is no time above 0")
    return seconds
