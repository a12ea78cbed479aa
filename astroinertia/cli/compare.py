"""The command `compare`: its arguments, and what it says and draws. Printing is left to main.py."""

import shutil
from pathlib import Path

from astroinertia.cli import result
from astroinertia.cli.parser import Add, Options
from astroinertia.errors import SceneError

HELP = """\
One scene can be answered by several models (scaling, rigid, ellipsoid, sph), or by one at several costs. The finest run
is the one whose model leaves least out; among particles, the one with most of them; --against names another.

Quantities are moment_of_inertia and mean_angular_velocity, about the axis of the angular momentum, and every variable
of the dataset with a time, such as kinetic_energy; vectors and tensors are compared by their size.

A sweep stands for its members that are finished; of more than seven of them, seven that are spread evenly.

example: astroinertia run sims/one_star_three_models.toml --set model=\\"scaling\\" --output runs/scaling
         astroinertia run sims/one_star_three_models.toml --set model=\\"ellipsoid\\" --output runs/ellipsoid
         astroinertia run sims/one_star_three_models.toml --output runs/particles
         astroinertia compare runs/scaling runs/ellipsoid runs/particles
"""


def add_arguments(add: Add) -> None:
    """Add the options of `compare`."""
    add("runs", metavar="RUN", nargs="+", type=Path, help="netCDF files or folders of runs, two or more, or of a sweep")
    add("--quantity", action="append", default=[], metavar="NAME", help="what to compare; may be repeated")
    add("--against", type=Path, metavar="RUN", help="the run that the others are measured against")
    add("--plot", type=Path, metavar="FILE.png", default=Path("compare.png"), help="the picture (default: compare.png)")


def report(options: Options) -> str:
    """What the command prints; the picture is written first. SceneError for what cannot be compared."""
    result.must_be_writable(options.plot, ".png")
    from astroinertia import dataset
    from astroinertia.plots import ladder, style

    paths, skipped = _chosen([run for path in options.runs for run in _runs(path)], options, ladder.MOST_RUNS)
    runs = [(path, dataset.open(path)) for path in paths]
    for path, data in runs:
        result.must_be_of_one_run(path, data, "compare")
    with result.shown(*paths):
        runs.sort(key=lambda run: ladder.fineness(run[1]))
        opened = [data for _, data in runs]
        finest = len(runs) - 1 if options.against is None else [path for path, _ in runs].index(options.against)
        try:
            comparison = ladder.compared(opened, options.quantity, finest)
        except ValueError as error:
            raise SceneError(str(error)) from None
        style.save(ladder.ladder_figure(opened, comparison, finest), options.plot)
        table = ladder.ladder_table(opened, comparison, finest, shutil.get_terminal_size((0, 0)).columns)
        return f"{table}{skipped}\n\npicture: {options.plot}"


def _chosen(paths: list[Path], options: Options, most: int) -> tuple[list[Path], str]:
    """The runs that are compared, and a line about members of a sweep that are not."""
    if options.against is not None and options.against not in paths:
        raise SceneError(f"--against names {options.against}, which is none of the runs that are compared")
    if len(paths) <= most or len(options.runs) == len(paths):
        return paths, ""
    spread = {round(place * (len(paths) - 1) / (most - 1)) for place in range(most)}
    if options.against is not None and (named := paths.index(options.against)) not in spread:
        spread = {*sorted(spread)[:-1], named}
    chosen = [paths[place] for place in sorted(spread)]
    names = ", ".join(path.name for path in chosen)
    return chosen, f"\n\nof {len(paths)} runs these are compared: {names}; name others by their folders"


def _runs(path: Path) -> list[Path]:
    """The runs that are meant: of a sweep, its members that are finished."""
    folder = result.folder_of_sweep(path)
    if folder is None:
        return [path]
    from astroinertia.sweeps import folder as folders

    return [
        folders.place(folder, number)
        for number in range(len(folders.read(folder).members))
        if folders.finished(folder, number) is not None
    ]
