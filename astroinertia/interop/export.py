"""Results in the formats of other programs: what each is called, where it is written, and who writes it.

Tests: tests/unit/interop/test_export.py, tests/physics/test_exports_elsewhere.py.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from astroinertia import dataset
from astroinertia.errors import SceneError
from astroinertia.interop.gadget import write_gadget
from astroinertia.interop.paraview import write_pvd, write_vtp
from astroinertia.interop.snapshots import Snapshot, snapshots_of
from astroinertia.interop.swift import write_swift
from astroinertia.interop.tables import write_particles, write_series
from astroinertia.interop.zarr_store import write_zarr
from astroinertia.units import shown


class Format(NamedTuple):
    """A format of snapshots: how its files are marked and end, and what writes one of them."""

    mark: str
    suffix: str
    write: Callable[[Snapshot, Path], None]


SNAPSHOT_FORMATS = {
    "gadget": Format("_gadget", ".hdf5", write_gadget),
    "swift": Format("_swift", ".hdf5", write_swift),
    "vtk": Format("", ".vtp", write_vtp),
    "csv": Format("", ".csv", write_particles),
}
FORMATS = (*SNAPSHOT_FORMATS, "zarr")


def export(source: Path, to: str, which: str | None = None, output: Path | None = None) -> list[Path]:
    """Write a run (its folder or netCDF file) in a format of FORMATS; returns the files, none of which was there.

    which: a snapshot's number, "last" or "all"; without it the last, and of csv the headline series. output: the file,
    or a folder, made where it is not there; beside the run's file without it. SceneError or ArchiveError says what is
    wrong.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     print(export(Path("runs/star"), "csv", output=Path(folder, "star.csv"))[0].name)
    star.csv
    """
    if to not in FORMATS:
        raise SceneError(f"the formats are {', '.join(FORMATS)}, not '{shown(to)}'")
    if to == "zarr":
        if which is not None:
            raise SceneError("zarr takes the whole dataset, so --snapshot is not for it")
        return [_written(source, output, f"{_stem(source)}.zarr", lambda path: write_zarr(source, path))]
    if to == "csv" and which is None:
        series = dataset.open(source)
        return [_written(source, output, f"{_stem(source)}_series.csv", lambda path: write_series(series, path))]
    chosen = SNAPSHOT_FORMATS[to]
    if which == "all" and output is not None and output.suffix == chosen.suffix:
        raise SceneError(f"{output} is one file, but --snapshot all writes several; give a folder")
    times, files = [], []
    for snapshot in snapshots_of(source, which or "last"):
        name = f"{_stem(source)}{chosen.mark}_{snapshot.number:03d}{chosen.suffix}"
        files.append(_written(source, output, name, lambda path, one=snapshot: chosen.write(one, path)))
        times.append(snapshot.time)
    if to == "vtk" and which == "all":
        named = f"{_stem(source)}.pvd"
        files.append(_written(source, output, named, lambda path: write_pvd(times, files, path)))
    return files


def _stem(source: Path) -> str:
    return source.stem if source.is_file() else source.resolve().name


def _written(source: Path, output: Path | None, name: str, write: Callable[[Path], None]) -> Path:
    """The path that was written: `output` itself where it ends like `name`, else `name` in that folder."""
    if output is None:
        path = (source if source.is_dir() else source.parent) / name
    elif output.suffix == Path(name).suffix:
        path = output
    elif output.suffix and not output.is_dir():
        raise SceneError(f"{output} does not end in {Path(name).suffix}, nor is it a folder that is there")
    else:
        path = output / name
    if path.exists():
        raise SceneError(f"{path} is there already and is left as it is")
    if path.parent != output and not path.parent.is_dir():
        raise SceneError(f"{path} cannot be written: there is no folder {path.parent}")
    try:
        path.parent.mkdir(exist_ok=True)
    except OSError as error:
        raise SceneError(f"the folder {path.parent} cannot be made ({error.strerror})") from None
    write(path)
    return path
