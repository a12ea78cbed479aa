"""Dumps of Phantom as particle tables, in SI if they tell units; sarracen reads them.

Format: the native binary format of Phantom's documentation ("dumpfile"), which is that of sphNG: Fortran records, each
between two tags with its length; a header of tagged values by type; blocks of tagged arrays, the second of them sinks.
A dump has masses by type of particle, halved at each level of adaptive refinement, marks particles that a sink has
accreted or that are dead by h <= 0, and sinks that were merged by m <= 0.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.sph.table_gadget import CM, GRAM, FileUnits
from astroinertia.units import shown

NEEDS = "pip install 'astroinertia[phantom]'"
_MARK = 60769  # the first number of a dump, by which it is known
_DEFAULT_SIZES = {20: (4, 4), 24: (4, 8), 36: (8, 4), 40: (8, 8)}  # bytes of integer and real, by the first record's
_TAG, _IDENTIFIER, _COUNTS = 16, 100, 40  # bytes of a name, of the dump's identifier, of a block's lengths
_LONGEST_HEADER = 1 << 16  # bytes of a record that are looked at
_PROCESSES = b"nblocks"  # the name of how many processes wrote
_ORDERS: tuple[Literal["little", "big"], ...] = ("little", "big")
_COLUMNS = ("x", "y", "z", "vx", "vy", "vz", "u")


@dataclass(frozen=True)
class Dump:
    """Columns mass, x, y, z and, if there, vx, vy, vz, u; in SI where the units are stated.

    note: what is among the particles or left out; unfit: what they have that a scene's body cannot; both may be empty.
    """

    columns: dict[str, np.ndarray]
    units: FileUnits | None
    note: str
    unfit: str


def is_dump(path: Path) -> bool:
    """Whether a file begins as Phantom's dumps do, whatever it is called."""
    if not path.is_file():
        return False
    try:
        with path.open("rb") as file:
            return bool(_order(file.read(12)[4:]))
    except (OSError, ValueError):
        return False


def read_dump(path: Path, most: int, what: str) -> Dump:
    """The particles of a dump; sinks count as points with their masses.

    most: particles at most; what: how messages call the file. SceneError that says what is wrong with it, or that
    sarracen is not installed.
    """
    name = f"{what} {path}"
    try:
        _refuse_damaged(path)
        particles, sinks = _by_sarracen(path)
    except (ArithmeticError, AssertionError, AttributeError, LookupError, OSError, TypeError, ValueError) as error:
        raise SceneError(f"{name} is not a whole dump of Phantom ({shown(str(error), 100)})") from error
    if len(particles) > most:
        raise SceneError(f"{name} has more than {most} particles")
    return _dump(name, particles.params, particles, sinks)


def _by_sarracen(path: Path) -> tuple[Any, Any]:
    """Tables of the particles and of the sinks, None where there is none."""
    try:
        import sarracen  # pyright: ignore[reportMissingImports]  an extra: only this file needs it
    except ImportError as error:
        lacks = f"is a dump of Phantom, which sarracen reads ({error}); install what it takes with: {NEEDS}"
        raise SceneError(f"{path} {lacks}") from None
    tables: Any = sarracen.read_phantom(str(path), separate_types="sinks", ignore_inactive=False)
    return (tables[0], tables[1]) if isinstance(tables, list) else (tables, None)


def _dump(name: str, header: dict[str, Any], particles: Any, sinks: Any) -> Dump:
    if not {"x", "y", "z"} <= set(particles):
        raise SceneError(f"{name} has particles without x, y and z")
    kinds = _whole(particles, "itype")
    columns = {key: particles[key].to_numpy(dtype=float) for key in _COLUMNS if key in particles}
    with np.errstate(over="ignore"):  # what is too large is found as not finite
        columns["mass"] = _masses(name, header, kinds) * 0.5 ** (_whole(particles, "apr_level") - 1)
    alive = np.ones(len(particles), dtype=bool)
    if "h" in particles:
        alive = ~(particles["h"].to_numpy() <= 0.0)
    columns = {key: column[alive] for key, column in columns.items()}
    kinds, dead = np.unique(kinds[alive]), int((~alive).sum())
    notes = [f"{dead} accreted or dead ones left out"] if dead else []
    unfit = [] if {"vx", "vy", "vz"} <= set(columns) else ["no velocities, as a small dump"]
    if kinds.size > 1:
        notes.append(f"of the types {', '.join(map(str, kinds))}")
        unfit.append(f"particles of {kinds.size} types")
    if sinks is not None:
        points = _sinks(name, sinks, columns)
        columns = {key: np.append(column, points[key]) for key, column in columns.items()}
        if count := points["mass"].size:
            counted = "1 sink" if count == 1 else f"{count} sinks"
            notes.append(f"{counted} among them as points")
            unfit.append(counted)
    return Dump(*_in_si(name, header, columns), ", ".join(notes), " and ".join(unfit))


def _whole(particles: Any, column: str) -> np.ndarray:
    """A column of small numbers, 1 where there is none."""
    return particles[column].to_numpy().astype(int) if column in particles else np.ones(len(particles), dtype=int)


