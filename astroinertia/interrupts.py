"""Signals that ask to stop: Ctrl-C, and what schedulers send before they kill.

Handlers are the main thread's: elsewhere signals stay with whoever owns them. `timeout` and schedulers send theirs to a
process and to its group, so that they come twice. Tests: tests/unit/test_stopping.py.
"""

import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
CTRL_C = "Ctrl-C"


@contextmanager
def noted(received: list[str]) -> Iterator[None]:
    """Notes the names of SIGNALS meanwhile; a second Ctrl-C acts as usual, a second one of the others does not."""

    def note(number: int, _: FrameType | None) -> None:
        received.append(CTRL_C if number == signal.SIGINT else signal.Signals(number).name)
        if number == signal.SIGINT:
            signal.signal(number, before[number])

    before = _handled(SIGNALS, note)
    try:
        yield
    finally:
        _restore(before)


@contextmanager
def raised() -> Iterator[None]:
    """Has the others of SIGNALS raise KeyboardInterrupt as Ctrl-C does, but once."""

    def interrupt(number: int, _: FrameType | None) -> None:
        for each in before:
            signal.signal(each, signal.SIG_IGN)
        raise KeyboardInterrupt(signal.Signals(number).name)

    before = _handled(SIGNALS[1:], interrupt)
    try:
        yield
    finally:
        _restore(before)


def cause(interrupt: KeyboardInterrupt) -> str:
    """Which signal it was."""
    return str((*interrupt.args, CTRL_C)[0])


def _handled(numbers: Sequence[int], handler: Callable[[int, FrameType | None], None]) -> dict[int, Any]:
    before: dict[int, Any] = {}
    try:
        for number in numbers:
            before[number] = signal.signal(number, handler)
    except ValueError:  # not the main thread
        before.clear()
    return before


def _restore(before: dict[int, Any]) -> None:
    for number, handler in before.items():
        signal.signal(number, handler)
