"""How the whole step and gravity grow with the number of particles, and what a second thread gives.

    python tests/benchmarks/scaling.py --particles 1000 10000 100000 1000000 --keep

Evrard's cloud with all defaults, mixed precision; the time of a step is the mean of the 16 from one sort to the next.
One thread and all of them take turns, and the shortest of several rounds counts. Exponents are least-squares fits of
log time against log N.
"""

import argparse
import contextlib
import time
from collections.abc import Callable, Iterator
from typing import Any
from unittest import mock

import numpy as np
from evrard_cloud import between_sorts, cloud, gravity
from fair_times import RESULTS, best_times, machine, publish, rows_of
from numba import config

from astroinertia.engines import tree
from astroinertia.engines.threads import available_threads, share_out
from astroinertia.gravity import multipole
from astroinertia.models.sph import evolution as running
from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS
from astroinertia.models.sph.sorting import rearranged

FITTED_FROM = 10_000  # below, what does not grow with N shows
STEADY = 100_000  # particles up to which the share of a step's parts is looked at
SMALL = 20_000  # particles up to which a round is short enough for four times as many


@contextlib.contextmanager
def threads(number: int) -> Iterator[None]:
    """With so many threads, no more than numba started with."""
    before = config.NUMBA_NUM_THREADS
    config.NUMBA_NUM_THREADS = number
    try:
        yield
    finally:
        config.NUMBA_NUM_THREADS = before


def on_threads(number: int, action: Callable[[], object]) -> Callable[[], None]:
    """The action with so many threads."""

    def act() -> None:
        with threads(number):
            action()

    return act


def measured(particles: int, precision: str, rounds: int) -> dict[tuple[str, int], float]:
    """Seconds of {(what, threads)}."""
    body = cloud(particles, precision)
    actions = {}
    for number in (1, available_threads()):
        actions["whole step", number] = on_threads(number, lambda: between_sorts(body))
        actions["gravity", number] = on_threads(number, lambda: gravity(body))
    times = best_times(actions, rounds * (4 if particles <= SMALL else 1))
    return {key: seconds / (STEPS_BETWEEN_SORTS if key[0] == "whole step" else 1) for key, seconds in times.items()}


def upkeep(particles: int, precision: str, rounds: int) -> float:
    """The share of a step that goes into sorting, trees, refits and gravity's moments; the least of rounds."""
    body, spent, inside = cloud(particles, precision), 0.0, False
    between_sorts(body)

    def timed(function: Callable) -> Callable:
        def act(*arguments: Any, **more: Any) -> Any:
            nonlocal spent, inside
            if inside:  # a refit within a sort counts once
                return function(*arguments, **more)
            inside, begin = True, time.perf_counter()
            try:
                return function(*arguments, **more)
            finally:
                inside, spent = False, spent + time.perf_counter() - begin

        return act

    def moments_timed(function: Callable, *rest: Any) -> None:
        share = timed(share_out) if function.__name__ == "upward" else share_out
        share(function, *rest)

    least = 1.0
    with (
        mock.patch.object(running, "rearranged", timed(rearranged)),
        mock.patch.object(tree, "fit", timed(tree.fit)),
        mock.patch.object(multipole, "share_out", moments_timed),
    ):
        for _ in range(rounds):
            spent, begin = 0.0, time.perf_counter()
            between_sorts(body)
            least = min(least, spent / (time.perf_counter() - begin))
    return least


def exponent(found: dict[int, float]) -> str:
    """Of time against number, from FITTED_FROM on."""
    fitted = {particles: seconds for particles, seconds in found.items() if particles >= FITTED_FROM}
    if len(fitted) < 2:
        return "not fitted"
    return f"{np.polyfit(np.log(list(fitted)), np.log(list(fitted.values())), 1)[0]:.3f}"


def picture(curves: dict[str, dict[int, float]]) -> None:
    """Time against number of particles."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, panel = pyplot.subplots(figsize=(5.0, 4.0), layout="constrained")
    for name, found in curves.items():
        panel.loglog(list(found), list(found.values()), marker="o", label=f"{name}, exponent {exponent(found)}")
    panel.set(xlabel="particles", ylabel="time (s)")
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8)
    figure.savefig(RESULTS / "scaling.png", dpi=90)
    pyplot.close(figure)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", nargs="+", type=int, default=[1000, 3000, 10_000, 30_000, 100_000])
    parser.add_argument("--precision", choices=("mixed", "float64"), default="mixed")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--keep", action="store_true", help="write the table and a picture")
    chosen = parser.parse_args()
    most, rows = available_threads(), []
    curves: dict[str, dict[int, float]] = {"whole step": {}, "gravity": {}}
    for particles in chosen.particles:
        times = measured(particles, chosen.precision, chosen.rounds)
        for what, curve in curves.items():
            one, all_of_them = times[what, 1], times[what, most]
            curve[particles] = all_of_them
            rows.append([
                particles, what, f"{1e3 * one:.4g}", f"{1e3 * all_of_them:.4g}", f"{one / all_of_them:.2f}",
                f"{particles / all_of_them / 1e6:.3f}",
            ])  # fmt: skip
    text = f"# Scaling of Evrard's cloud, {chosen.precision} precision\n\n{machine()}; wall time.\n\n"
    head = ["particles", "what", "1 thread (ms)", f"{most} threads (ms)", "faster by", "million/s"]
    text += rows_of(head, rows) + "\nExponent of the time against N, from 10,000 on: "
    text += ", ".join(f"{what} {exponent(curve)}" for what, curve in curves.items()) + ".\n"
    share = upkeep(largest := max(n for n in chosen.particles if n <= STEADY), chosen.precision, chosen.rounds)
    text += f"\nSorting, trees, refits and moments take {100 * share:.1f} % of a step with {largest} particles.\n"
    publish("scaling", text, chosen.keep)
    if chosen.keep:
        picture(curves)


if __name__ == "__main__":
    main()
