"""What a run takes that processes of MPI share out: sums over pairs are divided, all else each process does for itself.

Measured (tests/benchmarks/results/processes.md): of a step of Evrard's cloud with 20,000 particles, one process of two
has 0.63 (mixed) and 0.57 (float64) of the processor time of one alone, one of four 0.45 and 0.36.
"""

from dataclasses import replace

from astroinertia.costs.machine import PRECISIONS, Machine
from astroinertia.process.stopwatch import Seconds

SHARED = "density", "gradients", "forces", "multipole"  # passes over pairs, by their names among costs
# Of those passes: expansions of the tree's nodes, and putting particles in order for vectors. 100,000 particles have
# 0.04 by a profile of 16 steps; with 0.06, 20,000 come out within 15 % of what was measured.
NOT_SHARED = 0.06
RESULTS = 400.0  # bytes of sums a particle and evaluation, of gravity, pressure and viscosity
NETWORK = 1.25e9  # bytes a second between processes: 10 Gbit/s


def share(particles: int, processes: int) -> bool:
    """Whether so many processes share out a pass over so many particles at all."""
    if processes == 1:
        return False
    from astroinertia.engines.together import FEWEST  # one process has no part of an engine

    return particles >= FEWEST * processes


def shared_out(machine: Machine, processes: int) -> Machine:
    """The machine as one of so many processes finds it, each of which has all of the machine's threads to itself."""
    left = NOT_SHARED + (1.0 - NOT_SHARED) / processes
    passes = {f"{precision}.{name}" for precision in PRECISIONS for name in SHARED}
    seconds = {name: left * cost if name in passes else cost for name, cost in machine.seconds.items()}
    return replace(machine, seconds=seconds)


def received(particles: int, processes: int) -> float:
    """Bytes that a process gets from the others in an evaluation of all particles."""
    return (1.0 - 1.0 / processes) * RESULTS * particles


def sending(particles: int, processes: int) -> Seconds:
    """What an evaluation waits for them."""
    return Seconds(received(particles, processes) / NETWORK, 0.0)
