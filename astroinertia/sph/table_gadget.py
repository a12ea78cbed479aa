"""Snapshots of GADGET, SWIFT and codes that write alike (AREPO, GIZMO) as particle tables, in SI if they tell units.

Layout: the groups Header and PartType0 to 6; units are attributes of Units, Parameters or Header, by the names of each
code. Only the particles of one type are a body: a file with several is refused, as are one part of a snapshot and
comoving coordinates. A body that lies across the faces of a box that is said to be periodic is put together.
Tests: tests/unit/interop/test_export.py, tests/unit/sph/test_table_of_snapshots.py.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.storage.table_hdf5 import group_names, members, numbers, opened, split_vectors
from astroinertia.units import GRAVITATIONAL_CONSTANT, Dimension

_HEADER, _TYPE = "Header", "PartType"
_LONGEST_ATTRIBUTE = 1000  # numbers
_LONGEST_NUMBER = 64  # bytes of one that is text
_SAME_CONSTANT = 2e-3  # relative: how far values of G differ that codes have had
_EMPTY = 0.1  # of a periodic box: less than this between particles is no gap between a body and itself
_CONSTANT = "PhysicalConstants:G"  # of SWIFT, where its parameter file sets it
_PERIODIC = "InitialConditions:periodic"  # likewise
_FIELDS = {
    "position": ("Coordinates",),
    "velocity": ("Velocities", "Velocity"),
    "mass": ("Masses", "Mass"),
    "u": ("InternalEnergy", "InternalEnergies"),
}
_LENGTH = ("UnitLength_in_cm", "UnitLength_In_CGS", "Unit length in cgs (U_L)")
_MASS = ("UnitMass_in_g", "UnitMass_In_CGS", "Unit mass in cgs (U_M)")
_VELOCITY = ("UnitVelocity_in_cm_per_s", "UnitVelocity_In_CGS")
_TIME = ("Unit time in cgs (U_t)",)
CM, GRAM = 100.0, 1000.0  # a metre in cm, a kilogram in g: these divide exactly, where 0.01 and 0.001 would not


@dataclass(frozen=True)
class FileUnits:
    """The units of length, mass and velocity of a file, in SI, and G in them where it was set by hand."""

    length: float
    mass: float
    velocity: float
    constant: float | None = None

    @property
    def time(self) -> float:
        """The unit of time."""
        return self.length / self.velocity

    def of(self, dimension: Dimension) -> float:
        """The unit of a dimension."""
        return self.mass**dimension.mass * self.length**dimension.length * self.time**dimension.time

    @property
    def all_one(self) -> bool:
        """Whether they are those of cgs, as files have them whose numbers have none."""
        return (CM * self.length, GRAM * self.mass, CM * self.velocity) == (1.0, 1.0, 1.0)

    @property
    def in_itself(self) -> float:
        """G in these units: that set by hand; 1 where they are all 1; else as it is."""
        if self.constant is not None:
            return self.constant
        if self.all_one:
            return 1.0
        own = GRAVITATIONAL_CONSTANT * self.mass / self.length / self.velocity**2
        return 1.0 if abs(own - 1.0) < _SAME_CONSTANT else own


def snapshot_units(path: Path, what: str) -> FileUnits | None:
    """What a snapshot states of its units; None where it states none, and for a file that is no snapshot."""
    name = f"{what} {path}"
    with opened(path, name) as (h5py, file):
        _, attributes = _groups(h5py, name, file)
        return _units(name, attributes) if attributes else None


def snapshot_columns(path: Path, most: int, what: str) -> tuple[dict[str, np.ndarray], FileUnits | None, str] | None:
    """Columns of the particles (mass, x, y, z and, if there, vx, vy, vz, u), in SI where the units are stated.

    Third is what was done to them, or nothing. None for a file that is no snapshot of this kind; SceneError for one
    that is, and cannot be a body.
    """
    name = f"{what} {path}"
    with opened(path, name) as (h5py, file):
        types, attributes = _groups(h5py, name, file)
        if not attributes:
            return None
        _refuse_parts_and_expansion(name, attributes)
        by_type = {group: members(h5py, name, file[group], _ALL_FIELDS) for group in types}
        peopled = [group for group, fields in by_type.items() if any(_rows(field) for field, _ in fields.values())]
        if len(peopled) != 1:
            raise SceneError(f"{name} has particles of {' and '.join(peopled) or 'no type'}; a body is of one type")
        fields = by_type[peopled[0]]
        own = {alias: key for key, aliases in _FIELDS.items() for alias in aliases if alias in fields}
        read = numbers(path, name, {alias: fields[alias] for alias in own}, most)
        columns = {own[alias]: column for alias, column in read.items()}
        if "u" in columns and attributes[_HEADER].number("Flag_Entropy_ICs"):
            raise SceneError(f"{name} has entropies where energies are (Flag_Entropy_ICs), which are not read")
        if "position" not in columns:
            raise SceneError(f"{name} has no Coordinates in {peopled[0]}")
        if "mass" not in columns:
            columns["mass"] = _mass_of_all(name, attributes[_HEADER], peopled[0], len(columns["position"]))
        columns["position"], moved = _together(columns["position"], _periodic_box(attributes))
        units = _units(name, attributes)
    if units is not None:
        in_si = {
            "position": units.length,
            "mass": units.mass,
            "velocity": units.velocity,
            "u": units.velocity * units.velocity,
        }
        with np.errstate(over="ignore", invalid="ignore"):  # what is too large is found as not finite
            columns = {key: column * in_si[key] for key, column in columns.items()}
    note = f"put together across faces of a periodic box along {', '.join(moved)}" if moved else ""
    return split_vectors(name, columns), units, note


_ALL_FIELDS = tuple(alias for aliases in _FIELDS.values() for alias in aliases)


class _Attributes:
    """The attributes of a group, as numbers that are looked at before they are read."""

    def __init__(self, file_name: str, group: Any) -> None:
        self.file_name, self.attrs = file_name, group.attrs

    def numbers(self, *names: str) -> np.ndarray | None:
        """The first of these attributes that is there, flat; SceneError if it is not of a few finite numbers."""
        for name in names:
            if name in self.attrs:
                kept = self.attrs.get_id(name)
                size = np.prod(kept.shape, dtype=float)
                if kept.dtype.kind not in "fiu" or not 0 < size <= _LONGEST_ATTRIBUTE:
                    raise SceneError(f"{self.file_name}: the attribute {name} is not a number")
                values = np.asarray(self.attrs[name], dtype=float).ravel()
                if not np.isfinite(values).all():
                    raise SceneError(f"{self.file_name}: the attribute {name} is not finite")
                return values
        return None

    def text_number(self, name: str) -> float | None:
        """A positive number that is written as text, as SWIFT does with parameters; SceneError if it is none."""
        if name not in self.attrs:
            return None
        kept = self.attrs.get_id(name)
        try:
            if kept.shape != () or kept.dtype.itemsize > _LONGEST_NUMBER:
                raise ValueError
            value = self.attrs[name]
            number = float(value.decode("ascii") if isinstance(value, bytes) else value)
        except (TypeError, ValueError):
            raise SceneError(f"{self.file_name}: the attribute {name} is not a number") from None
        if not 0.0 < number < np.inf:
            raise SceneError(f"{self.file_name}: the attribute {name} is not positive")
        return number

    def is_one(self, name: str) -> bool:
        """Whether an attribute is the text 1."""
        if name not in self.attrs or self.attrs.get_id(name).dtype.itemsize > _LONGEST_NUMBER:
            return False
        return str(self.attrs[name]) in ("1", "b'1'")

    def number(self, *names: str) -> float | None:
        """The same where it is one number, or a list of one."""
        values = self.numbers(*names)
        return None if values is None else float(values[0])


def _groups(h5py: Any, name: str, file: Any) -> tuple[list[str], dict[str, _Attributes]]:
    """The groups of particles, and the attributes of all others; none of a file that is no snapshot."""
    groups = group_names(h5py, name, file)
    types = [group for group in groups if group.startswith(_TYPE)]
    if _HEADER not in groups or not types:
        return [], {}
    return types, {group: _Attributes(name, file[group]) for group in groups if group not in types}


def _refuse_parts_and_expansion(name: str, attributes: Mapping[str, _Attributes]) -> None:
    header = attributes[_HEADER]
    if (header.number("NumFilesPerSnapshot") or 1) > 1:
        raise SceneError(f"{name} is one of several files of a snapshot; join them first")
    cosmological = [header.number("Redshift")]
    cosmological += [group.number("ComovingIntegrationOn", "Cosmological run") for group in attributes.values()]
    if any(cosmological):
        raise SceneError(f"{name} is of an expanding universe, whose comoving coordinates are not read")
    if any(group.number("HubbleParam") not in (None, 0.0, 1.0) for group in attributes.values()):
        raise SceneError(f"{name} has a HubbleParam, so that lengths and masses may be over h; write them without it")


def _periodic_box(attributes: Mapping[str, _Attributes]) -> np.ndarray | None:
    """The sides of the box (3,), where the file says that it is periodic: SWIFT's parameter, GADGET-4's option."""
    of_gadget = "Config" in attributes and "PERIODIC" in attributes["Config"].attrs
    of_swift = "Parameters" in attributes and attributes["Parameters"].is_one(_PERIODIC)
    size = attributes[_HEADER].numbers("BoxSize") if of_gadget or of_swift else None
    return np.broadcast_to(size, 3) if size is not None and size.size in (1, 3) and (size > 0.0).all() else None


def _together(position: np.ndarray, box: np.ndarray | None) -> tuple[np.ndarray, list[str]]:
    """Positions (N, 3) with the box cut where it is emptiest, and the axes along which that is not at its faces."""
    moved = []
    for axis, side in enumerate(() if box is None or position.shape[1:] != (3,) else box):
        along = np.sort(position[:, axis])
        with np.errstate(invalid="ignore"):  # what is not finite is found later
            gaps, across = np.diff(along), side - np.ptp(along)
        if gaps.size and across >= 0.0 and gaps.max() > max(2.0 * across, _EMPTY * side):
            beyond = position[:, axis] > along[np.argmax(gaps)]
            position = position - side * beyond[:, None] * np.eye(3)[axis]
            moved.append("xyz"[axis])
    return position, moved


def _mass_of_all(name: str, header: _Attributes, group: str, count: int) -> np.ndarray:
    """Masses of particles that all have the one in the header."""
    table = header.numbers("MassTable")
    number = group.removeprefix(_TYPE)
    if table is None or not number.isdecimal() or int(number) >= table.size or not table[int(number)] > 0:
        raise SceneError(f"{name} has neither Masses in {group} nor a mass of theirs in the header")
    return np.full(count, table[int(number)])


def _units(name: str, attributes: Mapping[str, _Attributes]) -> FileUnits | None:
    """The file's units, if it tells them and they are such."""
    own = attributes.get("Astroinertia")
    if own is not None and str(own.attrs.get("units_system", "SI")) != "SI":
        return None
    for group in ("Units", "Parameters", _HEADER):
        if group in attributes:
            units = attributes[group]
            length, mass, velocity = units.number(*_LENGTH), units.number(*_MASS), units.number(*_VELOCITY)
            time = units.number(*_TIME)
            if velocity is None and length is not None and time:
                velocity = length / time
            if length is not None and mass is not None and velocity is not None:
                break
    else:
        return None
    if min(length, mass, velocity) <= 0.0:
        raise SceneError(f"{name} has a unit that is not positive")
    constant = attributes["Parameters"].text_number(_CONSTANT) if "Parameters" in attributes else None
    return FileUnits(length / CM, mass / GRAM, velocity / CM, constant)


def _rows(dataset: Any) -> int:
    return dataset.shape[0] if dataset.shape else 0
