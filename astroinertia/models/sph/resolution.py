"""How well particles resolve a body: numbers for the records of a run (numpy, code units, G = 1).

Tests: tests/unit/dataset/test_resolution.py.
"""

import numpy as np

from astroinertia.sph.profiles import CORE


def jeans_mass(specific_pressure: np.ndarray, density: np.ndarray) -> np.ndarray:
    """(5 (P/rho) / 2)^(3/2) (4 pi rho / 3)^(-1/2), (N,), the Jeans mass of Bate & Burkert (1997, MNRAS 288, 1060)."""
    return (2.5 * specific_pressure) ** 1.5 / np.sqrt(4 / 3 * np.pi * density)


def resolution(
    mass: np.ndarray, density: np.ndarray, pressure: np.ndarray | None, smoothing_length: np.ndarray,
    second_moment: np.ndarray, neighbours: float,
) -> dict[str, float]:  # fmt: skip
    """What is recorded: core_particles, jeans_ratio and smoothing_to_thickness; NaN where it has no meaning.

    jeans_ratio is the Jeans mass over that of two neighbourhoods, 2 `neighbours` m, of the denser half of the
    particles: at the surface of any star the Jeans mass goes to zero, and nothing fragments there. Of as many particles
    as two neighbourhoods have, alike in density, the median counts, as some may be at a surface that is as dense as the
    rest; and of these the least. It needs the pressure of a gas (None where there is none, or no gravity).
    """
    ratio = np.nan
    if pressure is not None:
        dense = np.argsort(density)[len(density) // 2 :]
        ratios = jeans_mass(pressure[dense] / density[dense], density[dense]) / (2.0 * neighbours * mass[dense])
        groups = np.array_split(ratios, max(1, int(len(dense) / (2.0 * neighbours))))
        ratio = float(min(map(np.median, groups)))
    thinnest = max(float(np.linalg.eigvalsh(second_moment)[0]), 0.0)
    thickness = np.sqrt(5.0 * thinnest / mass.sum())
    return {
        "core_particles": float((density >= CORE * density.max()).sum()),
        "jeans_ratio": ratio,
        "smoothing_to_thickness": float(np.median(smoothing_length) / thickness) if thickness > 0.0 else np.nan,
    }
