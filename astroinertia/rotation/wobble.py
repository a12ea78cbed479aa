"""The free wobble of a planet: Euler's period of a rigid one, what lengthens it by name, its damping and excitation.

A pole (x + i y, radians from the axis of figure) that is out of line goes round at the complex frequency

    sigma = omega (C - A)/A_m (1 - k/k_s),    m(t) = m_0 exp(i sigma t),

to first order in the flattening; A_m is the moment of what takes part (mantle and crust where a fluid core does not),
k how far the body yields to the change of its centrifugal force and k_s the k that a fluid of this flattening would
have. A complex k, of negative imaginary part, damps. No k is fitted to the observed period: each share has its cause.
Sources: Munk & MacDonald 1960, The Rotation of the Earth; Smith & Dahlen 1981, GJRAS 64, 223; Sasao, Okubo & Saito
1980, IAU Symp. 78, 165. Tests: tests/unit/rotation/test_wobble.py.
"""

from functools import lru_cache
from typing import Any, NamedTuple

import jax
import numpy as np

from astroinertia.bodies.earth import prem, prem_layer_names
from astroinertia.bodies.layered import shell_integrals
from astroinertia.bodies.planets import body
from astroinertia.errors import NumericalError
from astroinertia.process.quantities import with_quantities

Array = Any

DAY = 86400.0  # s
ELASTIC_LOVE_NUMBER = 0.298  # k2 of the elastic Earth, Smith & Dahlen 1981; 0.29525 of PREM at tides (IERS TN 36)
# Of PREM, degree 2: displacement under a potential, and under a load the potential and the displacement
# (Farrell 1972, Rev. Geophys. 10, 761; Wahr 1981, GJRAS 64, 677).
_DISPLACEMENT, _LOAD_POTENTIAL, _LOAD_DISPLACEMENT = 0.6032, -0.3075, -1.001
_OCEAN_SHARE, _OCEAN_DENSITY = 0.708, 1025.0  # of the surface (Eakins & Sharman 2010, NOAA); kg m-3
# Mantle anelasticity: Wahr & Bergen 1986, GJRAS 87, 633, as in IERS TN 36, eq. 6.12: k = k_e - SIZE (cot(EXPONENT pi/2)
# (1 - x) + i x) with x = (period / REFERENCE)^EXPONENT.
_ANELASTIC_SIZE, _ANELASTIC_EXPONENT, _ANELASTIC_REFERENCE = 5.796e-4, 0.15, 200.0
_MOST_ITERATIONS = 100


class Share(NamedTuple):
    """What one cause does to the period: its name, the period with it and all before it, the change, both in seconds.

    love_number: the part of k that it brings, complex where it damps; 0 for what acts otherwise.
    """

    name: str
    period: float
    change: float
    love_number: complex


class Chandler(NamedTuple):
    """The Chandler wobble: shares in their order, complex frequency (rad s-1), period (s) and quality factor.

    mantle_share: A_m/A; secular_love_number: k_s.
    """

    shares: tuple[Share, ...]
    frequency: complex
    period: float
    quality: float
    mantle_share: float
    secular_love_number: float


@with_quantities()
def euler_frequency(dynamical_ellipticity: Array, spin_rate: Array) -> Array:
    """The rate at which the pole of a rigid body goes round, omega (C - A)/A, rad s-1, from H = (C - A)/C.

    For small wobbles about the axis of C; ValueError for H >= 1. Source: Landau & Lifshitz 1976, Mechanics, section 33.
    Checked by tests/unit/rotation/test_wobble.py.

    >>> days = 2 * np.pi / euler_frequency(1 / 304.5, 7.292115e-5) / 86400
    >>> print(f"{days:.1f} d")  # of a rigid Earth
    302.7 d
    """
    ellipticity = np.asarray(dynamical_ellipticity, dtype=float)
    if np.any(ellipticity >= 1):
        raise ValueError("the dynamical ellipticity (C - A)/C is below 1")
    return np.asarray(spin_rate) * ellipticity / (1 - ellipticity)


@with_quantities()
def secular_love_number(j2: Array, gravitational_parameter: Array, radius: Array, spin_rate: Array) -> Array:
    """k_s = 3 J2 GM/(omega^2 a^3): the k2 of a fluid that this spin gives this J2 (radius a is that of J2).

    Source: Munk & MacDonald 1960, section 5.3. Checked by tests/unit/rotation/test_wobble.py.

    >>> print(f"{secular_love_number(1.0826e-3, 3.986e14, 6.378e6, 7.292e-5):.3f}")  # of the Earth
    0.938
    """
    return 3 * np.asarray(j2) * np.asarray(gravitational_parameter) / (np.asarray(spin_rate) ** 2 * radius**3)


