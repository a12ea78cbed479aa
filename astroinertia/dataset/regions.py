"""The quantities of regions in a dataset: those that are recorded, and those that follow from them.

A region has its own mass, centre, moments and ledger, under the same names and definitions as the whole body, with
`region_` before them. Tests: tests/unit/ledger/test_regions.py, tests/physics/test_regions.py.
"""

from collections.abc import Mapping

import numpy as np

from astroinertia.dataset.derived import derived_quantities
from astroinertia.dataset.schema import PARTS

RECORDED, DERIVED = PARTS["region"], PARTS["region_derived"]
QUANTITIES = RECORDED | DERIVED


def regional_quantities(series: Mapping[str, np.ndarray], tolerance: float) -> dict[str, np.ndarray]:
    """The derived quantities of regions, (T, R, ...), in the units of `series`; NaN while a region is empty."""
    mass = series["region_mass"]
    wanted = {name.removeprefix("region_"): name for name in DERIVED}
    regional: dict[str, np.ndarray] = {}
    for k in range(mass.shape[1]):
        there = np.flatnonzero(series["region_particles"][:, k] > 0)
        if not len(there):
            continue
        own = {
            name.removeprefix("region_"): series[name][there, k]
            for name in RECORDED
            if name in series and name != "region_virial_tensor"
        }
        derived = derived_quantities(own, tolerance, None)
        radius = own["volume_radius"]
        moment = np.einsum("ti,tij,tj->t", derived["spin_axis"], own["inertia_tensor"], derived["spin_axis"])
        derived["moment_ratio"] = moment / (own["mass"] * radius**2)
        for name, full in wanted.items():
            if name in derived:
                row = derived[name]
                regional.setdefault(full, np.full((*mass.shape, *row.shape[1:]), np.nan))[there, k] = row
    return regional
