"""Programs that this process waits for; they end with it where a signal ends a command."""

import subprocess
from collections.abc import Mapping, Sequence

from astroinertia import interrupts


def completed(
    command: Sequence[str], asked: str | None = None, env: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """What a program has printed, given a text to read, and its exit code; whatever stops the wait ends the program.

    Tests: tests/crash/test_signals.py.
    """
    given = subprocess.DEVNULL if asked is None else subprocess.PIPE
    with subprocess.Popen(
        command, stdin=given, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env
    ) as child:
        try:
            with interrupts.leaving(child.kill):
                output, errors = child.communicate(asked)
        except BaseException:
            child.kill()
            raise
    return subprocess.CompletedProcess(command, child.returncode, output, errors)
