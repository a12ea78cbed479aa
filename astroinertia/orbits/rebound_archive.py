"""Orbits out of a REBOUND SimulationArchive, snapshot by snapshot."""

import json
import subprocess
import sys
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import rebound
from rebound.units import hash_to_unit, lengths_SI, times_SI

from astroinertia.errors import SceneWarning
from astroinertia.orbits import rebound_archive_child
from astroinertia.orbits.simulation import BODY
from astroinertia.storage.atomic import temporary_folder
from astroinertia.storage.bounded import plain_text
from astroinertia.units import CodeUnits

Array = Any


def snapshots(path: str | Path, body: str | int | None = None, units: CodeUnits | None = None) -> list[Any]:
    """Every snapshot of an archive as a `rebound.Simulation`, with the body as particle 0 and time 0 at the first.

    body is the name or the number of the body's particle: without it that of the name "body", else the first. With
    `units` they are in code units, G = 1, for which the archive must say what its own are (`Simulation.units`) unless
    the code units are dimensionless. They go on by IAS15, whatever the archive was made with. ValueError, in a
    sentence, for a file that is no archive, a particle that is not there, or particles that come or go; a SceneWarning
    where only some snapshots of a damaged file can be read. Source: Rein & Tamayo 2017, MNRAS 467, 2377. Checked by
    tests/unit/orbits/test_rebound_archive.py.

    >>> import tempfile
    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0, name="body")
    >>> bodies.add(a=1.0, name="moon")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     bodies.save_to_file(str(Path(folder, "orbit.bin")), step=100)
    ...     bodies.integrate(10.0)
    ...     found = snapshots(Path(folder, "orbit.bin"))
    >>> print(found[0].t, found[0].particles[0].name, f"{found[-1].particles[1].a:.9f}")
    0.0 body 1.000000000
    """
    return list(_simulations(path, body, units))


def first_snapshot(path: str | Path, body: str | int | None = None, units: CodeUnits | None = None) -> Any:
    """The first of the `snapshots`. Checked by tests/unit/orbits/test_rebound_archive.py.

    >>> import tempfile
    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0, name="body")
    >>> bodies.add(a=1.0, name="moon")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     bodies.save_to_file(str(Path(folder, "orbit.bin")))
    ...     print(len(first_snapshot(Path(folder, "orbit.bin")).particles))
    2
    """
    return next(_simulations(path, body, units))


def _simulations(path: str | Path, body: str | int | None, units: CodeUnits | None) -> Iterator[Any]:
    source = Path(path)
    if not source.is_file():
        raise ValueError(f"{source.name} is not a file" if source.exists() else f"there is no archive {source.name}")
    facts = source.stat()
    stored = _read(source, facts.st_size, facts.st_mtime_ns)
    number = _number(stored.names, body)
    order = [number, *(k for k in range(len(stored.names)) if k != number)]
    length, time = _scales(stored, units, source.name)
    for moment, constant, particles in zip(stored.times, stored.constants, stored.particles, strict=True):
        fresh = rebound.Simulation()
        # What an orbit shows is G M: masses are those that it gives with G = 1.
        fresh.G, mass = (constant, 1.0) if units is None else (1.0, length**3 / time**2 / constant)
        for k in order:
            place, speed = particles[k, 1:4] / length, particles[k, 4:7] * (time / length)
            keys = ("x", "y", "z", "vx", "vy", "vz")
            state = dict(zip(keys, map(float, (*place, *speed)), strict=True))
            fresh.add(m=float(particles[k, 0]) / mass, name=stored.names[k], **state)
        fresh.t = (moment - stored.times[0]) / time
        yield fresh


@dataclass(frozen=True)
class _Stored:
    """What an archive of T snapshots of N particles holds, in its own units.

    particles: m, x, y, z, vx, vy, vz, (T, N, 7). length, time: REBOUND's numbers of the units, 0 where it has none.
    """

    names: list[str]
    times: list[float]
    constants: list[float]
    length: int
    time: int
    particles: np.ndarray


@lru_cache(maxsize=1)  # a run asks for it several times
def _read(source: Path, size: int, changed: int) -> _Stored:
    """The snapshots of a file, read by a process of its own; ValueError where that finds none, or ends at them."""
    with temporary_folder() as place:
        plain = place / "archive.bin"  # REBOUND takes ASCII only
        plain.symlink_to(source.resolve())
        command = [sys.executable, "-P", rebound_archive_child.__file__, str(plain)]
        child = subprocess.run(command, capture_output=True, check=False)
    if child.returncode:
        raise ValueError(f"{source.name} is not read as an archive of REBOUND's: it is damaged")
    line, _, states = child.stdout.partition(b"\n")
    header = json.loads(line)
    if "error" in header:
        raise ValueError(f"{source.name} is not read as an archive of REBOUND's: {plain_text(header['error'])}")
    if len(set(header["counts"])) > 1:
        raise ValueError(f"the particles of {source.name} come or go, but companions stay the same")
    shape = (len(header["counts"]), header["counts"][0], 7)
    particles = np.frombuffer(states, float).reshape(shape)
    numbers = np.array([*header["times"], *header["constants"], 0.0])
    if not shape[1] or not np.isfinite(particles).all() or not np.isfinite(numbers).all():
        raise ValueError(f"{source.name} has no particles, or some without numbers")
    if not header["whole"]:
        count = f"{shape[0]} snapshot" + ("s" if shape[0] > 1 else "")
        warnings.warn(f"the archive {source.name} is damaged: {count} of it can be read.", SceneWarning, stacklevel=2)
    return _Stored(header["names"], header["times"], header["constants"], header["length"], header["time"], particles)


def _number(names: list[str], body: str | int | None) -> int:
    if isinstance(body, str) and body not in names:
        raise ValueError(f"the archive has no particle {body} (it has {', '.join(names)})")
    if isinstance(body, int):
        if not 0 <= body < len(names):
            raise ValueError(f"the archive has no particle {body}, but {len(names)} of them")
        return body
    return names.index(body or BODY) if (body or BODY) in names else 0


def _scales(stored: _Stored, units: CodeUnits | None, name: str) -> tuple[float, float]:
    """The units of length and time in those of the archive."""
    if units is None or units.gravitational_constant == 1.0:
        return 1.0, 1.0
    length, time = (hash_to_unit(unit) if unit else None for unit in (stored.length, stored.time))
    if length is None or time is None:
        raise ValueError(f"{name} does not say what its units are: set Simulation.units before it is saved")
    return units.length / lengths_SI[length], units.time / times_SI[time]
