"""Slow rotation and tides of a star: moment of inertia, rotational quadrupole and tidal Love number (Hartle-Thorne).

Six equations ride along with the structure (tov.py, whose scaled U, W, E, p, f, q and h_c = eps they use). With
omega_bar the fluid's rate relative to the local inertial frame and j^2 = exp(-nu) f:

    A = dln(omega_bar)/dln r/(eps U) and L = ln(omega_bar)/eps, 0 at the centre: Hartle's equation for dragging in
    Riccati's form,
        A' = F (eps U A + 4) - A (eps U A + 5),   L' = U A,   F = 4 pi (E + eps p)/f;
    h_2 = U H and v_2 = h_2 + k_2 = eps U^2 V: the quadrupole, without and with its source in omega_bar^2,
        H' = 4 (pi (E - eps p) - W)/q H - 2 N H - 2 V/q
             + g [N (eps U A)^2/6 - eps U A^2/(12 q) + 2 eps U F N/3 + F/(3 q)],
        V' = -4 V - 2 q/f H + g (1 + N) [2 F/3 + eps U A^2/6],   N = eps U q/f = nu'/2,   g = j^2 omega_bar^2.

The homogeneous solution is the tidal perturbation as well. As a first-order system it holds no derivative of e, and
h_2 and v_2 are continuous where the density jumps, at the surface too: no jump condition is left to be forgotten.
For eps = 0 everything becomes Newton's: I is the integral of rho r^4 and twice the Love number is Clairaut's.

Sources: Hartle 1967, ApJ 150, 1005; Hartle & Thorne 1968, ApJ 153, 807; Hinderer 2008, ApJ 677, 1216 (and erratum);
Binnington & Poisson 2009, PRD 80, 084018 (the exterior in hypergeometric functions); Yagi & Yunes 2013, PRD 88, 023009.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import hyp2f1

from astroinertia.bodies.tov import Local, Structure


@dataclass(frozen=True)
class SlowRotation:
    """The star's answers to slow rotation at Omega and to a static quadrupolar tide.

    moment_ratio = I/(M R^2) with I = J/Omega; tidal_love_number: k2 of Hinderer, half the fluid Love number in
    Newton's limit; quadrupole = Q/(Omega^2 R^5), Q > 0 for an oblate star (M J2 R^2 in Newton's limit);
    quadrupole_bar = Q M/J^2 (NaN for a Newtonian star); central_dragging = 1 - omega_bar/Omega at the centre.
    """

    moment_ratio: float
    tidal_love_number: float
    quadrupole: float
    quadrupole_bar: float
    central_dragging: float


class Equations:
    """The perturbation that `tov.structure` integrates: A, L, then H and V without and with the source."""

    def start(self, here: Local) -> list[float]:
        """Regular values at the centre, the source-free H there 1."""
        F = 4 * math.pi * (here.E + here.relativity * here.p) / here.f
        return [0.8 * F, 0.4 * F * here.U, 1.0, -0.5 * here.q, 0.0, F / 6 * math.exp(-2 * here.relativity * here.depth)]

    def slopes(self, here: Local, values: list[float]) -> list[float]:
        """Derivatives by ln r."""
        A, L, H, V, H_source, V_source = values
        depth, eps, U, W, E, p, f, q = here
        F = 4 * math.pi * (E + eps * p) / f
        alpha = eps * U * A
        N = eps * U * q / f
        g = f * math.exp(2 * eps * (L - depth))  # exp(-nu) ~ exp(2 h), scaled to the centre
        on_H = 4 * (math.pi * (E - eps * p) - W) / q - 2 * N
        source_H = g * (N * alpha**2 / 6 - alpha * A / (12 * q) + 2 * eps * U * F * N / 3 + F / (3 * q))
        source_V = g * (1 + N) * (2 * F / 3 + alpha * A / 6)
        return [
            F * (alpha + 4) - A * (alpha + 5),
            U * A,
            on_H * H - 2 * V / q,
            -4 * V - 2 * q / f * H,
            on_H * H_source - 2 * V_source / q + source_H,
            -4 * V_source - 2 * q / f * H_source + source_V,
        ]


def decaying_exterior(compactness: float) -> tuple[float, float]:
    """Return R^3 times the decaying h_2 = r^-3 (1 - 2M/r) 2F1(3, 5; 6; 2M/r) at the surface, and its dln h_2/dln r.

    >>> print(*decaying_exterior(0.0))  # Newton's r^-3
    1.0 -3.0
    """
    x = 2 * compactness
    value, slope = hyp2f1(3, 5, 6, x), 2.5 * hyp2f1(4, 6, 7, x)
    return (1 - x) * value, -3 + x / (1 - x) - x * slope / value


def love_number(compactness: float, y: float) -> float:
    """k2 from y = dln h_2/dln r just outside the surface (Hinderer 2008, Eq. 23 without its cancellations).

    >>> print(f"{love_number(0.0, -1.0):.2f}")  # a Newtonian star of one density, whose surface is a jump: 3/4
    0.75
    """
    x = 2 * compactness
    value, y_decaying = decaying_exterior(compactness)
    y_growing = 2 + x / (1 - x)
    return (y_growing - y) / (y - y_decaying) / 2 * (1 - x) / value


def enclosed_moment_share(star: Structure) -> np.ndarray:
    """The share of I that lies within each radius of `star`, (points,), from 0 at the centre to 1.

    J(r) = r^4 j (domega_bar/dr)/6 is the angular momentum within r. Source: Hartle 1967, ApJ 150, 1005.

    >>> from astroinertia.matter.compact_stars import constant_density
    >>> from astroinertia.bodies.tov import structure
    >>> body = structure(constant_density(1.0), 1.0, relativistic=False, perturbation=Equations())
    >>> print(np.abs(enclosed_moment_share(body) - (body.r / body.radius) ** 5).max() < 1e-10)
    True
    """
    A, L, *_ = _perturbation(star)
    eps = star.relativity
    # j = (f exp(-nu))^(1/2) with -nu/2 = h but for a constant, and f = 1 - 2m/r
    compactness = np.divide(star.enclosed_mass, star.r, out=np.zeros_like(star.r), where=star.r > 0)
    drag = np.exp(star.log_enthalpy + eps * L) * np.sqrt(1 - 2 * compactness) if star.relativistic else 1.0
    momentum = star.r**5 * A * drag
    return momentum / momentum[-1]


def slow_rotation(star: Structure) -> SlowRotation:
    """Return what the perturbations integrated with `star` mean, by matching them to the exterior.

    >>> from astroinertia.matter.compact_stars import polytrope
    >>> from astroinertia.bodies.tov import structure
    >>> found = slow_rotation(structure(polytrope(100.0, 2.0), 1e-4, relativistic=False, perturbation=Equations()))
    >>> print(f"{found.moment_ratio:.4f} {2 / 3 * (1 - 6 / np.pi**2):.4f} {found.tidal_love_number:.2f}")  # of n = 1
    0.2614 0.2614 0.26
    """
    A, L, H, V, H_source, V_source = _perturbation(star)[:, -1].tolist()
    U, W = star.scaled_surface
    eps, C = star.relativity, star.compactness if star.relativistic else 0.0
    alpha = eps * U * A
    moment_ratio = A / W / (2 * (3 + alpha))
    rate = 3 / (3 + alpha)  # omega_bar/Omega at the surface, 1 - 2I/R^3
    N = C / (1 - 2 * C)
    y = -2 * V / (W * H) - 2 - 2 * N

    # Omega^2 R^2 (h_2 and v_2/C) inside = outside, with the amplitudes of the two homogeneous solutions unknown.
    scale = rate**2 * math.exp(2 * eps * (1 - L)) / (1 - 2 * C)
    decay, y_decaying = decaying_exterior(C)
    moment_squared = moment_ratio**2
    _, amplitude = np.linalg.solve(
        [[H, -decay], [V / W, decay * (y_decaying + 2 + 2 * N) / 2]],
        [moment_squared * C * (1 + C) - scale * H_source, -moment_squared * C - scale * V_source / W],
    )
    quadrupole = float(amplitude) + moment_squared * C
    return SlowRotation(
        moment_ratio=moment_ratio,
        tidal_love_number=love_number(C, y),
        quadrupole=quadrupole,
        quadrupole_bar=quadrupole / (moment_squared * C) if C > 0 else math.nan,
        central_dragging=-math.expm1(-math.log1p(alpha / 3) - eps * L),
    )


def _perturbation(star: Structure) -> np.ndarray:
    if len(star.perturbation) != 6:
        raise ValueError("the star was integrated without the equations of slow rotation")
    return star.perturbation
