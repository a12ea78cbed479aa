"""Of two processes one compiles a program, and the other waits for it; a process that ends holds up nobody."""

import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from numba.core import event
from numba.core.caching import Cache

from astroinertia.engines.numba_cache import load_module
from astroinertia.engines.numba_claims import claimed, shared
from astroinertia.process import activity

TEXT = """
from numba import njit


@njit(cache=True)
def doubled(value):
    return 2 * value + {more}
"""
# Claims the program, says so, and compiles it when asked to.
OTHER = """
import sys
from astroinertia.engines.numba_cache import load_module
from astroinertia.engines.numba_claims import claimed, shared

descriptor, text = int(sys.argv[1]), sys.argv[2]
doubled = load_module("doubled", text).doubled
with shared(descriptor, lambda: None):
    assert claimed(descriptor, doubled._cache)
    print("claimed", flush=True)
    if sys.stdin.readline().strip() == "compile":
        doubled(1)
"""


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.setenv("ASTROINERTIA_CACHE", str(tmp_path))
    tmp_path.chmod(0o700)
    with tempfile.TemporaryFile() as opened:
        yield opened.fileno()


@contextmanager
def other(descriptor: int, text: str) -> Iterator[Any]:
    command = [sys.executable, "-c", OTHER, str(descriptor), text]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, pass_fds=[descriptor], text=True) as child:
        try:
            assert child.stdout is not None and child.stdout.readline() == "claimed\n"
            yield child
        finally:
            child.kill()


def called_meanwhile(descriptor: int, function: Any, then: Any) -> tuple[int, str, int]:
    """What it returns for 3, the words while it waits, and how many functions were compiled here."""
    result: list[int] = []

    def call() -> None:
        with shared(descriptor, lambda: None):
            result.append(function(3))

    with event.install_recorder("numba:compile") as recorder:
        caller = threading.Thread(target=call)
        caller.start()
        deadline = time.monotonic() + 60.0
        while not (words := activity.current()):
            assert caller.is_alive() and time.monotonic() < deadline
            time.sleep(0.01)
        caller.join(0.5)
        assert caller.is_alive() and not result
        then()
        caller.join(60.0)
    return result[0], words, sum(happened.is_start for _, happened in recorder.buffer)


def test_what_another_process_compiles_is_waited_for_and_found(file) -> None:
    text = TEXT.format(more=os.getpid())
    with other(file, text) as child:
        doubled = load_module("doubled", text).doubled
        assert not claimed(file, doubled._cache)
        result, words, compiled = called_meanwhile(file, doubled, lambda: child.communicate("compile\n"))
    assert (result, words, compiled) == (6 + os.getpid(), "compiling doubled", 0)


def test_what_a_killed_process_was_to_compile_is_compiled_here(file) -> None:
    text = TEXT.format(more=-os.getpid())
    with other(file, text) as child:
        doubled = load_module("doubled", text).doubled
        result, _, compiled = called_meanwhile(file, doubled, child.kill)
    assert (result, compiled) == (6 - os.getpid(), 1)


def test_a_program_is_free_again_once_it_is_kept_and_numba_is_left_as_it_was(file) -> None:
    load, save = Cache.load_overload, Cache.save_overload
    missed: list[None] = []
    text = TEXT.format(more=0.5)
    doubled = load_module("doubled", text).doubled
    with shared(file, lambda: missed.append(None)):
        assert doubled(1) == 2.5
        assert doubled(2) == 4.5 and len(missed) == 1
        with other(file, text):  # which can claim it
            pass
    assert (Cache.load_overload, Cache.save_overload) == (load, save)