def _masses(name: str, header: dict[str, Any], kinds: np.ndarray) -> np.ndarray:
    # sarracen repeats the tag of every type's mass with a number, and would give a type that is alone the gas's.
    masses = np.zeros(len(kinds))
    for kind in np.unique(kinds):
        particle_mass = header.get("massoftype" if kind == 1 else f"massoftype_{kind}")
        if particle_mass is None:
            raise SceneError(f"{name} does not state the mass of particles of type {kind}")
        masses[kinds == kind] = float(particle_mass)
    return masses


def _sinks(name: str, sinks: Any, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Sinks in the columns of the particles; u, which they have not, is 0."""
    there = sinks[sinks["m"] > 0.0] if "m" in sinks else None
    needed = set(columns) - {"mass", "u"}
    if there is None or not needed <= set(there):
        raise SceneError(f"{name} has sinks without a mass, a position or a velocity")
    points = {key: there[key].to_numpy(dtype=float) for key in needed}
    return {"mass": there["m"].to_numpy(dtype=float), "u": np.zeros(len(there)), **points}


def _in_si(
    name: str, header: dict[str, Any], columns: dict[str, np.ndarray]
) -> tuple[dict[str, np.ndarray], FileUnits | None]:
    scales = [float(header[key]) for key in ("umass", "udist", "utime") if key in header]
    if len(scales) < 3 or scales == [1.0, 1.0, 1.0]:  # Phantom's units where a setup has none
        return columns, None
    mass, length, time = scales
    if not (min(mass, length, time) > 0.0 and np.isfinite([mass, length, time]).all()):
        raise SceneError(f"{name} has a unit that is not positive")
    mass, length = mass / GRAM, length / CM
    units = {"mass": mass, "u": (length / time) ** 2}
    units |= dict.fromkeys("xyz", length) | dict.fromkeys(("vx", "vy", "vz"), length / time)
    with np.errstate(over="ignore", invalid="ignore"):  # what is too large is found as not finite
        in_si = {key: column * units[key] for key, column in columns.items()}
    return in_si, FileUnits(length, mass, length / time)


def _refuse_damaged(path: Path) -> None:
    """ValueError unless the file has the records that it announces, whole.

    sarracen looks at no length, and would go on looking for as many arrays as a damaged file announces.
    """
    records = _records(path)

    def taken(length: int) -> bytes:
        stored, start = next(records, (None, b""))
        if stored != length:
            raise ValueError(f"a record of {length} bytes is {'missing' if stored is None else f'of {stored}'}")
        return start

    length, start = next(records, (0, b""))
    if length not in _DEFAULT_SIZES:
        raise ValueError("it does not begin as one")
    order = "<" if _order(start[:8]) == "little" else ">"
    integer, real = _DEFAULT_SIZES[length]
    sizes = (integer, 1, 2, 4, 8, real, 4, 8)
    taken(_IDENTIFIER)
    processes = _processes(taken, sizes, order)
    blocks = _numbers(taken(4), f"{order}i4")[0]
    if not 0 < processes <= blocks or blocks % processes:
        raise ValueError(f"it has {blocks} blocks of {processes} processes")
    for _ in range(processes):
        for counts in [taken(_COUNTS) for _ in range(blocks // processes)]:
            rows = _numbers(counts[:8], f"{order}i8")[0]
            for size, arrays in zip(sizes, _numbers(counts[8:], f"{order}i4"), strict=True):
                for _ in range(arrays):
                    taken(_TAG)
                    taken(size * rows)
    if next(records, None):
        raise ValueError("it has more records than it announces")


def _processes(taken: Callable[[int], bytes], sizes: Sequence[int], order: str) -> int:
    """How many processes wrote a dump, by its header of numbers of all kinds, which is taken whole; else 1."""
    processes = 1
    for kind, size in enumerate(sizes):
        if count := _numbers(taken(4), f"{order}i4")[0]:
            tags, values = taken(_TAG * count), taken(size * count)
            names = [tags[at : at + _TAG].strip() for at in range(0, len(tags), _TAG)]
            if kind == 0 and _PROCESSES in names:
                processes = _numbers(values, f"{order}i{size}")[names.index(_PROCESSES)]
    return processes


def _records(path: Path) -> Iterator[tuple[int, bytes]]:
    """Length and first bytes of every record; ValueError where one does not close as it opens."""
    with path.open("rb") as file:
        size, at = os.fstat(file.fileno()).st_size, 0
        order = _order(file.read(12)[4:])
        while at < size:
            file.seek(at)
            opening = file.read(4)
            length = int.from_bytes(opening, order)
            start = file.read(min(length, _LONGEST_HEADER))
            file.seek(at + 4 + length)
            if file.read(4) != opening:
                raise ValueError(f"the record at byte {at} does not end where it says")
            yield length, start
            at += length + 8


def _order(mark: bytes) -> Literal["little", "big"]:
    """The order of bytes in which a file begins with the mark of a dump; ValueError if it does not."""
    for size in (4, 8):
        for order in _ORDERS:
            if int.from_bytes(mark[:size], order) == _MARK:
                return order
    raise ValueError("it does not begin as one")


def _numbers(content: bytes, kind: str) -> list[int]:
    return np.frombuffer(content, kind).tolist()
