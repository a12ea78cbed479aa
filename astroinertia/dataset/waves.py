"""What gravitational waves of the quadrupole formula carry away: power, energy, angular momentum and spectrum, in SI.

With A = d2Q/dt2, which every record has in closed form, and A' its derivative (of a quintic spline through them),

    dE/dt = G/(5 c^5) A'_ij A'_ij    dL_i/dt = 2 G/(5 c^5) eps_ijk A_jl A'_kl    dE/df = 2 G/(5 c^5) |A'_ij(f)|^2,

all without their traces. Of 12 records a period of the waves, the luminosity is within 1e-5, and 7e-3 at the ends of
the record; of 24, within 2e-7 and 2e-4. Sources: Misner, Thorne & Wheeler (1973), Gravitation, eqs. 36.23 and 36.24;
the spectrum by Parseval's theorem; h_char by Flanagan & Hughes (1998, Physical Review D 57, 4535, eq. 5.1). Tests:
tests/unit/dataset/test_waves.py.
"""

from typing import NamedTuple

import numpy as np

from astroinertia.inertia.tensor import axial_vector
from astroinertia.units import SPEED_OF_LIGHT

FEWEST = 4  # records that a cubic spline goes through, which is taken with fewer than the quintic needs
_OF_QUINTIC = 6
FAINTEST = 1e-20  # m, strain times distance: 3e-41 at 10 kpc; tops and asteroids stay far below it
FAINT = f"the waves are too faint: their strain times distance stays below {FAINTEST:g} m"


class Waves(NamedTuple):
    """luminosity and energy (T,) in W and J, angular_momentum (T, 3) carried away since the start; the rest over f.

    frequency (F,) in Hz; energy_spectrum dE/df (F,) in J/Hz; characteristic_strain (F,), h_char times distance, in m.
    """

    luminosity: np.ndarray
    energy: np.ndarray
    angular_momentum: np.ndarray
    frequency: np.ndarray
    energy_spectrum: np.ndarray
    characteristic_strain: np.ndarray


def too_faint(*strains: np.ndarray) -> bool:
    """Whether strains times distance, in m, are known and too small throughout to be of any use."""
    return all(np.isfinite(strain).all() and np.abs(strain).max(initial=0.0) < FAINTEST for strain in strains)


def waves(time: np.ndarray, acceleration: np.ndarray, gravitational_constant: float) -> Waves:
    """What d2Q/dt2 (T, 3, 3), in J at times (T,) in s, carries away; NaN with fewer than 4 records or unknown ones."""
    count = len(time)
    if count < FEWEST or not np.isfinite(acceleration).all():
        nothing = np.full(count, np.nan)
        frequency = np.zeros(1)
        return Waves(nothing, nothing, np.full((count, 3), np.nan), frequency, np.full(1, np.nan), np.full(1, np.nan))
    traceless = acceleration - np.trace(acceleration, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    # Only here: who opens a file need not wait for them.
    from scipy.integrate import cumulative_trapezoid
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(time, traceless, k=5 if count >= _OF_QUINTIC else 3)
    rate = spline(time, 1)
    scale = gravitational_constant / (5.0 * SPEED_OF_LIGHT**5)
    luminosity = scale * (rate**2).sum((1, 2))
    torque = 2.0 * scale * axial_vector(np.einsum("tjl,tkl->tjk", traceless, rate))
    # Over even times, as many as the records would be if all were as close as the closest usual ones.
    step = np.quantile(np.diff(time), 0.1)
    samples = min(round((time[-1] - time[0]) / step) + 1, 16 * count)
    even, spacing = np.linspace(time[0], time[-1], max(samples, FEWEST), retstep=True)
    frequency = np.fft.rfftfreq(len(even), spacing)
    transformed = spacing * np.fft.rfft(spline(even, 1), axis=0)
    spectrum = 2.0 * scale * (np.abs(transformed) ** 2).sum((1, 2))
    strain = np.sqrt(2.0 / np.pi**2 * gravitational_constant / SPEED_OF_LIGHT**3 * spectrum)
    # By the trapezoidal rule energies only grow.
    energy, momentum = (cumulative_trapezoid(rate, time, axis=0, initial=0) for rate in (luminosity, torque))
    return Waves(luminosity, energy, momentum, frequency, spectrum, strain)
