"""Quantities of the headline series: each a row of quantities.csv, with what it is and why models lack it.

A model says what it knows of its body (BodyState) and what it has of its own; all that follows from the former is
worked out here, for all models alike.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, Self

import numpy as np

from astroinertia.inertia.tensor import axial_vector, inertia_from_second_moment
from astroinertia.storage.data_tables import rows_of
from astroinertia.units import DIMENSIONS, Dimension

Array = Any


@dataclass(frozen=True)
class BodyState:
    """What every model says of its body at one moment, in code units (G = 1); E is the number of effects.

    Moments are about the centre of mass. Energies are NaN where the model has no such thing. Each is recorded under its
    own name. particles: arrays of particles by name, as a snapshot has them, for observables of the model sph alone.
    """

    time: float
    step: int
    mass: float
    centre_of_mass: Array  # (3,)
    momentum: Array  # (3,)
    second_moment: Array  # (3, 3), Q
    mixed_moment: Array  # (3, 3), P
    kinetic_tensor: Array  # (3, 3), K
    virial_tensor: Array  # (E, 3, 3), V
    force: Array  # (E, 3)
    impulse: Array  # (E, 3)
    work: Array  # (E,)
    heating: Array  # (E,)
    kinetic_energy: float
    internal_energy: float
    gravitational_energy: float
    potential_energy: float
    total_energy: float
    integration_energy_error: float
    particles: Mapping[str, Array] | None = None


# What limits the time step of particles, besides the effects of a scene, as `timestep_limit` numbers it after these.
MODES = (1, 2, 3, 4)  # azimuthal wave numbers
TIMESTEP_CRITERIA = ("acceleration", "energy", "longest", "contact")
SAID = tuple(field.name for field in fields(BodyState) if field.name != "particles")
"""What of it is recorded."""


def row(body: BodyState, **own: Any) -> dict[str, Any]:
    """One row of the headline series: what every model says, what follows from it, and what a model has of its own.

    own: by name; it goes before what would follow, where a model knows a number by another way.
    """
    follows = {name: quantity.of(body) for name, quantity in RECORDED.items() if quantity.of and name not in own}
    return {name: getattr(body, name) for name in SAID} | follows | own


def of_ledger(evolved: Array, second_moment: Array, largest: float, mixed_impulse: Array) -> dict[str, Any]:
    """What a model records that integrates a ledger beside its body.

    evolved: Q by its own evolution equation (3, 3), beside that of the body. largest: the largest |I| of the run.
    mixed_impulse: what each effect has added to P, (E, 3, 3).
    """
    return {
        "inertia_tensor_evolved": inertia_from_second_moment(evolved),
        "ledger_closure": ledger_closure(evolved, second_moment, largest),
        "mixed_impulse": mixed_impulse,
    }


def ledger_closure(evolved: Array, second_moment: Array, largest: float) -> float:
    """|I of the ledger - I of the body| over the largest |I| of the run, from Q of both."""
    difference = inertia_from_second_moment(evolved) - inertia_from_second_moment(second_moment)
    return float(np.linalg.norm(difference) / largest)


class Quantity(NamedTuple):
    """One variable: its dimensions in the file, exponents of (mass, length, time), SI unit, long name, comment.

    `dimension` is None where the numbers are not converted: wall time, counts, ratios. absent: why models lack it, by
    model; all others have it. of: how it follows from what every model says of its body, where it does.
    """

    dims: tuple[str, ...]
    dimension: Dimension | None
    unit: str
    long_name: str
    comment: str = ""
    absent: Mapping[str, str] = MappingProxyType({})
    of: Callable[[BodyState], Array] | None = None

    def described(self) -> dict[str, Any]:
        """What a run's description keeps of it, as plain data."""
        dimension = None if self.dimension is None else list(self.dimension)
        return {**dict(zip(self._fields[:5], self, strict=False)), "dims": list(self.dims), "dimension": dimension}

    @classmethod
    def of_description(cls, said: Mapping[str, Any]) -> Self:
        """The quantity of such a description."""
        dimension = None if said["dimension"] is None else Dimension(*said["dimension"])
        return cls(tuple(said["dims"]), dimension, said["unit"], said["long_name"], said["comment"])


LAYERS_DEGREE = 20  # of the gravity field of a body of similar layers
ENCLOSED = 0.99
"""Share of the mass of particles that the ellipsoid of their surface encloses."""
UNRECORDED = "this model does not record it"
_RECURS = {
    "equivalent": "of the homogeneous ellipsoid with the same mass and second moments (a_k^2 = 5 Q_k / M)",
    "spin_axis": "n is the direction of the angular momentum, or the axis of the largest moment where there is none",
    "ratio": "moment of inertia about the spin axis over M R^2",
    "sphere": "of a sphere about the centre of mass; mean radius of a similar ellipsoid where the profile is kept",
    "system": "of the body and the point masses that move with it",
    "two_points": "of the companion and the body as two points at their centres of mass",
    "shifted": "the shift of the centre of mass is included",
}
_FOLLOWS: dict[str, Callable[[BodyState], Array]] = {
    "angular_momentum": lambda body: axial_vector(body.mixed_moment),
    "inertia_tensor": lambda body: inertia_from_second_moment(body.second_moment),
    "torque": lambda body: axial_vector(body.virial_tensor),
}


def quantities_of(path: Path, recurs: Mapping[str, str]) -> dict[str, dict[str, Quantity]]:
    """The quantities of a table beside the code (quantities.csv says what its columns are), by their part of it.

    recurs: what {phrases} in its texts stand for.
    """
    parts: dict[str, dict[str, Quantity]] = {}
    for row in rows_of(path):
        long_name, comment = (row[head].format(**recurs) for head in ("long_name", "comment"))
        parts.setdefault(row["table"], {})[row["name"]] = Quantity(
            tuple(row["axes"].split()), _dimension(row["dimension"]), row["unit"], long_name, comment,
            _absent(row["absent"]), _FOLLOWS.get(row["name"]),
        )  # fmt: skip
    return parts


def _dimension(text: str) -> Dimension | None:
    if not text:
        return None
    return DIMENSIONS[text] if text in DIMENSIONS else Dimension(*map(int, text.split()))


def _absent(text: str) -> dict[str, str]:
    reasons = (part.partition(": ") for part in text.split(" | ") if part)
    return {model: reason for models, _, reason in reasons for model in models.split()}


_PARTS = quantities_of(Path(__file__).with_name("quantities.csv"), _RECURS)
RECORDED = _PARTS["recorded"]
"""What a run records, in code units, under the same names."""
DERIVED = _PARTS["derived"]
"""What follows from the recorded quantities; computed in code units, but for the waves, which are in SI already."""
OF_EFFECTS = _PARTS["effects"]
"""What only scenes with certain effects have, and only then; recorded in code units, under the same names."""
OF_ATTITUDE = _PARTS["attitude"]
"""What follows from the attitude of a rigid body, and only of one: dataset.attitude."""

RENAMED = {"flattening": "ellipsoid_flattening", "mean_spin": "mean_angular_velocity"}
"""Series of before by their names of now: older files have them by these."""

LABELS: dict[str, tuple[list, str]] = {
    "i": (["x", "y", "z"], "Cartesian component"),
    "j": (["x", "y", "z"], "Cartesian component"),
    "principal": ([1, 2, 3], "number of the principal axis"),
    "mode": (list(MODES), "azimuthal wave number"),
    "coefficient": (["C20", "C21", "S21", "C22", "S22"], "coefficient of degree 2 of the gravity field"),
    "observer": (["polar", "equatorial"], "direction that a gravitational wave is seen from"),
}
