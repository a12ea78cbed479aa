"""Radial mass profiles of the unit sphere of unit mass, by which particles are placed.

s is the distance from the centre over the radius; the mass inside s is `enclosed(s)`. Stretched into an ellipsoid, s
labels the similar surfaces. Tests: tests/unit/sph/test_initial_particles.py.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from astroinertia.bodies.polytrope import Polytrope

CORE = 0.1  # of the largest density: what is denser is the core


@dataclass(frozen=True)
class Profile:
    """A mass profile, M = R = 1.

    enclosed(s) and its inverse radius(m), density(s); second_moment is the mean of x^2 (so I = 2 second_moment) and
    gravitational_energy the W of the sphere with G = 1. `name` identifies the profile for caches.
    """

    name: str
    enclosed: Callable[[np.ndarray], np.ndarray]
    radius: Callable[[np.ndarray], np.ndarray]
    density: Callable[[np.ndarray], np.ndarray]
    second_moment: float
    gravitational_energy: float


def polytrope(index: float) -> Profile:
    """Return the profile of the polytrope of `index`; ValueError outside 0 <= n < 5."""
    body = Polytrope(float(index))
    return _of_body(f"polytrope {body.index!r}", body)


def homologous_core(share: float) -> Profile:
    """Return that of a homologous collapse at `share` of the critical rate; ValueError outside 0 <= share <= 1."""
    from astroinertia.bodies.homologous_core import HomologousCore  # with integrators that other bodies do without

    body = HomologousCore(float(share))
    return _of_body(f"homologous_core {body.share!r}", body)


def _of_body(name: str, body: Any) -> Profile:
    moment, energy = body.moment_of_inertia / 2, body.gravitational_energy
    return Profile(name, body.enclosed_mass, body.radius_enclosing, body.density, moment, energy)


def uniform() -> Profile:
    """Return the profile of constant density."""
    return power_law(0.0)


def power_law(exponent: float) -> Profile:
    """Return rho ~ s^-exponent, truncated at the surface (Evrard 1988: exponent 1); ValueError unless 0 <= p < 3.

    From 2.5 on the gravitational energy diverges, and is -inf here.
    """
    p = float(exponent)
    if not 0 <= p < 3:
        raise ValueError(f"a power-law sphere rho ~ r^-p of finite mass needs 0 <= p < 3, not {exponent!r}")
    return Profile(
        name=f"power_law {p!r}",
        enclosed=lambda s: np.clip(s, 0.0, 1.0) ** (3 - p),
        radius=lambda m: np.clip(m, 0.0, 1.0) ** (1 / (3 - p)),
        density=lambda s: np.where(s <= 1.0, (3 - p) / (4 * math.pi) * np.maximum(s, 1e-100) ** -p, 0.0),
        second_moment=(3 - p) / (3 * (5 - p)),
        gravitational_energy=-(3 - p) / (5 - 2 * p) if p < 2.5 else -math.inf,
    )


def dyson(gamma: float) -> Profile:
    """Return rho ~ (1 - s^2)^(1/(gamma - 1)), the isentropic ellipsoid of Dyson (1968, J. Math. Mech. 18, 91).

    ValueError unless gamma > 1. The enclosed mass is the regularised incomplete beta function I_(s^2)(3/2, k + 1).
    """
    if not (math.isfinite(gamma) and gamma > 1):
        raise ValueError(f"a Dyson ellipsoid needs a finite gamma above 1, not {gamma!r}")
    from scipy import special  # which other bodies do without

    k = 1 / (float(gamma) - 1)
    central = math.exp(math.lgamma(k + 2.5) - math.lgamma(k + 1)) / math.pi**1.5

    def enclosed(s):
        return special.betainc(1.5, k + 1, np.clip(s, 0.0, 1.0) ** 2)

    # W = -integral of m(s) 4 pi s rho ds, by parts.
    binding = 2 * math.pi * central / (k + 1) * special.beta(1.5, 2 * k + 2) / special.beta(1.5, k + 1)
    return Profile(
        name=f"dyson {float(gamma)!r}",
        enclosed=enclosed,
        radius=lambda m: np.sqrt(special.betaincinv(1.5, k + 1, np.clip(m, 0.0, 1.0))),
        density=lambda s: central * np.maximum(1 - np.asarray(s) ** 2, 0.0) ** k,
        second_moment=1 / (2 * k + 5),
        gravitational_energy=-float(binding),
    )


def ellipsoid_gravitational_energy(profile: Profile, mass: float, semi_axes) -> float:
    """Return W of the ellipsoid whose similar surfaces carry the profile, G = 1, semi_axes (3,).

    W = W_sphere (abc)^(1/3) R_F(a^2, b^2, c^2) with the sphere of the same volume and Carlson's R_F, whatever the
    profile (Roberts 1962, ApJ 136, 1108).
    """
    from scipy.special import elliprf  # which other bodies do without

    a, b, c = (float(axis) for axis in semi_axes)
    return profile.gravitational_energy * mass**2 * float(elliprf(a**2, b**2, c**2))
