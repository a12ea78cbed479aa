"""What a run resolved too coarsely, in sentences that say what to change."""

import math
from collections.abc import Mapping

import numpy as np

from astroinertia.process.words import times_as_many

COARSEST = 0.5  # smoothing length over the smallest semi-axis
FRAGMENTS = 0.25
"""Jeans mass over a body's mass above which it is in one piece: the denser half of polytropes in equilibrium, of index
0.5 to 4.5, has at least 0.31."""
APART = 10.0  # times as far out as at the start: half of the mass of a body that does not come back


def resolution_warnings(
    series: Mapping[str, np.ndarray], neighbours: float | None, particles: float = math.inf, boxed: bool = False
) -> list[str]:
    """Sentences about records in any units; neighbours: the mean number of a particle's, None where there are none.

    particles: of the body, or of the smallest of several, where that is known. boxed: matter that fills a box which
    repeats itself has no thickness.
    """
    if neighbours is None or not {"core_particles", "jeans_ratio", "smoothing_to_thickness"} <= set(series):
        return []
    if apart := _flown_apart(series):
        return [apart]
    warnings = []
    core, jeans, coarse = (series[name] for name in ("core_particles", "jeans_ratio", "smoothing_to_thickness"))
    least, fewest = float(np.nanmin(core)), 2.0 * neighbours
    if least < fewest:
        warnings.append(
            f"the core, denser than a tenth of the greatest density, held only {least:.0f} particles, fewer than two "
            f"neighbourhoods ({fewest:.0f}): its density and spin depend on their number; take "
            f"{times_as_many(fewest, least)}."
        )
    most = min(1.0, FRAGMENTS * particles / fewest)
    if np.isfinite(jeans).any() and (lowest := float(np.nanmin(jeans))) < most:
        warnings.append(
            f"the Jeans mass fell to {lowest:.2g} of the mass of two neighbourhoods, so fragments may be artificial "
            f"(Bate & Burkert 1997): take {times_as_many(1.0, lowest)} particles, or stiffen the equation of state "
            "at those densities."
        )
    if not boxed and np.isfinite(coarse).any() and (largest := float(np.nanmax(coarse))) > COARSEST:
        warnings.append(
            f"the smoothing length reached {largest:.2g} of the body's smallest semi-axis: its thickness is not "
            f"resolved; take {times_as_many((largest / COARSEST) ** 3)} particles, or a kernel of fewer "
            "neighbours."
        )
    return warnings


def _flown_apart(series: Mapping[str, np.ndarray]) -> str:
    """What is gone of a body that gravity did not hold; empty where it did, or where there is none."""
    if not {"half_mass_radius", "total_energy", "gravitational_energy"} <= set(series):
        return ""
    half, most = (series[name] / series[name][0] for name in ("half_mass_radius", "radius_enclosing_99"))
    if not (half[-1] > APART and series["total_energy"][-1] > 0.0 and np.isfinite(series["gravitational_energy"][-1])):
        return ""
    return (
        f"the body flew apart: at the end half of its mass is {half[-1]:.3g} times as far from its centre as at the "
        f"start, 99 % of it within {most[-1]:.3g} times as far, and gravity does not hold it; its shape, spin and "
        "moment ratio are those of the debris. Less heat, slower rotation or a weaker pull from outside would hold it."
    )
