"""What gravity costs by direct sums and by multipoles, as measured: which of the two a run should take."""

from dataclasses import dataclass
from typing import Literal

from astroinertia.effects.entries import FORCE_ERROR

Method = Literal["direct", "multipole"]


@dataclass(frozen=True)
class Cost:
    """Seconds of one evaluation: by direct sums, fixed + pair N^2; by multipoles, fixed + particle N.

    That is at an error of 2e-4; the part that grows with N goes as force_error^-growth.
    """

    pair: float
    fixed: float
    particle: float
    growth: float = 0.15


# On two cores with AVX-512 (tests/benchmarks/gravity_crossover.py); what counts is where they cross.
COSTS = {
    ("numba_cpu", "mixed"): Cost(pair=2e-10, fixed=1e-4, particle=7e-7),
    ("numba_cpu", "float64"): Cost(pair=5.5e-10, fixed=1e-4, particle=1.4e-6),
    # Direct sums as in tests/benchmarks/results/pair_throughput_xla.md; the cost of multipoles is an estimate.
    ("xla", "mixed"): Cost(pair=2.3e-9, fixed=1e-3, particle=8e-6),
    ("xla", "float64"): Cost(pair=2.3e-9, fixed=1e-3, particle=8e-6),
}


def seconds(method: Method, particles: int, engine: str, precision: str, force_error: float) -> float:
    """What one evaluation takes on the machine that the costs were measured on."""
    cost = COSTS[engine, precision]
    if method == "direct":
        return cost.fixed + cost.pair * particles**2
    return cost.fixed + cost.particle * particles * (FORCE_ERROR / force_error) ** cost.growth


def cheaper(particles: int, engine: str, precision: str, force_error: float) -> Method:
    """The method that takes less time for so many particles."""
    direct, multipole = (
        seconds(method, particles, engine, precision, force_error) for method in ("direct", "multipole")
    )
    return "multipole" if multipole < direct else "direct"
