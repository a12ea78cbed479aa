"""Scenes given to the command line by a process that serves many of them, and what it says while it works.

    python -m tests.hard.judged_scenes      reads lines of JSON, the arguments of a command each, until there are none

Time is that of the processor, so that a busy machine judges as a quiet one does: a command is silent where it works
longer than SILENT without a line on the screen, and by the clock too, for compilers have threads; it hangs where it
works longer than LONGEST.
"""

import json
import os
import subprocess
import sys
import time
import traceback
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
SILENT, LONGEST = 10.0, 60.0  # seconds of processor time
STOPPED = 900.0  # seconds of the clock, after which a process that does not work at all is ended
MOST_MEMORY = 4 * 2**30  # bytes of data
TICK = os.sysconf("SC_CLK_TCK")
ENDED = "\x1eended "
# One thread, whose time is that of the process.
ALONE = {"NUMBA_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "COLUMNS": "200",
         "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"}  # fmt: skip


@dataclass(frozen=True)
class Verdict:
    """How a command ended. code: None where it hung; silence, seconds: of processor time, the longest and in all."""

    code: int | None
    said: str
    silence: float
    seconds: float

    @property
    def fault(self) -> str:
        """What is wrong with it; empty where it ended well, or with one sentence."""
        if self.code is None:
            return "no answer"
        if "Traceback" in self.said:
            return "traceback: " + self.said.strip().split("\n")[-1]
        complaints = [line for line in self.said.split("\n") if line.startswith("astroinertia: ")]
        if self.code not in (0, 1, 2):
            return f"exit code {self.code}"
        if self.code and not complaints:
            return "no sentence"
        return f"silence of {self.silence:.0f} s" if self.silence > SILENT else ""

    @property
    def refusal(self) -> str:
        """The sentence that it ended with; empty where it ended well."""
        complaints = [line for line in self.said.split("\n") if line.startswith("astroinertia: ")]
        return complaints[-1] if self.code and complaints else ""


class Judge:
    """A process that carries out commands one after the other; another takes its place where it must be ended."""

    def __init__(self) -> None:
        self.child: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> "Judge":
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def judged(self, *arguments: object) -> Verdict:
        """What one command does."""
        if self.child is None:
            self.child = subprocess.Popen(
                [sys.executable, "-m", "tests.hard.judged_scenes"], cwd=ROOT, env={**os.environ, **ALONE},
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            )  # fmt: skip
        child = self.child
        assert child.stdin is not None and child.stdout is not None
        os.set_blocking(child.stdout.fileno(), False)
        begun, opened = _worked(child.pid), time.monotonic()
        child.stdin.write(json.dumps([str(each) for each in arguments]).encode() + b"\n")
        child.stdin.flush()
        said, last, silence, now, heard = "", begun, 0.0, begun, opened
        while True:
            some = child.stdout.read()
            now = _worked(child.pid) if child.poll() is None else now
            silence = max(silence, min(now - last, time.monotonic() - heard))
            if some:
                said, last, heard = said + some.decode(errors="replace"), now, time.monotonic()
            if ENDED in said and said.endswith("\n"):
                said, _, code = said.rpartition(ENDED)
                return Verdict(int(code), said, silence, now - begun)
            if child.poll() is not None:
                self._end()
                return Verdict(child.returncode, said, silence, now - begun)
            if now - begun > LONGEST or time.monotonic() - opened > STOPPED:
                self._end()
                return Verdict(None, said, silence, now - begun)
            time.sleep(0.02)

    def _end(self) -> None:
        if self.child is not None:
            self.child.kill()
            self.child.communicate()
        self.child = None


def _worked(process: int) -> float:
    """Seconds that a process has worked."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / TICK


def main() -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_DATA, (MOST_MEMORY, resource.RLIM_INFINITY))
    from astroinertia.cli.main import main as command

    os.dup2(1, 2)
    for line in sys.stdin:
        code = 9
        try:
            code = command(json.loads(line))
        except SystemExit as ended:
            code = int(ended.code or 0)
        except BaseException:
            traceback.print_exc()
        sys.stderr.flush()
        sys.stdout.write(f"{ENDED}{code}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
