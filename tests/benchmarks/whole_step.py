"""The whole step of Evrard's cloud, against the time of pytreegrav's quadrupole gravity alone in the same run.

    python tests/benchmarks/whole_step.py --particles 100000 1000000 --keep

Density with smoothing lengths, pressure, viscosity with reconstruction and switch, gravity, ledger, time step, sorting:
the mean of the 16 steps from one sort to the next, the shortest of several such rounds; kernel, neighbour number and
tolerances at their defaults. The force error is that of the timed run, on a sample against a direct sum. Freed memory
is kept for all, as in `astroinertia run`.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np
from evrard_cloud import between_sorts, cloud, gravity
from fair_times import best_times, clock_of, machine, publish, rows_of
from gravity_codes import QUADRUPOLE, kernel_softened, present
from gravity_peers import JUDGED, errors
from point_sets import PointSet

from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS
from astroinertia.process.freed_memory import keep_freed_memory
from astroinertia.sph.kernels import KERNELS

SAMPLE = 1000


def force_errors(points: PointSet, acceleration: np.ndarray, kernel: str) -> dict[str, float]:
    """Errors of gravity in a run, against a direct sum for a sample of its particles."""
    count = len(points.mass)
    sample = np.sort(np.random.default_rng(6).choice(count, min(SAMPLE, count), replace=False))
    return errors(acceleration[sample], kernel_softened(points, sample, KERNELS[kernel]))


def measured(
    particles: int, precisions: list[str], rounds: int, clock: Callable[[], float] = time.perf_counter
) -> list[list[object]]:
    """Rows for one number of particles: what, milliseconds, ratio, million updates a second, force errors."""
    clouds = {precision: cloud(particles, precision) for precision in precisions}
    points = gravity(clouds[precisions[0]])[0]
    actions = {precision: lambda each=each: between_sorts(each) for precision, each in clouds.items()}
    for peer in present((QUADRUPOLE,)):
        actions[peer.name] = peer.action(points, JUDGED)
    times = best_times(actions, rounds, clock)
    rows = []
    for name in actions:
        seconds = times[name] / (STEPS_BETWEEN_SORTS if name in clouds else 1)
        ratio = f"{seconds / times[QUADRUPOLE.name]:.3f}" if QUADRUPOLE.name in times else ""
        errors = ["", "", ""]
        if name in clouds:
            found = force_errors(*gravity(clouds[name]), clouds[name].problem.kernel)
            errors = [f"{found[kind]:.1e}" for kind in ("median", "rms", "p99")]
        what = f"whole step, {name}" if name in clouds else f"{name}, {JUDGED}"
        rows.append([particles, what, f"{1e3 * seconds:.4g}", ratio, f"{particles / seconds / 1e6:.3f}", *errors])
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", nargs="+", type=int, default=[10_000, 100_000])
    parser.add_argument("--precision", nargs="+", choices=("mixed", "float64"), default=["mixed", "float64"])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--processor-time", action="store_true", help="count processor time, not wall time")
    parser.add_argument("--keep", action="store_true", help="write the table")
    chosen = parser.parse_args()
    keep_freed_memory()
    rows = []
    clock, kind = clock_of(chosen.processor_time)
    for particles in chosen.particles:
        rows += measured(particles, chosen.precision, chosen.rounds, clock)
    head = ["particles", "what", "time (ms)", "ratio", "million/s", "median", "rms", "99th percentile"]
    text = (
        f"# The whole step of Evrard's cloud\n\n{machine()}; {kind}, the shortest of {chosen.rounds} rounds in turn.\n"
    )
    text += f"Ratio: to pytreegrav's quadrupole gravity at {JUDGED}. Last columns: errors of gravity in the run.\n\n"
    publish("whole_step", text + rows_of(head, rows), chosen.keep)


if __name__ == "__main__":
    main()
