"""The synthetic runs as datasets in SI: headline series and particles."""

import numpy as np
import xarray as xr

from astroinertia import dataset
from astroinertia.dataset import snapshots
from astroinertia.dataset.schema import code_units
from tests.unit.affine_body import METADATA


def headline(records, metadata=METADATA):
    """The headline dataset of records in code units."""
    stacked = {name: np.stack([np.asarray(record[name]) for record in records]) for name in records[0]}
    return dataset.headline(stacked, metadata)


def particles(parts, metadata=METADATA):
    """The dataset of snapshots in code units."""
    arrays = {name: np.stack([np.asarray(part[name]) for part in parts]) for name in parts[0]}
    units = code_units(metadata)
    found = {}
    for name, values in arrays.items():
        quantity = snapshots.snapshot_quantity(name, values.shape[1:])
        factor = 1.0 if quantity.dimension is None else units.unit(quantity.dimension)
        found[name] = (quantity.dims, values * factor, {"units": quantity.unit})
    return xr.Dataset(found).rename(time="snapshot_time").set_coords("snapshot_time").assign_coords(i=["x", "y", "z"])
