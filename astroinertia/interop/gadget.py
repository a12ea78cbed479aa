"""Snapshots as GADGET-2 and GADGET-4 write them in HDF5 ("snap_000.hdf5"), in GADGET's default units and float64.

The layout is that of the GADGET-2 user guide (Springel 2005, section 6) with the groups Header and PartType0, and the
unit system in Parameters and in the attributes of every field as in GADGET-4 (Springel, Pakmor, Zier & Reinecke 2021,
MNRAS 506, 2871), and as in GADGET-3 (VarDescription and beside it, as in EAGLE's files), which pynbody looks for.
GADGET's SmoothingLength is the radius at which the kernel vanishes; the h of this package, of which
that is a multiple, stands beside it as KernelScale. yt takes the default units (kpc, 10^10 solar masses, km/s) for
granted, and pynbody finds the time in Time_GYR alone. Tests: tests/unit/interop/test_export.py,
tests/physics/test_exports_elsewhere.py.
"""

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import SceneWarning
from astroinertia.interop.hdf5 import Column, dimension, in_cgs, origin, plain, write_hdf5
from astroinertia.interop.snapshots import Snapshot
from astroinertia.sph.table_gadget import CM, GRAM, FileUnits
from astroinertia.units import DIMENSIONS, Dimension

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
_GRAVITY = Dimension(-1, 3, -2)  # of G
GIGAYEAR = 3.15576e16  # s, of 365.25 days


# GADGET-2's default units, with the solar mass and the parsec of yt (unyt 3), which does not read what a file says
DEFAULT = FileUnits(mass=1e10 * 1.98841586e30, length=3.085677580962325e19, velocity=1e3)
NONE = FileUnits(1.0, 1.0, 1.0)


def write_gadget(snapshot: Snapshot, path: Path) -> None:
    """Write one snapshot in GADGET's default units, or as it is where the run has none.

    A SceneWarning where the run has a periodic box that is no cube, as GADGET's are: it is left out.

    >>> import h5py, tempfile
    >>> from astroinertia.interop.snapshots import snapshots_of
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_gadget(next(snapshots_of(Path("runs/star"), "last")), Path(folder, "snap_000.hdf5"))
    ...     with h5py.File(Path(folder, "snap_000.hdf5")) as file:
    ...         print(file["Header"].attrs["NumPart_Total"][0], f"{file['PartType0/Masses'][:].sum():.5g} x 10^10 suns")
    100 1e-10 x 10^10 suns
    """
    arrays, units = snapshot.arrays, NONE if snapshot.dimensionless else DEFAULT
    if snapshot.box is not None and not _is_cube(snapshot.box):
        warnings.warn(
            "the periodic box of the run is left out, for GADGET's are cubes (BoxSize is 0); files of SWIFT have it.",
            SceneWarning,
            stacklevel=2,
        )

    def column(values: np.ndarray, of: Dimension) -> Column:
        attributes = _scaling(of, units)
        return Column(
            values / units.of(of) if values.dtype.kind == "f" else values, attributes | _described(attributes)
        )

    columns = {"PartType0/ParticleIDs": column(snapshot.identity, Dimension(0, 0, 0))}
    for name, written in NAMES.items():
        if name in arrays:
            columns[f"PartType0/{written}"] = column(plain(name, arrays[name]), dimension(name))
    if "smoothing_length" in arrays:
        scale = arrays["smoothing_length"]
        columns["PartType0/KernelScale"] = column(scale, DIMENSIONS["length"])
        if snapshot.support is not None:
            columns["PartType0/SmoothingLength"] = column(snapshot.support * scale, DIMENSIONS["length"])
    groups = {"Header": _header(snapshot, units), "Parameters": _parameters(snapshot, units)}
    write_hdf5(path, groups | {"Astroinertia": origin(snapshot)}, columns)


def _header(snapshot: Snapshot, units: FileUnits) -> dict[str, Any]:
    counts = np.zeros(TYPES, dtype=np.uint32)
    counts[0] = snapshot.identity.size
    flags = ("Sfr", "Cooling", "StellarAge", "Metals", "Feedback")
    return {
        "NumPart_ThisFile": counts,
        "NumPart_Total": counts,
        "NumPart_Total_HighWord": np.zeros(TYPES, dtype=np.uint32),
        "MassTable": np.zeros(TYPES),
        "Time": snapshot.time / units.time,
        "Redshift": 0.0,
        "BoxSize": _box_size(snapshot) / units.length,
        "NumFilesPerSnapshot": 1,
        "Omega0": 0.0,
        "OmegaLambda": 0.0,
        "HubbleParam": 1.0,
        "Flag_DoublePrecision": 1,
        "Flag_Entropy_ICs": 0,
        **{f"Flag_{name}": 0 for name in flags},
    }


def _parameters(snapshot: Snapshot, units: FileUnits) -> dict[str, Any]:
    time = {} if snapshot.dimensionless else {"Time_GYR": snapshot.time / GIGAYEAR}
    return {
        **_cgs(units, snapshot.dimensionless),
        **time,
        "GravityConstantInternal": snapshot.gravitational_constant / units.of(_GRAVITY),
        "ComovingIntegrationOn": 0,
        "Omega0": 0.0,
        "OmegaLambda": 0.0,
        "HubbleParam": 1.0,
        "BoxSize": _box_size(snapshot) / units.length,
    }


def _cgs(units: FileUnits, dimensionless: bool) -> dict[str, float]:
    """The units in cgs; all of them 1, as files of other codes have them, where there are none."""
    mass, length = (1.0, 1.0) if dimensionless else (GRAM, CM)
    return {
        "UnitLength_in_cm": units.length * length,
        "UnitMass_in_g": units.mass * mass,
        "UnitVelocity_in_cm_per_s": units.velocity * length,
    }


def _is_cube(box: Sequence[float]) -> bool:
    return len(set(box)) == 1


def _box_size(snapshot: Snapshot) -> float:
    """GADGET's boxes are cubes; 0 says that there is none."""
    return snapshot.box[0] if snapshot.box is not None and _is_cube(snapshot.box) else 0.0


def _scaling(of: Dimension, units: FileUnits) -> dict[str, float]:
    # GADGET-4 counts in powers of length, mass and velocity
    return {
        "a_scaling": 0.0,
        "h_scaling": 0.0,
        "length_scaling": float(of.length + of.time),
        "mass_scaling": float(of.mass),
        "velocity_scaling": float(-of.time),
        "to_cgs": 1.0 if units is NONE else units.of(of) * in_cgs(of),
    }


def _described(scaling: dict[str, float]) -> dict[str, Any]:
    """What GADGET-3 says of a field: its unit as a product of powers, such as U_M U_L^-3; no field is comoving."""
    powers = {"U_M": "mass_scaling", "U_L": "length_scaling", "U_V": "velocity_scaling"}
    factors = [(unit, scaling[name]) for unit, name in powers.items() if scaling[name] != 0.0]
    product = [unit if power == 1.0 else f"{unit}^{power:g}" for unit, power in factors]
    return {
        # Readers look for a power up to the next blank.
        "VarDescription": f"Physical, in {' '.join(product) or 'no unit'} .",
        "CGSConversionFactor": scaling["to_cgs"],
        "aexp-scale-exponent": 0.0,
        "h-scale-exponent": 0.0,
    }
