"""What formats in HDF5 share: groups and datasets with attributes, SI in cgs."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.dataset.schema import SNAPSHOT
from astroinertia.interop.snapshots import Snapshot
from astroinertia.sph.table_gadget import CM, GRAM
from astroinertia.storage.atomic import hdf5_refusals, write_whole
from astroinertia.storage.table_hdf5 import h5py_for
from astroinertia.units import Dimension


@dataclass(frozen=True)
class Column:
    """An array and its attributes."""

    values: np.ndarray
    attributes: Mapping[str, Any] = field(default_factory=dict)


def write_hdf5(path: Path, groups: Mapping[str, Mapping[str, Any]], columns: Mapping[str, Column]) -> None:
    """Write groups by name with their attributes, and columns by path, whole or not at all.

    SceneError if h5py is not installed, ArchiveError if the file cannot be written.

    >>> import h5py, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_hdf5(Path(folder, "a.hdf5"), {"Header": {"Time": 2.0}}, {"mass": Column(np.ones(3), {"unit": "kg"})})
    ...     with h5py.File(Path(folder, "a.hdf5")) as file:
    ...         print(file["Header"].attrs["Time"], file["mass"].attrs["unit"], file["mass"][:])
    2.0 kg [1. 1. 1.]
    """
    h5py = h5py_for(path)

    @hdf5_refusals()
    def fill(aside: Path) -> None:
        with h5py.File(aside, "w") as file:
            for name, attributes in groups.items():
                file.create_group(name).attrs.update(attributes)
            for name, column in columns.items():
                file.create_dataset(name, data=column.values).attrs.update(column.attributes)

    write_whole(path, fill)


def dimension(name: str) -> Dimension:
    """Exponents of mass, length and time of a quantity of the snapshots.

    >>> print(dimension("density") == Dimension(1, -3, 0))
    True
    """
    return SNAPSHOT[name].dimension or Dimension(0, 0, 0)


def origin(snapshot: Snapshot) -> dict[str, Any]:
    """What the file says of the run; a reader knows by units_system whether its numbers have units at all.

    >>> from astroinertia.interop.snapshots import snapshots_of
    >>> source = origin(next(snapshots_of(Path("runs/star"), "last")))
    >>> print(source["snapshot"], source["units_system"])
    2 SI
    """
    return {
        "name": snapshot.name,
        "source": snapshot.source,
        "snapshot": snapshot.number,
        "units_system": "dimensionless, G = 1" if snapshot.dimensionless else "SI",
    }


def in_cgs(of: Dimension) -> float:
    """The SI unit of a dimension in cgs.

    >>> print(f"{in_cgs(dimension('density')):g} g/cm3")  # 1 kg/m3
    0.001 g/cm3
    """
    return CM**of.length * GRAM**of.mass


def plain(name: str, values: np.ndarray) -> np.ndarray:
    """Values as other codes have them: numbers of materials are whole.

    >>> print(plain("material", np.array([0.0, 2.0])), plain("mass", np.array([0.0, 2.0])))
    [0 2] [0. 2.]
    """
    return values.astype(np.int32) if name == "material" else values
