"""Oscillations and instabilities of rotating stars, however fast and differential: bars above all.

A displacement xi exp(i m phi + i sigma t) of the matter of a star that turns with Omega(w) obeys, for every trial eta,

    sigma^2 (eta, xi) + 2 sigma (eta, N xi) + (eta, N^2 xi) - V(eta, xi) = 0,    (eta, xi) = int rho eta* . xi dV,

where N multiplies the Cartesian component xi_x + i xi_y by (m + 1) Omega, xi_x - i xi_y by (m - 1) Omega and xi_z by
m Omega (sigma + N is the rate that the matter itself sees), and

    V = int (gamma - 1) P div eta* div xi + P d_i eta*_j d_j xi_i + rho eta*_i xi_j d_i d_j Phi dV
        - int int div(rho eta*) div'(rho' xi') / |x - x'| dV dV'.

With all displacements that are polynomials in x, y and z (even in z) up to a degree this is Ritz's method; their linear
part alone is the second-order virial equations. No condition is needed at the surface, where P and rho vanish, and a
liquid (gamma large) is no exception. What grows fast converges like a power (five digits with degree 7, measured); slow
growth where the pattern turns as the matter somewhere does comes of the discrete matrices and has no limit.

In a star that turns rigidly the displaced matter moves with i (sigma + m Omega) xi, and viscosity adds
-i (sigma + m Omega) int rho nu (2 s(eta*) : s(xi) + (bulk/shear) div eta* div xi) dV, s the shear: what makes bars grow
beyond the secular limit, at T/|W| = 0.1375 of a liquid.

Sources: Lynden-Bell & Ostriker 1967, MNRAS 136, 293 (the equation); Tassoul & Ostriker 1968, ApJ 154, 613, and
Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 5 (linear displacements). Tests:
tests/unit/bodies/test_rotating_modes.py.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import assoc_legendre_p, legendre_p_all

from astroinertia.bodies.rotating_star import RotatingStar
from astroinertia.errors import NumericalError
from astroinertia.process.blas import one_thread
from astroinertia.process.quantities import with_quantities

_DEGREES = (4, 6)  # in w^2 and z^2 of the trial displacements: the second for the answer, both for its error
_LIKE_A_BAR = 0.5  # share of a linear displacement in a mode, over the largest such share, that makes it a bar
_GROWS = 1e-6  # of the largest rate of a bar: less is round-off
_SAME = 1e-12  # of the largest eigenvalue of (eta, xi): below, trial displacements are not independent
_AGREED = 0.02  # of the pattern speed: the most by which the two degrees may differ


class BarMode(NamedTuple):
    """Rates of a star's bar in its own unit: growth_rate is zero where it neither grows nor decays (then negative).

    difference: of either rate, between two degrees of the trial displacements.
    """

    growth_rate: float
    pattern_speed: float
    difference: float


class _Trial(NamedTuple):
    # Amplitudes (B, K, J) of exp(i m phi): xi_x + i xi_y, xi_x - i xi_y, xi_z, and the derivatives d_a xi_b of these
    # components along x + i y, x - i y and z.
    plus: np.ndarray
    minus: np.ndarray
    up: np.ndarray
    slopes: dict[str, np.ndarray]


@with_quantities()
def bar_mode(
    star: RotatingStar, gamma: float, kinematic_viscosity: float = 0.0, bulk_over_shear: float = 0.0
) -> BarMode:
    """Return the growth rate and pattern speed of the bar mode (m = 2) of a star of adiabatic exponent gamma.

    Of the two bars of a star that is stable, that which turns more slowly, or backwards, and with viscosity that which
    grows, or decays more slowly. kinematic_viscosity: the same everywhere, with a bulk viscosity so many times the
    shear viscosity (5/3 for particles, effects/kinds/shear_viscosity.py). NumericalError where two degrees of trial
    displacements disagree; ValueError for viscosity in a star that it would make turn otherwise.
    """
    eigenvalues = [_bar(star, gamma, degree, kinematic_viscosity, bulk_over_shear) for degree in _DEGREES]
    difference = abs(eigenvalues[1] - eigenvalues[0])
    if difference > _AGREED * abs(eigenvalues[1]):
        raise NumericalError(
            f"the bar mode is not resolved: its rate changes by {difference / abs(eigenvalues[1]):.1%}"
        )
    return BarMode(-eigenvalues[1].imag, -eigenvalues[1].real / 2, difference)


def _bar(star: RotatingStar, gamma: float, degree: int, viscosity: float, bulk: float) -> complex:
    rates, share = spectrum(star, gamma, 2, degree, viscosity, bulk)
    bars = rates[share > _LIKE_A_BAR * share.max()]
    growth = -np.imag(bars)
    if viscosity or growth.max() > _GROWS * np.abs(bars).max():
        return complex(bars[np.argmax(growth)])
    return complex(np.real(bars).max())


@with_quantities()
@one_thread
def spectrum(
    star: RotatingStar, gamma: float, mode: int, degree: int, kinematic_viscosity: float = 0.0,
    bulk_over_shear: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return sigma (complex, (S,)) of all modes exp(i mode phi + i sigma t) that one discretisation has.

    Second the share (S,) in each, by mass, of the displacement whose xi_x - i xi_y goes as w^(mode - 1): for mode 2
    that of a bar, linear in x and y. mode: 1, 2, ...; degree: of the polynomials in w^2 and z^2. gamma: Gamma1, the
    same everywhere; viscosities as in bar_mode.
    """
    if mode < 1:
        raise ValueError(f"modes must be 1, 2, ..., not {mode!r}")
    if kinematic_viscosity and star.rotation_law.kind != "rigid":
        raise ValueError("viscosity leaves only rigid rotation as it is: the star must turn rigidly")
    mass, gyration, spread, stiffness, friction, bar = _matrices(star, gamma, mode, degree, bulk_over_shear)
    values, vectors = np.linalg.eigh(mass)
    kept = values > _SAME * values[-1]
    basis = vectors[:, kept] / np.sqrt(values[kept])
    gyration, stiffness = basis.T @ gyration @ basis, basis.T @ (spread - stiffness) @ basis
    unit = star.equatorial_radius**2 * math.sqrt(star.max_density * star.gravitational_constant)  # of a viscosity
    friction = 1j * kinematic_viscosity / unit * (basis.T @ friction @ basis)
    turning = mode * math.sqrt(star.field.rate_squared)
    zero, one = np.zeros_like(gyration), np.eye(len(gyration))
    sigma, modes = np.linalg.eig(np.block([[zero, one], [turning * friction - stiffness, friction - 2 * gyration]]))
    modes = modes[: len(one)]
    along = basis.T @ mass @ bar
    share = np.abs(along @ modes) ** 2 / (along @ along) / (np.abs(modes) ** 2).sum(axis=0)
    return sigma * math.sqrt(star.max_density * star.gravitational_constant), share


