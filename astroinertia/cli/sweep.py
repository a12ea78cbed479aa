"""What `run`, `resume`, `plan` and `show` do with a scene that has [sweep]. Printing is left to main.py."""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from astroinertia.cli.parser import Add, Options, Say
from astroinertia.process.words import aligned
from astroinertia.run.meter import Meter

if TYPE_CHECKING:
    from astroinertia.scene.plan import Plan
    from astroinertia.scene.schema import Scene
    from astroinertia.scene.sweep import Sweep
    from astroinertia.sweeps.ensemble import Carried
    from astroinertia.sweeps.folder import Failure

MOST_ROWS = 20  # of a table of members


def add_arguments(add: Add) -> None:
    """Add where the members of a sweep are run."""
    add("--workers", type=_workers, metavar="N",
        help="of a scene with [sweep], or of sensitivity: processes that the runs are shared out over (default: one "
        "for each core where that pays; 1 is this process alone)")  # fmt: skip
    add("--cluster", metavar="ADDRESS",
        help="of the same: a cluster of dask that does the runs instead, such as tcp://host:8786, and sees the same "
        "files")  # fmt: skip


def _workers(text: str) -> int:
    with suppress(ValueError):
        if (number := int(text)) > 0:
            return number
    raise argparse.ArgumentTypeError(f"'{text:.40}' is no whole number above 0")


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


def scenes(sweep: "Sweep") -> "Iterator[Scene]":
    """The scene of each member in turn."""
    return map(sweep.scene, range(len(sweep.members)))


def is_folder(folder: Path) -> bool:
    """Whether a folder is that of a sweep."""
    from astroinertia.storage.archive import SWEEP

    return (folder / SWEEP).exists()


def carry_out(sweep: "Sweep", folder: Path, options: Options, deadline: float, meter: Meter, say: Say) -> "Carried":
    """Run the members of a sweep that are left, until a deadline, shown by the meter."""
    from astroinertia.engines import hosts
    from astroinertia.errors import SceneError
    from astroinertia.sweeps import ensemble

    if options.workers is not None and options.cluster is not None:
        raise SceneError("--workers are processes of this machine, and --cluster is another: give one of the two.")
    hosts.must_be_alone("a sweep")
    left = ensemble.left(sweep, folder)
    refused = _refused(sweep, left)
    possible = [number for number in left if number not in refused]
    cluster = options.cluster
    workers: int = 1 if options.workers is None else options.workers
    if options.workers is None and cluster is None:
        workers = ensemble.usual_workers(ensemble.predictions(sweep, possible))
    where = f"on {cluster}" if cluster else "one after another" if workers == 1 else f"by {workers} workers"
    done = len(sweep.members) - len(left)
    say(
        f"{sweep.name}: a {sweep.kind} of {len(sweep.members)} members over {', '.join(sweep.keys)}"
        + (f", {done} of them done before" if done else "")
        + (f"; {where}" if left else "")
    )
    if refused:
        say("\n".join(_table(sweep, refused, "will have no result, for")))
    minutes = getattr(options, "minutes", None) or ensemble.DEFAULT_MINUTES
    return ensemble.run_sweep(sweep, folder, workers, cluster, minutes, meter.tell_members, deadline)


def failures(sweep: "Sweep", found: "Mapping[int, Failure]") -> list[str]:
    """The members that have no result, and why; no lines where all have one."""
    sentences = {
        number: failure.sentence + ("" if failure.lasting else " (resume runs it again)")
        for number, failure in found.items()
    }
    return _table(sweep, sentences, "has no result, for") if sentences else []


def _table(sweep: "Sweep", sentences: Mapping[int, str], title: str) -> list[str]:
    from astroinertia.scene.sweep import member

    rows = [(member(number), sweep.description(number), sentences[number]) for number in sorted(sentences)]
    return _first(aligned([("member", "with", title), *rows]), 1)


def _refused(sweep: "Sweep", numbers: Sequence[int]) -> dict[int, str]:
    """Members whose body cannot be, and why; SceneError where that is all of them."""
    from astroinertia.errors import SceneError
    from astroinertia.scene.sweep import member
    from astroinertia.sweeps import ensemble

    refused = ensemble.refused(sweep, numbers)
    if refused and len(refused) == len(sweep.members):
        number, sentence = next(iter(refused.items()))
        where = f"{member(number)}: {sweep.description(number)}"
        raise SceneError(f"no member of the sweep can be run: {sentence.removesuffix('.')} ({where}).")
    return refused


def early(file: Path) -> list[str]:
    """The members that were over before their end, and why; no lines where none was."""
    from astroinertia import dataset

    members = str(dataset.open(file).attrs.get("ended_early", "")).splitlines()
    return _first(["over before their end:", *members], 1) if members else []


