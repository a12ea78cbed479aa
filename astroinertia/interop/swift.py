"""Snapshots as SWIFT writes them in HDF5, with the unit system and the groups that its readers ask for, in float64.

SWIFT's smoothing length is twice the standard deviation of the kernel (Dehnen & Aly 2012, MNRAS 425, 1068, equation 8);
the h of this package stands beside it bit for bit as KernelScales. SWIFT has its particles in a box that begins at 0:
here they stay where the run has them, about the origin, and `InitialConditions:shift` is the parameter by which SWIFT
moves them. Tests: tests/unit/interop/test_export.py, tests/physics/test_exports_elsewhere.py.
"""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.dataset.schema import SNAPSHOT
from astroinertia.interop.hdf5 import Column, dimension, in_cgs, origin, plain, write_hdf5
from astroinertia.interop.snapshots import Snapshot
from astroinertia.sph.table_gadget import CM, GRAM
from astroinertia.units import DIMENSIONS, Dimension

NAMES = {
    "position": "Coordinates",
    "velocity": "Velocities",
    "mass": "Masses",
    "internal_energy": "InternalEnergies",
    "density": "Densities",
    "pressure": "Pressures",
    "material": "MaterialIDs",
}
TYPES = 7  # of particles: gas is type 0
KERNELS = {  # SWIFT's name, and the radius of the support over twice the standard deviation: Dehnen & Aly, table 1
    "cubic": ("Cubic spline (M4)", 1.825742),
    "quartic": ("Quartic spline (M5)", 2.018932),
    "quintic": ("Quintic spline (M6)", 2.195775),
    "wendland_c2": ("Wendland C2", 1.936492),
    "wendland_c4": ("Wendland C4", 2.207940),
    "wendland_c6": ("Wendland C6", 2.449490),
}


def write_swift(snapshot: Snapshot, path: Path) -> None:
    """Write one snapshot; the numbers are the dataset's own, bit for bit.

    >>> import h5py, tempfile
    >>> from astroinertia.interop.snapshots import snapshots_of
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_swift(next(snapshots_of(Path("runs/star"), "last")), Path(folder, "star.hdf5"))
    ...     with h5py.File(Path(folder, "star.hdf5")) as file:
    ...         print(file["Header"].attrs["Time"][0], file["PartType0/Coordinates"].shape)
    1200.0 (100, 3)
    """
    arrays = snapshot.arrays
    field = partial(_field, dimensionless=snapshot.dimensionless)
    nothing = Dimension(0, 0, 0)
    columns = {"PartType0/ParticleIDs": Column(snapshot.identity, field(nothing, "number of the particle, from 1"))}
    for name, written in NAMES.items():
        if name in arrays:
            described = field(dimension(name), SNAPSHOT[name].long_name)
            columns[f"PartType0/{written}"] = Column(plain(name, arrays[name]), described)
    if "smoothing_length" in arrays:
        scale = arrays["smoothing_length"]
        columns["PartType0/KernelScales"] = Column(scale, field(DIMENSIONS["length"], "h of astroinertia"))
        if snapshot.support is not None:
            lengths = snapshot.support / KERNELS[str(snapshot.kernel)][1] * scale
            columns["PartType0/SmoothingLengths"] = Column(
                lengths, field(DIMENSIONS["length"], "twice the kernel's deviation")
            )
    write_hdf5(path, _groups(snapshot), columns)


def _groups(snapshot: Snapshot) -> dict[str, dict[str, Any]]:
    units = {
        "Unit length in cgs (U_L)": 1.0 if snapshot.dimensionless else CM,
        "Unit mass in cgs (U_M)": 1.0 if snapshot.dimensionless else GRAM,
        "Unit time in cgs (U_t)": 1.0,
        "Unit current in cgs (U_I)": 1.0,
        "Unit temperature in cgs (U_T)": 1.0,
    }
    kernel = {} if snapshot.support is None else {"Kernel function": _text(KERNELS[str(snapshot.kernel)][0])}
    return {
        "Header": _header(snapshot),
        "Units": _lists(units),
        "InternalCodeUnits": _lists(units),
        "Cosmology": {"Cosmological run": np.array([0]), **_lists({"Redshift": 0.0, "Scale-factor": 1.0, "h": 1.0})},
        "Policy": {"cosmological integration": 0, "hydrodynamics": 1, "self gravity": 0},
        "Parameters": {"InitialConditions:periodic": _text("0" if snapshot.box is None else "1")},
        "HydroScheme": {
            "Scheme": _text("astroinertia, entropy-conserving SPH"),
            "Dimension": np.array([3.0]),
            **kernel,
        },
        "SubgridScheme": {},
        "GravityScheme": {},
        "PhysicalConstants": _lists({"newton_G": snapshot.gravitational_constant}),
        "Code": {"Code": _text("astroinertia")},
        "Astroinertia": origin(snapshot),
    }


def _header(snapshot: Snapshot) -> dict[str, Any]:
    counts = np.zeros(TYPES, dtype=np.uint32)
    counts[0] = snapshot.identity.size
    edge = 2.0 * float(np.abs(snapshot.arrays["position"]).max(initial=0.0)) or 1.0
    return {
        "Code": _text("SWIFT"),  # by which readers know the format; who wrote the file is in the group Code
        "BoxSize": np.array(snapshot.box or (edge, edge, edge)),
        "Dimension": np.array([3]),
        "NumPart_ThisFile": counts,
        "NumPart_Total": counts,
        "NumPart_Total_HighWord": np.zeros(TYPES, dtype=np.uint32),
        "MassTable": np.zeros(TYPES),
        "CanHaveTypes": np.array([1] + [0] * (TYPES - 1), dtype=np.int32),
        "NumPartTypes": np.array([TYPES], dtype=np.int32),
        "NumFilesPerSnapshot": np.array([1], dtype=np.int32),
        "OutputType": _text("FullVolume"),
        "RunName": _text(snapshot.name),
        "Flag_Entropy_ICs": np.zeros(TYPES, dtype=np.uint32),
        **_lists({"Time": snapshot.time, "Redshift": 0.0, "Scale-factor": 1.0}),
    }


def _field(of: Dimension, description: str, dimensionless: bool) -> dict[str, Any]:
    cgs = 1.0 if dimensionless else in_cgs(of)
    exponents = {
        "U_M": of.mass,
        "U_L": of.length,
        "U_t": of.time,
        "U_I": 0.0,
        "U_T": 0.0,
        "a-scale": 0.0,
        "h-scale": 0.0,
    }
    return {
        **_lists({f"{name} exponent": power for name, power in exponents.items()}),
        **_lists({
            "Conversion factor to CGS (not including cosmological corrections)": cgs,
            "Conversion factor to physical CGS (including cosmological corrections)": cgs,
        }),
        "Description": _text(description),
        "Lossy compression filter": _text("None"),
        "Value stored as physical": np.array([1], dtype=np.int32),
        "Property can be converted to comoving": np.array([1], dtype=np.int32),
    }  # fmt: skip


def _lists(numbers: dict[str, float]) -> dict[str, np.ndarray]:
    """SWIFT's numbers are lists of one."""
    return {name: np.array([float(number)]) for name, number in numbers.items()}


def _text(text: str) -> np.bytes_:
    return np.bytes_(text.encode())
