"""Where multipoles become cheaper than direct sums, and what their error costs: the figures of scene/gravity_costs.py.

    python tests/benchmarks/gravity_crossover.py --keep

Both as a step takes them, particles being sorted and their tree made beforehand: Evrard's cloud at rest.
"""

import argparse

import numpy as np
from evrard_cloud import cloud, gravity
from fair_times import best_times, machine, publish, rows_of

from astroinertia.effects.entries import FORCE_ERROR

COUNTS = (100, 300, 1000, 3000, 10_000)
ERRORS = (1e-3, 1e-4, 1e-5, 1e-6)
MANY = 30_000  # particles at which the cost of an error is taken


def measured(particles: int, precision: str, rounds: int, methods: dict[str, str]) -> dict[str, float]:
    """Seconds of an evaluation by {name: settings of gravity}."""
    bodies = {name: cloud(particles, precision, *given.split()) for name, given in methods.items()}
    return best_times({name: lambda body=body: gravity(body) for name, body in bodies.items()}, rounds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--keep", action="store_true", help="write the table")
    chosen = parser.parse_args()
    text = (
        f"# Gravity by direct sums and by multipoles\n\n{machine()}; the shortest of {chosen.rounds} rounds in turn.\n"
    )
    both = {method: f'effects.gravity.method="{method}"' for method in ("direct", "multipole")}
    for precision in ("mixed", "float64"):
        times = {count: measured(count, precision, chosen.rounds, both) for count in COUNTS}
        rows = [[count, *(f"{1e3 * found[method]:.3g}" for method in both)] for count, found in times.items()]
        text += f"\n**{precision}, to an error of {FORCE_ERROR:g}**\n\n"
        text += rows_of(["particles", "direct (ms)", "multipoles (ms)"], rows)
        counts = np.array(COUNTS, dtype=float)
        # Least squares of relative deviations: all numbers of particles count alike.
        for method, growth in (("direct", counts**2), ("multipole", counts)):
            seconds = np.array([found[method] for found in times.values()])
            basis = np.stack([np.ones_like(counts), growth], axis=1) / seconds[:, None]
            fixed, slope = np.linalg.lstsq(basis, np.ones_like(counts), rcond=None)[0]
            text += (
                f"\n{method}: {fixed:.2g} s and {slope:.2g} s for each {'pair' if method == 'direct' else 'particle'}"
            )
        settings = {
            f"{error:g}": f'effects.gravity.method="multipole" effects.gravity.force_error={error}' for error in ERRORS
        }
        found = measured(MANY, precision, max(3, chosen.rounds // 4), settings)
        slope = np.polyfit(np.log(ERRORS), np.log(list(found.values())), 1)[0]
        text += f"\n\n{MANY} particles: "
        text += ", ".join(f"{1e3 * seconds:.3g} ms to {error}" for error, seconds in found.items())
        text += f"; as the error to the power {slope:.2f}.\n"
    publish("gravity_crossover", text, chosen.keep)


if __name__ == "__main__":
    main()
