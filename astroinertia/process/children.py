"""Programs that this process waits for; they end with it where a signal ends a command."""

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from astroinertia.process import interrupts


def imports_as_here() -> dict[str, str]:
    """The environment for another interpreter, which then imports what this one would, wherever that was found."""
    return os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}


def completed(
    command: Sequence[str], text: str | None = None, env: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """What a program has printed, given a text to read, and its exit code; whatever stops the wait ends the program.

    Tests: tests/crash/test_signals.py.
    """
    with started(command, env) as child:
        output, errors = child.communicate(text)
    return subprocess.CompletedProcess(command, child.returncode, output, errors)


@contextmanager
def started(command: Sequence[str], env: Mapping[str, str] | None = None) -> "Iterator[subprocess.Popen[str]]":
    """A program that runs meanwhile, with pipes for what it reads and prints, and is ended where it has not by then.

    A signal to the group of this process does not reach it: that this process is asked to stop is no failure of it.
    """
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True, env=env, process_group=0) as child:
        try:
            with interrupts.leaving(child.kill):
                yield child
        finally:
            child.kill()
