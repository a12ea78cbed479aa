"""The free wobble of a planet: Euler's period of a rigid one, what changes it by name, its damping and excitation.

A pole (x + i y, radians from the axis of figure) that is out of line goes round at the complex frequency

    sigma = omega (C - A)/A_m (1 - k/k_s),    m(t) = m_0 exp(i sigma t),

to first order in the flattening; A_m is the moment of what takes part (mantle and crust where a fluid core does not),
k how far the body yields to the change of its centrifugal force and k_s the k that a fluid of this flattening would
have. A complex k, of negative imaginary part, damps. What core and mantle do to each other is in
`wobble_and_nutation`. No k is fitted to the observed period: each share has its cause.
Sources: Munk & MacDonald 1960, The Rotation of the Earth; Smith & Dahlen 1981, GJRAS 64, 223; Sasao, Okubo & Saito
1980, IAU Symp. 78, 165; Mathews, Herring & Buffett 2002, JGR 107, B4.
"""

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from astroinertia.bodies.earth import elastic_prem, prem, prem_layer_names, prem_shear_quality
from astroinertia.bodies.layered import shell_integrals
from astroinertia.bodies.love_numbers import YieldingBody, love_numbers
from astroinertia.bodies.planets import body
from astroinertia.errors import NumericalError
from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.precession import ARCSECOND

Array = Any

DAY = 86400.0  # s
# k2 of the ellipsoidal, rotating, elastic Earth at long periods, which the IERS takes for the pole tide, too: TN 36,
# table 6.3 and section 6.4.
_ELLIPSOIDAL = 0.29525
# Fully normalised dC21 and dS21 of the oceans in equilibrium with the pole tide, over an arc second of m1 and m2, with
# true shores, their own attraction and load: Desai 2002, JGR 107, C11, 3186, as in IERS TN 36, (6.24).
_OCEAN_C21, _OCEAN_S21 = 2.1778e-10, 1.7232e-10
# Mantle anelasticity: Wahr & Bergen 1986, GJRAS 87, 633, as in IERS TN 36, eq. 6.12: k = k_e - SIZE (cot(EXPONENT pi/2)
# (1 - x) + i x) with x = (period / REFERENCE)^EXPONENT.
_ANELASTIC_SIZE, _ANELASTIC_EXPONENT, _ANELASTIC_REFERENCE = 5.796e-4, 0.15, 200.0
# The fluid core: its dynamical ellipticity (Mathews, Herring & Buffett 2002, of the core's nutation), how far its own
# moment follows the potential of the wobble, and how far that of its own rotation (gamma and beta of PREM: Mathews,
# Buffett, Herring & Shapiro 1991, JGR 96, 8243).
CORE_ELLIPTICITY, CORE_COMPLIANCE, CORE_OWN_COMPLIANCE = 0.0026456, 1.965e-3, 6.160e-4
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

    Source: Munk & MacDonald 1960, section 5.3.

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
    Source: Smith & Dahlen 1981; Sasao, Okubo & Saito 1980.

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


@with_quantities(frequency="rad/s")
def quality(frequency: Array) -> Array:
    """Q = Re sigma/(2 Im sigma) of a complex frequency: the amplitude falls by e in Q/pi periods; inf without damping.

    Source: Munk & MacDonald 1960, section 10.1.

    >>> print(quality(1.0 + 0.01j))  # Re/(2 Im)
    50.0
    """
    frequency = np.asarray(frequency)
    with np.errstate(divide="ignore"):
        return np.real(frequency) / (2 * np.imag(frequency))


