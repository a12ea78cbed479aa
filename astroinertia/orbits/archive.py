"""Orbits out of a REBOUND SimulationArchive, snapshot by snapshot."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import rebound
from rebound.units import hash_to_unit, lengths_SI, times_SI

from astroinertia.orbits.simulation import BODY
from astroinertia.orbits.states import names
from astroinertia.units import CodeUnits

Array = Any


def snapshots(path: str | Path, body: str | int | None = None, units: CodeUnits | None = None) -> list[Any]:
    """Every snapshot of an archive as a `rebound.Simulation`, with the body as particle 0 and time 0 at the first.

    body is the name or the number of the body's particle: without it that of the name "body", else the first. With
    `units` they are in code units, G = 1, for which the archive must say what its own are (`Simulation.units`) unless
    the code units are dimensionless. They go on by IAS15, whatever the archive was made with. ValueError, in a
    sentence, for a file that is no archive, a particle that is not there, or particles that come or go. Source: Rein &
    Tamayo 2017, MNRAS 467, 2377. Checked by tests/unit/test_orbit_archive.py.
    """
    source = Path(path)
    if not source.is_file():
        raise ValueError(f"there is no archive {source.name}")
    try:
        with warnings.catch_warnings():
            # An archive of another version of REBOUND: what cannot be read raises.
            warnings.simplefilter("ignore", RuntimeWarning)
            opened = rebound.Simulationarchive(str(source))
            stored = list(opened)
    except RuntimeError as error:
        raise ValueError(f"{source.name} is not read as an archive of REBOUND's: {error}") from None
    for each in stored:
        each.synchronize()
    if len({each.N for each in stored}) > 1:
        raise ValueError(f"the particles of {source.name} come or go, but companions stay the same")
    known = names(stored[-1])  # REBOUND 5.2 reads some names of the first snapshot wrong
    number = _number(known, body)
    order = [number, *(k for k in range(len(known)) if k != number)]
    length, time = _scales(stored[0], units, source.name)
    found = []
    for each in stored:
        fresh = rebound.Simulation()
        # What an orbit shows is G M: masses are those that it gives with G = 1.
        fresh.G, mass = (each.G, 1.0) if units is None else (1.0, length**3 / time**2 / each.G)
        for k in order:
            particle = each.particles[k]
            place, speed = np.array(particle.xyz) / length, np.array(particle.vxyz) * (time / length)
            keys = ("x", "y", "z", "vx", "vy", "vz")
            state = dict(zip(keys, map(float, (*place, *speed)), strict=True))
            fresh.add(m=particle.m / mass, name=known[k], **state)
        fresh.t = (each.t - stored[0].t) / time
        found.append(fresh)
    return found


def _number(known: list[str], body: str | int | None) -> int:
    if isinstance(body, str) and body not in known:
        raise ValueError(f"the archive has no particle {body} (it has {', '.join(known)})")
    if isinstance(body, int):
        if not 0 <= body < len(known):
            raise ValueError(f"the archive has no particle {body}, but {len(known)} of them")
        return body
    return known.index(body or BODY) if (body or BODY) in known else 0


def _scales(bodies: rebound.Simulation, units: CodeUnits | None, name: str) -> tuple[float, float]:
    """The units of length and time in those of the archive."""
    if units is None or units.gravitational_constant == 1.0:
        return 1.0, 1.0
    length, time = (hash_to_unit(each) if each else None for each in (bodies.python_unit_l, bodies.python_unit_t))
    if length is None or time is None:
        raise ValueError(f"{name} does not say what its units are: set Simulation.units before it is saved")
    return units.length / lengths_SI[length], units.time / times_SI[time]
