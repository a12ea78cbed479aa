"""Polytropes in synchronous rotation about a distant point mass, tide to second degree: compressible Roche figures.

In the frame that turns with the companion, M' >> M, mu = G M'/d^3 = Omega^2, and the fluid is at rest where

    h + Phi - 3/2 mu x^2 + 1/2 mu z^2 = constant,      h = (n + 1) K rho^(1/n),

x towards the companion, z along the axis. It is solved as a self-consistent field (Hachisu 1986, ApJS 61, 479, and
62, 461): with the ends of the body on x and z held, Phi of the present density gives mu, the constant and h, hence a
new density. Phi is expanded in the spherical harmonics that are even in x, y and z. The limit of Roche is the largest
mu.

Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 8 (homogeneous); Lai, Rasio & Shapiro 1993, ApJS 88,
205 (compressible ellipsoids, the approximation that this does without). Tests:
tests/unit/bodies/test_roche_polytrope.py.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import sph_legendre_p

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.errors import NumericalError
from astroinertia.process.quantities import with_quantities

_DEGREES = 16  # largest degree of the expansion
_RADII = 192
_LEAST_RADII = 16
_HEIGHTS = 24  # cos theta between 0 and 1, by Gauss and Legendre
_ANGLES = 24  # phi between 0 and pi/2, by Gauss and Legendre
_TOLERANCE = 1e-9
_MOST_ITERATIONS = 400
_LIMITS_LIE = (0.42, 0.75)  # c/a at the limit: 0.482 for n = 0, 0.593 for n = 1.5


@dataclass(frozen=True)
class RochePolytrope:
    """A Roche figure; tide is mu over G M/R^3 with R the radius of the same polytrope (M, K) left alone.

    second_moments: of x, y and z over M R^2. virial: |2T + W + tide + 3 int P| over |W|, an independent error.
    """

    index: float
    c_over_a: float
    tide: float
    longest_axis: float
    second_moments: tuple[float, float, float]
    virial: float

    @property
    def scaled_distance(self) -> float:
        """(d/R) (M/M')^(1/3) = tide^(-1/3)."""
        return self.tide ** (-1.0 / 3.0)


@dataclass(frozen=True)
class _Mesh:
    """Radii (R,), harmonics (L, A) at A directions with their weights (A,), degrees (L,), and x, y, z of directions.

    along and above (L,): the harmonics on the axes x and z.
    """

    radius: np.ndarray
    harmonics: np.ndarray
    along: np.ndarray
    above: np.ndarray
    weight: np.ndarray
    degree: np.ndarray
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray


@lru_cache(maxsize=4)
def _mesh(radii: int, degrees: int) -> _Mesh:
    node, weight = np.polynomial.legendre.leggauss(_HEIGHTS)
    z, z_weight = (node + 1) / 2, weight / 2
    node, weight = np.polynomial.legendre.leggauss(_ANGLES)
    phi, phi_weight = (node + 1) * math.pi / 4, weight * math.pi / 4
    z, phi = (grid.ravel() for grid in np.meshgrid(z, phi, indexing="ij"))
    degree, order = np.array([(l_, m) for l_ in range(0, degrees + 1, 2) for m in range(0, l_ + 1, 2)]).T
    norm = np.where(order, math.sqrt(2.0), 1.0)

    def harmonics(theta: Any, phi: Any) -> np.ndarray:
        scale, l_, m = (part.reshape(-1, *[1] * np.ndim(theta)) for part in (norm, degree, order))
        return scale * sph_legendre_p(l_, m, theta)[0] * np.cos(m * phi)

    s = np.sqrt(1 - z * z)
    return _Mesh(
        radius=np.linspace(0.0, 1.0, radii + 1)[1:],
        harmonics=harmonics(np.arccos(z), phi),
        along=harmonics(math.pi / 2, 0.0),
        above=harmonics(0.0, 0.0),
        weight=8 * np.outer(z_weight, phi_weight).ravel(),
        degree=degree,
        x=s * np.cos(phi),
        y=s * np.sin(phi),
        z=z,
    )


def _potential_parts(mesh: _Mesh, density: np.ndarray) -> np.ndarray:
    """Phi_l(r) of each harmonic, (R, L), from the density (R, A): -4 pi/(2l + 1) (inside + outside)."""
    r, degree = mesh.radius, mesh.degree
    part = density * mesh.weight @ mesh.harmonics.T
    step = r[0]
    inner = part * (r[:, None] ** (degree + 2))
    outer = part * (r[:, None] ** (1.0 - degree))
    inside = (np.cumsum(inner, axis=0) - 0.5 * inner) * step
    outside = (np.cumsum(outer[::-1], axis=0)[::-1] - 0.5 * outer) * step
    return -4 * math.pi / (2 * degree + 1) * (inside * r[:, None] ** (-degree - 1.0) + outside * r[:, None] ** degree)


def _at(mesh: _Mesh, parts: np.ndarray, radius: float, harmonics: np.ndarray) -> float:
    """Phi at a radius in the direction of these harmonics."""
    return float(np.array([np.interp(radius, mesh.radius, part) for part in parts.T]) @ harmonics)


@with_quantities()
def roche_polytrope(index: float, c_over_a: float, radii: int = _RADII, degrees: int = _DEGREES) -> RochePolytrope:
    """The figure of that index, 0 < n < 3, with the polar over the longest semi-axis 0 < c/a < 1.

    radii: shells of the mesh; degrees: the highest degree of the expansion, even. ValueError for other numbers than
    these, NumericalError where the iteration does not settle. Tests: virial theorem, Love numbers, the homogeneous
    limit.

    >>> figure = roche_polytrope(1.0, 0.9)
    >>> print(f"{figure.scaled_distance:.2f} (M'/M)^(1/3) R away, virial error {figure.virial:.0e}")
    3.17 (M'/M)^(1/3) R away, virial error 2e-05
    """
    if not 0 < index < 3:
        raise ValueError(f"a polytrope whose radius follows from its mass needs an index 0 < n < 3 here, not {index}")
    if not 0 < c_over_a < 1:
        raise ValueError(f"the polar over the longest semi-axis of a Roche figure is 0 < c/a < 1, not {c_over_a}")
    if not (radii >= _LEAST_RADII and radii % 1 == 0 and degrees >= 2 and degrees % 2 == 0):
        raise ValueError(
            f"a Roche figure needs {_LEAST_RADII} radii or more and an even degree of 2 or more, not {radii!r} and "
            f"{degrees!r}"
        )
    mesh, n, c = _mesh(int(radii), int(degrees)), float(index), float(c_over_a)
    a = 0.95  # of the mesh: where the axis ends
    r = mesh.radius[:, None]
    density = (np.sqrt((r * mesh.x) ** 2 + ((r * mesh.y) ** 2 + (r * mesh.z) ** 2) / c**2) < a).astype(float)
    tide_shape = -1.5 * (r * mesh.x) ** 2 + 0.5 * (r * mesh.z) ** 2
    before = math.inf
    for _ in range(_MOST_ITERATIONS):
        parts = _potential_parts(mesh, density)
        at_a, at_c = _at(mesh, parts, a, mesh.along), _at(mesh, parts, c * a, mesh.above)
        mu = (at_a - at_c) / (1.5 * a**2 + 0.5 * (c * a) ** 2)
        enthalpy = at_a - 1.5 * mu * a**2 - parts @ mesh.harmonics - mu * tide_shape
        # Beyond the end of the axis the tide wins again: only what hangs together with the centre is the body.
        enthalpy = np.where(np.cumsum(enthalpy <= 0, axis=0) > 0, 0.0, enthalpy)
        largest = float(enthalpy.max())
        density = (enthalpy / largest) ** n
        if abs(mu - before) < _TOLERANCE * abs(mu):
            return _figure(mesh, n, c, a, mu, largest, density, parts)
        before = mu
    raise NumericalError(f"no Roche figure of index {index:g} and c/a = {c_over_a:g} was found")


def _figure(mesh, n, c, a, mu, largest, density, parts) -> RochePolytrope:
    volume = mesh.radius[:, None] ** 2 * mesh.radius[0] * mesh.weight
    r, matter = mesh.radius[:, None], density * volume
    mass = float(matter.sum())
    second = tuple(float((matter * (r * axis) ** 2).sum()) for axis in (mesh.x, mesh.y, mesh.z))
    constant = largest / (n + 1)
    radius = (constant / Polytrope(n, mass, 1.0).constant) ** (n / (3 - n))
    gravity = 0.5 * float((matter * (parts @ mesh.harmonics)).sum())
    pressure = constant * float((volume * density ** (1 + 1 / n)).sum())
    outside = mu * (3 * second[0] - second[2])
    return RochePolytrope(
        index=n,
        c_over_a=c,
        tide=mu * radius**3 / mass,
        longest_axis=a / radius,
        second_moments=tuple(moment / (mass * radius**2) for moment in second),
        virial=abs(gravity + outside + 3 * pressure) / abs(gravity),
    )


@with_quantities()
@lru_cache(maxsize=16)
def roche_limit(index: float, radii: int = _RADII, degrees: int = _DEGREES) -> RochePolytrope:
    """The figure with the largest tide, 0.2 <= n <= 1.5: no synchronous polytrope stands nearer to the companion.

    ValueError for another index. Measured: mu to 3e-4 against a mesh twice as fine and half the degrees.

    >>> print(f"{roche_limit(1.0, radii=48, degrees=8).scaled_distance:.2f}")  # nearer than a liquid's, 2.455
    2.23
    """
    if not 0.2 <= index <= 1.5:
        raise ValueError(f"Roche's limit is found for polytropic indices from 0.2 to 1.5, not {index}")
    limit = minimize_scalar(
        lambda c: -roche_polytrope(index, c, radii, degrees).tide,
        bounds=_LIMITS_LIE,
        method="bounded",
        options={"xatol": 1e-3},  # mu is flat there: 1e-5 of it
    )
    return roche_polytrope(index, float(limit.x), radii, degrees)  # type: ignore[union-attr]