@with_quantities()
def wobble_and_nutation(
    dynamical_ellipticity: float, spin_rate: float, love_number: complex, secular: float, core_share: float,
    core_ellipticity: float = CORE_ELLIPTICITY, core_compliance: float = CORE_COMPLIANCE,
    core_own_compliance: float = CORE_OWN_COMPLIANCE,
) -> tuple[complex, complex]:  # fmt: skip
    """Frequencies (rad/s, in axes of the body) of the free wobble and the free core nutation of mantle and fluid core.

    With e = (C - A)/A, kappa = e k/k_s, the share A_f/A and the ellipticity e_f of the core, and its compliances gamma
    and beta, they are the roots, over omega, of

        (sigma - e + (1 + sigma) kappa)(1 + e_f + (1 + beta) sigma) = sigma (1 + sigma)(1 + gamma)^2 A_f/A.

    The nutation is omega plus its frequency in space. ValueError as for `chandler_frequency`.
    Source: Sasao, Okubo & Saito 1980; Mathews, Herring & Buffett 2002, (21), without an inner core of its own.

    >>> wobble, nutation = wobble_and_nutation(1 / 304.5, 7.292115e-5, 0.297, 0.938, 0.1137)
    >>> print(f"{2 * np.pi / (7.292115e-5 + nutation.real) / 86400:.0f} d")  # in space; observed: -430
    -436 d
    """
    if not np.isfinite(chandler_frequency(dynamical_ellipticity, spin_rate, love_number, secular, 1 - core_share)):
        raise ValueError("the numbers of a wobble must be finite")
    e = dynamical_ellipticity / (1 - dynamical_ellipticity)
    kappa = e * love_number / secular
    core = core_share * (1 + core_compliance) ** 2  # the mantle's compliance for the core's rotation is gamma A_f/A
    outer, inner = [1 + kappa, kappa - e], [1 + core_own_compliance, 1 + core_ellipticity]
    roots = np.roots(np.polymul(outer, inner) - [core, core, 0])
    nutation, wobbling = (complex(root) for root in spin_rate * roots[np.argsort(roots.real)])
    return wobbling, nutation


@with_quantities(frequency="rad/s")
def nutation_ratio(
    frequency: Array, dynamical_ellipticity: float, spin_rate: float, love_number: complex, secular: float,
    core_share: float, core_ellipticity: float = CORE_ELLIPTICITY, core_compliance: float = CORE_COMPLIANCE,
    core_own_compliance: float = CORE_OWN_COMPLIANCE,
) -> Array:  # fmt: skip
    """A circular nutation of mantle and fluid core over that of a rigid body, at frequencies in space (rad/s).

    Prograde ones are above 0; 1 for the precession itself, of frequency 0. It is large near the free core nutation of
    `wobble_and_nutation`, whose equations and arguments it has, forced by a torque on the figure. ValueError as there.
    Source: Sasao, Okubo & Saito 1980; Mathews, Herring & Buffett 2002, (21) and (22).

    >>> node = 2 * np.pi / (6798.4 * 86400.0)  # of the Moon: 18.6 years
    >>> ratios = nutation_ratio(np.array([-node, 0.0, node]), 1 / 305.5, 7.292115e-5, 0.297, 0.938, 0.1137)
    >>> print(ratios.real.round(4))
    [0.9965 1.     1.0031]
    """
    chandler_frequency(dynamical_ellipticity, spin_rate, love_number, secular, 1 - core_share)
    e = dynamical_ellipticity / (1 - dynamical_ellipticity)
    in_space = np.asarray(frequency, dtype=float) / spin_rate
    sigma, kappa, coupled = in_space - 1, e * love_number / secular, core_share * (1 + core_compliance)
    resonant = 1 + core_ellipticity + (1 + core_own_compliance) * sigma
    behind = in_space * coupled * sigma / resonant
    mantle = sigma - e + in_space * kappa - behind * (1 + core_compliance)
    return (e - in_space * kappa + behind * core_compliance) * (sigma - e) / (e * mantle)


@lru_cache(maxsize=1)
def elastic_love_number() -> float:
    """k2 of PREM at a period of 1 s, without an ocean, referred to the Earth's equatorial radius: about 0.2966.

    The potential of a sphere of radius R goes as k R^5, and so k over the equatorial radius a is k (R/a)^5, as k_s is.
    Source: Dziewonski & Anderson 1981, PEPI 25, 297.

    >>> print(f"{elastic_love_number():.4f}")
    0.2966
    """
    return _referred(love_numbers(elastic_prem()).k)


