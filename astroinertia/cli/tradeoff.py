"""The command `tradeoff`: what accuracy costs in time. Printing is left to main.py."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from astroinertia.cli.choice import minutes
from astroinertia.cli.parser import Add, Options

if TYPE_CHECKING:
    from astroinertia.accuracy.tradeoff import Standing
    from astroinertia.scene.schema import Scene


def add_arguments(add: Add) -> None:
    """Add the options of `tradeoff`, beside those of every scene."""
    add("--minutes", type=minutes, default=5.0, metavar="M",
        help="wall time to spend; runs that the folder already has cost nothing (default: 5)")  # fmt: skip
    add("--observable", action="append", default=[], metavar="NAME",
        help='what is judged: a series of the dataset and its labels, as in "inertia_tensor z z", flattening, '
        '"frequency of inertia_tensor z z"; may be repeated (default: I_zz and the angular velocity at the '
        "end)")  # fmt: skip
    add("--knob", action="append", default=[], metavar="NAME",
        help="turn only these knobs, besides the first, which sets the resolution; may be repeated")  # fmt: skip
    add("--output", type=Path, metavar="DIR", help="folder of the table (default: runs/NAME-tradeoff)")


def carry_out(scene: "Scene", options: Options, listener: Callable[["Standing"], None]) -> tuple[list[str], bool]:
    """Run what the options ask for; the lines to print, and whether Ctrl-C ended it."""
    from astroinertia.accuracy import table
    from astroinertia.accuracy.tradeoff import carry_out as run
    from astroinertia.plots import style
    from astroinertia.plots.tradeoff import tradeoff_figure

    folder = options.output or Path("runs") / f"{scene.name}-tradeoff"
    outcome = run(scene, folder, options.minutes, options.observable, options.knob, listener)
    if not outcome.measured:
        return table.conclusions(outcome)[-1:] if outcome.left else [], outcome.interrupted
    file = table.write(outcome)
    picture = style.save(tradeoff_figure(table.read(file)), folder / "tradeoff.png")
    return [*_rows(outcome), "", *table.conclusions(outcome), "", f"wrote {file} and {picture}"], outcome.interrupted


def _rows(outcome) -> list[str]:
    """The settings on the front of the first observable, from the cheapest."""
    from astroinertia.accuracy.analysis import analysed
    from astroinertia.process.words import duration

    judged = analysed(outcome).judged
    heads = "".join(f"{judgement.observable.name:>24}" for judgement in judged)
    lines = [f"{'worth its cost':44}{'processor time':>16}{heads}"]
    front = dict.fromkeys(setting for judgement in judged for setting in judgement.front)
    for setting in sorted(front, key=lambda setting: outcome.measured[setting].cpu_time):
        errors = "".join(f"{judgement.errors[setting]:>24.1e}" for judgement in judged)
        mark = " <- base" if setting == outcome.base else ""
        lines.append(f"{setting.label[:43]:44}{duration(outcome.measured[setting].cpu_time):>16}{errors}{mark}")
    return lines
