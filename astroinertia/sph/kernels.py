"""Smoothing kernels and the gravitational potentials that they soften, as functions of q = r/h.

Each kernel has five functions of (xp, q), dimensionless, for three dimensions:

    W(r, h)   = w(q) / h^3      dW/dr   = dw(q) / h^4       dW/dh   = -(3 w + q dw) / h^4
                                d2W/dr2 = d2w(q) / h^5
    phi(r, h) = phi(q) / h      dphi/dr = dphi(q) / h^2     dphi/dh = -(phi + q dphi) / h^2

phi is the potential of a unit mass spread as W: dphi = M(q)/q^2 with M(q) = 4 pi int_0^q w s^2 ds, and
phi = -1/q beyond the support, exactly (Price & Monaghan 2007, MNRAS 374, 1347, section 2.1 and appendix A; the
integrals here were done again, in exact rationals). Splines: Schoenberg's M4, M5, M6 (Price 2012, JCP 231, 759,
equations 6 to 8). Wendland's C2, C4, C6 for three dimensions (Dehnen & Aly 2012, MNRAS 425, 1068, table 1).

Forms are chosen for accuracy. Near the origin the potentials are polynomials in q; further out they are -1/q plus
products of truncated powers with positive coefficients, which vanish at the support and beyond, so that nothing large
is ever subtracted. The outer form is guarded at half its lower knot, not at the knot, where a maximum has no
derivative. Potential and gradient both multiply by 1/p, so that one division serves them.
`tests/unit/sph/test_kernels.py` holds every function to the mass integral and to exact rationals.

The functions are plain: arithmetic and xp.where, xp.maximum only, literals only, so that an engine can compile their
source as it stands.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from astroinertia.sph.kernel_softening import (
    cubic_softening,
    quartic_softening,
    quintic_softening,
    wendland_c2_softening,
    wendland_c4_softening,
    wendland_c6_softening,
)

PARTICLES_OF_OWN_NUMBER = 1000.0  # from which on numbers of neighbours may rise
MOST_NEIGHBOURS = 1000.0  # to which they may
OWN_SHARE_NEIGHBOURS = (45.0, 60.0, 74.0, 100.0, 137.0, 200.0, 300.0)
"""Mean numbers of neighbours that own_share of a kernel is for."""


@dataclass(frozen=True)
class Kernel:
    """A smoothing kernel: `support` is its radius in units of h; w, dw, d2w, phi, dphi are functions of (xp, q).

    variance: the second moment along an axis, in units of h^2: 4 pi/3 int_0^support w q^4 dq.
    softening: h^2 dphi/dh = -(phi + q dphi) = 4 pi int_q^support w s ds, which has no cancellation.
    eta: the recommended h / (m/rho)^(1/3), the defaults of the code of Price et al. 2018 (PASA 35, e031): 58, 87 and
    113 neighbours for the splines and 74, 113 and 137 for the Wendland kernels.
    own_share: what is taken off the contrast of sph.fourth_order, at OWN_SHARE_NEIGHBOURS, as gas at rest needs it
    (tests/benchmarks/own_share.py).
    self_excess: (epsilon_100, alpha) of the function `self_excess`, where it is not 0.
    """

    name: str
    support: float
    eta: float
    w: Callable
    dw: Callable
    d2w: Callable
    phi: Callable
    dphi: Callable
    variance: float
    softening: Callable
    own_share: tuple[float, ...]
    self_excess: tuple[float, float] | None = None


def neighbour_number(kernel: Kernel, eta: float) -> float:
    """Mean number of particles within the support, 4/3 pi (support eta)^3, the particle itself included."""
    return 4.0 / 3.0 * math.pi * (kernel.support * eta) ** 3


def eta_for_neighbours(kernel: Kernel, neighbours: float) -> float:
    """The eta that gives a mean neighbour number: the inverse of `neighbour_number`."""
    return (3.0 * neighbours / (4.0 * math.pi)) ** (1.0 / 3.0) / kernel.support


def rising_neighbours(kernel: Kernel, particles: int) -> float:
    """The neighbour number with which sums over neighbours converge as particles do, from 1000 particles on.

    The kernel's own times (N/1000)^(1/2), at most 1000: the smoothing length falls as N^(-1/6), so that smoothing and
    the noise of the sums fall together (Zhu, Hernquist & Li 2015, ApJ 800, 6).
    """
    growth = max(1.0, particles / PARTICLES_OF_OWN_NUMBER) ** 0.5
    return min(MOST_NEIGHBOURS, growth * neighbour_number(kernel, kernel.eta))


def self_excess(kernel: Kernel, eta: float) -> float:
    """What the sum of m w over a settled body has too much, in units of a particle's mass.

    epsilon w(0) with epsilon = epsilon_100 (neighbours/100)^-alpha (Dehnen & Aly 2012, eqs. 18 and 19): particles keep
    their distance from each other, but not from themselves. 0 for the splines, whose errors cancel.
    """
    if kernel.self_excess is None:
        return 0.0
    share, falls = kernel.self_excess
    return share * (neighbour_number(kernel, eta) / 100.0) ** -falls * kernel.w(np, 0.0)


# M4, cubic spline, support 2, normalised by 1/(4 pi)


def cubic_w(xp, q):
    """M4 kernel value."""
    a = xp.maximum(0.0, 2.0 - q)
    b = xp.maximum(0.0, 1.0 - q)
    return 0.07957747154594767 * (a * a * a - 4.0 * (b * b * b))


def cubic_dw(xp, q):
    """M4 kernel derivative."""
    a = xp.maximum(0.0, 2.0 - q)
    b = xp.maximum(0.0, 1.0 - q)
    return -0.238732414637843 * (a * a - 4.0 * (b * b))


def cubic_d2w(xp, q):
    """M4 second derivative."""
    a = xp.maximum(0.0, 2.0 - q)
    b = xp.maximum(0.0, 1.0 - q)
    return 0.477464829275686 * (a - 4.0 * b)


def cubic_phi(xp, q):
    """M4 potential."""
    s = q * q
    inner = -1.4 + s * (2.0 / 3.0 + s * (-0.3 + 0.1 * q))
    p = xp.maximum(q, 0.5)
    t = xp.maximum(0.0, 2.0 - p)
    t2 = t * t
    outer = (t2 * t2 * t * (p + t / 3.0) * 0.05 - 1.0) * (1.0 / p)
    return xp.where(q < 1.0, inner, outer)


def cubic_dphi(xp, q):
    """M4 potential gradient."""
    s = q * q
    inner = q * (4.0 / 3.0 + s * (-1.2 + 0.5 * q))
    p = xp.maximum(q, 0.5)
    t = xp.maximum(0.0, 2.0 - p)
    t2 = t * t
    inverse = 1.0 / p
    outer = (1.0 - t2 * t2 * (p * p * 0.25 + t * (p * 0.1 + t / 60.0))) * (inverse * inverse)
    return xp.where(q < 1.0, inner, outer)


# M5, quartic spline, support 2.5, normalised by 1/(20 pi)


def quartic_w(xp, q):
    """M5 kernel value."""
    a = xp.maximum(0.0, 2.5 - q)
    b = xp.maximum(0.0, 1.5 - q)
    c = xp.maximum(0.0, 0.5 - q)
    a2 = a * a
    b2 = b * b
    c2 = c * c
    return 0.015915494309189534 * (a2 * a2 - 5.0 * (b2 * b2) + 10.0 * (c2 * c2))


def quartic_dw(xp, q):
    """M5 kernel derivative; the polynomial of the innermost piece keeps it exact to round-off near the origin."""
    p = xp.maximum(q, 0.25)
    a = xp.maximum(0.0, 2.5 - p)
    b = xp.maximum(0.0, 1.5 - p)
    outer = -0.06366197723675814 * (a * a * a - 5.0 * (b * b * b))
    inner = 0.38197186342054884 * q * (q * q - 1.25)
    return xp.where(q < 0.5, inner, outer)


def quartic_d2w(xp, q):
    """M5 second derivative."""
    a = xp.maximum(0.0, 2.5 - q)
    b = xp.maximum(0.0, 1.5 - q)
    c = xp.maximum(0.0, 0.5 - q)
    return 0.1909859317102744 * (a * a - 5.0 * (b * b) + 10.0 * (c * c))


def quartic_phi(xp, q):
    """M5 potential."""
    s = q * q
    inner = -1199.0 / 960.0 + s * (23.0 / 48.0 + s * (-0.15 + s / 35.0))
    p = xp.maximum(q, 0.25)
    a = xp.maximum(0.0, 2.5 - p)
    b = xp.maximum(0.0, 1.5 - p)
    a2 = a * a
    b2 = b * b
    far_knot = a2 * a2 * a2 * (p + 2.0 / 7.0 * a)
    near_knot = b2 * b2 * b2 * (p + 2.0 / 7.0 * b)
    outer = ((far_knot - 5.0 * near_knot) / 150.0 - 1.0) * (1.0 / p)
    return xp.where(q < 0.5, inner, outer)


def quartic_dphi(xp, q):
    """M5 potential gradient."""
    s = q * q
    inner = q * (23.0 / 24.0 + s * (-0.6 + 6.0 / 35.0 * s))
    p = xp.maximum(q, 0.25)
    p2 = p * p
    a = xp.maximum(0.0, 2.5 - p)
    b = xp.maximum(0.0, 1.5 - p)
    a2 = a * a
    b2 = b * b
    far_knot = a2 * a2 * a * (p2 / 5.0 + a * (p / 15.0 + a / 105.0))
    near_knot = b2 * b2 * b * (p2 / 5.0 + b * (p / 15.0 + b / 105.0))
    inverse = 1.0 / p
    outer = (1.0 - (far_knot / 5.0 - near_knot)) * (inverse * inverse)
    return xp.where(q < 0.5, inner, outer)


# M6, quintic spline, support 3, normalised by 1/(120 pi)


def quintic_w(xp, q):
    """M6 kernel value."""
    a = xp.maximum(0.0, 3.0 - q)
    b = xp.maximum(0.0, 2.0 - q)
    c = xp.maximum(0.0, 1.0 - q)
    a2 = a * a
    b2 = b * b
    c2 = c * c
    return 0.0026525823848649222 * (a2 * a2 * a - 6.0 * (b2 * b2 * b) + 15.0 * (c2 * c2 * c))


def quintic_dw(xp, q):
    """M6 kernel derivative; the polynomial of the innermost piece keeps it exact to round-off near the origin."""
    p = xp.maximum(q, 0.5)
    a = xp.maximum(0.0, 3.0 - p)
    b = xp.maximum(0.0, 2.0 - p)
    a2 = a * a
    b2 = b * b
    outer = -0.013262911924324612 * (a2 * a2 - 6.0 * (b2 * b2))
    s = q * q
    inner = 0.13262911924324614 * q * (-2.4 + s * (2.4 - q))
    return xp.where(q < 1.0, inner, outer)


def quintic_d2w(xp, q):
    """M6 second derivative."""
    a = xp.maximum(0.0, 3.0 - q)
    b = xp.maximum(0.0, 2.0 - q)
    c = xp.maximum(0.0, 1.0 - q)
    return 0.05305164769729845 * (a * a * a - 6.0 * (b * b * b) + 15.0 * (c * c * c))


def quintic_phi(xp, q):
    """M6 potential."""
    s = q * q
    inner = -239.0 / 210.0 + s * (11.0 / 30.0 + s * (-0.1 + s * (1.0 / 42.0 - q / 168.0)))
    p = xp.maximum(q, 0.5)
    a = xp.maximum(0.0, 3.0 - p)
    b = xp.maximum(0.0, 2.0 - p)
    a2 = a * a
    b2 = b * b
    far_knot = a2 * a2 * a2 * a * (p + 0.25 * a)
    near_knot = b2 * b2 * b2 * b * (p + 0.25 * b)
    outer = ((far_knot - 6.0 * near_knot) / 1260.0 - 1.0) * (1.0 / p)
    return xp.where(q < 1.0, inner, outer)


def quintic_dphi(xp, q):
    """M6 potential gradient."""
    s = q * q
    inner = q * (11.0 / 15.0 + s * (-0.4 + s * (1.0 / 7.0 - q / 24.0)))
    p = xp.maximum(q, 0.5)
    p2 = p * p
    a = xp.maximum(0.0, 3.0 - p)
    b = xp.maximum(0.0, 2.0 - p)
    a2 = a * a
    b2 = b * b
    far_knot = a2 * a2 * a2 * (p2 / 6.0 + a * (p / 21.0 + a / 168.0))
    near_knot = b2 * b2 * b2 * (p2 / 6.0 + b * (p / 21.0 + b / 168.0))
    inverse = 1.0 / p
    outer = (1.0 - (far_knot - 6.0 * near_knot) / 30.0) * (inverse * inverse)
    return xp.where(q < 1.0, inner, outer)


# Wendland kernels, support 2, in x = q/2 and t = 1 - x; the inner polynomials are used below q = 0.6, where neither
# form loses more than a factor of four to cancellation


def wendland_c2_w(xp, q):
    """Wendland C2 kernel value, normalised by 21/(16 pi)."""
    t = xp.maximum(0.0, 1.0 - 0.5 * q)
    t2 = t * t
    return 0.4177817256162253 * (t2 * t2 * (1.0 + 2.0 * q))


def wendland_c2_dw(xp, q):
    """Wendland C2 kernel derivative."""
    t = xp.maximum(0.0, 1.0 - 0.5 * q)
    return -2.088908628081126 * q * (t * t * t)


def wendland_c2_d2w(xp, q):
    """Wendland C2 second derivative."""
    t = xp.maximum(0.0, 1.0 - 0.5 * q)
    return 2.088908628081126 * (t * t * (2.0 * q - 1.0))


def wendland_c2_phi(xp, q):
    """Wendland C2 potential."""
    x = 0.5 * q
    s = x * x
    inner = -1.5 + s * (3.5 + s * (-10.5 + x * (14.0 + x * (-7.5 + 1.5 * x))))
    p = xp.maximum(q, 0.3)
    x = 0.5 * p
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    outer = (t2 * t2 * t2 * (1.0 + x * (3.0 + 3.0 * x)) - 1.0) * (1.0 / p)
    return xp.where(q < 0.6, inner, outer)


def wendland_c2_dphi(xp, q):
    """Wendland C2 potential gradient."""
    x = 0.5 * q
    s = x * x
    inner = x * (3.5 + s * (-21.0 + x * (35.0 + x * (-22.5 + 5.25 * x))))
    p = xp.maximum(q, 0.3)
    x = 0.5 * p
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    inverse = 1.0 / p
    outer = (1.0 - t2 * t2 * t * (1.0 + x * (5.0 + x * (15.0 + 21.0 * x)))) * (inverse * inverse)
    return xp.where(q < 0.6, inner, outer)


def wendland_c4_w(xp, q):
    """Wendland C4 kernel value, normalised by 495/(256 pi)."""
    x = 0.5 * q
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    return 0.6154820064881891 * (t2 * t2 * t2 * (1.0 + x * (6.0 + 35.0 / 3.0 * x)))


def wendland_c4_dw(xp, q):
    """Wendland C4 kernel derivative."""
    x = 0.5 * q
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    return -5.744498727223098 * x * (t2 * t2 * t * (1.0 + 5.0 * x))


def wendland_c4_d2w(xp, q):
    """Wendland C4 second derivative."""
    x = 0.5 * q
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    return 2.872249363611549 * (t2 * t2 * (x * (35.0 * x - 4.0) - 1.0))


def wendland_c4_phi(xp, q):
    """Wendland C4 potential."""
    x = 0.5 * q
    s = x * x
    inner = 51.5625 + x * (-82.5 + x * (60.15625 + x * (-22.0 + 3.28125 * x)))
    inner = -1.71875 + s * (5.15625 + s * (-14.4375 + s * inner))
    p = xp.maximum(q, 0.3)
    x = 0.5 * p
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    t4 = t2 * t2
    outer = (t4 * t4 * (1.0 + x * (4.5625 + x * (8.5 + 6.5625 * x))) - 1.0) * (1.0 / p)
    return xp.where(q < 0.6, inner, outer)


def wendland_c4_dphi(xp, q):
    """Wendland C4 potential gradient."""
    x = 0.5 * q
    s = x * x
    inner = 618.75 + x * (-1155.0 + x * (962.5 + x * (-396.0 + 65.625 * x)))
    inner = 0.25 * x * (20.625 + s * (-115.5 + s * inner))
    p = xp.maximum(q, 0.3)
    x = 0.5 * p
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    beyond = t2 * t2 * t2 * t * (1.0 + x * (7.0 + x * (28.0 + x * (63.375 + 65.625 * x))))
    inverse = 1.0 / p
    return xp.where(q < 0.6, inner, (1.0 - beyond) * (inverse * inverse))


def wendland_c6_w(xp, q):
    """Wendland C6 kernel value, normalised by 1365/(512 pi)."""
    x = 0.5 * q
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    t4 = t2 * t2
    return 0.8486191301579575 * (t4 * t4 * (1.0 + x * (8.0 + x * (25.0 + 32.0 * x))))


def wendland_c6_dw(xp, q):
    """Wendland C6 kernel derivative."""
    x = 0.5 * q
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    return -9.334810431737534 * x * (t2 * t2 * t2 * t * (1.0 + x * (7.0 + 16.0 * x)))


def wendland_c6_d2w(xp, q):
    """Wendland C6 second derivative."""
    x = 0.5 * q
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    return 4.667405215868767 * (t2 * t2 * t2 * (x * (x * (15.0 + 160.0 * x) - 6.0) - 1.0))


def wendland_c6_phi(xp, q):
    """Wendland C6 potential."""
    x = 0.5 * q
    s = x * x
    inner = -273.7109375 + x * (500.5 + x * (-447.890625 + x * (227.5 + x * (-63.1640625 + 7.5 * x))))
    inner = -1.9140625 + s * (7.109375 + s * (-23.4609375 + s * (67.03125 + s * inner)))
    p = xp.maximum(q, 0.3)
    x = 0.5 * p
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    t4 = t2 * t2
    beyond = t4 * t4 * t2 * (1.0 + x * (6.171875 + x * (16.71875 + x * (23.671875 + 15.0 * x))))
    return xp.where(q < 0.6, inner, (beyond - 1.0) * (1.0 / p))


def wendland_c6_dphi(xp, q):
    """Wendland C6 potential gradient."""
    x = 0.5 * q
    s = x * x
    inner = -4379.375 + x * (9009.0 + x * (-8957.8125 + x * (5005.0 + x * (-1515.9375 + 195.0 * x))))
    inner = 0.25 * x * (28.4375 + s * (-187.6875 + s * (804.375 + s * inner)))
    p = xp.maximum(q, 0.3)
    x = 0.5 * p
    t = xp.maximum(0.0, 1.0 - x)
    t2 = t * t
    t4 = t2 * t2
    beyond = t4 * t4 * t * (1.0 + x * (9.0 + x * (45.0 + x * (136.5625 + x * (239.0625 + 195.0 * x)))))
    inverse = 1.0 / p
    return xp.where(q < 0.6, inner, (1.0 - beyond) * (inverse * inverse))


# fmt: off
_ALL = (
    Kernel(
        "cubic", 2.0, 1.2, cubic_w, cubic_dw, cubic_d2w, cubic_phi, cubic_dphi, 3 / 10, cubic_softening,
        (-0.0218, -0.0313, -0.0257, -0.0269, -0.0365, -0.0293, -0.0289),
    ),
    Kernel(
        "quartic", 2.5, 1.1, quartic_w, quartic_dw, quartic_d2w, quartic_phi, quartic_dphi, 23 / 60, quartic_softening,
        (-0.0003, -0.0033, -0.0032, -0.0039, -0.0036, -0.0034, -0.0034),
    ),
    Kernel(
        "quintic", 3.0, 1.0, quintic_w, quintic_dw, quintic_d2w, quintic_phi, quintic_dphi, 7 / 15, quintic_softening,
        (0.0463, 0.0075, 0.0019, -0.0001, -0.0007, -0.0011, -0.0010),
    ),
    Kernel(
        "wendland_c2", 2.0, 1.3, wendland_c2_w, wendland_c2_dw, wendland_c2_d2w, wendland_c2_phi, wendland_c2_dphi,
        4 / 15, wendland_c2_softening,
        (0.0177, 0.0122, 0.0062, 0.0004, 0.0005, 0.0001, -0.0001), (0.0294, 0.977),
    ),
    Kernel(
        "wendland_c4", 2.0, 1.5, wendland_c4_w, wendland_c4_dw, wendland_c4_d2w, wendland_c4_phi, wendland_c4_dphi,
        8 / 39, wendland_c4_softening,
        (0.0422, 0.0244, 0.0184, 0.0091, 0.0024, 0.0012, 0.0003), (0.01342, 1.579),
    ),
    Kernel(
        "wendland_c6", 2.0, 1.6, wendland_c6_w, wendland_c6_dw, wendland_c6_d2w, wendland_c6_phi, wendland_c6_dphi,
        1 / 6, wendland_c6_softening,
        (0.1798, 0.0603, 0.0284, 0.0129, 0.0056, 0.0014, 0.0004), (0.0116, 2.236),
    ),
)
# fmt: on
KERNELS: dict[str, Kernel] = {kernel.name: kernel for kernel in _ALL}
