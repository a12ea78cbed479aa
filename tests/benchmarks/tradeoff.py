"""What accuracy costs in eight scenes with exact answers: orders, whose error it is, and what the next digit costs.

    python tests/benchmarks/tradeoff.py --folder runs/tradeoffs --keep

Runs that are in the folder already are not repeated.
"""

import argparse
import math
import sys
from pathlib import Path

from fair_times import machine, publish, rows_of

sys.path.insert(0, str(Path(__file__).parents[2]))  # run as a script: the tests' own scenes are beside it

from astroinertia.accuracy import table
from astroinertia.accuracy.analysis import analysed
from astroinertia.accuracy.tradeoff import carry_out
from astroinertia.plots import style
from astroinertia.plots.tradeoff import tradeoff_figure
from astroinertia.process.words import duration
from tests.tradeoff_scenes import CASES

HEAD = ["scene", "observable", "settings", "error at the base", "time", "knob", "its error", "order", "theory",
        "next digit costs"]  # fmt: skip


def rows(name, found):
    """A row for every knob of every observable whose order was found."""
    for judged in analysed(found).judged:
        base = found.measured.get(found.base)
        for source in judged.sources:
            law = source.law
            if not law.points:
                continue
            spread = "" if math.isnan(law.uncertainty) else f" ± {law.uncertainty:.2f}"
            cost = 10 ** (source.cost_order / law.order) if law.order > 0 and source.cost_order > 0 else math.nan
            yield [
                name, judged.observable.name, len(found.measured), f"{judged.errors.get(found.base, math.nan):.1e}",
                "-" if base is None else duration(base.cpu_time),
                f"**{source.knob.name}**" if source is judged.limiting else source.knob.name,
                "-" if math.isnan(source.error) else f"{source.error:.1e}",
                f"{law.order:.2f}{spread}", source.knob.order, "-" if math.isnan(cost) else f"{cost:.2g} times",
            ]  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--folder", type=Path, default=Path("runs/tradeoffs"))
    parser.add_argument("--minutes", type=float, help="for each scene, instead of its own")
    parser.add_argument("--only", nargs="+", default=[case.name for case in CASES])
    parser.add_argument("--keep", action="store_true", help="write the table to tests/benchmarks/results")
    chosen = parser.parse_args()
    lines, words = [], []
    for case in CASES:
        if case.name not in chosen.only:
            continue
        found = carry_out(
            case.scene(), chosen.folder / case.name, chosen.minutes or case.minutes, case.observables, case.knobs,
            lambda now: print(f"{now.done} of {now.settings}, {now.spent:.0f} s: {now.now}", flush=True),
        )  # fmt: skip
        file = table.write(found)
        style.save(tradeoff_figure(table.read(file)), file.with_suffix(".png"))
        lines += rows(case.name, found)
        words += [f"**{case.name}**, base {found.base.label}", "", *[f"- {each.strip()}" for each in
                                                                      table.conclusions(found)], ""]  # fmt: skip
    text = (
        f"# What accuracy costs, in eight scenes with exact answers\n\n{machine()}; times are processor time of the "
        f"steps.\n\n{rows_of(HEAD, lines)}\nThe knob that limits the error at the base is in bold.\n\n"
        + "\n".join(words)
    )
    publish("tradeoff", text, chosen.keep)


if __name__ == "__main__":
    main()
