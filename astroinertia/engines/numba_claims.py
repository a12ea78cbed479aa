"""Processes that compile for each other: each program is compiled by one of them, and found by the others on disk.

Numba's cache keeps programs for whoever comes later, and does not know who is compiling one now. Here a process locks
a byte of a file that the processes share while it compiles a program: the byte that its name stands for. The system
lets go of the locks of a process that ends, however it ends, and of a file without a name nothing is left.
Tests: tests/unit/engines/test_numba_claims.py.
"""

import fcntl
import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.event import Event, Listener, install_listener

from astroinertia.engines.threads import compiling
from astroinertia.process import activity

BYTES_OF_A_NAME = 7  # places in a file are signed numbers of eight bytes


@contextmanager
def shared(descriptor: int, missed: Callable[[], None]) -> Iterator[None]:
    """Within, programs that another process compiles with the same file are waited for, not compiled once more.

    descriptor: of the file, open for writing; missed: called before each program that is not on disk is compiled here.
    """
    ready = set()

    def compile_first(function: Any, *arguments: Any) -> None:
        if function not in ready and hasattr(function, "compile"):  # with numba switched off it is plain Python
            compile_once(descriptor, function, tuple(map(function.typeof_pyval, arguments)))
            ready.add(function)

    before = compiling.set(compile_first)
    try:
        with install_listener("numba:compile", _Missed(missed)):
            yield
    finally:
        compiling.reset(before)


def compile_once(descriptor: int, function: Any, signature: tuple, patient: bool = True) -> None:
    """Compile a program, or find it on disk; what another process compiles is waited for, or left to that."""
    place = _place(function.py_func)
    try:
        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, place)
    except BlockingIOError:
        if not patient:
            return
        with activity.under_way(f"compiling {function.py_func.__name__.replace('_', ' ').strip()}"):
            fcntl.lockf(descriptor, fcntl.LOCK_EX, 1, place)
    try:
        function.compile(signature)
    finally:
        fcntl.lockf(descriptor, fcntl.LOCK_UN, 1, place)


class _Missed(Listener):
    """Calls a function when a program that is kept on disk is compiled; what is found there is not an event."""

    def __init__(self, missed: Callable[[], None]) -> None:
        self._missed = missed

    def on_start(self, event: Event) -> None:
        if (event.data or {})["dispatcher"].stats.cache_path:
            self._missed()

    def on_end(self, event: Event) -> None:
        pass


def _place(function: Callable) -> int:
    name = hashlib.sha256(f"{function.__module__}.{function.__qualname__}".encode()).digest()
    return int.from_bytes(name[:BYTES_OF_A_NAME], "big")
