"""A whole step by processes of MPI against as many threads of one process, and what it sends.

    python tests/benchmarks/processes.py --particles 100000 1000000 --processes 2 --keep

Evrard's cloud with all defaults; the time of a step is the mean of the 16 from one sort to the next. Both kinds of run
take turns, each in processes of its own, and the shortest of several rounds counts. Processes have one thread each.
Bytes are those of results that a process gets from the others. Needs mpi4py and an mpiexec.
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

from fair_times import machine, publish, rows_of

HEAD = [
    "particles", "precision", "one process, K threads: a step (s)", "K processes: a step (s)", "K", "speed-up ratio",
    "received a step and particle (bytes)", "same bits",
]  # fmt: skip


def of_a_process(particles: int, precision: str, rounds: int) -> None:
    """Take steps as one of the processes that were started; the first prints what it found."""
    from astroinertia.engines import mpi

    with mpi.joined() if mpi.started() > 1 else nullcontext():
        import jax
        import numpy as np
        from evrard_cloud import between_sorts, cloud

        from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS

        with jax.enable_x64(True):
            body, times = cloud(particles, precision), []
            between_sorts(body)
            received = getattr(mpi.together(), "received", 0)
            for _ in range(rounds):
                begin = time.perf_counter()
                between_sorts(body)
                times.append((time.perf_counter() - begin) / STEPS_BETWEEN_SORTS)
        received = getattr(mpi.together(), "received", 0) - received
        if mpi.communicator() is None or mpi.communicator().Get_rank() == 0:
            bits = hash(np.asarray(body.state.position).tobytes() + np.asarray(body.state.velocity).tobytes())
            print(json.dumps([min(times), received / (rounds * STEPS_BETWEEN_SORTS * particles), bits]))


def measured(particles: int, precision: str, rounds: int, processes: int, threads: int) -> tuple[float, float, int]:
    """Seconds of a step, bytes received for it and a hash of where it led to."""
    starter = [] if processes == 1 else [str(_mpiexec()), "-n", str(processes)]
    words = [sys.executable, __file__, "--as-one-of-them", precision, str(rounds), "--particles", str(particles)]
    environment = {**os.environ, "NUMBA_NUM_THREADS": str(threads), "PYTHONHASHSEED": "0"}
    done = subprocess.run([*starter, *words], check=True, capture_output=True, text=True, env=environment)
    seconds, received, bits = json.loads(done.stdout.splitlines()[-1])
    return seconds, received, bits


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
    same = len({bits for *_, bits in plain + several}) == 1
    return [
        f"{particles}", precision, f"{one[0]:.3g}", f"{many[0]:.3g}", f"{processes}", f"{one[0] / many[0]:.2f}",
        f"{many[1]:.0f}", "yes" if same else "NO",
    ]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, nargs="+", default=[10_000, 100_000])
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--precisions", nargs="+", default=["mixed", "float64"])
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
    text = "# One run by several processes\n\n" + rows_of(HEAD, rows) + f"\n{machine()}.\n"
    publish("processes", text, chosen.keep)


if __name__ == "__main__":
    main()
