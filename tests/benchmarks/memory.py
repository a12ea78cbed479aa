"""Bytes a particle: what a run of Evrard's cloud holds, and the most that a step takes.

    python tests/benchmarks/memory.py --particles 100000 1000000 --keep

Resident memory of a process of its own, over that of the same process with a few particles, after three steps and a
record; Linux only, as it counts there what the kernel tells of a process. What the plan tells (costs/machine.py)
is the larger of those found, rounded up. As in `astroinertia run`, freed memory is kept.
"""

import argparse
import itertools
import multiprocessing
from pathlib import Path

from evrard_cloud import cloud
from fair_times import machine, publish, rows_of

from astroinertia.process.freed_memory import keep_freed_memory

FEW = 2000
STATUS, CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def resident(kind: str) -> int:
    """Bytes of this process: VmRSS now, VmHWM the most since it was last forgotten."""
    line = next(line for line in STATUS.read_text().splitlines() if line.startswith(kind))
    return 1024 * int(line.split()[1])


def measured(particles: int, precision: str, steps: str) -> tuple[float, float, float]:
    """Bytes a particle: held between steps, at most in a step, at most in a record."""
    keep_freed_memory()
    setting = f'numerics.timesteps="{steps}"'
    small = cloud(FEW, precision, setting)
    small.advance(small.end)
    small.record(None)
    del small
    begin = resident("VmRSS")
    run = cloud(particles, precision, setting)
    found = []
    for act in (lambda: [run.advance(run.end) for _ in range(3)], lambda: run.record(None)):
        CLEAR.write_text("5")  # forget the peak
        act()
        found.append((resident("VmHWM") - begin) / particles)
    return (resident("VmRSS") - begin) / particles, *found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--particles", type=int, nargs="+", default=[100_000])
    parser.add_argument("--precision", nargs="+", default=["mixed", "float64"])
    parser.add_argument("--steps", nargs="+", default=["global", "individual"])
    parser.add_argument("--keep", action="store_true", help="write the table to tests/benchmarks/results")
    chosen = parser.parse_args()
    rows = []
    for case in itertools.product(chosen.particles, chosen.precision, chosen.steps):
        with multiprocessing.get_context("spawn").Pool(1) as process:
            held, step, record = process.apply(measured, case)
        rows.append([*case, f"{held:.0f}", f"{step:.0f}", f"{record:.0f}", f"{1e7 * step / 1e9:.1f}"])
    head = ["particles", "precision", "steps", "held", "in a step", "in a record", "GB in a step with 1e7"]
    text = f"# Bytes a particle, Evrard's cloud\n\n{machine()}\n\n{rows_of(head, rows)}"
    publish("memory", text, chosen.keep)


if __name__ == "__main__":
    main()
