"""Snapshots as GADGET-2 and GADGET-4 write them in HDF5 ("snap_000.hdf5"), in SI units and float64.

The layout is that of the GADGET-2 user guide (Springel 2005, section 6) with the groups Header and PartType0, and the
unit system in Parameters and in the attributes of every field as in GADGET-4 (Springel, Pakmor, Zier & Reinecke 2021,
MNRAS 506, 2871). GADGET's SmoothingLength is the radius at which the kernel vanishes; the h of this package, of which
that is a multiple, stands beside it bit for bit as KernelScale. Tests: tests/unit/interop/test_export.py.
"""

from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.interop.hdf5 import CM, GRAM, Column, dimension, in_cgs, origin, plain, write_hdf5
from astroinertia.interop.snapshots import Snapshot
from astroinertia.observables.quantities import LENGTH
from astroinertia.units import Dimension

NAMES = {
    "position": "Coordinates",
    "velocity": "Velocities",
    "mass": "Masses",
    "internal_energy": "InternalEnergy",
    "density": "Density",
    "pressure": "Pressure",
    "material": "MaterialIDs",
}
TYPES = 6  # of particles: gas is type 0


def write_gadget(snapshot: Snapshot, path: Path) -> None:
    """Write one snapshot; the numbers are the dataset's own, bit for bit.

    >>> import h5py, tempfile
    >>> from astroinertia.interop.snapshots import snapshots_of
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_gadget(next(snapshots_of(Path("runs/star"), "last")), Path(folder, "snap_000.hdf5"))
    ...     with h5py.File(Path(folder, "snap_000.hdf5")) as file:
    ...         print(file["Header"].attrs["NumPart_Total"][0], f"{file['PartType0/Masses'][:].sum():.4g} kg")
    100 1.988e+30 kg
    """
    arrays = snapshot.arrays
    columns = {"PartType0/ParticleIDs": Column(snapshot.identity, _scaling(Dimension(0, 0, 0)))}
    for name, written in NAMES.items():
        if name in arrays:
            columns[f"PartType0/{written}"] = Column(plain(name, arrays[name]), _scaling(dimension(name)))
    if "smoothing_length" in arrays:
        scale = arrays["smoothing_length"]
        columns["PartType0/KernelScale"] = Column(scale, _scaling(LENGTH))
        if snapshot.support is not None:
            columns["PartType0/SmoothingLength"] = Column(snapshot.support * scale, _scaling(LENGTH))
    groups = {"Header": _header(snapshot), "Parameters": _parameters(snapshot), "Astroinertia": origin(snapshot)}
    write_hdf5(path, groups, columns)


def _header(snapshot: Snapshot) -> dict[str, Any]:
    counts = np.zeros(TYPES, dtype=np.uint32)
    counts[0] = snapshot.identity.size
    flags = ("Sfr", "Cooling", "StellarAge", "Metals", "Feedback")
    return {
        "NumPart_ThisFile": counts,
        "NumPart_Total": counts,
        "NumPart_Total_HighWord": np.zeros(TYPES, dtype=np.uint32),
        "MassTable": np.zeros(TYPES),
        "Time": snapshot.time,
        "Redshift": 0.0,
        "BoxSize": _box_size(snapshot),
        "NumFilesPerSnapshot": 1,
        "Omega0": 0.0,
        "OmegaLambda": 0.0,
        "HubbleParam": 1.0,
        "Flag_DoublePrecision": 1,
        "Flag_Entropy_ICs": 0,
        **{f"Flag_{name}": 0 for name in flags},
    }


def _parameters(snapshot: Snapshot) -> dict[str, Any]:
    return {
        "UnitLength_in_cm": CM,
        "UnitMass_in_g": GRAM,
        "UnitVelocity_in_cm_per_s": CM,
        "GravityConstantInternal": snapshot.gravitational_constant,
        "ComovingIntegrationOn": 0,
        "Omega0": 0.0,
        "OmegaLambda": 0.0,
        "HubbleParam": 1.0,
        "BoxSize": _box_size(snapshot),
    }


def _box_size(snapshot: Snapshot) -> float:
    """GADGET's boxes are cubes; 0 says that there is none."""
    return snapshot.box[0] if snapshot.box is not None and len(set(snapshot.box)) == 1 else 0.0


def _scaling(of: Dimension) -> dict[str, float]:
    # GADGET-4 counts in powers of length, mass and velocity
    return {
        "a_scaling": 0.0,
        "h_scaling": 0.0,
        "length_scaling": float(of.length + of.time),
        "mass_scaling": float(of.mass),
        "velocity_scaling": float(-of.time),
        "to_cgs": in_cgs(of),
    }
