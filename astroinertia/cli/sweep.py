"""What `run`, `resume`, `plan` and `show` do with a scene that has [sweep]. Printing is left to main.py."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from astroinertia.cli.parser import Add, Options, Say
from astroinertia.run.meter import Meter

if TYPE_CHECKING:
    from astroinertia.scene.plan import Plan
    from astroinertia.scene.sweep import Sweep
    from astroinertia.sweeps.ensemble import Carried

MOST_ROWS = 20  # of a table of members


def add_arguments(add: Add) -> None:
    """Add where the members of a sweep are run."""
    add("--workers", type=int, metavar="N",
        help="of a scene with [sweep]: processes that its members are shared out over (default: one for each core "
        "where that pays; 1 is this process alone)")  # fmt: skip
    add("--cluster", metavar="ADDRESS",
        help="of a scene with [sweep]: a cluster of dask that runs its members, such as tcp://host:8786, and sees the "
        "same files")  # fmt: skip


def sweep_of(options: Options) -> "Sweep | None":
    """The sweep that a scene file holds; None, and no options of one allowed, where it is a scene of one run."""
    from astroinertia.scene.sweep import load_file

    sweep = load_file(options.scene, options.overrides)
    if sweep is None:
        refuse_options(options)
    return sweep


def refuse_options(options: Options) -> None:
    """Raise SceneError where options of a sweep are given to a single run."""
    from astroinertia.errors import SceneError

    for name in ("workers", "cluster"):
        if getattr(options, name, None) is not None:
            raise SceneError(f"--{name} is for a scene with [sweep], which makes several runs.")


def is_folder(folder: Path) -> bool:
    """Whether a folder is that of a sweep."""
    from astroinertia.storage.archive import SWEEP

    return (folder / SWEEP).exists()


def carry_out(sweep: "Sweep", folder: Path, options: Options, deadline: float, meter: Meter, say: Say) -> "Carried":
    """Run the members of a sweep that are left, until a deadline, shown by the meter."""
    from astroinertia.engines import hosts
    from astroinertia.sweeps import ensemble

    hosts.must_be_alone("a sweep")
    left = ensemble.left(sweep, folder)
    cluster = options.cluster
    workers: int = 1 if options.workers is None else options.workers
    if options.workers is None and cluster is None:
        workers = ensemble.usual_workers(ensemble.predictions(sweep, left))
    where = f"on {cluster}" if cluster else "one after another" if workers == 1 else f"by {workers} workers"
    done = len(sweep.members) - len(left)
    say(
        f"{sweep.name}: a {sweep.kind} of {len(sweep.members)} members over {', '.join(sweep.keys)}"
        + (f", {done} of them done before" if done else "")
        + (f"; {where}" if left else "")
    )

    minutes = getattr(options, "minutes", ensemble.DEFAULT_MINUTES)
    return ensemble.run_sweep(sweep, folder, workers, cluster, minutes, meter.tell_members, deadline)


def failures(sweep: "Sweep", outcome: "Carried") -> list[str]:
    """The members that have no result, and why; no lines where all have one."""
    from astroinertia.scene.sweep import member

    if not outcome.failures:
        return []
    rows = [("member", "with", "has no result, for")]
    for number in sorted(outcome.failures)[:MOST_ROWS]:
        failure = outcome.failures[number]
        again = "" if failure.lasting else " (resume runs it again)"
        rows.append((member(number), sweep.description(number), f"{failure.sentence}{again}"))
    more = len(outcome.failures) - MOST_ROWS
    return [*_aligned(rows), *([f"and {more} more"] if more > 0 else [])]


def unclosed(file: Path) -> list[str]:
    """What of the members' ledgers or energies does not close; no lines where all do."""
    from astroinertia import dataset
    from astroinertia.ledger import bounds

    lines = bounds.ledger_message(dataset.open(file).attrs).splitlines()
    more = len(lines) - MOST_ROWS
    return [*lines[:MOST_ROWS], *([f"and {more} more"] if more > 0 else [])]


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def planned(sweep: "Sweep", options: Options) -> "Plan":
    """The plan of the first member, with what varies and what all members take."""
    from dataclasses import replace

    from astroinertia.costs import plan_lines
    from astroinertia.errors import SceneError
    from astroinertia.scene.plan import Line, plan
    from astroinertia.scene.sweep import member
    from astroinertia.sweeps import ensemble

    for name in ("pilot", "audit"):
        if getattr(options, name):
            raise SceneError(f"--{name} is for a scene of one run, not for one with [sweep].")
    count = len(sweep.members)
    lines = [Line("members", f"{count}", f"a {sweep.kind}; all below is of {member(0)}")]
    for place, key in enumerate(sweep.keys):
        values = list(dict.fromkeys(str(settings[place]) for settings in sweep.members))
        few = values if len(values) <= 6 else [*values[:3], "...", values[-1]]
        lines.append(Line(key, ", ".join(few), f"{len(values)} values"))
    scene = sweep.scene(0)
    all_costs = ensemble.predictions(sweep, range(count))
    costs = [cost for cost in all_costs if cost is not None]
    if len(costs) < count:
        lines.append(Line("time of all", "not known", "the time of a member is not"))
    else:
        work, start = (
            sum(cost.evolution.wall for cost in costs),
            max(cost.wall_time - cost.evolution.wall for cost in costs),
        )
        workers = ensemble.usual_workers(all_costs)
        beside = f"{plan_lines.seconds(start + work / workers)} by {workers} workers, " if workers > 1 else ""
        lines.append(
            Line("time of all", f"{beside}{plan_lines.seconds(start + work)} one after another", "when none fails")
        )
        lines.append(Line("files of all", plan_lines.size(sum(cost.files for cost in costs)), "in the sweep's folder"))
    whole = plan(scene)
    sections = {"sweep": tuple(lines), **whole.sections, f"cost of {member(0)}": plan_lines.lines(scene, all_costs[0])}
    return replace(whole, sections=sections)


def summary(folder: Path) -> list[str]:
    """What members ended with, one row each."""
    import numpy as np

    from astroinertia import dataset
    from astroinertia.scene.sweep import member
    from astroinertia.sweeps import combined
    from astroinertia.sweeps.folder import read
    from astroinertia.units import shown

    sweep, end = read(folder), combined.at_end(dataset.open(folder))
    spin = np.sqrt((end["angular_velocity"] ** 2).sum("i", skipna=False))
    columns = {
        "I_zz (kg m2)": end["inertia_tensor"].sel(i="z", j="z"),
        "mean angular velocity (rad s-1)": spin,
        "T/|W|": end["rotational_to_gravitational"],
        f"I/(M R^2), {end['moment_ratio'].attrs.get('radius', 'reference_radius').replace('_', ' ')}": end[
            "moment_ratio"
        ],
    }
    rows = [("member", *sweep.keys, *columns)]
    values = [column.values.ravel() for column in columns.values()]  # members of a grid are in the order of its axes
    for number, settings in enumerate(sweep.members[:MOST_ROWS]):
        figures = ["" if np.isnan(numbers[number]) else f"{numbers[number]:.6g}" for numbers in values]
        rows.append((member(number), *(shown(str(value)) for value in settings), *figures))
    more = len(sweep.members) - MOST_ROWS
    beyond = [f"and {more} more"] if more > 0 else []
    return [f"{sweep.name} at the end", *_aligned(rows), *beyond, *unclosed(combined.path(sweep, folder))]
