"""Axially and equatorially symmetric solutions of Laplace's and Helmholtz's equations that fit a flattened body.

Powers r^l P_l(mu) of degree 40 differ by (a/c)^40 between the equator and the pole of a body, and a sum of them loses
as many digits. Oblate spheroidal harmonics of about the body's own flattening stay of order one on its surface: with
focal radius d, z = t eta and varpi^2 = (t^2 + d^2)(1 - eta^2), the functions

    p_l(t) P_l(eta)    regular at the centre,       q_l(t) P_l(eta)    decaying at infinity

are harmonic, and d = 0 gives r^l P_l and r^-(l+1) P_l. Vekua's integral turns a regular harmonic function h into a
regular solution of laplacian u = -u, and r^l P_l into (2l + 1)!! j_l(r) P_l:

    u(x) = h(x) - (r^2/4) integral_0^1 sqrt(s) G(r sqrt(1 - s)) h(s x) ds,    G(z) = 2 J_1(z)/z

Source: Vekua 1967, New Methods for Solving Elliptic Equations, section 13; Hobson 1931, The Theory of Spherical and
Ellipsoidal Harmonics, ch. X. Tests: tests/unit/bodies/test_spheroidal_basis.py.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import j0, j1, roots_jacobi

_EXTRA_NODES = 12  # of the Vekua quadrature beyond half the degree: G needs them for r up to 6
_MILLER_EXTRA = 60  # degrees beyond the last from which the decaying solution is recurred down


@dataclass(frozen=True)
class SpheroidalBasis:
    """Even degrees 0, 2, ..., `degree` with focal radius d, scaled to one on the axis at distance `reference`."""

    degree: int
    focal_radius: float
    reference: float

    @property
    def degrees(self) -> np.ndarray:
        """0, 2, ..., degree."""
        return np.arange(0, self.degree + 1, 2)

    def regular_harmonics(self, r, mu):
        """Return h, r dh/dr and dh/dmu of the regular harmonics, each of shape (degrees, *points)."""
        t, eta, metric = self._coordinates(r, mu)
        legendre, slope = legendre_polynomials(self.degree, eta)
        radial, radial_slope = self._growing(t)
        return self._gradient(r, t, eta, metric, radial, radial_slope, legendre, slope)

    def decaying_harmonics(self, r, mu):
        """Return h, r dh/dr and dh/dmu of the decaying harmonics; not on the focal disc (z = 0, varpi <= d)."""
        t, eta, metric = self._coordinates(r, mu)
        legendre, slope = legendre_polynomials(self.degree, eta)
        radial, radial_slope = self._decaying(t)
        return self._gradient(r, t, eta, metric, radial, radial_slope, legendre, slope)

    def helmholtz_solutions(self, r, mu):
        """Return u, r du/dr and du/dmu of the Vekua transforms of the regular harmonics, (degrees, *points)."""
        r, mu = np.broadcast_arrays(np.asarray(r, float), np.asarray(mu, float))
        nodes, weights = roots_jacobi(self.degree // 2 + _EXTRA_NODES, 0.0, 0.5)
        s, weights = (nodes + 1) / 2, weights / 2**1.5  # the weight is sqrt(s) on 0 < s < 1
        value, radial, angular = self.regular_harmonics(r, mu)
        inner, inner_radial, inner_angular = self.regular_harmonics(r[..., None] * s, mu[..., None])
        z = np.maximum(r[..., None] * np.sqrt(1 - s), 1e-300)
        share = r[..., None] ** 2 / 4 * weights
        kernel, kernel_slope = share * 2 * j1(z) / z, share * 2 * j0(z)  # r d/dr of r^2 G is 2 r^2 J_0
        return (
            value - (kernel * inner).sum(-1),
            radial - (kernel_slope * inner + kernel * inner_radial).sum(-1),
            angular - (kernel * inner_angular).sum(-1),
        )

    def _coordinates(self, r, mu):
        """t, eta and t^2 + d^2 eta^2; t^2 is the positive root of t^4 - (r^2 - d^2) t^2 - d^2 z^2."""
        d2 = self.focal_radius**2
        z2, difference = (r * mu) ** 2, r**2 - d2
        metric = np.hypot(difference, 2 * self.focal_radius * r * mu)
        other = np.where(difference > 0, 1.0, metric - difference)  # each form of the root where it does not cancel
        t2 = np.where(difference > 0, (difference + metric) / 2, 2 * d2 * z2 / np.where(other > 0, other, 1.0))
        t = np.sqrt(t2)
        eta = np.where(t > 0, r * mu / np.where(t > 0, t, 1.0), np.sqrt(np.clip(1 - r**2 / max(d2, 1e-300), 0, 1)))
        return t, np.clip(eta, -1.0, 1.0), metric

    def _gradient(self, r, t, eta, metric, radial, radial_slope, legendre, slope):
        """Values, r d/dr and d/dmu at constant r, from the factors in t and eta and their derivatives."""
        d2, metric = self.focal_radius**2, np.where(metric > 0, metric, 1.0)
        along_t, along_eta = radial_slope * legendre, radial * slope
        return (
            radial * legendre,
            (t * (t**2 + d2) * along_t - d2 * eta * (1 - eta**2) * along_eta) / metric,
            r * (d2 * eta * along_t + t * along_eta) / metric,
        )

    def _growing(self, t):
        """p_l(t)/p_l(reference) and its slope, from p_(l+1) = t p_l + d^2 c_l p_(l-1): no term is negative."""
        ratio = self.reference
        values, slopes = [np.ones_like(t), t / ratio], [np.zeros_like(t), np.full_like(t, 1 / ratio)]
        for degree in range(1, self.degree):
            coupling = self.focal_radius**2 * _coupling(degree) / ratio
            ratio = self.reference + coupling
            values.append((t * values[-1] + coupling * values[-2]) / ratio)
            slopes.append((values[-2] + t * slopes[-1] + coupling * slopes[-2]) / ratio)
        return np.array(values[: self.degree + 1 : 2]), np.array(slopes[: self.degree + 1 : 2])

    def _decaying(self, t):
        """q_l(t)/q_l(reference) and its slope, from q_(l-1) = t q_l + d^2 c_(l+1) q_(l+1), recurred downwards."""
        t = np.asarray(t, dtype=float)
        ratios, reference_ratios = self._downwards(t), self._downwards(np.asarray(self.reference))
        value = self._lowest(t) / self._lowest(np.asarray(self.reference))
        values, slopes = [], []
        for degree in range(self.degree + 1):
            if degree:
                value = value * ratios[degree] / reference_ratios[degree]
            coupling = (2 * degree + 1) * self.focal_radius**2 * _coupling(degree + 1)
            slope = -value * ((degree + 1) * t + coupling * ratios[degree + 1]) / (t**2 + self.focal_radius**2)
            values.append(value)
            slopes.append(slope)
        return np.array(values[::2]), np.array(slopes[::2])

    def _lowest(self, t):
        """q_0: the arc whose cotangent is t/d, over d."""
        d = self.focal_radius
        return np.arctan2(d, t) / d if d > 0 else 1 / t

    def _downwards(self, t):
        """The ratios q_l/q_(l-1) for l up to degree + 1, by Miller's algorithm."""
        d2, last = self.focal_radius**2, self.degree + _MILLER_EXTRA
        ratio = 2 / (t + np.sqrt(t**2 + d2))
        ratios = {}
        for degree in range(last, 0, -1):
            ratio = 1 / (t + d2 * _coupling(degree + 1) * ratio)
            ratios[degree] = ratio
        return ratios


def _coupling(degree: int) -> float:
    """l^2/(4 l^2 - 1): of the recurrence of Legendre functions scaled to leading coefficient one."""
    return degree**2 / (4 * degree**2 - 1)


def legendre_polynomials(degree: int, x) -> tuple[np.ndarray, np.ndarray]:
    """Return P_l(x) and dP_l/dx of the even degrees 0, 2, ..., `degree`, each (degrees, *x.shape)."""
    x = np.asarray(x, dtype=float)
    values, slopes = [np.ones_like(x), x], [np.zeros_like(x), np.ones_like(x)]
    for k in range(1, degree):
        values.append(((2 * k + 1) * x * values[-1] - k * values[-2]) / (k + 1))
        slopes.append(slopes[-2] + (2 * k + 1) * values[-2])
    return np.array(values[: degree + 1 : 2]), np.array(slopes[: degree + 1 : 2])
