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

from numba.core.caching import Cache

from astroinertia.process import activity

BYTES_OF_A_NAME = 7  # places in a file are signed numbers of eight bytes


@contextmanager
def shared(descriptor: int, missed: Callable[[], None]) -> Iterator[None]:
    """Within, programs that another process compiles with the same file are waited for, not compiled once more.

    descriptor: of the file, open for writing; missed: called before each program that is not on disk is compiled here
    or waited for.
    """
    load, save = Cache.load_overload, Cache.save_overload

    def loaded(cache: Any, signature: Any, context: Any) -> Any:
        found = load(cache, signature, context)
        if found is not None:
            return found
        missed()
        if not claimed(descriptor, cache):
            _wait_for(descriptor, cache)
            found = load(cache, signature, context)
            if found is not None:
                _let_go(descriptor, cache)
        return found

    def saved(cache: Any, signature: Any, data: Any) -> None:
        try:
            save(cache, signature, data)
        finally:
            _let_go(descriptor, cache)

    Cache.load_overload, Cache.save_overload = loaded, saved  # type: ignore[method-assign]
    try:
        yield
    finally:
        Cache.load_overload, Cache.save_overload = load, save  # type: ignore[method-assign]


def claimed(descriptor: int, cache: Any) -> bool:
    """Whether the program of a cache is this process's to compile from now on; not where another compiles it."""
    try:
        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, _place(cache))
    except BlockingIOError:
        return False
    return True


def _wait_for(descriptor: int, cache: Any) -> None:
    words = f"compiling {cache._py_func.__name__.replace('_', ' ').strip()}"
    activity.begin(words)
    try:
        fcntl.lockf(descriptor, fcntl.LOCK_EX, 1, _place(cache))
    finally:
        activity.end(words)


def _let_go(descriptor: int, cache: Any) -> None:
    fcntl.lockf(descriptor, fcntl.LOCK_UN, 1, _place(cache))


def _place(cache: Any) -> int:
    function = cache._py_func
    name = hashlib.sha256(f"{function.__module__}.{function.__qualname__}".encode()).digest()
    return int.from_bytes(name[:BYTES_OF_A_NAME], "big")
