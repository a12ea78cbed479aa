"""CSV: the headline series, one flat column a number with its unit, and the particles of a snapshot.

Numbers are written with the fewest digits that read back as the same float64. A snapshot has the columns of a particle
table, so that `moments` and scenes read it. Tests: tests/unit/interop/test_export.py.
"""

import csv
import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from astroinertia.dataset.absent import with_absent
from astroinertia.dataset.by_member import swept
from astroinertia.dataset.schema import SNAPSHOT
from astroinertia.interop.snapshots import Snapshot
from astroinertia.storage.atomic import write_whole
from astroinertia.units import unit_of

_COLUMNS = {
    "mass": ("mass",),
    "position": ("x", "y", "z"),
    "velocity": ("vx", "vy", "vz"),
    "internal_energy": ("u",),
    "density": ("density",),
    "smoothing_length": ("smoothing_length",),
    "pressure": ("pressure",),
}


@with_absent
def write_series(dataset: xr.Dataset, path: Path) -> None:
    """Write every quantity that has a time and is known: `inertia_tensor_x_y [kg m2]`, `torque_gravity_z [N m]`, ...

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_series(ds, Path(folder, "star.csv"))
    ...     print(Path(folder, "star.csv").read_text()[:8])
    time [s]
    """
    columns = dict(series_columns(dataset))
    _write(path, [], list(columns), zip(*(values.tolist() for values in columns.values()), strict=True))


def series_columns(dataset: xr.Dataset) -> Iterator[tuple[str, np.ndarray]]:
    """Header and values (time,) of every column; quantities and components that are NaN throughout have none.

    In a sweep a column says what its member has: `density_max_body.radius=1500000.0 m [kg m-3]`. Where members have a
    number only, as in a sample, columns that are the same at all times have its values: `body_radius_member=0 [m]`.

    >>> print(next(iter(series_columns(ds)))[0])
    time [s]
    """
    of_members = _of_members(dataset)
    for name in ("time", *of_members, *dataset.data_vars):
        variable = dataset[name]
        if name in of_members:
            variable = variable.expand_dims(time=dataset.sizes["time"])
        elif "time" not in variable.dims or variable.dtype.kind not in "fiub":
            continue
        variable = variable.transpose("time", ...)
        others = [_labels(dataset, str(dim)) for dim in variable.dims[1:]]
        unit = unit_of(variable)
        flat = variable.values.reshape(dataset.sizes["time"], -1)
        for place, label in enumerate(itertools.product(*others)):
            if flat.dtype.kind != "f" or not np.isnan(flat[:, place]).all():
                yield "_".join((str(name), *label)) + f" [{unit}]", flat[:, place]


def write_particles(snapshot: Snapshot, path: Path) -> None:
    """Write one snapshot as a particle table, with the names of such, and units but in code units: `mass [kg]`, ...

    >>> import tempfile
    >>> from astroinertia.interop.snapshots import snapshots_of
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_particles(next(iter(snapshots_of(Path("runs/star"), "last"))), Path(folder, "star.csv"))
    ...     print(len(Path(folder, "star.csv").read_text().splitlines()))
    102
    """
    held = {name: columns for name, columns in _COLUMNS.items() if name in snapshot.arrays}
    comments = [f"# {snapshot.name}: snapshot {snapshot.number} at time {snapshot.time!r}"]
    units = {name: "" if snapshot.dimensionless else f" [{SNAPSHOT[name].unit}]" for name in held}
    heads = [f"{column}{units[name]}" for name, columns in held.items() for column in columns]
    numbers = np.column_stack([snapshot.arrays[name] for name in held])
    _write(path, comments, heads, numbers.tolist())


def _of_members(dataset: xr.Dataset) -> list[str]:
    """What members along a dimension have, where that is not what labels the dimension."""
    return [
        str(name)
        for name, values in dataset.coords.items()
        if name not in (*values.dims, "member", "failure") and values.dims and set(values.dims) <= {*swept(dataset)}
    ]


def _labels(dataset: xr.Dataset, dim: str) -> list[str]:
    labels = [str(label) for label in (dataset[dim].values if dim in dataset.coords else range(dataset.sizes[dim]))]
    if dim in swept(dataset):
        unit = unit_of(dataset[dim]).removeprefix("1") if dim in dataset.coords else ""
        return [f"{dim}={label} {unit}".rstrip() for label in labels]
    return labels


def _write(path: Path, comments: Sequence[str], names: Sequence[str], rows) -> None:
    def fill(aside: Path) -> None:
        with aside.open("w", newline="", encoding="utf-8") as stream:
            stream.writelines(f"{comment}\n" for comment in comments)
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(names)
            writer.writerows(rows)

    write_whole(path, fill)
