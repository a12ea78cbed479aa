"""How fast a bar grows and turns in a run, and in the Maclaurin spheroid with the T/|W| of a star.

The star's own bar: bodies.rotating_modes. Tests: tests/physics/test_bar_mode.py.
"""

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

from astroinertia.bodies import maclaurin
from astroinertia.bodies.ellipsoid_stability import spectrum
from astroinertia.bodies.rotating_star import RotatingStar
from astroinertia.dataset.absent import with_absent
from astroinertia.inertia import growth
from astroinertia.process.quantities import with_quantities


class BarGrowth(NamedTuple):
    """Rates in the dataset's unit of inverse time, fitted between the times begin and end."""

    growth_rate: float
    pattern_speed: float
    begin: float
    end: float


@with_quantities()
@with_absent
def bar_growth(dataset: xr.Dataset, low: float = 0.05, high: float = 0.15) -> BarGrowth:
    """Return how fast the bar_strength of a run grew from low to high, and its phase advanced, by straight lines.

    A seed begins as a growing and a decaying mode together: `low` must be some times that at the start. ValueError
    where the bar never came to `high`.
    """
    time = dataset["time"].values
    strength, phase = dataset["bar_strength"].values, dataset["bar_phase"].values
    reached = np.flatnonzero(strength >= high)
    if not len(reached):
        raise ValueError(f"the bar never came to a distortion of {high:g}, but to {strength.max():.3g}")
    end = int(reached[0])
    below = np.flatnonzero(strength[:end] < low)
    chosen = slice(int(below[-1]) + 1 if len(below) else 0, end)
    rate = growth.growth(time[chosen], strength[chosen]).slope
    pattern = growth.turning(time[chosen], 2 * phase[chosen], 2).slope
    return BarGrowth(rate, pattern, float(time[chosen][0]), float(time[chosen][-1]))


@with_quantities()
def bar_of_liquid(star: RotatingStar) -> tuple[float, float]:
    """Return growth rate and pattern speed of the bar of the Maclaurin spheroid with a star's T/|W|, W and I_zz.

    Rates go as (|W|/I_zz)^(1/2) where displacements are linear in position and rotation is rigid; (0, nan) where the
    liquid is stable. Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 5; Tassoul & Ostriker 1968,
    ApJ 154, 613.
    """
    liquid = maclaurin.from_energy_ratio(star.rotational_to_gravitational)
    unit = math.sqrt(-star.gravitational_energy / star.polar_moment)
    unit /= math.sqrt(-liquid.gravitational_energy / liquid.polar_moment)
    grows = spectrum(liquid).growth_rate
    return grows * unit, 0.5 * liquid.angular_velocity * unit if grows else math.nan