@with_quantities()
def chandler_frequency(
    dynamical_ellipticity: Array, spin_rate: Array, love_number: Array = 0.0, secular: Array = 1.0,
    mantle_share: Array = 1.0,
) -> Array:  # fmt: skip
    """sigma = omega (C - A)/A (1 - k/k_s)/(A_m/A), rad s-1: real k gives a real frequency, complex k a complex one.

    secular is k_s; mantle_share A_m/A is 1 without a fluid core. To first order in the flattening: a wholly elastic
    Earth that is integrated, with the inertia of its own bulge, has a period 0.1 % longer. ValueError for k >= k_s,
    where there is no wobble, and for a share that is not above 0 and at most 1.
    Source: Smith & Dahlen 1981; Sasao, Okubo & Saito 1980. Checked by tests/unit/rotation/test_wobble.py.

    >>> rigid = chandler_frequency(1 / 304.5, 7.292115e-5)  # nothing yields
    >>> print(f"{2 * np.pi / rigid / 86400:.1f} d")
    302.7 d
    """
    share = np.asarray(mantle_share, dtype=float)
    if np.any(np.real(love_number) >= np.asarray(secular)):
        raise ValueError("a body that yields like a fluid, with a Love number of k_s or above, has no free wobble")
    if not np.all((share > 0) & (share <= 1)):
        raise ValueError("the share of the moment outside the core, A_m/A, is above 0 and at most 1")
    return euler_frequency(dynamical_ellipticity, spin_rate) * (1 - np.asarray(love_number) / secular) / share


@with_quantities()
def quality(frequency: Array) -> Array:
    """Q = Re sigma/(2 Im sigma) of a complex frequency: the amplitude falls by e in Q/pi periods; inf without damping.

    Source: Munk & MacDonald 1960, section 10.1. Checked by tests/unit/rotation/test_wobble.py.

    >>> print(quality(1.0 + 0.01j))  # Re/(2 Im)
    50.0
    """
    with np.errstate(divide="ignore"):
        return np.real(frequency) / (2 * np.imag(frequency))


def ocean_love_number(love_number: float = ELASTIC_LOVE_NUMBER) -> float:
    """What an ocean in equilibrium with the pole tide adds to k2: about 0.047.

    Its surface follows (1 + k - h) of the potential, its own load and the yielding to it included; that of an ocean
    over the whole globe is taken times the share of the surface that oceans cover, which stands for their true shores.
    Source: Dahlen 1976, GJRAS 46, 363 (true shores: 27.6 d on the period). Checked by
    tests/unit/rotation/test_wobble.py.

    >>> print(f"{ocean_love_number():.3f}")
    0.047
    """
    earth = body("Earth")
    load = 0.6 * _OCEAN_DENSITY / earth.mean_density
    tide = 1 + love_number - _DISPLACEMENT
    yielding = 1 - load * (1 + _LOAD_POTENTIAL - _LOAD_DISPLACEMENT)
    return _OCEAN_SHARE * load * tide * (1 + _LOAD_POTENTIAL) / yielding


@with_quantities()
def anelastic_love_number(period: Array) -> Array:
    """What the mantle's anelasticity adds to k2 at a period (s): complex, 0.0125 - 0.0036 i at the Chandler period.

    From seismic periods, where k2 is elastic, Q falls as period^-0.15. ValueError for a period of zero or below.
    Source: Wahr & Bergen 1986, GJRAS 87, 633; Petit & Luzum 2010, IERS TN 36, (6.12). Checked by
    tests/unit/rotation/test_wobble.py.

    >>> print(f"{anelastic_love_number(433 * 86400.0):.4f}")
    0.0125-0.0036j
    """
    if not np.all(np.asarray(period) > 0):
        raise ValueError("a period is above 0")
    ratio = (np.asarray(period) / _ANELASTIC_REFERENCE) ** _ANELASTIC_EXPONENT
    cotangent = 1 / np.tan(_ANELASTIC_EXPONENT * np.pi / 2)
    return -_ANELASTIC_SIZE * (cotangent * (1 - ratio) + 1j * ratio)


@lru_cache(maxsize=1)
def mantle_share() -> float:
    """The share of the Earth's moment that is not of its fluid core, A_m/A, by PREM: about 0.887.

    Checked by tests/unit/rotation/test_wobble.py.

    >>> print(f"{mantle_share():.4f}")  # of the polar moment
    0.8870
    """
    with jax.enable_x64(True):
        shells = np.asarray(shell_integrals(prem(), 4))
    fluid = prem_layer_names().index("outer core")
    return float(1 - shells[fluid] / shells.sum())


