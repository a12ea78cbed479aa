"""What a dataset has beside its headline series (observables.quantities): snapshots, labels, attributes, units."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.observables.quantities import LABELS, UNRECORDED, Quantity, quantities_of
from astroinertia.units import DIMENSIONLESS, CodeUnits

FORMAT = 1
COMPUTED = "computed by astroinertia from the scene in `scene`, with the versions in `versions`"
"""The first line of a history; a line follows for each time that a run went on otherwise, or was branched."""
CONVENTIONS = "CF-1.11"
INERTIAL = "inertial"
"""The frame of vectors and tensors where no effect turns it."""
PARTS = quantities_of(
    Path(__file__).with_name("quantities.csv"),
    {
        "own": "about the region's own centre of mass",
        "flux": "what particles that entered or left have changed since the start, membership being judged at each "
        "record",
    },
)
"""What is beside the headline series, by the parts of the table quantities.csv."""
SNAPSHOT = PARTS["snapshot"]
"""Per particle, in the order of the particles' identities."""
TIME_QUANTITY, SNAPSHOT_TIME = PARTS["time"]["time"], PARTS["time"]["snapshot_time"]
_DIGITS = 15  # of times


def reason_for_absence(name: str, effects: list[str], dimensionless: bool, frame: str) -> str:
    """Why a quantity is NaN throughout."""
    if name in ("gravitational_energy", "rotational_to_gravitational") and "gravity" not in effects:
        return "the scene lists no gravity"
    if name == "internal_energy" and "pressure" not in effects:
        return "the scene lists no pressure"
    if name.startswith("gw_"):
        if dimensionless:
            return "the scene is dimensionless, so the speed of light has no value"
        if frame != INERTIAL:
            return "the frame is not inertial"
        return "too few records, or not all that the waves follow from is known"
    if name.startswith(("moment_ratio", "surface_")):
        return "the surface of the body is not known"
    if name.startswith("region_"):
        return "the region is empty throughout" if "gravity" in effects else "the scene lists no gravity"
    if name == "figure_rotation_rate":
        return "the principal axes are undefined throughout: moments are equal within the tolerance"
    if name in ("angular_velocity", "angular_speed", "rotational_energy"):
        return "the body has no moment about one axis, so that its rotation about it is not defined"
    return UNRECORDED


def code_units(metadata: Mapping[str, Any]) -> CodeUnits:
    """The units that a run's records are in; with the G it used, so that old files keep their meaning."""
    units = metadata.get("code_units")
    if units is None or metadata.get("dimensionless"):
        return DIMENSIONLESS
    return CodeUnits(units["mass"], units["length"], units["G"])


def attributes(quantity: Quantity, metadata: Mapping[str, Any]) -> dict[str, str]:
    """The attributes of a variable; in a dimensionless scene the unit of all that is converted is 1."""
    plain = quantity.dimension is None or code_units(metadata) != DIMENSIONLESS
    attrs = {"units": quantity.unit if plain else "1", "long_name": quantity.long_name}
    return attrs | ({"comment": quantity.comment} if quantity.comment else {})


def label(name: str) -> tuple[str, list, dict[str, str]]:
    """A coordinate of labels, as xarray takes it."""
    labels, text = LABELS[name]
    return name, labels, {"long_name": text}


def converted(array: np.ndarray, quantity: Quantity, units: CodeUnits) -> np.ndarray:
    """An array in code units, in SI where its quantity is one of these.

    Times, which are labels, have 15 digits, so that multiples of an interval are what its user writes.
    """
    values = array if quantity.dimension is None else array * units.unit(quantity.dimension)
    if quantity not in (TIME_QUANTITY, SNAPSHOT_TIME):
        return values
    return np.array([float(f"{time:.{_DIGITS}g}") for time in np.ravel(values)]).reshape(np.shape(values))
