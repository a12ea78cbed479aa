"""A whole step by processes of MPI against as many threads of one process, and what it sends.

    python tests/benchmarks/processes.py --particles 100000 1000000 --processes 2 --keep

Evrard's cloud with all defaults; the time of a step is the mean of the 16 from one sort to the next. Both kinds of run
take turns, each in processes of its own, and the shortest of several rounds counts. Processes have one thread each.
Bytes are those of results that a process gets from the others. What a process works is its processor time without that
within calls of MPI, which wait by computing; more processes than cores can so be judged, too. Needs mpi4py and an
mpiexec.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from fair_times import machine, publish, rows_of

HEAD = [
    "particles", "precision", "one process, K threads: a step (s)", "K processes: a step (s)", "K", "speed-up ratio",
    "received a step and particle (bytes)", "same bits",
]  # fmt: skip
WORK = ["particles", "precision", "processes", "a process works (s)", "over one alone", "received a step and particle"]
COLLECTIVE = "Allgather", "Allgatherv", "Allreduce"


class Watched:
    """A communicator that counts the processor time within its calls."""

    def __init__(self, communicator: Any) -> None:
        self._communicator, self.spent = communicator, 0.0

    def __getattr__(self, name: str) -> Any:
        function = getattr(self._communicator, name)
        if name not in COLLECTIVE:
            return function

        def called(*arguments: Any) -> Any:
            begin = time.process_time()
            result = function(*arguments)
            self.spent += time.process_time() - begin
            return result

        return called


def of_a_process(particles: int, precision: str, rounds: int) -> None:
    """Take steps as one of the processes that were started; the first prints what it found."""
    from astroinertia.engines import mpi

    with mpi.joined() if mpi.started() > 1 else nullcontext():
        import jax
        import numpy as np
        from evrard_cloud import between_sorts, cloud

        from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS

        with jax.enable_x64(True):
            body, times, works = cloud(particles, precision), [], []
            together: Any = mpi.together()
            watched = Watched(getattr(together, "communicator", None))
            if mpi.started() > 1:
                together.communicator = watched
            between_sorts(body)
            received = getattr(together, "received", 0)
            for _ in range(rounds):
                begin, busy, spent = time.perf_counter(), time.process_time(), watched.spent
                between_sorts(body)
                times.append((time.perf_counter() - begin) / STEPS_BETWEEN_SORTS)
                works.append((time.process_time() - busy - (watched.spent - spent)) / STEPS_BETWEEN_SORTS)
        received = getattr(together, "received", 0) - received
        if mpi.communicator() is None or mpi.communicator().Get_rank() == 0:
            bits = hash(np.asarray(body.state.position).tobytes() + np.asarray(body.state.velocity).tobytes())
            print(json.dumps([min(times), received / (rounds * STEPS_BETWEEN_SORTS * particles), bits, min(works)]))


def measured(
    particles: int, precision: str, rounds: int, processes: int, threads: int
) -> tuple[float, float, int, float]:
    """Seconds of a step, bytes received for it, a hash of where it led to, and processor time of the first process."""
    starter = [] if processes == 1 else [str(_mpiexec()), "-n", str(processes)]
    words = [sys.executable, __file__, "--as-one-of-them", precision, str(rounds), "--particles", str(particles)]
    environment = {**os.environ, "NUMBA_NUM_THREADS": str(threads), "PYTHONHASHSEED": "0"}
    done = subprocess.run([*starter, *words], check=True, capture_output=True, text=True, env=environment)
    seconds, received, bits, work = json.loads(done.stdout.splitlines()[-1])
    return seconds, received, bits, work


def _mpiexec() -> str | Path:
    beside = Path(sys.executable).parent / "mpiexec"
    found = beside if beside.exists() else shutil.which("mpiexec")
    if found is None:
        raise SystemExit("there is no mpiexec: pip install 'astroinertia[mpi]' mpich")
    return found


def row_of(particles: int, precision: str, rounds: int, processes: int) -> list[str]:
    """The row of a number of particles: the best of two turns of either kind."""
    plain = [measured(particles, precision, rounds, 1, processes)]
    several = [measured(particles, precision, rounds, processes, 1)]
    plain.append(measured(particles, precision, rounds, 1, processes))
    several.append(measured(particles, precision, rounds, processes, 1))
    one, many = min(plain), min(several)
    same = len({bits for _, _, bits, _ in plain + several}) == 1
    return [
        f"{particles}", precision, f"{one[0]:.3g}", f"{many[0]:.3g}", f"{processes}", f"{one[0] / many[0]:.2f}",
        f"{many[1]:.0f}", "yes" if same else "NO",
    ]  # fmt: skip


def works(particles: int, precision: str, rounds: int, most: int) -> list[list[str]]:
    """Rows of what one process of 1, 2, 4, ... of one thread each works in a step, and is sent for it."""
    rows, alone = [], 0.0
    for processes in (2**k for k in range(most.bit_length())):
        _, received, _, work = measured(particles, precision, rounds, processes, 1)
        alone = alone or work
        shown = [f"{work:.3g}", f"{work / alone:.3f}", f"{received:.0f}"]
        rows.append([f"{particles}", precision, f"{processes}", *shown])
        print(*rows[-1], flush=True)
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, nargs="+", default=[10_000, 100_000])
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--precisions", nargs="+", default=["mixed", "float64"])
    parser.add_argument(
        "--work", type=int, nargs="+", default=[20_000], help="numbers of particles of the second table"
    )
    parser.add_argument("--most", type=int, default=4, help="how many processes it goes to")
    parser.add_argument("--keep", action="store_true", help="write the table")
    parser.add_argument("--as-one-of-them", nargs=2, metavar=("PRECISION", "ROUNDS"), help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.as_one_of_them:
        precision, rounds = chosen.as_one_of_them
        of_a_process(chosen.particles[0], precision, int(rounds))
        return
    rows = []
    for particles in chosen.particles:
        for precision in chosen.precisions:
            rows.append(row_of(particles, precision, chosen.rounds, chosen.processes))
            print(*rows[-1], flush=True)
    shared = [row for count in chosen.work for name in chosen.precisions
              for row in works(count, name, chosen.rounds, chosen.most)]  # fmt: skip
    text = "# One run by several processes\n\n" + rows_of(HEAD, rows)
    text += "\nWhat one process works in a step, with one thread, as processor time without that within MPI:\n\n"
    text += rows_of(WORK, shared) + f"\n{machine()}.\n"
    publish("processes", text, chosen.keep)


if __name__ == "__main__":
    main()