def dispersion_love_number() -> float:
    """What seismic dispersion adds to k2 from 1 s, of PREM's moduli, to 200 s: about 0.0021.

    mu goes as 1 - (2/(pi Q)) ln(period/1 s) with PREM's Q of each layer. Source: Kanamori & Anderson 1977, Rev.
    Geophys. 15, 105.

    >>> print(f"{dispersion_love_number():.4f}")
    0.0021
    """
    earth, logarithm = elastic_prem(), math.log(_ANELASTIC_REFERENCE)
    softer = [
        mu * (1 - 2 / (np.pi * q) * logarithm) for mu, q in zip(earth.rigidity, prem_shear_quality(), strict=False)
    ]
    return _referred(love_numbers(YieldingBody(earth.layers, softer, earth.bulk_modulus, earth.rheology)).k) - (
        elastic_love_number()
    )


def _referred(number: float) -> float:
    earth = body("Earth")
    return float(number) * float(prem().mean_radius / earth.adopted("j2").radius) ** 5


def ocean_love_number() -> float:
    """What oceans in equilibrium with the pole tide add to k2: 0.0450, the mean of 0.0503 about m1 and 0.0398 about m2.

    Their shores are the true ones, and what the Earth yields under them is in it.
    Source: Desai 2002; Petit & Luzum 2010, IERS TN 36, (6.24).

    >>> print(f"{ocean_love_number():.4f}")
    0.0450
    """
    earth = body("Earth")
    j2 = earth.adopted("j2")
    per_radian = earth.angular_velocity**2 * j2.radius**3 / earth.gravitational_parameter / math.sqrt(15)
    return (_OCEAN_C21 + _OCEAN_S21) / 2 / (per_radian * ARCSECOND)


