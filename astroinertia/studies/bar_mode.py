"""How fast a bar grows and turns in a run, beside the Maclaurin spheroid of the same T/|W|.

Tests: tests/physics/test_bar_mode.py.
"""

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

from astroinertia.bodies import maclaurin
from astroinertia.bodies.ellipsoid_stability import spectrum
from astroinertia.inertia import growth


class BarGrowth(NamedTuple):
    """Rates in the dataset's unit of inverse time, of a bar and of the liquid; t_over_w is that at the start.

    maclaurin_growth_rate is zero, and maclaurin_pattern_speed nan, where the liquid is stable. begin and end are the
    times between which the rates were fitted.
    """

    growth_rate: float
    pattern_speed: float
    maclaurin_growth_rate: float
    maclaurin_pattern_speed: float
    t_over_w: float
    begin: float
    end: float


def bar_growth(dataset: xr.Dataset, low: float = 0.05, high: float = 0.15) -> BarGrowth:
    """Return how fast the bar_strength of a run grew from low to high, and its phase advanced, by straight lines.

    A static seed begins as a growing and a decaying mode together: `low` must be some times that at the start. The
    liquid is the Maclaurin spheroid with the T/|W| of the start, its rates scaled by (|W|/I_zz)^(1/2): for motions that
    are linear in position nothing else enters the virial equations. ValueError where the bar never came to `high`.
    Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 5; Tassoul & Ostriker 1968, ApJ 154, 613 (the
    same for compressible bodies). Test: tests/physics/test_bar_mode.py.
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
    bound = -float(dataset["gravitational_energy"][0])
    share = float(dataset["kinetic_energy"][0]) / bound
    unit = math.sqrt(bound / float(dataset["inertia_tensor"].sel(i="z", j="z")[0]))
    liquid = maclaurin.from_energy_ratio(share)
    liquid_unit = math.sqrt(-liquid.gravitational_energy / liquid.polar_moment)
    grows = spectrum(liquid).growth_rate
    return BarGrowth(
        rate,
        pattern,
        grows / liquid_unit * unit,
        0.5 * liquid.angular_velocity / liquid_unit * unit if grows else math.nan,
        share,
        float(time[chosen][0]),
        float(time[chosen][-1]),
    )