def unclosed(file: Path) -> list[str]:
    """What of the members' ledgers or energies does not close; no lines where all do."""
    from astroinertia import dataset
    from astroinertia.dataset import bounds

    return _first(bounds.message(dataset.open(file).attrs, "ledger").splitlines())


def _first(lines: list[str], heads: int = 0) -> list[str]:
    """The first lines below those that are heads, and how many more there are."""
    more = len(lines) - heads - MOST_ROWS
    return [*lines[: heads + MOST_ROWS], *([f"and {more} more"] if more > 0 else [])]


def planned(sweep: "Sweep", options: Options) -> "tuple[Plan, bool]":
    """The plan of the first member that can be, with what varies and what all take; and whether all members can be."""
    from dataclasses import replace

    from astroinertia.costs import plan_lines
    from astroinertia.errors import SceneError
    from astroinertia.process.words import duration, size
    from astroinertia.scene.plan import Line, plan
    from astroinertia.scene.sweep import member
    from astroinertia.scene.sweep_values import short_text
    from astroinertia.sweeps import ensemble

    for name in ("pilot", "audit"):
        if getattr(options, name):
            raise SceneError(f"--{name} is for a scene of one run, not for one with [sweep].")
    count = len(sweep.members)
    refused = _refused(sweep, range(count))
    possible = [number for number in range(count) if number not in refused]
    first = possible[0]
    lines = [Line("members", f"{count}", f"a {sweep.kind}; all below is of {member(first)}")]
    for place, key in enumerate(sweep.keys):
        values = [short_text(value) for value in dict.fromkeys(str(settings[place]) for settings in sweep.members)]
        few = values if len(values) <= 6 else [*values[:3], "...", values[-1]]
        lines.append(Line(key, ", ".join(few), f"{len(values)} values"))
    numbers = sorted(refused)
    lines += [Line(f"{member(n)} refused", sweep.description(n), refused[n]) for n in numbers[:MOST_ROWS]]
    if len(numbers) > MOST_ROWS:
        lines.append(Line("and refused", f"{len(numbers) - MOST_ROWS} more members"))
    scene = sweep.scene(first)
    all_costs = ensemble.predictions(sweep, possible)
    costs = [cost for cost in all_costs if cost is not None]
    if len(costs) < len(possible):
        lines.append(Line("time of all", "not known", "the time of a member is not"))
    else:
        work, start = (
            sum(cost.evolution.wall for cost in costs),
            max(cost.wall_time - cost.evolution.wall for cost in costs),
        )
        workers = ensemble.usual_workers(all_costs)
        beside = f"{duration(start + work / workers)} by {workers} workers, " if workers > 1 else ""
        lines.append(Line("time of all", f"{beside}{duration(start + work)} one after another", "when none fails"))
        lines.append(Line("files of all", size(sum(cost.files for cost in costs)), "in the sweep's folder"))
    whole = plan(scene)
    sections = {
        "sweep": tuple(lines),
        **whole.sections,
        f"cost of {member(first)}": plan_lines.lines(scene, all_costs[0]),
    }
    return replace(whole, sections=sections), not refused


def summary(folder: Path) -> list[str]:
    """What members ended with, one row each."""
    import numpy as np

    from astroinertia.cli import result
    from astroinertia.scene.sweep import member
    from astroinertia.scene.sweep_values import short_text
    from astroinertia.sweeps import combined
    from astroinertia.sweeps.folder import failure, read
    from astroinertia.units import shown, unit_of

    def with_unit(name: str, series: Any) -> str:
        return name if (unit := unit_of(series)) == "1" else f"{name} ({unit})"

    sweep, data = read(folder), result.opened(folder)
    end = combined.at_end(data.assign(spin_rate=data.inertia.spin_rate()))
    I_zz = end["inertia_tensor"].sel(i="z", j="z")
    columns = {
        with_unit("I_zz", I_zz): I_zz,
        with_unit("mean angular velocity", end["spin_rate"]): end["spin_rate"],
        "T/|W|": end["rotational_to_gravitational"],
        f"I/(M R^2), {end['moment_ratio'].attrs.get('radius', 'reference_radius').replace('_', ' ')}": end[
            "moment_ratio"
        ],
    }
    rows = [("member", *sweep.keys, *columns)]
    order = np.argsort(data["member"].values, axis=None)
    values = [column.values.ravel()[order] for column in columns.values()]
    for number, settings in enumerate(sweep.members):
        figures = ["" if np.isnan(numbers[number]) else f"{numbers[number]:.6g}" for numbers in values]
        rows.append((member(number), *(shown(short_text(value)) for value in settings), *figures))
    noted = {number: why for number in range(len(sweep.members)) if (why := failure(folder, number))}
    table, file = [f"{sweep.name} at the end", *_first(aligned(rows), 1)], combined.path(sweep, folder)
    return [*table, *(["", *failures(sweep, noted)] if noted else []), *early(file), *unclosed(file)]
