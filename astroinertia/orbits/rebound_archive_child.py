"""Reads a REBOUND SimulationArchive in a process of its own, which a damaged one may end: `python -P FILE ARCHIVE`.

REBOUND trusts what an archive says of its lengths, and its memory with it; a flipped bit crashes it in one of four
cases. Written to the standard output: a line of JSON, then m, x, y, z, vx, vy, vz of each particle of each snapshot,
float64. The JSON says whether it was the whole archive. It stands alone, so that it starts in a tenth of a second.
Tests: tests/unit/orbits/test_rebound_archive.py.
"""

import json
import os
import resource
import sys
import warnings
from array import array
from pathlib import Path

import rebound

SECONDS, SECONDS_PER_BYTE = 2, 1e-6  # of processor time
MEMORY, MEMORY_PER_BYTE = 2**30, 50


def main(path: str) -> None:
    """Print what the archive holds, or why it is none."""
    place = Path(path)
    size = place.stat().st_size
    seconds = int(SECONDS + SECONDS_PER_BYTE * size)
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    memory = MEMORY + MEMORY_PER_BYTE * size
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    os.chdir(place.parent)  # REBOUND takes ASCII only
    try:
        with warnings.catch_warnings(record=True, action="always") as said:
            stored = list(rebound.Simulationarchive(place.name))
        for snapshot in stored:
            snapshot.synchronize()
        header = {
            # REBOUND 5.2 reads some names of the first snapshot wrong
            "names": [particle.name or f"particle {k}" for k, particle in enumerate(stored[-1].particles)],
            "counts": [snapshot.N for snapshot in stored],
            "times": [snapshot.t for snapshot in stored],
            "constants": [snapshot.G for snapshot in stored],
            "length": stored[0].python_unit_l,
            "time": stored[0].python_unit_t,
            "whole": not any("corrupted" in str(warning.message) for warning in said),
        }
        particles = [particle for snapshot in stored for particle in snapshot.particles]
    except Exception as error:
        header, particles = {"error": str(error)}, []
    states = array("d")
    for particle in particles:
        states.extend((particle.m, *particle.xyz, *particle.vxyz))
    sys.stdout.buffer.write(json.dumps(header).encode() + b"\n" + states.tobytes())


if __name__ == "__main__":
    main(sys.argv[1])