def _matrices(star: RotatingStar, gamma: float, m: int, degree: int, bulk: float) -> tuple[np.ndarray, ...]:
    """(eta, xi), (eta, N xi), (eta, N^2 xi), V and friction over nu, (B, B), and the trial displacement of a bar, (B,).

    In units of the equatorial radius, the largest density and G; integrals are over the sphere's 4 pi.
    """
    field = star.field
    r = field.mesh.radius[:, None]
    sine = np.sqrt(1 - field.cosine**2)
    w, z = r * sine, r * field.cosine
    volume = field.mesh.volume_weight[:, None] * field.weight
    rho, pressure = field.matter.density(field.level), field.matter.pressure(field.level) * field.peak
    rate = math.sqrt(field.rate_squared) * field.law.rate(w)
    trial = _trial(w, z, field.axis_ratio, m, degree)
    plus, minus, up, d = trial

    def summed(weight: np.ndarray, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        return (left.reshape(len(left), -1) * (volume * weight).ravel()) @ right.reshape(len(right), -1).T

    def kinetic(power: int) -> np.ndarray:
        weight = rho * rate**power
        across = (m + 1) ** power * summed(weight, plus, plus) + (m - 1) ** power * summed(weight, minus, minus)
        return across / 2 + m**power * summed(weight, up, up)

    divergence = (d["-+"] + d["+-"]) / 2 + d["zz"]
    stiffness = (gamma - 1) * summed(pressure, divergence, divergence)
    friction = (bulk - 2 / 3) * summed(rho, divergence, divergence)
    # a . b = (a+ b- + a- b+)/2 + az bz, for each of the two contractions
    for a, first in (("+", 0.5), ("-", 0.5), ("z", 1.0)):
        for b, second in (("+", 0.5), ("-", 0.5), ("z", 1.0)):
            stiffness += first * second * summed(pressure, d[a + b], d[b + a])
            friction += first * second * (summed(rho, d[a + b], d[a + b]) + summed(rho, d[a + b], d[b + a]))
    outwards, around = (plus + minus) / 2, (plus - minus) / 2  # xi_w and i xi_phi
    ww, wz, zz, round_about = _tides(star)
    mixed = summed(rho * wz, outwards, up)
    stiffness += summed(rho * ww, outwards, outwards) + summed(rho * zz, up, up) + mixed + mixed.T
    stiffness += summed(rho * round_about, around, around) + _gravity(star, rho, outwards, around, up, m)
    bar = np.zeros(len(plus))
    bar[len(plus) // 3] = 1.0
    return kinetic(0), kinetic(1), kinetic(2), stiffness, friction, bar


def _trial(w: np.ndarray, z: np.ndarray, height: float, m: int, degree: int) -> _Trial:
    """Legendre polynomials in w^2 and z^2 times w^(m+1), w^(m-1) and w^m z for the three components in turn."""

    def polynomials(x: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        basis = [np.polynomial.legendre.Legendre.basis(k) for k in range(degree + 1)]
        return np.array([p(x) for p in basis]), np.array([p.deriv()(x) * slope for p in basis])

    across, across_slope = polynomials(2 * w**2 - 1, 4 * w)
    along, along_slope = polynomials(2 * (z / height) ** 2 - 1, 4 * z / height**2)
    a, b = np.array([(a, b) for a in range(degree + 1) for b in range(degree + 1 - a)]).T
    f, f_w, f_z = across[a] * along[b], across_slope[a] * along[b], across[a] * along_slope[b]
    none = np.zeros_like(f)

    def component(place: int, values: np.ndarray) -> np.ndarray:
        return np.concatenate([values if place == k else none for k in range(3)])

    slopes = {}
    # d/dx +- i d/dy of f(w) exp(i k phi) has the amplitude df/dw -+ k f/w
    for place, (name, k, factor, factor_z) in enumerate(
        (("+", m + 1, 1.0, 0.0), ("-", m - 1, 1.0, 0.0), ("z", m, z, 1.0))
    ):
        by_w, over_w = w**k * f_w + k * w ** (k - 1) * f, k * w ** (k - 1) * f
        slopes["+" + name] = component(place, factor * (by_w - over_w))
        slopes["-" + name] = component(place, factor * (by_w + over_w))
        slopes["z" + name] = component(place, w**k * (factor * f_z + factor_z * f))
    return _Trial(component(0, w ** (m + 1) * f), component(1, w ** (m - 1) * f), component(2, w**m * z * f), slopes)


def _tides(star: RotatingStar) -> tuple[np.ndarray, ...]:
    """Second derivatives (K, J) of the star's potential: ww, wz, zz, and (1/w) d/dw."""
    field = star.field
    degrees, r, mu = field.mesh.degrees, field.mesh.radius[:, None], field.cosine
    inner, outer, *_ = field.mesh.integrals(field.moments)
    first = 4 * math.pi * ((degrees + 1) * inner - degrees * outer) / r
    second = (
        4 * math.pi * (2 * degrees + 1) * field.moments - 2 * first / r + degrees * (degrees + 1) * field.phi / r**2
    )
    p, p_slope, p_curve = legendre_p_all(int(degrees[-1]), mu, diff_n=2)[:, ::2]
    sine = np.sqrt(1 - mu**2)

    def at(components: np.ndarray, table: np.ndarray) -> np.ndarray:
        return np.einsum("kl,lkj->kj", components, table)

    over_r, turn = at(first, p) / r, -sine * at(field.phi, p_slope) / r**2  # phi_r/r, phi_theta/r^2
    rr, rt = at(second, p), -sine * at(first, p_slope) / r - turn
    tt = over_r + (sine**2 * at(field.phi, p_curve) - mu * at(field.phi, p_slope)) / r**2
    around = over_r - mu * at(field.phi, p_slope) / r**2
    ww = sine**2 * rr + 2 * sine * mu * rt + mu**2 * tt
    zz = mu**2 * rr - 2 * sine * mu * rt + sine**2 * tt
    return ww, sine * mu * (rr - tt) + (mu**2 - sine**2) * rt, zz, around


def _gravity(
    star: RotatingStar, rho: np.ndarray, outwards: np.ndarray, around: np.ndarray, up: np.ndarray, m: int
) -> np.ndarray:
    """Minus the double integral, (B, B): by harmonics, with div(rho xi) integrated by parts on every sphere.

    With a = int rho xi_r Y and b = int rho xi . (r grad Y) over a sphere, the potential of the displaced matter is
    -4 pi/(2l+1) Y times int_0^r (s/r)^(l+1) (l a + b) ds + int_r^1 (r/s)^l (b - (l+1) a) ds.
    """
    field, mesh = star.field, star.field.mesh.odd() if m % 2 else star.field.mesh
    degrees, r, mu = mesh.degrees, mesh.radius[:, None], field.cosine
    sine = np.sqrt(1 - mu**2)
    harmonic, slope = assoc_legendre_p(degrees[:, None, None], m, mu, norm=True, diff_n=1)
    slope = -sine * slope  # by the angle
    weight = field.weight * rho
    radial = np.einsum("bkj,lkj->bkl", weight * (outwards * sine + up * mu), harmonic)
    tangential = np.einsum("bkj,lkj->bkl", weight * (outwards * mu - up * sine), slope)
    tangential -= np.einsum("bkj,lkj->bkl", weight * m / sine * around, harmonic)
    source = (degrees * radial + tangential) / r
    inner = np.array([mesh.integrals(row)[0] for row in source])
    dr = (mesh.volume_weight / mesh.radius)[:, None]  # r dr
    half = np.einsum("akl,bkl->ab", 8 * math.pi / (2 * degrees + 1) * dr * (tangential - (degrees + 1) * radial), inner)
    return -(half + half.T) - 8 * math.pi * np.einsum("akl,bkl->ab", r * dr * radial, radial)
