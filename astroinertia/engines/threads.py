"""Compiled loops shared out over threads: every thread runs the same function and takes its work from one counter.

The functions release Python's lock, so plain threads do; nothing depends on which of them does what.
"""

import functools
import os
from collections.abc import Callable
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

noting: ContextVar[Callable[..., None] | None] = ContextVar("noting", default=None)
"""What notes passes in place of carrying them out, and may make up their results."""

compiling: ContextVar[Callable[..., None] | None] = ContextVar("compiling", default=None)
"""What compiles a program for its arguments before it is run with them, where not numba as it comes to it."""


def available_threads() -> int:
    """Threads that a loop is shared out over unless set otherwise: NUMBA_NUM_THREADS, or the processor's cores."""
    from numba import config  # only here: what only describes loops need not wait for it

    return int(config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]


def share_out(function: Callable[..., Any], threads: int, *arguments: Any) -> None:
    """Run function(counter, *arguments) on every thread; counter (1,) int64 starts at 0 and is theirs to count on."""
    counter = np.zeros(1, np.int64)
    if (compile_first := compiling.get()) is not None:
        compile_first(function, counter, *arguments)
    if threads == 1:
        function(counter, *arguments)
        return
    others = [_pool(os.getpid(), threads - 1).submit(function, counter, *arguments) for _ in range(threads - 1)]
    try:
        function(counter, *arguments)
    finally:
        for other in others:
            other.result()


def carry_out(function: Callable[..., Any], threads: int, *arguments: Any) -> bool:
    """Share a pass out, unless somebody only notes which passes there are; whether it was carried out."""
    if (note := noting.get()) is None:
        share_out(function, threads, *arguments)
        return True
    note(function, *arguments)
    return False


@functools.lru_cache(maxsize=4)
def _pool(process: int, threads: int) -> "ThreadPoolExecutor":
    from concurrent.futures import ThreadPoolExecutor

    # A forked process has none of its parent's threads, and must start its own.
    return ThreadPoolExecutor(threads, thread_name_prefix=f"pair-sums-{process}")
