"""The density pass, with neighbours, smoothing lengths and sums, against SciPy's search for the neighbours alone.

    python tests/benchmarks/neighbour_search.py --points 10000 100000 --keep

SciPy's cKDTree is asked for as many nearest points as the kernel has neighbours, on all cores, its tree being built in
the time; this code sorts its particles, builds its tree and solves for the smoothing lengths from a guess that is off
by 2 %, as from one step to the next.
"""

import argparse

import numpy as np
from fair_times import best_times, machine, publish, rows_of
from point_sets import SETS, point_set
from scipy.spatial import cKDTree

from astroinertia.engines.numba_cpu import Engine
from astroinertia.engines.threads import available_threads
from astroinertia.sph.kernels import KERNELS, neighbour_number

KERNEL = KERNELS["wendland_c2"]


def measured(name: str, count: int, rounds: int) -> list[list[object]]:
    """Rows for one set: what, milliseconds, ratio."""
    points = point_set(name, count)
    engine, neighbours = Engine(precision="mixed"), round(neighbour_number(KERNEL, KERNEL.eta))
    wrong = 1.0 + 0.02 * np.random.default_rng(4).normal(size=count)

    def density(guess: np.ndarray, sorts: bool = True) -> np.ndarray:
        nonlocal order, arrangement
        if sorts:
            order, arrangement = engine.arrange(points.position, guess)
        found = engine.density(
            arrangement, KERNEL.name, points.position[order], points.mass[order], guess[order], KERNEL.eta, 1e-8, True
        )
        return found.smoothing_length

    order, arrangement = engine.arrange(points.position, points.smoothing_length)
    solved = np.empty(count)
    lengths = density(points.smoothing_length)
    solved[order] = lengths
    actions = {
        "density, sorting included": lambda: density(solved * wrong),
        "density, sorted before": lambda: density(solved * wrong, sorts=False),
        f"cKDTree, {neighbours} nearest": lambda: cKDTree(points.position).query(
            points.position, neighbours, workers=available_threads()
        ),
    }
    times = best_times(actions, rounds)
    judged = list(times.values())[-1]
    return [[name, count, what, f"{1e3 * t:.4g}", f"{judged / t:.1f}"] for what, t in times.items()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", nargs="+", type=int, default=[10_000, 100_000])
    parser.add_argument("--sets", nargs="+", choices=tuple(SETS), default=list(SETS))
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--keep", action="store_true", help="write the table")
    chosen = parser.parse_args()
    rows = [row for name in chosen.sets for count in chosen.points for row in measured(name, count, chosen.rounds)]
    text = f"# Neighbours\n\n{machine()}; the shortest of {chosen.rounds} rounds in turn. Faster: than cKDTree.\n\n"
    publish("neighbour_search", text + rows_of(["set", "points", "what", "time (ms)", "faster by"], rows), chosen.keep)


if __name__ == "__main__":
    main()
