"""How many neighbours particles have in spherical shells: kernels of a thin envelope reach over a dense core.

A smoothing length h is that of the density which its kernel sees, h^3 rho = eta^3 m. At a distance r from the centre
that is the sum over shells at r' of their masses times the kernel's mean over a sphere,

    <W> = [g(|r - r'|/h) - g((r + r')/h)] / (8 pi r r' h),   g(q) = 4 pi int_q w s ds,

and of a sphere at r' the part [R^2 - (r - r')^2] / (4 r r') is within the reach R of a particle at r. Tests:
tests/unit/costs/test_shells.py.
"""

import math

import numpy as np

from astroinertia.process.roots import bisected
from astroinertia.sph.kernels import Kernel

HALVINGS = 12  # of the interval of log h in which a smoothing length is looked for
WIDEST = 16.0  # times the largest radius: the end of that interval; it begins at 1/4096 of the radius


def neighbours(mass: np.ndarray, place: np.ndarray, particle: float, kernel: Kernel, eta: float) -> np.ndarray:
    """The mean number (K,) that particles have in shells of those masses, whose middles are at those radii (K,)."""
    apart, beyond = np.abs(place[:, None] - place), place[:, None] + place
    both = place[:, None] * place

    def sparse(log_length: np.ndarray) -> np.ndarray:
        length = np.exp(log_length)
        h = length[:, None]
        seen = kernel.softening(np, apart / h) - kernel.softening(np, beyond / h)
        mass_of_h = length**2 * (mass * seen / (8.0 * math.pi * both)).sum(axis=1)  # h^3 rho
        return mass_of_h <= eta**3 * particle

    high = np.full_like(place, math.log(WIDEST * place.max()))
    length = np.exp(bisected(sparse, high - math.log(WIDEST * 2.0**HALVINGS), high, HALVINGS))
    reach = kernel.support * length[:, None]
    within = np.clip((reach**2 - apart**2) / (4.0 * both), 0.0, 1.0)
    return (within * mass).sum(axis=1) / particle
