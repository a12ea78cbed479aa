"""Roche-Riemann ellipsoids: Roche's, with a steady flow inside as of a body that does not turn with its orbit.

The fluid has the vorticity f Omega along the axis of the orbit, in axes that turn with it and with the figure: f = 0 is
Roche's synchronous body, f = -2 one without vorticity in space, as of neutron stars that viscosity cannot lock. With
mu, p and Omega^2 = (1 + p) mu as in roche.py, a = 1 and the flow u = f Omega (-a^2 y, b^2 x)/(a^2 + b^2),

    ((3 + p) + c^2 + (1 + p) b^2 (2 f/(1 + b^2) + f^2/(1 + b^2)^2)) mu = 2 (1 - c^2) B_13,
    (p b^2 + c^2 + (1 + p) b^2 (2 f/(1 + b^2) + f^2 b^2/(1 + b^2)^2)) mu = 2 (b^2 - c^2) B_23     (in pi G rho).

Figures are labelled by c/a; b may be less than c. The limit is where mu is largest.

Source: Aizenman 1968, ApJ 153, 511; Lai, Rasio & Shapiro 1993, ApJS 88, 205. Tests: tests/unit/bodies/test_roche.py.
"""

import math
from dataclasses import dataclass

from astroinertia.bodies.ellipsoid_gravity import index_integral
from astroinertia.bodies.roche import RocheEllipsoid
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

_COMPLEX_STEP = 1e-40  # exact derivatives: nothing is subtracted
_ROUNDEST, _THINNEST = 1 - 1e-6, 0.2  # c/a between which figures are looked for
_FLATTEST = 1e-6  # b^2 from which on
_LEAST, _MOST = -4.0, 1.0  # f of figures whose limit has such a c/a


@dataclass(frozen=True)
class RocheRiemannEllipsoid(RocheEllipsoid):
    """One of them: `vorticity_ratio` is f, the vorticity over Omega in the axes of the figure."""

    vorticity_ratio: float = 0.0


def _equation(y, z, p: float, f: float):
    """What is zero for b^2 = y and c^2 = z, and mu."""
    squares = (1.0, y, z)
    flow = (1 + p) * y * f / (1 + y)
    towards = 3 + p + z + flow * (2 + f / (1 + y))
    along = p * y + z + flow * (2 + f * y / (1 + y))
    b_13, b_23 = index_integral(squares, (0, 2), 1), index_integral(squares, (1, 2), 1)
    return towards * (y - z) * b_23 - along * (1 - z) * b_13, 2 * (1 - z) * b_13 / towards


def _slopes(y: float, z: float, p: float, f: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Derivatives of the equation and of mu, by y and by z."""
    by_y, by_z = _equation(y + 1j * _COMPLEX_STEP, z, p, f), _equation(y, z + 1j * _COMPLEX_STEP, p, f)
    equation, mu = (
        (one.imag / _COMPLEX_STEP, other.imag / _COMPLEX_STEP) for one, other in zip(by_y, by_z, strict=True)
    )
    return equation, mu


def _middle_square(z: float, p: float, f: float) -> float:
    """b^2 of the figure with c^2 = z: the equation is below zero for a needle and above it for an oblate spheroid."""
    return root_between(lambda y: float(_equation(y, z, p, f)[0]), _FLATTEST, 1.0)


@with_quantities()
def from_axis_ratio(
    mass_ratio: float, vorticity_ratio: float, c_over_a: float, **scale: float
) -> RocheRiemannEllipsoid:
    """Return the ellipsoid of p = M/M' >= 0, f from -4 to 1, and c/a from 0.2 to 1 - 1e-6.

    `scale`: mass, mean_radius, gravitational_constant. ValueError outside. Source: Aizenman 1968, ApJ 153, 511. Test:
    tests/unit/bodies/test_roche.py.

    >>> print(from_axis_ratio(1.0, -2.0, 0.8).axes.round(4))  # without vorticity in space: b is the shortest
    [1.1766 0.9029 0.9413]
    """
    p, f, c = float(mass_ratio), float(vorticity_ratio), float(c_over_a)
    if not (0 <= p < math.inf and _LEAST <= f <= _MOST):
        raise ValueError(
            f"a Roche-Riemann ellipsoid has a finite mass ratio M/M' of 0 or above and a vorticity of {_LEAST:g} to "
            f"{_MOST:g} Omega, not {mass_ratio} and {vorticity_ratio}"
        )
    if not _THINNEST <= c <= _ROUNDEST:
        raise ValueError(f"c/a of a Roche-Riemann ellipsoid lies in {_THINNEST:g} <= c/a <= 1 - 1e-6, not {c_over_a}")
    y = _middle_square(c * c, p, f)
    tide = float(_equation(y, c * c, p, f)[1])
    figure = RocheRiemannEllipsoid(math.sqrt(y), c, (1 + p) * tide, mass_ratio=p, tide=tide, vorticity_ratio=f)
    return figure.rescaled(**scale)


@with_quantities()
def limit(mass_ratio: float, vorticity_ratio: float, **scale: float) -> RocheRiemannEllipsoid:
    """Return the ellipsoid that is closest to its companion, of p = M/M' >= 0 and f from -4 to 1. ValueError outside.

    Source: Aizenman 1968, ApJ 153, 511. Test: tests/unit/bodies/test_roche.py.

    >>> print(f"{limit(0.0, -2.0).tide:.4f} {limit(0.0, 0.0).tide:.4f}")  # without vorticity in space, and Roche's
    0.0851 0.0901
    """

    def rise(c: float) -> float:
        """Of mu along the sequence, with a sign that does not change."""
        p, f, z = float(mass_ratio), float(vorticity_ratio), c * c
        (e_y, e_z), (mu_y, mu_z) = _slopes(_middle_square(z, p, f), z, p, f)
        return (mu_z * e_y - mu_y * e_z) / abs(e_y)

    from_axis_ratio(mass_ratio, vorticity_ratio, 0.9)  # refuses what is none
    return from_axis_ratio(mass_ratio, vorticity_ratio, root_between(rise, _THINNEST, 0.999), **scale)
