"""Evrard's collapse to t = 3: time in evaluations of pytreegrav's quadrupole gravity, and what the run conserves.

    python tests/benchmarks/evrard_run.py --particles 10000 --keep

Global steps, and each particle's own. pytreegrav takes its turn all through the run, on the same
particles, and its shortest evaluation is the unit; compilation is apart, and so is what the run writes.
"""

import argparse
import time
from dataclasses import dataclass

import numpy as np
from evrard_cloud import cloud, gravity
from fair_times import machine, processor_clock, publish, rows_of
from gravity_codes import QUADRUPOLE, present
from gravity_peers import JUDGED

END = 3.0
TURNS = 30  # of pytreegrav in a run
# Steps as long as half a percent of the energy allows, and forces as exact as those of the code that is the unit.
SETTINGS = ("numerics.courant=0.5", "effects.gravity.force_error=1e-3")
INDIVIDUAL = ('numerics.timesteps="individual"',)  # settings of each particle's own steps


@dataclass
class Run:
    """What a run took and kept; momentum over the largest sum |m v|, angular momentum over the largest sum |m x v|."""

    steps: int
    seconds: float
    processor_seconds: float
    evaluation: float
    processor_evaluation: float
    energy_worst: float
    energy_end: float
    momentum: float
    angular_momentum: float
    closure: float


def run(particles: int, precision: str, settings: tuple[str, ...]) -> Run:
    """The collapse, from its first step to t = 3."""
    cloud(particles, precision, *settings).advance(END)  # compiles
    body = cloud(particles, precision, *settings, placement="glass")
    peers = [QUADRUPOLE.action(gravity(body)[0], JUDGED) for _ in present((QUADRUPOLE,))]
    for act in peers:
        act()
    opening = body.record(None)
    seconds = processor = 0.0
    evaluation = processor_evaluation = float("inf")
    worst = largest = turning = closure = 0.0
    next_turn, record = 0.0, opening
    while body.time < END * (1.0 - 1e-12):
        begin, begin_processor = time.perf_counter(), processor_clock()
        body.advance(END)
        seconds += time.perf_counter() - begin
        processor += processor_clock() - begin_processor
        state = body.state
        speed = np.linalg.norm(state.velocity, axis=1)
        largest = max(largest, float(state.mass @ speed))
        turning = max(turning, float(state.mass @ (np.linalg.norm(state.position, axis=1) * speed)))
        if body.time >= next_turn or body.time >= END * (1.0 - 1e-12):
            next_turn = body.time + END / TURNS
            record = body.record(opening["potential_energy"])
            worst = max(worst, abs(record["total_energy"] / opening["total_energy"] - 1.0))
            closure = max(closure, float(record["ledger_closure"]))
            for act in peers:
                begin, begin_processor = time.perf_counter(), processor_clock()
                act()
                evaluation = min(evaluation, time.perf_counter() - begin)
                processor_evaluation = min(processor_evaluation, processor_clock() - begin_processor)
    return Run(
        body.steps,
        seconds,
        processor,
        evaluation,
        processor_evaluation,
        worst,
        abs(record["total_energy"] / opening["total_energy"] - 1.0),
        float(np.linalg.norm(record["momentum"] - opening["momentum"])) / largest,
        float(np.linalg.norm(record["angular_momentum"] - opening["angular_momentum"])) / turning,
        closure,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, default=10_000)
    parser.add_argument("--precision", nargs="+", choices=("mixed", "float64"), default=["mixed", "float64"])
    parser.add_argument("--set", nargs="+", default=SETTINGS, metavar="KEY=VALUE", help="settings of the scene")
    parser.add_argument("--keep", action="store_true", help="write the table")
    chosen = parser.parse_args()
    rows = []
    for steps, settings in (("global", ()), ("individual", INDIVIDUAL)):
        for precision in chosen.precision:
            found = run(chosen.particles, precision, (*settings, *chosen.set))
            rows.append([
                f"{steps}, {precision}", found.steps, f"{found.seconds:.3g}", f"{found.seconds / found.evaluation:.0f}",
                f"{found.processor_seconds / found.processor_evaluation:.0f}",
                *(f"{value:.1e}" for value in (
                    found.energy_worst, found.energy_end, found.momentum, found.angular_momentum, found.closure)),
            ])  # fmt: skip
    head = [
        "steps", "number", "time (s)", "evaluations", "by processor time",
        "worst energy error", "at the end", "momentum", "angular momentum", "closure",
    ]  # fmt: skip
    text = f"# Evrard's collapse to t = {END:g} with {chosen.particles} particles\n\n{machine()}.\n"
    text += (
        f"Evaluations: the run's time over that of one evaluation of pytreegrav's quadrupole gravity at {JUDGED}. "
        f"Settings beside the defaults: {', '.join(chosen.set) or 'none'}.\n\n"
    )
    publish("evrard_run", text + rows_of(head, rows), chosen.keep)


if __name__ == "__main__":
    main()
