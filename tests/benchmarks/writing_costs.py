"""What writing costs in a run: segments, checkpoints, syncing, hashing and the final file, as shares of the run.

    python tests/benchmarks/writing_costs.py --scene sims/pulsar_collapse.toml --keep

One run, taken apart while it goes on: every part is timed by wall and by processor (of all threads), each without what
it calls of the others, and divided by the whole of the same run, from run_scene to the netCDF file that it returns.
What records are computed from is physics, and listed beside. A first run with a few steps compiles. Pictures are no
part of a run: `astroinertia show`, which `make demo` calls after it, draws them, and their time is listed as well.
"""

import argparse
import os
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from fair_times import machine, publish, rows_of

from astroinertia import dataset, plots
from astroinertia.models.sph.evolution import Particles
from astroinertia.run import loop
from astroinertia.scene.load import load_file
from astroinertia.storage import archive, atomic, manifest

BAR = 0.03
SAVING, FINAL = "checkpoints and segments", "final file"
PARTS: dict[str, tuple[tuple[Any, str], ...]] = {
    "segments and checkpoints, written": ((archive, "write_arrays"),),
    "state copied for checkpoints": ((Particles, "arrays"),),
    "manifests": ((manifest, "write_json"),),
    "synced to disk": ((os, "fsync"),),
    "hashed": ((atomic, "sha256"),),
    "segments read back": ((archive, "read_arrays"),),
    "headline series computed": ((dataset, "headline"),),
    "the rest of the final file": ((loop.dataset, "finish"),),
    "the rest of saving": ((loop._Run, "_checkpoint"),),
}
PHYSICS: dict[str, tuple[tuple[Any, str], ...]] = {
    "records and snapshots computed": ((Particles, "record"), (Particles, "snapshot")),
}
"""What each part is called in the table, and the functions that it is the time of."""


@dataclass
class Meter:
    """Times of the functions it has wrapped, each without the others that it calls: seconds of {name: [wall, all]}."""

    spent: dict[str, np.ndarray] = field(default_factory=lambda: defaultdict(lambda: np.zeros(2)))
    calls: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    inner: list[np.ndarray] = field(default_factory=list)

    def timed(self, name: str, function: Callable) -> Callable:
        """The function, timed under a name."""

        def act(*arguments: Any, **more: Any) -> Any:
            begin = now()
            self.inner.append(np.zeros(2))
            try:
                return function(*arguments, **more)
            finally:
                taken = now() - begin
                self.spent[name] += taken - self.inner.pop()
                self.calls[name] += 1
                if self.inner:
                    self.inner[-1] += taken

        return act

    def watching(self) -> ExitStack:
        """Within it, all parts are timed."""
        watched = ExitStack()
        for name, places in {**PARTS, **PHYSICS}.items():
            for place, attribute in places:
                act = self.timed(name, getattr(place, attribute))
                watched.enter_context(mock.patch.object(place, attribute, act))
        return watched


def now() -> np.ndarray:
    """Wall time and processor time of all threads, in seconds."""
    return np.array([time.perf_counter(), time.process_time()])


def measured(scene: Path, settings: list[str], folder: Path) -> tuple[Meter, np.ndarray, np.ndarray, Path]:
    """The parts of one run, the whole of it, its pictures, and the file that it leaves."""
    loop.run_scene(load_file(scene, [*settings, "time.max_steps=20"]), folder / "compiling")
    meter = Meter()
    loaded = load_file(scene, settings)
    with meter.watching():
        begin = now()
        finished = loop.run_scene(loaded, folder / "run")
        whole = now() - begin
    begin = now()
    plots.write_all(dataset.open(finished), folder / "pictures")
    return meter, whole, now() - begin, finished


def share(part: np.ndarray, whole: np.ndarray) -> list[str]:
    """A part of a run in seconds and per cent, by wall and by processor."""
    return [f"{part[0]:.3f}", f"{100 * part[0] / whole[0]:.2f}", f"{part[1]:.3f}", f"{100 * part[1] / whole[1]:.2f}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", type=Path, default=Path("sims/pulsar_collapse.toml"))
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--keep", action="store_true", help="write the table")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        meter, whole, pictures, finished = measured(chosen.scene, chosen.settings, Path(place))
        size = sum(path.stat().st_size for path in finished.parent.iterdir())
        attributes = dataset.open(finished).attrs
        outputs = dataset.open(finished).sizes["time"]
    writing = np.sum([meter.spent[name] for name in PARTS], axis=0)
    rows = [[name, meter.calls[name], *share(meter.spent[name], whole)] for name in PARTS]
    rows.append(["**writing, all of it**", "", *share(writing, whole)])
    rows += [[name, meter.calls[name], *share(meter.spent[name], whole)] for name in PHYSICS]
    rows += [["the whole run", 1, *share(whole, whole)], ["pictures, after the run", 1, *share(pictures, whole)]]
    head = ["part", "times", "wall (s)", "% of the run", "processor (s)", "% of the run"]
    text = f"# What writing costs: {' '.join([chosen.scene.name, *chosen.settings])}\n\n{machine()}.\n"
    text += (
        f"{outputs} records, {size / 1e6:.1f} MB in the run folder, {attributes['model']}, {attributes['engine']}.\n"
    )
    text += "Of one run; each part without what it calls of the others.\n\n" + rows_of(head, rows)
    with_pictures = (writing + pictures) / (whole + pictures)
    text += f"\nWriting takes {100 * writing[0] / whole[0]:.2f} % of the run's wall time and "
    text += (
        f"{100 * writing[1] / whole[1]:.2f} % of its processor time; the bar is {100 * BAR:.0f} %. With pictures, of "
    )
    text += f"the run and them: {100 * with_pictures[0]:.1f} and {100 * with_pictures[1]:.1f} %.\n"
    publish("writing_costs", text, chosen.keep)


if __name__ == "__main__":
    main()
