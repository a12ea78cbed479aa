"""Signals that ask to stop: Ctrl-C, and what schedulers send before they kill. Handlers only note them.

A loop that has something to save looks at what is noted. As a command (`watched`), a process in which nothing is to be
saved is ended at once by a thread of its own, whatever the main thread is doing: one that compiles sees no signal, and
an exception raised inside a compiler's lock would never let go of it. `timeout` and schedulers send theirs to a process
and to its group, so that what comes within AGAIN of the first is the same request; what comes later ends the process.
Handlers are the main thread's: elsewhere signals stay with whoever owns them. Tests: tests/unit/test_stopping.py,
tests/crash/test_signals.py.
"""

import math
import os
import select
import signal
import threading
import time as clock
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, NamedTuple

from astroinertia.errors import RunInterrupted

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
CTRL_C, LIMIT = "Ctrl-C", "its limit of wall time"
AGAIN = 1.0  # s
_LONGEST = 1e6  # s, that the system waits

Said = Callable[[str], RunInterrupted | str]
"""What is said of the work that is ended, by what was sent."""


class Ended(NamedTuple):
    """What ends a process: the exit code that goes with it, its name, and what is said of the work under way, if so.

    saved: whether nothing of that is lost.
    """

    code: int
    name: str
    said: RunInterrupted | str | None
    saved: bool


class _Loop(NamedTuple):
    received: list[str]
    unsaved: Callable[[], bool]


class _Work(NamedTuple):
    said: Said
    resumable: bool


_loops: list[_Loop] = []
_work: list[_Work] = []
_leftovers: list[Callable[[], Any]] = []
_watchers: list["_Watcher"] = []


def name(number: int) -> str:
    """What a signal is called."""
    return CTRL_C if number == signal.SIGINT else signal.Signals(number).name


@contextmanager
def noted(received: list[str], unsaved: Callable[[], bool] = lambda: True) -> Iterator[None]:
    """Notes the name of the first of SIGNALS meanwhile; whoever runs the loop looks at it and saves what there is.

    unsaved: whether anything would be lost now; a command ends at once where nothing would. A later signal ends a
    command, and elsewhere acts as it did before.
    """
    loop = _Loop(received, unsaved)
    first = math.inf

    def note(number: int, _: FrameType | None) -> None:
        nonlocal first
        if _watchers or clock.monotonic() < first + AGAIN < math.inf:
            return
        if math.isinf(first):
            first = clock.monotonic()
            received.append(name(number))
        else:
            signal.signal(number, before[number])
            signal.raise_signal(number)

    before = _handled(SIGNALS, note)
    try:
        with _among(_loops, loop):
            yield
    finally:
        _restore(before)


@contextmanager
def held() -> Iterator[None]:
    """Has the first signal act after what is done meanwhile; a later one acts at once.

    An exception that a handler raises inside a library's lock may never let go of it, and whoever asks for it next
    waits for ever: closing a netCDF file did.
    """
    received: list[int] = []

    def hold(number: int, _: FrameType | None) -> None:
        received.append(number)
        if len(received) > 1:
            _restore(before)
            signal.raise_signal(number)

    before = {} if _watchers else _handled(SIGNALS, hold)  # no handler of a command raises anything
    try:
        yield
    finally:
        _restore(before)
        if len(received) == 1:
            signal.raise_signal(received[0])


@contextmanager
def under_way(said: Said, resumable: bool = True) -> Iterator[None]:
    """Has `said` say what becomes of the work that goes on meanwhile, if a command is ended in it.

    resumable: whether loops in it have something to save; nothing goes on from runs that a comparison makes.
    """
    with _among(_work, _Work(said, resumable)):
        yield


@contextmanager
def leaving(discard: Callable[[], Any]) -> Iterator[None]:
    """Has `discard` called if a command is ended meanwhile: it removes a file by half, or ends a child."""
    with _among(_leftovers, discard):
        yield


def left_behind(discard: Callable[[], Any]) -> None:
    """The same, from now on."""
    _leftovers.append(discard)


def discard_leftovers() -> None:
    """Remove what work that is ended has begun, the latest first."""
    for discard in reversed(_leftovers.copy()):
        with suppress(OSError):
            discard()


@contextmanager
def watched(end: Callable[[Ended], Any]) -> Iterator[None]:
    """Has `end`, which is to end the process, called in a thread of its own for a signal that no loop is to see."""
    before = _handled(SIGNALS, lambda *_: None)
    if not before:
        yield
        return
    watcher = _Watcher(end)
    fd = signal.set_wakeup_fd(watcher.writer, warn_on_full_buffer=False)
    _watchers.append(watcher)
    watcher.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(fd)
        _watchers.remove(watcher)
        watcher.close()
        _restore(before)


@contextmanager
def _among(things: list[Any], one: Any) -> Iterator[None]:
    """Within, it is one of the things that whoever ends this process looks at."""
    things.append(one)
    try:
        yield
    finally:
        things.remove(one)


def ask(number: int) -> None:
    """Do in a watched process what a signal would."""
    _watchers[-1].take(name(number), 128 + number)


def end_by(deadline: float, what: str, code: int) -> None:
    """Do in a watched process what a signal would at an instant of time.monotonic(), under this name and exit code."""
    for watcher in _watchers:
        watcher.alarm(deadline, what, code)


class _Watcher(threading.Thread):
    """Reads the numbers of signals as the system delivers them, also while the main thread is in compiled code."""

    def __init__(self, end: Callable[[Ended], Any]) -> None:
        super().__init__(name="signals", daemon=True)
        self.end, self.first = end, math.inf
        self.deadline, self.limit = math.inf, ("", 0)
        self.reader, self.writer = os.pipe()
        os.set_blocking(self.writer, False)

    def run(self) -> None:
        while True:
            left = self.deadline - clock.monotonic()
            if not select.select([self.reader], [], [], min(max(0.0, left), _LONGEST))[0]:
                if self.deadline <= clock.monotonic():
                    self.deadline = math.inf
                    self.take(*self.limit)
                continue
            numbers = os.read(self.reader, 64)
            for number in numbers:
                if number in SIGNALS:
                    self.take(name(number), 128 + number)
            if not numbers:
                break
        os.close(self.reader)

    def close(self) -> None:
        os.close(self.writer)
        self.join()

    def alarm(self, deadline: float, what: str, code: int) -> None:
        self.deadline, self.limit = deadline, (what, code)
        with suppress(BlockingIOError):
            os.write(self.writer, bytes(1))  # no signal: the thread looks at the clock

    def take(self, what: str, code: int) -> None:
        if clock.monotonic() < self.first + AGAIN < math.inf:
            return
        work = _work.copy()
        resumable = all(task.resumable for task in work)
        unsaved = [loop for loop in _loops.copy() if loop.unsaved()] if resumable else []
        if unsaved and math.isinf(self.first):
            self.first = clock.monotonic()
            unsaved[-1].received.append(what)
            return
        said = work[0].said(what) if work else None
        self.end(Ended(code, what, said, not unsaved))


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
