"""The free surface of a rotating polytrope of index 1: trial densities, and Newton's method on their coefficients.

For n = 1 hydrostatic equilibrium is linear inside. In units of length 1/k, k^2 = 2 pi G/K, and of some density,

    rho = w + sum_l a_l u_l(r, mu),    laplacian u_l = -u_l,    w = Omega^2/(2 pi G),    a_0 = 1,    u_0 = j_0(r)
    V = rho - (w/4) varpi^2 + constant                        (minus the gravitational potential over 2K)

and only the surface rho = 0 makes it non-linear. V continues into a decaying harmonic function outside exactly if

    F_l = surface integral of (V grad h_l - h_l grad V) . dS = 0,    l = 2, 4, ...

for every decaying harmonic function h_l (Green's second identity outside the body). No expansion of the exterior field
is made, so nothing depends on its convergence inside the sphere through the equator. Since V grad h - h grad V has
the divergence -h laplacian V = h rho, which is zero on the surface, a displacement of the surface changes F_l only in
second order: the exact Jacobian of Newton's method is the same integral with V replaced by its derivative.

Source: the condition on the surface is the null-field form of Waterman 1965, Proc. IEEE 53, 805.
Tests: tests/unit/bodies/test_spectral_polytrope.py, tests/hard/test_spectral_polytrope_hard.py.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from astroinertia.bodies.spheroidal_basis import SpheroidalBasis
from astroinertia.process.blas import one_thread

# Below it spherical functions lose no digits, and cancellation can be kept out of the integrals.
_PLAIN_FLATTENING = 0.1
# Step of the second derivative that Newton's method needs to find the saddle at the equator.
_PROBE = 1e-6


@dataclass(frozen=True, eq=False)
class Trial:
    """A density and its surface: the last two points are the equator and the pole, with no weight."""

    basis: SpheroidalBasis
    unknowns: np.ndarray  # a_0 = 1, a_2, ..., w
    mu: np.ndarray
    weights: np.ndarray  # of the integral over 0 < mu < 1
    swelling: np.ndarray  # r/pi - 1
    values: np.ndarray  # u_l on the surface, and 1 for the derivative by w as the last row
    radial: np.ndarray  # r du_l/dr
    angular: np.ndarray  # du_l/dmu

    @property
    def r(self) -> np.ndarray:
        """Radii of the surface."""
        return math.pi * (1 + self.swelling)

    @property
    def w(self) -> float:
        """Omega^2/(2 pi G)."""
        return float(self.unknowns[-1])

    @cached_property
    def slope(self) -> np.ndarray:
        """(1 - mu^2) d(ln R)/dmu of the surface."""
        return -(1 - self.mu**2) * (self.unknowns @ self.angular) / (self.unknowns @ self.radial)

    def flux(self, radial, angular):
        """The gradient through the surface, grad f . dS/(2 pi dmu), from r df/dr and df/dmu."""
        return self.r * (radial - self.slope * angular)

    @cached_property
    def varpi2(self) -> np.ndarray:
        """Square of the distance from the axis."""
        return self.r**2 * (1 - self.mu**2)

    @cached_property
    def potential_changes(self) -> tuple[np.ndarray, np.ndarray]:
        """dV/d(unknown) and the flux of its gradient, on the surface."""
        values = np.vstack([self.values[:-1], 1 - self.varpi2 / 4])
        fluxes = self.flux(self.radial, self.angular)
        fluxes[-1] = -self.flux(2 * self.varpi2, -2 * self.mu * self.r**2) / 4
        return values, fluxes

    @cached_property
    def potential_flux(self) -> np.ndarray:
        """The gradient of V through the surface."""
        return self.unknowns @ self.potential_changes[1]

    @cached_property
    def mass(self) -> float:
        """The volume integral of the density."""
        return float(-4 * math.pi * self.potential_flux @ self.weights)

    def mass_change(self) -> np.ndarray:
        """dM/d(unknown), without that of a_0."""
        return -4 * math.pi * self.potential_changes[1][1:] @ self.weights

    def surface_change(self) -> np.ndarray:
        """dr/d(unknown), at all points but a cusp."""
        slope = self.unknowns @ self.radial
        return -self.values[1:] * self.r / np.where(slope < 0, slope, -math.inf)

    def identity(self, h, radial, angular, exponent=None):
        """Green's surface integral of (V grad h - h grad V) over 4 pi, for harmonic h of degree 2 and more.

        With exponent (-l - 1 or l) the h are r^exponent P_l(mu), and the spherical part of the flux is taken relative
        to that through r = pi, which cannot contribute: what is left is small with the rotation, and so are errors.
        """
        remainder = self.potential_flux
        part = 0.0
        if exponent is not None:
            s = self.swelling
            sine, cosine = np.sin(math.pi * s), np.cos(math.pi * s)
            spherical = sine - math.pi * (1 + s) * cosine  # R^2 j_0'(R)
            excess = sine - math.pi * s + 2 * math.pi * (1 + s) * np.sin(math.pi * s / 2) ** 2  # minus that at pi
            remainder = self.unknowns[1:] @ self.potential_changes[1][1:]
            growth = np.exp(exponent * np.log1p(s))
            part = h * (spherical * np.expm1(exponent * np.log1p(s)) + excess) / growth
        return ((-self.w / 4 * self.varpi2 * self.flux(radial, angular) - h * remainder - part) * self.weights).sum(-1)

    def conditions(self) -> tuple[np.ndarray, np.ndarray]:
        """F_l and its derivatives by a_2, ..., w."""
        h, radial, angular = (parts[1:] for parts in self.basis.decaying_harmonics(self.r, self.mu))
        exponent = None if self.basis.focal_radius else -(self.basis.degrees[1:, None] + 1)
        values, fluxes = self.potential_changes
        weighted = h * self.weights
        jacobian = (self.flux(radial, angular) * self.weights) @ values[1:].T - weighted @ fluxes[1:].T
        return self.identity(h, radial, angular, exponent), jacobian


def _points(nodes: int) -> tuple[np.ndarray, np.ndarray]:
    x, weights = np.polynomial.legendre.leggauss(nodes)
    return np.append((x + 1) / 2, [0.0, 1.0]), np.append(weights / 2, [0.0, 0.0])


def _fields(basis: SpheroidalBasis, swelling, mu):
    """u_l, r du_l/dr and du_l/dmu, with the row of the derivative by w."""
    r = math.pi * (1 + swelling)
    values, radial, angular = basis.helmholtz_solutions(r, mu)
    values[0] = -np.sin(math.pi * swelling) / r  # j_0 without cancellation near r = pi
    radial[0] = np.cos(r) - values[0]
    angular[0] = 0.0
    nothing = np.zeros((1, *r.shape))
    return np.vstack([values, nothing + 1]), np.vstack([radial, nothing]), np.vstack([angular, nothing])


def find_surface(basis, unknowns, mu, weights, swelling, cusp=False) -> Trial | None:
    """Find the surface rho = 0 by Newton's method from a guess; with `cusp` the equator's point is the saddle of rho.

    None where it is not found: the density does not fall to zero on every ray.
    """
    last = math.inf
    for attempt in range(80):
        values, radial, angular = _fields(basis, swelling, mu)
        density, slope = unknowns @ values, unknowns @ radial
        step = np.where(slope < 0, -density * (1 + swelling) / np.where(slope < 0, slope, -1.0), -0.03)
        if cusp:
            beyond = unknowns @ _fields(basis, swelling[-2:-1] + _PROBE, mu[-2:-1])[1]
            step[-2] = -slope[-2] * _PROBE / (beyond[0] - slope[-2])
            density[-2] = 0.0
        size = np.max(np.abs(step))
        if not np.isfinite(size):
            return None
        round_off = 1e-14 * np.max(np.abs(unknowns[:, None] * values))
        stalled = attempt > 2 and size > 0.5 * last and np.max(np.abs(density)) < round_off
        if size <= 2e-16 * np.max(np.abs(swelling)) or stalled:
            return Trial(basis, unknowns, mu, weights, swelling, values, radial, angular)
        last = size
        swelling = swelling + np.clip(step, -0.1, 0.1)
        if np.any(swelling < -0.9):
            return None
    return None


def sphere(degree: int) -> Trial:
    """Return the body without rotation, rho = j_0(r)."""
    mu, weights = _points(2 * degree + 10)
    basis = SpheroidalBasis(degree, 0.0, math.pi)
    unknowns = np.zeros(degree // 2 + 2)
    unknowns[0] = 1.0
    trial = find_surface(basis, unknowns, mu, weights, np.zeros_like(mu))
    assert trial is not None
    return trial


@one_thread
def rebased(trial: Trial, degree: int) -> Trial | None:
    """The same density in functions up to `degree` that fit its flattening, by least squares on its surface."""
    equator, pole = trial.r[-2:]
    plain = 1 - pole / equator < _PLAIN_FLATTENING
    focal = 0.0 if plain else math.sqrt(equator**2 - pole**2)
    mu, weights = _points(2 * degree + 10)
    order = np.argsort(trial.mu)
    guess = np.interp(mu, trial.mu[order], trial.swelling[order])
    basis = SpheroidalBasis(degree, focal, float(pole))
    new, old = _fields(basis, guess, mu), _fields(trial.basis, guess, mu)
    matrix = np.hstack([new[0][:-1], new[1][:-1]]).T
    wanted = trial.unknowns[:-1] @ np.hstack([old[0][:-1], old[1][:-1]])
    coefficients = np.linalg.lstsq(matrix, wanted)[0]
    unknowns = np.append(coefficients, trial.w) / coefficients[0]
    return find_surface(basis, unknowns, mu, weights, guess)


def _rotation_parameter(trial: Trial):
    equator = trial.r[-2]
    unit = 2 * math.pi * equator**3 / trial.mass
    change = trial.w * unit * (3 * trial.surface_change()[:, -2] / equator - trial.mass_change() / trial.mass)
    change[-1] += unit
    return trial.w * unit, change


def _small_m(trial: Trial):
    volume = trial.r**3 @ trial.weights
    growth = 3 * (trial.surface_change() * trial.r**2) @ trial.weights
    unit = 2 * math.pi * volume / trial.mass
    change = trial.w * unit * (growth / volume - trial.mass_change() / trial.mass)
    change[-1] += unit
    return trial.w * unit, change


def _central_rotation(trial: Trial):
    central = np.append(trial.basis.helmholtz_solutions(0.0, 1.0)[0], 1.0)
    density = trial.unknowns @ central
    change = -trial.w / 2 / density**2 * central[1:]
    change[-1] += 0.5 / density
    return trial.w / 2 / density, change


def _flattening(trial: Trial):
    equator, pole = trial.swelling[-2:]
    change = trial.surface_change() / math.pi
    ratio = (1 + pole) / (1 + equator)
    return (equator - pole) / (1 + equator), (change[:, -2] * ratio - change[:, -1]) / (1 + equator)


def _equatorial_saddle(trial: Trial):
    return trial.unknowns @ trial.values[:, -2], trial.values[1:, -2]


QUANTITIES = {
    "rotation_parameter": _rotation_parameter,
    "small_m": _small_m,
    "central_rotation_parameter": _central_rotation,
    "flattening": _flattening,
    "saddle": _equatorial_saddle,
}


@one_thread
def newton(trial: Trial | None, quantity: str, target: float) -> Trial | None:
    """Solve F_l = 0 and quantity = target; None where Newton's method does not converge to round-off."""
    cusp, last = quantity == "saddle", math.inf
    for _ in range(40):
        if trial is None:
            return None
        residual, jacobian = trial.conditions()
        value, change = QUANTITIES[quantity](trial)
        try:
            step = -np.linalg.solve(np.vstack([jacobian, change]), np.append(residual, value - target))
        except np.linalg.LinAlgError:
            return None
        size = np.max(np.abs(step)) / max(np.max(np.abs(trial.unknowns[1:])), 1e-300)
        if size < 1e-15 or (size < 1e-9 and size > 0.3 * last):
            return trial
        if not np.isfinite(size):
            return None
        last = size
        trial = _stepped(trial, step, cusp)
    return None


def _stepped(trial: Trial, step, cusp: bool) -> Trial | None:
    """The trial after a Newton step, shortened as often as it takes for the new density to have a surface."""
    moved = trial.surface_change()
    for halving in range(8):
        share = 0.5**halving
        unknowns = trial.unknowns + share * np.append(0.0, step)
        swelling = trial.swelling + np.clip(share * (step @ moved) / math.pi, -0.05, 0.05)
        better = find_surface(trial.basis, unknowns, trial.mu, trial.weights, swelling, cusp)
        if better is not None:
            return better
    return None
