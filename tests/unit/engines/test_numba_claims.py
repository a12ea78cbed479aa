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

import numpy as np
import pytest
from numba import float64, int64
from numba.core import event

from astroinertia.engines.numba_cache import load_module
from astroinertia.engines.numba_claims import compile_once, shared
from astroinertia.engines.threads import share_out
from astroinertia.process import activity

SIGNATURE = int64[::1], int64, float64[::1]
TEXT = """
from numba import njit


@njit(cache=True)
def doubled(counter, value, result):
    result[0] = 2 * value + {more}
"""
# Claims the program, where it is not on disk, says so, and compiles it when asked to.
OTHER = """
import sys
import numpy as np
from astroinertia.engines.numba_cache import load_module
from astroinertia.engines.numba_claims import shared
from astroinertia.engines.threads import share_out

def missed():
    print("claimed", flush=True)
    if sys.stdin.readline().strip() != "compile":
        sys.exit()

descriptor, text = int(sys.argv[1]), sys.argv[2]
with shared(descriptor, missed):
    share_out(load_module("doubled", text).doubled, 1, 1, np.empty(1))
"""


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.setenv("ASTROINERTIA_CACHE", str(tmp_path))
    tmp_path.chmod(0o700)
    with tempfile.TemporaryFile() as opened:
        yield opened.fileno()


def command(descriptor: int, text: str) -> list[str]:
    return [sys.executable, "-c", OTHER, str(descriptor), text]


@contextmanager
def other(descriptor: int, text: str) -> Iterator[Any]:
    pipe = subprocess.PIPE
    with subprocess.Popen(
        command(descriptor, text), stdin=pipe, stdout=pipe, pass_fds=[descriptor], text=True
    ) as child:
        try:
            assert child.stdout is not None and child.stdout.readline() == "claimed\n"
            yield child
        finally:
            child.kill()


def called(function: Any, value: int) -> float:
    share_out(function, 1, value, result := np.empty(1))
    return float(result[0])


def called_meanwhile(descriptor: int, function: Any, then: Any) -> tuple[float, str, int]:
    """What it returns for 3, the words while it waits, and how many functions were compiled here."""
    result: list[float] = []

    def call() -> None:
        with shared(descriptor, lambda: None):
            result.append(called(function, 3))

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


@pytest.mark.full
def test_what_another_process_compiles_is_waited_for_and_found(file) -> None:
    text = TEXT.format(more=os.getpid())
    with other(file, text) as child:
        doubled = load_module("doubled", text).doubled
        compile_once(file, doubled, SIGNATURE, patient=False)
        assert not doubled.signatures  # that is left to the other
        result, words, compiled = called_meanwhile(file, doubled, lambda: child.communicate("compile\n"))
    assert (result, words, compiled) == (6 + os.getpid(), "compiling doubled", 0)


@pytest.mark.slow
def test_what_a_killed_process_was_to_compile_is_compiled_here(file) -> None:
    text = TEXT.format(more=-os.getpid())
    with other(file, text) as child:
        doubled = load_module("doubled", text).doubled
        result, _, compiled = called_meanwhile(file, doubled, child.kill)
    assert (result, compiled) == (6 - os.getpid(), 1)


@pytest.mark.slow
def test_a_program_is_free_again_once_it_is_kept_and_nothing_is_claimed_afterwards(file) -> None:
    missed: list[None] = []
    text = TEXT.format(more=0.5)
    doubled = load_module("doubled", text).doubled
    with shared(file, lambda: missed.append(None)):
        assert called(doubled, 1) == 2.5
        assert called(doubled, 2) == 4.5 and len(missed) == 1
        found = subprocess.run(command(file, text), pass_fds=[file], capture_output=True, timeout=60.0, check=True)
        assert not found.stdout  # nor does it wait
    text = TEXT.format(more=1.5)
    with other(file, text):
        assert called(load_module("doubled", text).doubled, 1) == 3.5 and len(missed) == 1
