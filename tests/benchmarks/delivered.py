"""What was asked and what was delivered: accuracies of scenes with exact answers, and their cost against a scan's.

    python tests/benchmarks/delivered.py --seed 1 --folder runs/delivered --keep

For every scene the program chooses settings by its own pilots; then a coarse scan of settings is run, and the cheapest
of those that have the accuracy is what the choice is compared with. Times are processor time of the steps. Rows that
are in the folder already are not found again.
"""

import argparse
import json
import math
import sys
from pathlib import Path

import numpy as np
from fair_times import machine, publish, rows_of

sys.path.insert(0, str(Path(__file__).parents[2]))  # run as a script: the tests' own scenes are beside it

from astroinertia.accuracy import choice, choice_smooth
from astroinertia.accuracy.analysis import reference_of
from astroinertia.accuracy.exact import exact
from astroinertia.accuracy.knobs import knobs
from astroinertia.accuracy.pilots import Pilots
from astroinertia.accuracy.selected_observables import default_names, parsed, relative_error
from astroinertia.process.words import duration
from astroinertia.storage.cache import content_key
from tests.delivered_scenes import asked, carried_out

COUNTS = (250, 750, 2250, 6750, 20250)
FACTORS = (2.0, 1.0)  # of the time step
MINUTES = 4.0  # that the chosen run may take
SCANNED = 60.0  # seconds of processor time, at which a ladder of the scan ends
HEAD = ["scene", "asked", "delivered", "bar", "time", "scan's cheapest", "ratio", "pilots", "chosen"]


def judged(case, folder):
    """One row: what was asked, what came, and what it took."""
    scene = case.scene()
    names = tuple(parsed(name) for name in (scene.judged_by or default_names(scene)))
    answer = exact(scene)
    assert answer is not None  # all families have one
    truths = {each.name: reference_of(answer, each).values for each in names}

    def error(measured):
        if measured.failure:
            return math.inf
        return max(relative_error(np.array(measured.values[each.name]), truths[each.name]) for each in names)

    row = {"scene": case.name, "asked": case.accuracy, "floor": answer.accuracy}
    try:
        found = choice.choose(scene, folder, MINUTES)
        measured = carried_out(found, folder)
        row |= {
            "delivered": error(measured), "bar": found.settings.bar, "time": measured.cpu_time,
            "pilots": found.pilots.spent, "chosen": dict(found.settings.chosen),
        }  # fmt: skip
    except choice.UnreachableAccuracy as refusal:
        row |= {"refused": str(refusal)}
    pilots = Pilots(scene, names, folder, lambda text: None)
    ladders = particles(scene) if scene.model == "sph" else smooth(scene, case.accuracy)
    best, with_ = math.inf, ""
    for ladder in ladders:
        for label, overrides in ladder:
            run = pilots.run(label, overrides)
            if error(run) <= case.accuracy and run.cpu_time < best:
                best, with_ = run.cpu_time, label
            if error(run) <= case.accuracy or run.cpu_time > min(best, SCANNED):
                break
    return row | {"scan": best, "with": with_}


def particles(scene):
    """Ladders of the number of particles, one for each factor of the time step."""
    by_name = {knob.name: knob for knob in knobs(scene)}
    main, steps = by_name["particles"], by_name["timestep_factor"]
    for factor in FACTORS:
        yield [(f"{n} particles, {factor:g} dt", (*main.overrides(float(n)), *steps.overrides(factor))) for n in COUNTS]


def smooth(scene, accuracy):
    """Ladders of all methods of a model without particles."""
    for method in choice_smooth.methods(scene, accuracy):
        yield [(f"{method.name} {value:g}", method.overrides(value)) for value in method.values]


def ratio(row):
    """The time of the choice over that of the scan's cheapest."""
    return row["time"] / row["scan"] if "time" in row and math.isfinite(row["scan"]) else math.nan


def conclusions(rows):
    """What is asked of the whole table."""
    met = [row.get("delivered", math.inf) <= max(row["asked"], row["floor"]) for row in rows]
    # Where the scan finds nothing, a refusal is right; where it does, it is a failure.
    right = ["refused" in row and not math.isfinite(row["scan"]) for row in rows]
    cheap = [ratio(row) <= 2.0 or ("time" in row and not math.isfinite(row["scan"])) for row in rows]
    barred = [row for row in rows if "bar" in row and math.isfinite(row["bar"])]
    inside = [row["delivered"] <= max(row["bar"], row["floor"]) for row in barred]
    loose = [row["bar"] / max(row["delivered"], row["floor"]) for row in barred]
    count = len(rows)
    return [
        f"{sum(a or b for a, b in zip(met, right, strict=True))} of {count} have the accuracy that was asked for "
        f"({sum('refused' in row for row in rows)} were refused, {sum(right)} of them rightly)",
        f"{sum(a or b for a, b in zip(cheap, right, strict=True))} of {count} take at most twice the time of the "
        f"cheapest setting of the scan; median ratio {np.nanmedian([ratio(row) for row in rows]):.2f}",
        f"{sum(inside)} of {len(barred)} true errors lie within the error that the choice states; "
        f"in the median that is {np.median(loose):.1f} times the true error",
    ]


def cells(row):
    """What the table says of one scene."""
    scan = f"{duration(row['scan'])}, {row['with']}" if row["with"] else "none"
    if "refused" in row:
        return [row["scene"], f"{row['asked']:.1e}", "-", "-", "-", scan, "-", "-", row["refused"]]
    return [
        row["scene"], f"{row['asked']:.1e}", f"{row['delivered']:.1e}", f"{row['bar']:.1e}", duration(row["time"]),
        scan, f"{ratio(row):.2f}", duration(row["pilots"]),
        ", ".join(f"{name.replace('_', ' ')} {value:g}" for name, value in row["chosen"].items()),
    ]  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("runs/delivered"))
    parser.add_argument("--only", nargs="+", help="families")
    parser.add_argument("--most", type=int, default=1000, help="of each family")
    parser.add_argument("--keep", action="store_true", help="write the table to tests/benchmarks/results")
    chosen = parser.parse_args()
    rows = []
    for case in asked(chosen.seed):
        if (chosen.only and case.family not in chosen.only) or case.number >= chosen.most:
            continue
        key = content_key(case=repr(case))[:8]
        place = chosen.folder / f"{chosen.seed}-{case.name.replace(' ', '_')}-{key}"
        file = place / "row.json"
        if file.exists():
            row = json.loads(file.read_text())
        else:
            row = judged(case, place)
            place.mkdir(parents=True, exist_ok=True)
            file.write_text(json.dumps(row))
        rows.append(row)
        outcome = row.get("refused") or f"{row['delivered']:.1e} (bar {row['bar']:.1e}) in {duration(row['time'])}"
        print(
            f"{row['scene']}: asked {row['asked']:.1e}, {outcome}; ratio {ratio(row):.2f} to {row['with']}", flush=True
        )
    lines = [cells(row) for row in rows]
    text = "\n\n".join(
        [
            "# What was asked, and what was delivered",
            f"{machine()}; times are processor time of the steps; scenes of seed {chosen.seed}.",
            rows_of(HEAD, lines),
            "\n".join(f"- {line}" for line in conclusions(rows)),
        ]
    )
    publish("delivered", text + "\n", chosen.keep)


if __name__ == "__main__":
    main()
