"""Runs the scene of its command line again and again, each time in a process of its own that can be killed.

It reads names of run folders, one a line. Each is run, or gone on with, by a fork, which spares the imports; it prints
the fork's process number, the steps that it has taken and, once it has ended, with what status. Another line lets go of
that number.
"""

import os
import sys
import traceback
from pathlib import Path

import astroinertia.accuracy.running  # before the forks, which share what is imported
from astroinertia.storage import manifest
from tests.few_with_steps import split_few


def live(scene: str, settings: list[str], folder: Path) -> None:
    def tell(progress):
        os.write(1, f"step {progress.step}\n".encode())

    if (folder / manifest.MANIFEST).exists():
        astroinertia.resume(folder, tell)
    else:
        astroinertia.run_scene(astroinertia.load(scene, settings), folder, tell)


def main() -> None:
    scene, *settings = sys.argv[1:]
    split_few()
    while line := sys.stdin.readline():
        child = os.fork()
        if child == 0:
            try:
                live(scene, settings, Path(line.strip()))
            except BaseException:
                traceback.print_exc()
                os._exit(1)
            os._exit(0)
        os.write(1, f"process {child}\n".encode())
        ended = os.waitid(os.P_PID, child, os.WEXITED | os.WNOWAIT)  # its number stays taken until it is reaped
        os.write(1, f"ended {ended.si_status}\n".encode())
        sys.stdin.readline()
        os.waitpid(child, 0)


if __name__ == "__main__":
    main()
