"""How the planes of orbits turn each other over ages: Laplace and Lagrange's modes, first order in masses.

With zeta_j = sin(I_j/2) exp(i node_j) of each planet, d zeta/dt = i B zeta, and each plane is a sum of as many steady
turns as there are planets, one of which stands still. Eccentricities and higher orders, which change the rates by a few
per cent and let them wander over 1e8 years, are left out. Source: Murray & Dermott 1999, Solar System Dynamics, chapter
7.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.special import hyp2f1

from astroinertia.process.quantities import with_quantities

Array = Any


class NodeModes(NamedTuple):
    """Steady turns of the planes of N orbits: rates (N,), rad s-1, amplitudes of sin(I/2) and phases (planet, mode)."""

    rates: np.ndarray
    amplitudes: np.ndarray
    phases: np.ndarray


@with_quantities()
def laplace_coefficient(s: float, j: int, ratio: float) -> float:
    """b_s^(j)(ratio) = (1/pi) int_0^(2 pi) cos(j psi)/(1 - 2 ratio cos psi + ratio^2)^s dpsi.

    Relative error 2e-12 up to j = 100, 1e-10 up to 300. ValueError for a ratio outside 0 <= ratio < 1, an s that
    is not finite and a j that is no whole number. Source: Murray & Dermott 1999, (6.67) and (6.68), a hypergeometric
    function.

    >>> print(laplace_coefficient(0.5, 0, 0.0))  # 2, of a vanishing ratio
    2.0
    """
    if not 0 <= ratio < 1:
        raise ValueError("a ratio of semi-major axes is from 0 to below 1")
    if not math.isfinite(s):
        raise ValueError(f"the s of a Laplace coefficient must be a finite number, not {s!r}")
    if j % 1 != 0:
        raise ValueError(f"the j of a Laplace coefficient must be a whole number, not {j!r}")
    j = abs(j)
    k = np.arange(j)
    leading = 2.0 * np.prod(ratio * (s + k) / (k + 1))
    if s > 0.5:  # by Euler's transformation (DLMF 15.8.1): next to 1 the other one has no more digits than 1 - ratio^2
        return float(leading * ((1 - ratio) * (1 + ratio)) ** (1 - 2 * s) * hyp2f1(j + 1 - s, 1 - s, j + 1, ratio**2))
    return float(leading * hyp2f1(s, s + j, j + 1, ratio**2))


@with_quantities(central="m3/s2", parameters="m3/s2", nodes="rad")
def node_modes(
    central: float, parameters: Array, semi_major_axes: Array, inclinations: Array, nodes: Array
) -> NodeModes:
    """The modes of the planes of N planets about a mass: GM (m3 s-2), m, and angles in rad at time 0.

    sin(I/2) exp(i node) of planet j is the sum over modes of amplitudes[j] exp(i (rates t + phases[j])), as
    `secular_spin.orbit_normal` takes it. ValueError for lengths that differ or values that are not above 0.
    Source: Murray & Dermott 1999, (7.10), (7.11) and (7.27).

    >>> masses, axes = np.array([1.267e17, 3.793e16]), np.array([7.785e11, 1.433e12])  # Jupiter and Saturn
    >>> modes = node_modes(1.327e20, masses, axes, np.array([0.01, 0.02]), np.array([0.0, 1.0]))
    >>> print((np.degrees(modes.rates) * 3600 * 3.15576e7).round(1) + 0.0)  # arcsec a year; of all planets it is -26
    [-25.1   0. ]
    """
    m, a = np.asarray(parameters, dtype=float), np.asarray(semi_major_axes, dtype=float)
    start = np.sin(0.5 * np.asarray(inclinations)) * np.exp(1j * np.asarray(nodes))
    if not (m.ndim == 1 and m.shape == a.shape == start.shape and np.all(m > 0) and np.all(a > 0) and central > 0):
        raise ValueError("planets have masses and semi-major axes above 0, inclinations and nodes, one of each")
    matrix = np.zeros((len(m), len(m)))
    for j in range(len(m)):
        for k in range(len(m)):
            if k != j:
                ratio = min(a[j], a[k]) / max(a[j], a[k])
                motion = np.sqrt((central + m[j]) / a[j] ** 3)
                inner = ratio if a[j] < a[k] else 1.0
                matrix[j, k] = (
                    0.25 * motion * m[k] / (central + m[j]) * ratio * inner * laplace_coefficient(1.5, 1, ratio)
                )
        matrix[j, j] = -matrix[j].sum()
    # Symmetric in the square roots of the angular momenta, so that the modes are at right angles and real.
    weight = np.sqrt(m * np.sqrt((central + m) * a))
    symmetric = matrix * weight[:, None] / weight
    rates, vectors = np.linalg.eigh(0.5 * (symmetric + symmetric.T))
    strength = vectors.T @ (weight * start)
    parts = vectors / weight[:, None] * strength
    return NodeModes(rates, np.abs(parts), np.angle(parts))