def chandler_wobble(love_number: float = ELASTIC_LOVE_NUMBER) -> Chandler:
    """The Earth's free wobble with each cause by name: rigid, elasticity, fluid core, oceans, anelasticity.

    love_number: k2 of the wholly elastic Earth. Observed: 433 days (430 to 435), Q of tens to above 100. Not in it: the
    coupling of core and mantle, the true shores of the oceans and their departure from equilibrium, the triaxiality.
    NumericalError where the period does not settle. Source: Smith & Dahlen 1981. Checked by
    tests/unit/rotation/test_wobble.py.

    >>> print(f"{chandler_wobble().period / 86400:.1f} d")  # observed: 433
    435.0 d
    """
    earth = body("Earth")
    ellipticity, spin = earth.value("dynamical_ellipticity"), earth.angular_velocity
    j2 = earth.adopted("j2")
    secular = float(secular_love_number(j2.value, earth.gravitational_parameter, j2.radius, spin))
    outside = mantle_share()

    def frequency(number: complex, share: float) -> complex:
        return complex(chandler_frequency(ellipticity, spin, number, secular, share))

    oceans = ocean_love_number(love_number)
    anelastic = _anelastic(lambda extra: frequency(love_number + oceans + extra, outside))
    causes = (
        ("rigid", 0.0, 1.0), ("elasticity", love_number, 1.0), ("fluid core", 0.0, outside),
        ("oceans", oceans, outside), ("anelasticity", anelastic, outside),
    )  # fmt: skip
    shares: list[Share] = []
    total: complex = 0.0
    for name, number, share in causes:
        total += number
        period = 2 * np.pi / frequency(total, share).real
        shares.append(Share(name, period, period - shares[-1].period if shares else period, number))
    sigma = frequency(total, outside)
    return Chandler(tuple(shares), sigma, 2 * np.pi / sigma.real, float(quality(sigma)), outside, secular)


def _anelastic(frequency) -> complex:
    number, period = 0.0j, 400 * DAY
    for _ in range(_MOST_ITERATIONS):
        number = complex(anelastic_love_number(period))
        before, period = period, 2 * np.pi / frequency(number).real
        if abs(period - before) < 1e-14 * period:
            return number
    raise NumericalError("the period of the wobble and the anelasticity at that period do not settle")


@with_quantities()
def wobble(times: Array, frequency: complex, start: complex = 0.0, excitation: Array | None = None) -> np.ndarray:
    """The pole m (complex, radians) at increasing times (N,), s, of (i/sigma) dm/dt + m = chi, beginning at `start`.

    excitation: chi (N,) at the times, straight between them, for which the answer is exact; none without it. ValueError
    for times that do not increase, for lengths that differ, and for a frequency of zero or that grows (Im sigma < 0).
    Source: Munk & MacDonald 1960, (6.1.4); Wilson & Haubrich 1976, GJRAS 46, 707. Checked by
    tests/unit/rotation/test_wobble.py.

    >>> print(abs(wobble(np.array([0.0, 100.0]), 1e-3 + 0j, 1e-6)))  # a free wobble keeps its size
    [1.e-06 1.e-06]
    """
    times = np.asarray(times, dtype=float)
    if times.ndim != 1 or np.any(np.diff(times) <= 0):
        raise ValueError("the times of a wobble increase")
    if frequency == 0 or np.imag(frequency) < 0:
        raise ValueError("a free wobble has a frequency, and an imaginary part of it that damps (not below 0)")
    if excitation is None:
        return start * np.exp(1j * frequency * (times - times[0]))
    chi = np.asarray(excitation, dtype=complex)
    if chi.shape != times.shape:
        raise ValueError("the excitation has one value for each of the times")
    steps = np.diff(times)
    turn = 1j * frequency * steps
    # m - chi obeys d(m - chi)/dt = i sigma (m - chi) - dchi/dt, whose last term is constant between the times.
    pushes = -np.diff(chi) * _mean_exponential(turn)
    offset = np.empty(len(times), dtype=complex)
    offset[0] = start - chi[0]
    for k, (factor, push) in enumerate(zip(np.exp(turn), pushes, strict=True)):
        offset[k + 1] = factor * offset[k] + push
    return offset + chi


@with_quantities()
def forced_wobble(frequency: complex, forcing_rate: Array, excitation: Array) -> Array:
    """The pole's amplitude (complex, rad) under chi = excitation exp(i forcing_rate t), prograde for a rate above 0.

    chi sigma/(sigma - rate): the annual wobble is a forced one. Source: Munk & MacDonald 1960, section 6.3.
    Checked by tests/unit/rotation/test_wobble.py.

    >>> print(forced_wobble(1.0 + 0j, 0.5, 1e-6))  # chi sigma/(sigma - rate)
    (2e-06+0j)
    """
    return np.asarray(excitation) * frequency / (frequency - np.asarray(forcing_rate))


def _mean_exponential(z: np.ndarray) -> np.ndarray:
    """(exp(z) - 1)/z, 1 at 0, for complex z without loss of digits."""
    safe = np.where(z == 0, 1.0, z)
    half = 0.5 * safe
    return np.where(z == 0, 1.0, np.exp(half) * np.sinh(half) / half)
