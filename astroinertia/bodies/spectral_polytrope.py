"""The rigidly rotating polytrope of index 1 to round-off, from no rotation to mass shedding: a spectral solution.

The density is a sum of solutions of Helmholtz's equation (bodies/spheroidal_basis.py), the surface is free
(bodies/null_field.py), and the exterior field is never expanded, so that nothing depends on whether multipoles converge
down to the surface.

Measured, error of J_2: at q = 0.09 1e-13 with degree 12, at 0.25 4e-13 with 16, at 0.6 3e-14 with 28, at 0.9 1e-12 with
56. At mass shedding, where the surface has a cusp, errors fall as degree^-4 only: 5e-6 of q at degree 38, 1e-6 at 80.

Source: Wisdom & Hubbard 2016, Icarus 267, 315 (expansion in Bessel functions, to q = 0.3).
Tests: tests/unit/bodies/test_spectral_polytrope.py, tests/hard/test_spectral_polytrope_hard.py.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from astroinertia.bodies.equilibrium_figure import EquilibriumFigure
from astroinertia.bodies.null_field import QUANTITIES, Trial, find_surface, newton, rebased, sphere
from astroinertia.bodies.spheroidal_basis import legendre_polynomials
from astroinertia.errors import NumericalError
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities

_DEGREES = (12, 18, 26, 38, 56, 80)  # tried in turn until two agree
_MARCH_DEGREE = 18
_MARCH = (0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.575, 0.562)  # axis ratios on the way to mass shedding at 0.557
_FROM_SPHERE = {"rotation_parameter": 0.2, "small_m": 0.15, "central_rotation_parameter": 0.015, "flattening": 0.12}
_RADIAL_NODES = 40  # of the volume integrals: exact to round-off for sines of up to one and a half periods
_ROUND_OFF = 1e-14  # of the ratios


@lru_cache(maxsize=1)
def _milestones() -> tuple[Trial, ...]:
    """Solutions of low degree along the sequence, from the sphere to the neighbourhood of mass shedding."""
    trials = [sphere(_MARCH_DEGREE)]
    for ratio in _MARCH:
        trial = newton(rebased(trials[-1], _MARCH_DEGREE), "flattening", 1 - ratio)
        if trial is None:
            raise NumericalError(f"the rotating polytrope of axis ratio {ratio} did not converge")
        trials.append(trial)
    return tuple(trials)


def _start(quantity: str, target: float) -> Trial:
    """A solution of low degree for the target, or, next to mass shedding, the last milestone before it."""
    before = sphere(_MARCH_DEGREE)
    if target > _FROM_SPHERE[quantity]:
        for trial in _milestones():
            if QUANTITIES[quantity](trial)[0] > target:  # all of them rise along the sequence
                break
            before = trial
    return newton(rebased(before, _MARCH_DEGREE), quantity, target) or before


@dataclass(frozen=True, eq=False)
class RotatingPolytrope(EquilibriumFigure):
    """A rigidly rotating polytrope of index 1 of given mass and mean radius, in units with the given G.

    Lengths, densities and energies follow from `mass`, `mean_radius` and `gravitational_constant`; ratios do not
    depend on them. `truncation_error` is the largest relative change of the ratios since the previous degree.
    """

    trial: Trial = field(repr=False)
    truncation_error: float
    mass: float = 1.0
    mean_radius: float = 1.0
    gravitational_constant: float = 1.0

    @property
    def degree(self) -> int:
        """The highest degree of the expansion."""
        return self.trial.basis.degree

    @cached_property
    def _mean(self) -> float:
        return float(np.cbrt(self.trial.r**3 @ self.trial.weights))

    @property
    def _density_unit(self) -> float:
        return self.mass / self.trial.mass * (self._mean / self.mean_radius) ** 3

    @property
    def equatorial_radius(self) -> float:
        """a."""
        return float(self.trial.r[-2]) * self.mean_radius / self._mean

    @property
    def polar_radius(self) -> float:
        """c."""
        return float(self.trial.r[-1]) * self.mean_radius / self._mean

    @property
    def flattening(self) -> float:
        """1 - c/a."""
        return float(QUANTITIES["flattening"](self.trial)[0])

    @property
    def axis_ratio(self) -> float:
        """c/a."""
        return self.polar_radius / self.equatorial_radius

    @property
    def rotation_parameter(self) -> float:
        """q = Omega^2 a^3/(G M)."""
        return float(QUANTITIES["rotation_parameter"](self.trial)[0])

    @property
    def small_m(self) -> float:
        """m = Omega^2 R_mean^3/(G M)."""
        return float(QUANTITIES["small_m"](self.trial)[0])

    @property
    def central_rotation_parameter(self) -> float:
        """Omega^2/(4 pi G rho_c)."""
        return float(QUANTITIES["central_rotation_parameter"](self.trial)[0])

    @property
    def angular_velocity(self) -> float:
        """Omega."""
        return math.sqrt(self.small_m * self.gravitational_constant * self.mass / self.mean_radius**3)

    @property
    def central_density(self) -> float:
        """rho_c."""
        return float(self.density(0.0, 0.0))

    @property
    def constant(self) -> float:
        """K of P = K rho^2."""
        return 2 * math.pi * self.gravitational_constant * (self.mean_radius / self._mean) ** 2

    @cached_property
    def zonal_harmonics(self) -> np.ndarray:
        """J_2, J_4, ... J_degree, normalised with the mass and the equatorial radius."""
        trial, equator = self.trial, self.trial.r[-2]
        degrees = trial.basis.degrees[1:, None]
        legendre, slope = (values[1:] for values in legendre_polynomials(self.degree, trial.mu))
        powers = (trial.r / equator) ** degrees
        integrals = trial.identity(powers * legendre, degrees * powers * legendre, powers * slope, degrees)
        return -4 * math.pi / trial.mass * integrals

    @cached_property
    def _volume_integrals(self) -> tuple[float, float, float, float]:
        """Of rho, rho varpi^2, rho V and rho^2, in the units of the solution, over the volume."""
        trial = self.trial
        x, weights = np.polynomial.legendre.leggauss(_RADIAL_NODES)
        r = (x[:, None] + 1) / 2 * trial.r
        volume = 2 * math.pi * weights[:, None] * r**2 * trial.r * trial.weights
        density = self._dimensionless_density(r, trial.mu)
        inverse = trial.flux(-1 / trial.r, 0.0)
        boundary = -trial.w / 4 * trial.varpi2 * inverse - trial.potential_flux / trial.r
        varpi2 = r**2 * (1 - trial.mu**2)
        potential = density - trial.w / 4 * varpi2 + boundary @ trial.weights
        integrands = (1.0, varpi2, potential, density)
        return tuple(float((volume * density * integrand).sum()) for integrand in integrands)  # pyright: ignore[reportReturnType]

    @property
    def polar_moment_ratio_equatorial(self) -> float:
        """C/(M a^2)."""
        return self._volume_integrals[1] / self.trial.mass / float(self.trial.r[-2]) ** 2

    @property
    def equatorial_moment_ratio_equatorial(self) -> float:
        """A/(M a^2), which is C/(M a^2) - J_2."""
        return self.polar_moment_ratio_equatorial - float(self.zonal_harmonics[0])

    @property
    def moment_ratio(self) -> float:
        """Mean moment over M R_mean^2."""
        mean = self.polar_moment_ratio_equatorial - 2 / 3 * float(self.zonal_harmonics[0])
        return mean * (self.equatorial_radius / self.mean_radius) ** 2

    @property
    def polar_moment(self) -> float:
        """C."""
        return self.polar_moment_ratio_equatorial * self.mass * self.equatorial_radius**2

    @property
    def equatorial_moment(self) -> float:
        """A."""
        return self.equatorial_moment_ratio_equatorial * self.mass * self.equatorial_radius**2

    @property
    def mean_moment(self) -> float:
        """(2A + C)/3."""
        return (2 * self.equatorial_moment + self.polar_moment) / 3

    @property
    def rotational_to_gravitational(self) -> float:
        """T/|W|."""
        _, varpi2, potential, _ = self._volume_integrals
        return self.trial.w * varpi2 / 2 / potential

    @property
    def gravitational_energy(self) -> float:
        """W, from the potential of the body (not from the virial theorem)."""
        return -self.constant * self._density_unit**2 * (self.mean_radius / self._mean) ** 3 * self._volume_integrals[2]

    @property
    def virial_error(self) -> float:
        """(2 T + W + 3 integral P dV)/|W|: zero for an exact solution, of second order in its error."""
        _, varpi2, potential, square = self._volume_integrals
        return (self.trial.w * varpi2 - potential + 3 * square) / potential

    def _dimensionless_density(self, r, mu) -> np.ndarray:
        r, mu = np.broadcast_arrays(np.asarray(r, float), np.asarray(mu, float))
        return self.trial.w + np.tensordot(self.trial.unknowns[:-1], self.trial.basis.helmholtz_solutions(r, mu)[0], 1)

    def surface_radius(self, mu) -> np.ndarray:
        """Radius of the surface (points,) at mu = cos(colatitude); NumericalError where it is not found."""
        mu = np.abs(np.atleast_1d(np.asarray(mu, dtype=float)))
        order = np.argsort(self.trial.mu)
        guess = np.interp(mu, self.trial.mu[order], self.trial.swelling[order])
        at_mu = find_surface(self.trial.basis, self.trial.unknowns, mu, np.zeros_like(mu), guess)
        if at_mu is None:
            raise NumericalError("the surface of the rotating polytrope was not found at the points asked for")
        return at_mu.r * self.mean_radius / self._mean

    @with_quantities(r="m")
    def density(self, r, mu) -> np.ndarray:
        """Density at radius r and mu = cos(colatitude), of any shapes that broadcast; zero outside."""
        r, mu = np.broadcast_arrays(np.asarray(r, float), np.asarray(mu, float))
        inside = r < self.surface_radius(mu.ravel()).reshape(mu.shape)
        density = self._dimensionless_density(np.where(inside, r, 0.0) * self._mean / self.mean_radius, mu)
        return np.where(inside, density * self._density_unit, 0.0)

    @with_quantities(r="m")
    def pressure(self, r, mu) -> np.ndarray:
        """Pressure K rho^2 at radius r and mu = cos(colatitude), of any shapes that broadcast; zero outside."""
        return self.constant * self.density(r, mu) ** 2

    @with_quantities()
    def rescaled(self, mass: float, mean_radius: float, gravitational_constant: float) -> "RotatingPolytrope":
        """The same figure with another mass, mean radius and G; ValueError unless they are positive and finite."""
        scale = {"mass": mass, "mean_radius": mean_radius, "gravitational_constant": gravitational_constant}
        require_positive(**scale)
        return replace(self, **scale)


def _ratios(body: RotatingPolytrope) -> np.ndarray:
    return np.array(
        [body.flattening, body.rotation_parameter, body.polar_moment_ratio_equatorial, *body.zonal_harmonics[:3]]
    )


def _converged(quantity: str, target: float, start: Trial, degrees, tolerance: float) -> RotatingPolytrope:
    """Raise the degree until two in turn agree to the tolerance."""
    before, error = None, math.inf
    for degree in degrees:
        trial = newton(rebased(start, degree), quantity, target)
        if trial is None:  # a low degree may shed mass before the target
            continue
        body = RotatingPolytrope(trial, error)
        ratios = _ratios(body)
        if before is not None:
            error = float(
                np.max(np.abs(ratios - before) / np.maximum(np.abs(ratios), max(_ROUND_OFF / tolerance, 1e-300)))
            )
            if error <= tolerance:
                return replace(body, truncation_error=error)
        before, start = ratios, trial
    outcome = f"with {quantity} = {target:.9g} has converged to {error:.1e} only, not to {tolerance:.1e}"
    met = f": a tolerance of {10.0 ** math.ceil(math.log10(error)):.0e} is met" if error < 1 else ""
    raise NumericalError(f"the rotating polytrope {outcome}{met}")


@with_quantities()
@lru_cache(maxsize=8)
def mass_shedding(tolerance: float = 1e-5) -> RotatingPolytrope:
    """Return the figure of mass shedding (unit mass, mean radius and G), whose equator is a cusp without gravity.

    q = 1.10339, c/a = 0.556978, T/|W| = 0.1028247, Omega^2/(4 pi G rho_c) = 0.0418720. Test: the hard ones.

    >>> body = mass_shedding()
    >>> print(f"{body.rotation_parameter:.3f} {body.axis_ratio:.4f}")
    1.103 0.5570
    """
    return _converged("saddle", 0.0, _milestones()[-1], _DEGREES, tolerance)


@with_quantities()
def rotating_polytrope(
    rotation_parameter: float | None = None,
    *,
    small_m: float | None = None,
    central_rotation_parameter: float | None = None,
    axis_ratio: float | None = None,
    mass: float = 1.0,
    mean_radius: float = 1.0,
    gravitational_constant: float = 1.0,
    tolerance: float = 1e-10,
    degree: int | None = None,
) -> RotatingPolytrope:
    """Return the rigidly rotating polytrope of index 1 with one given measure of its rotation.

    rotation_parameter: Omega^2 a^3/(G M), a the equatorial radius; small_m: Omega^2 R_mean^3/(G M);
    central_rotation_parameter: Omega^2/(4 pi G rho_c); axis_ratio: c/a. The degree rises until two in turn agree to
    `tolerance` in flattening, q, C/(M a^2), J_2, J_4 and J_6 (relative, down to round-off); a given even `degree` is
    used as it is, and `truncation_error` tells what it has reached against three quarters of it. ValueError for an
    argument out of range; NumericalError beyond mass shedding, or so close to it that the tolerance is not reached.
    Test: tests/unit/bodies/test_spectral_polytrope.py.

    >>> body = rotating_polytrope(0.0892)  # Jupiter's Omega^2 a^3/(G M)
    >>> print(f"{body.zonal_harmonics[0]:.4f} {body.flattening:.3f}")  # of Jupiter 0.0147 and 0.065
    0.0140 0.064
    """
    options = {
        "rotation_parameter": rotation_parameter,
        "small_m": small_m,
        "central_rotation_parameter": central_rotation_parameter,
        "flattening": None if axis_ratio is None else 1 - axis_ratio,
    }
    stated = {name: float(value) for name, value in options.items() if value is not None}
    if len(stated) != 1:
        raise ValueError("give one of rotation_parameter, small_m, central_rotation_parameter and axis_ratio")
    [(quantity, target)] = stated.items()
    if not (0 <= target < math.inf):
        raise ValueError("a polytrope needs a finite rotation of zero or more, and an axis ratio of at most one")
    if not tolerance > 0:
        raise ValueError(f"the tolerance has to be positive, not {tolerance}")
    if degree is not None and (degree < 8 or degree % 2):
        raise ValueError(f"the degree of the expansion has to be even and at least 8, not {degree}")
    if target > _FROM_SPHERE[quantity] and target > QUANTITIES[quantity](_milestones()[-1])[0]:
        limit = float(QUANTITIES[quantity](mass_shedding().trial)[0])
        if target > limit:
            raise NumericalError(f"the polytrope sheds mass at {quantity} = {limit:.6g}: {target:.9g} is beyond")
    body = _solution(quantity, target, tolerance, degree)
    return body.rescaled(mass, mean_radius, gravitational_constant)


@lru_cache(maxsize=64)
def _solution(quantity: str, target: float, tolerance: float, degree: int | None) -> RotatingPolytrope:
    start = _start(quantity, target)
    if degree is None:
        return _converged(quantity, target, start, _DEGREES, tolerance)
    return _converged(quantity, target, start, (2 * (3 * degree // 8), degree), math.inf)