@with_quantities()
def anelastic_love_number(period: Array) -> Array:
    """What the mantle's anelasticity adds to k2 at a period (s): complex, 0.0125 - 0.0036 i at the Chandler period.

    From seismic periods, where k2 is elastic, Q falls as period^-0.15. ValueError for a period of zero or below.
    Source: Wahr & Bergen 1986, GJRAS 87, 633; Petit & Luzum 2010, IERS TN 36, (6.12).

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
    """The share of the Earth's moment that is not of its core, A_m/A, by PREM: about 0.886.

    The inner core stays behind with the fluid that it floats in: the mantle's gravity turns it in years (Mathews,
    Buffett, Herring & Shapiro 1991).

    >>> print(f"{mantle_share():.4f}")  # of the polar moment
    0.8862
    """
    shells = shell_integrals(prem(), 4)
    core = prem_layer_names().index("outer core") + 1
    return float(1 - shells[:core].sum() / shells.sum())


@with_quantities()
def chandler_wobble(love_number: float | None = None) -> Chandler:
    """The Earth's free wobble with each cause by name, in the order of `shares`, each on top of those before it.

    rigid. elasticity: PREM's, at 1 s, of a sphere. fluid core: it stays behind. coupling: of core and mantle by the
    shape of their boundary, and of the bulge by its own inertia. flattening: of the layers, in k2. oceans: in
    equilibrium. dispersion: from 1 s to 200 s. anelasticity: from there to the period itself. love_number: k2 of the
    elastic sphere over the equatorial radius, PREM's without it. Observed: 433 days (430 to 435), Q of tens to above
    100. PREM's Q is known to a tenth, which leaves 1 d open; the oceans' departure from equilibrium is not in it.
    NumericalError where the period does not settle. Source: Smith & Dahlen 1981; Mathews et al. 2002.

    >>> print(f"{chandler_wobble().period / 86400:.1f} d")  # observed: 433
    433.2 d
    """
    earth = body("Earth")
    ellipticity, spin = earth.value("dynamical_ellipticity"), earth.angular_velocity
    j2 = earth.adopted("j2")
    secular = float(secular_love_number(j2.value, earth.gravitational_parameter, j2.radius, spin))
    outside = mantle_share()
    elastic = elastic_love_number() if love_number is None else love_number

    def apart(number: complex, share: float) -> complex:
        return complex(chandler_frequency(ellipticity, spin, number, secular, share))

    def coupled(number: complex) -> complex:
        return wobble_and_nutation(ellipticity, spin, number, secular, 1 - outside)[0]

    steps: list[tuple[str, complex, complex]] = [
        ("rigid", 0.0, apart(0.0, 1.0)),
        ("elasticity", elastic, apart(elastic, 1.0)),
    ]
    steps += [("fluid core", 0.0, apart(elastic, outside)), ("coupling", 0.0, coupled(elastic))]
    total = elastic
    flattening = _ELLIPSOIDAL - elastic_love_number()
    for name, number in (
        ("flattening", flattening), ("oceans", ocean_love_number()), ("dispersion", dispersion_love_number()),
    ):  # fmt: skip
        total += number
        steps.append((name, number, coupled(total)))
    anelastic = _anelastic(lambda extra: coupled(total + extra))
    steps.append(("anelasticity", anelastic, coupled(total + anelastic)))
    periods = [2 * np.pi / sigma.real for _, _, sigma in steps]
    changes = np.diff(periods, prepend=0.0)
    shares = (Share(name, p, float(by), k) for (name, k, _), p, by in zip(steps, periods, changes, strict=True))
    sigma = steps[-1][2]
    return Chandler(tuple(shares), sigma, 2 * np.pi / sigma.real, float(quality(sigma)), outside, secular)


def _anelastic(frequency) -> complex:
    number, period = 0.0j, 400 * DAY
    for _ in range(_MOST_ITERATIONS):
        number = complex(anelastic_love_number(period))
        before, period = period, 2 * np.pi / frequency(number).real
        if abs(period - before) < 1e-14 * period:
            return number
    raise NumericalError("the period of the wobble and the anelasticity at that period do not settle")


@with_quantities(frequency="rad/s")
def wobble(times: Array, frequency: complex, start: complex = 0.0, excitation: Array | None = None) -> np.ndarray:
    """The pole m (complex, radians) at increasing times (N,), s, of (i/sigma) dm/dt + m = chi, beginning at `start`.

    excitation: chi (N,) at the times, straight between them, for which the answer is exact; none without it. ValueError
    for times that do not increase, for lengths that differ, and for a frequency of zero or that grows (Im sigma < 0).
    Source: Munk & MacDonald 1960, (6.1.4); Wilson & Haubrich 1976, GJRAS 46, 707.

    >>> print(abs(wobble(np.array([0.0, 100.0]), 1e-3 + 0j, 1e-6)))  # a free wobble keeps its size
    [1.e-06 1.e-06]
    """
    times = np.asarray(times, dtype=float)
    if times.ndim != 1 or not np.all(np.diff(times) > 0):
        raise ValueError("the times of a wobble increase")
    _require_free_wobble(frequency)
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


@with_quantities(frequency="rad/s")
def forced_wobble(frequency: complex, forcing_rate: Array, excitation: Array) -> Array:
    """The pole's amplitude (complex, rad) under chi = excitation exp(i forcing_rate t), prograde for a rate above 0.

    chi sigma/(sigma - rate): the annual wobble is a forced one. ValueError for a frequency as of `wobble`, and for a
    rate that is that of an undamped wobble, which grows without end. Source: Munk & MacDonald 1960, section 6.3.

    >>> print(forced_wobble(1.0 + 0j, 0.5, 1e-6))  # chi sigma/(sigma - rate)
    (2e-06+0j)
    """
    _require_free_wobble(frequency)
    away = frequency - np.asarray(forcing_rate)
    if np.any(away == 0):
        raise ValueError(
            f"a wobble that nothing damps, forced at its own rate of {frequency.real:g}, grows without end"
        )
    return np.asarray(excitation) * frequency / away


@with_quantities()
def polar_excitation(
    inertia_change: Array, axial_moment: Array, transverse_moment: Array, love_number: Array = 0.0,
    secular: Array = 1.0, load_love_number: Array = 0.0,
) -> Array:  # fmt: skip
    """The excitation chi (complex, rad) of `wobble` by changes (..., 3, 3) of the inertia tensor, in axes of the body.

    (1 + k')/(1 - k/k_s) (Delta I_xz + i Delta I_yz)/(C - A), about which the pole goes round. k and k_s are those of
    `chandler_frequency`; k' is how the body yields to the change where that is a load on it, -0.31 of the Earth, and 0
    where the change holds that or loads nothing. For changes of more than some days, with a fluid core or without; what
    currents carry is apart. ValueError for k >= k_s and for equal moments.
    Source: Munk & MacDonald 1960, sections 6.1 and 6.2; Gross 2007, Treatise on Geophysics 3, chapter 9.

    >>> change = np.zeros((3, 3))
    >>> change[0, 2] = change[2, 0] = -5e14 * 6.371e6**2 * np.sin(2.0) / 2  # -m x z of ice, 1 rad from the pole
    >>> chi = polar_excitation(change, 8.0365e37, 8.0101e37, 0.355, 0.938, -0.316)
    >>> print(f"{1e3 * chi.real / ARCSECOND:.1f} mas")  # away from the ice
    -7.9 mas
    """
    change = np.asarray(inertia_change, dtype=float)
    if np.any(np.real(love_number) >= np.asarray(secular)):
        raise ValueError("a body that yields like a fluid, with a Love number of k_s or above, keeps no pole")
    ellipticity = np.asarray(axial_moment, dtype=float) - transverse_moment
    if np.any(ellipticity == 0):
        raise ValueError("a body whose moments are equal has no axis of figure")
    yields = (1 + np.asarray(load_love_number)) / (1 - np.asarray(love_number) / secular)
    return yields * (change[..., 0, 2] + 1j * change[..., 1, 2]) / ellipticity


@with_quantities()
def length_of_day_change(
    inertia_change: Array, axial_moment: Array, load_love_number: Array = 0.0, mantle_share: Array = 1.0,
    length_of_day: Array = DAY,
) -> Array:  # fmt: skip
    """How much longer a day becomes (s) as its body's inertia tensor changes by (..., 3, 3), by the angular momentum.

    (1 + k') Delta I_zz/(C A_m/A) of the day, to first order. mantle_share is A_m/A where a fluid core does not follow.
    k' is as in `polar_excitation`, and for what turns without the Earth's core -0.25. ValueError for a share that is
    not above 0 and at most 1. Source: Munk & MacDonald 1960, section 6.1; Gross 2007.

    >>> change = np.diag([1.0, 1.0, -2.0]) / 3 * 3e-11 * 5.972e24 * 6.378e6**2  # J2 less by 3e-11, as in a year
    >>> print(f"{1e6 * length_of_day_change(change, 8.0365e37):.1f} microseconds")
    -5.2 microseconds
    """
    share = np.asarray(mantle_share, dtype=float)
    if not np.all((share > 0) & (share <= 1)):
        raise ValueError("the share of the moment outside the core, A_m/A, is above 0 and at most 1")
    growth = (1 + np.asarray(load_love_number)) * np.asarray(inertia_change, dtype=float)[..., 2, 2]
    return length_of_day * growth / (axial_moment * share)


def _require_free_wobble(frequency: complex) -> None:
    if not np.isfinite(frequency) or frequency == 0 or np.imag(frequency) < 0:
        raise ValueError("a free wobble has a frequency, and an imaginary part of it that damps (not below 0)")


def _mean_exponential(z: np.ndarray) -> np.ndarray:
    """(exp(z) - 1)/z, 1 at 0, for complex z without loss of digits."""
    safe = np.where(z == 0, 1.0, z)
    half = 0.5 * safe
    return np.where(z == 0, 1.0, np.exp(half) * np.sinh(half) / half)
