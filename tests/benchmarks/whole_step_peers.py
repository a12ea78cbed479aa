"""The whole step of Evrard's cloud here, with SWIFT and with Phantom: the same particles, all of them in every step.

    python tests/benchmarks/whole_step_peers.py --swift src/swift --phantom bin/phantom --particles 100000 --keep

Both are built as evrard_codes.py says, Phantom with IND_TIMESTEPS=no. Here it is the mean of the 16 steps from one sort
to the next; of the others a run of 20 steps less one of 4 (of a million particles 6 less 2), and SWIFT's are so short
that all particles are in each. All take turns, and the shortest counts. Processor time is that of all threads, shared
out over them. Viscosity, kernel and tolerances are each code's defaults, with 58 to 60 neighbours; SWIFT's gravity is
as in its own example of this problem.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from evrard_cloud import between_sorts, cloud
from evrard_codes import HEAT, Length, Ran, run_phantom, run_swift
from fair_times import machine, processor_clock, publish, rows_of

from astroinertia.engines.threads import available_threads
from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS, Particles
from astroinertia.process.freed_memory import keep_freed_memory
from astroinertia.test_problems.matter import Matter

FEW, MANY = 4, 20  # steps of a run whose opening is to be taken off, and of one to take it from
LARGE, OF_LARGE = 10**6, (2, 6)  # the same of so many particles and more
LONGEST = 1e-4  # of SWIFT's steps: below the least of a million particles
Times = tuple[float, float]  # wall and processor time in seconds


def own_steps(particles: Particles) -> Times:
    """Steps here from one sort to the next."""
    wall, processor = time.perf_counter(), processor_clock()
    between_sorts(particles)
    return time.perf_counter() - wall, processor_clock() - processor


def steps_of(run: Callable[..., Ran], program: Path, matter: Matter, steps: int) -> Times:
    """So many steps of another code, with its opening."""
    threads = available_threads()
    ran = run(program, matter, Length(end=1.2, every=1.2, longest=LONGEST, steps=steps), threads)
    return ran.wall, ran.processor / threads


def measured(particles: int, programs: dict[str, tuple[Callable[..., Ran], Path]], rounds: int) -> list[list[object]]:
    """Rows for one number of particles: code, milliseconds, ratios to ours, million updates a second."""
    clouds = {f"here, {precision}": cloud(particles, precision) for precision in ("mixed", "float64")}
    few, many = (FEW, MANY) if particles < LARGE else OF_LARGE
    state = clouds["here, mixed"].state
    matter = Matter(state.mass, state.position, state.velocity, np.full(particles, HEAT))
    actions: dict[tuple[str, int], Callable[[], Times]] = {
        (name, STEPS_BETWEEN_SORTS): lambda each=each: own_steps(each) for name, each in clouds.items()
    }
    for name, (run, program) in programs.items():
        for steps in (few, many):
            actions[name, steps] = lambda r=run, p=program, n=steps: steps_of(r, p, matter, n)
    for each in clouds.values():
        between_sorts(each)  # compiles
    taken = {key: np.full(2, np.inf) for key in actions}
    for _ in range(rounds):
        for key, action in actions.items():
            taken[key] = np.minimum(taken[key], action())
    found = {name: taken[name, STEPS_BETWEEN_SORTS] / STEPS_BETWEEN_SORTS for name in clouds}
    found |= {name: (taken[name, many] - taken[name, few]) / (many - few) for name in programs}
    ours = found["here, mixed"]
    rows: list[list[object]] = []
    for name, seconds in found.items():
        cells = [*(f"{1e3 * each:.4g}" for each in seconds), *(f"{each:.2f}" for each in seconds / ours)]
        rows.append([particles, name, *cells, f"{particles / seconds[0] / 1e6:.3f}"])
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", nargs="+", type=int, default=[10_000, 100_000])
    parser.add_argument("--swift", type=Path, help="program swift")
    parser.add_argument("--phantom", type=Path, help="program phantom, with global steps")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--keep", action="store_true", help="write the table")
    chosen = parser.parse_args()
    keep_freed_memory()
    programs = {"SWIFT": (run_swift, chosen.swift), "Phantom": (run_phantom, chosen.phantom)}
    given = {name: (run, program) for name, (run, program) in programs.items() if program}
    rows = [row for particles in chosen.particles for row in measured(particles, given, chosen.rounds)]
    words = __doc__.strip().split("\n\n")
    head = ["particles", "code", "wall (ms)", "processor (ms)", "times ours, wall", "processor", "million updates/s"]
    text = f"# {words[0]}\n\n{words[2]}\n\n{machine()}; the shortest of {chosen.rounds} rounds.\n\n"
    publish("whole_step_peers", text + rows_of(head, rows), chosen.keep)


if __name__ == "__main__":
    main()
