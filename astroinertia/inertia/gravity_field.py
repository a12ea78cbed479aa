"""The gravity field outside a body as spherical harmonics, and the inertia tensor from it and back.

    V = -(G M/r) sum_l (R/r)^l sum_m P_lm(sin latitude) (C_lm cos m longitude + S_lm sin m longitude)

Longitude is from x, latitude from the plane z = 0. Normalisations and the sign of Condon and Shortley are named as in
pyshtools: "4pi" (geodesy: the mean square of each harmonic over the sphere is 1), "ortho" (their integral is 1),
"schmidt" and "unnorm"; csphase 1 leaves (-1)^m out of P_lm and -1 puts it in. Lengths and masses are in any units.

All sums run over R_lm = r^l P_lm exp(i m longitude)/(l + m)!, whose derivatives are those of degree l - 1. By Euler's
theorem the integral of one over a simplex with corners a, b, ... follows from the same of degree l - 1 and from that
over the simplex without a: (l + k) S_l(a, b, ...) = S_l(b, ...) + a . grad S_(l-1)(a, b, ...), k its dimension. That is
exact, and stable: with normalised harmonics no factor exceeds 1 for corners within R. Sources: Werner 1997, Computers
& Geosciences 23, 1071, and Jamet & Thomas 2004, Proc. 2nd GOCE workshop, for polyhedra by recursion; Hofmann-Wellenhof
& Moritz 2006, Physical Geodesy, sections 2.5 to 2.10.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from astroinertia.inertia.mesh import mesh_body
from astroinertia.inertia.orthogonal import require_orthogonal
from astroinertia.inertia.principal import principal_frame
from astroinertia.inertia.tensor import centre_of_mass, namespace, require_plausible
from astroinertia.process.quantities import with_quantities
from astroinertia.process.vectors import require_components

Array = Any

MAX_DEGREE = 80  # factorials of 2 MAX_DEGREE are numbers of float64
NORMALIZATIONS = ("4pi", "ortho", "schmidt", "unnorm")
_TOGETHER = 2048  # simplices at a time, which the cache holds


@dataclass(frozen=True, eq=False)
class GravityField:
    """The field of a mass with a reference radius R about the origin; fields of one origin and R add up.

    coefficients (2, L + 1, L + 1): C_lm and S_lm by [0 or 1, l, m], "4pi" without the phase. Those of degree 1 are the
    centre of mass: with it in the origin they are 0. A cavity is a body of negative mass.

    >>> shell = ellipsoid_field(8.0, (2.0, 2.0, 2.0), 4, 2.0) + ellipsoid_field(-1.0, (1.0, 1.0, 0.9), 4, 2.0)
    >>> print(shell.mass, f"{shell.zonal_harmonic(2):.6f}")  # the cavity is flattened
    7.0 -0.001357
    """

    mass: float
    radius: float
    coefficients: np.ndarray

    @property
    def degree(self) -> int:
        """The highest degree, L."""
        return self.coefficients.shape[1] - 1

    @with_quantities()
    def normalized(self, normalization: str = "4pi", csphase: int = 1) -> np.ndarray:
        """C_lm and S_lm (2, L + 1, L + 1) in another convention; ValueError for one that is none."""
        return self.coefficients / _convention(self.degree, normalization, csphase)

    def zonal_harmonic(self, degree: int) -> float:
        """J_l = -C_l0, not normalised, about z; ValueError for a degree that the field has not."""
        if not 0 <= degree <= self.degree or degree % 1 != 0:
            raise ValueError(f"the field has the degrees 0 to {self.degree}, not {degree}")
        return float(-self.coefficients[0, int(degree), 0] * math.sqrt(2 * degree + 1))

    @property
    def centre_of_mass(self) -> np.ndarray:
        """(3,), from degree 1."""
        (cosine, sine), scale = self.coefficients[:, 1], self.radius * math.sqrt(3.0)
        return scale * np.array([cosine[1], sine[1], cosine[0]])

    @with_quantities()
    def with_radius(self, radius: float) -> "GravityField":
        """The same field with another reference radius."""
        shares = (self.radius / radius) ** np.arange(self.degree + 1)
        return GravityField(self.mass, radius, self.coefficients * shares[:, None])

    @with_quantities()
    def rotated(self, matrix: Array) -> "GravityField":
        """The field of the body turned about the origin: a point x of it goes to matrix (3, 3) x, which may mirror.

        The body is replaced by a layer of mass on the unit sphere with the same harmonics, at the nodes of a quadrature
        that is exact for them, and the nodes are turned.
        """
        matrix = np.asarray(matrix, dtype=float)
        require_orthogonal(matrix)
        heights, weights = np.polynomial.legendre.leggauss(self.degree + 1)
        turns = np.arange(2 * self.degree + 2) * (np.pi / (self.degree + 1))
        z, longitude = (part.ravel() for part in np.meshgrid(heights, turns, indexing="ij"))
        across = np.sqrt(1 - z**2)
        nodes = np.stack([across * np.cos(longitude), across * np.sin(longitude), z], axis=-1)
        layer = self._sum_over_degrees(nodes) * np.repeat(weights, len(turns)) / (2 * len(turns))
        moments = _moments(layer, (nodes @ matrix.T)[None], self.degree)
        return replace(self, coefficients=_coefficients(moments) * (2 * np.arange(self.degree + 1) + 1)[:, None])

    @with_quantities()
    def potential(self, positions: Array, gravitational_constant: float = 1.0) -> np.ndarray:
        """V (...,) at positions (..., 3) outside the sphere about the origin that holds the body."""
        points = np.asarray(positions, dtype=float)
        square = (points**2).sum(-1)
        inverse = (points * (self.radius / square[..., None])).reshape(-1, 3)
        total = self._sum_over_degrees(inverse).reshape(square.shape)
        return -gravitational_constant * self.mass / np.sqrt(square) * total

    @with_quantities()
    def inertia_tensor(self, polar_moment_ratio: float | None = None, trace: float | None = None) -> np.ndarray:
        """I (3, 3) about the origin, from degree 2 and either C/(M R^2), C the largest principal moment, or tr I.

        ValueError where not just one is given or no body has the tensor. Source: Hofmann-Wellenhof & Moritz 2006, eq.
        2-85; C/(M R^2) itself is what precession tells of a planet.
        """
        if (polar_moment_ratio is None) == (trace is None):
            raise ValueError("give either polar_moment_ratio or trace")
        size, second = self.mass * self.radius**2, self._reduced_quadrupole()
        mean = 0.0 if trace is None else trace / 3
        if polar_moment_ratio is not None:  # C is the mean moment and the largest of tr Q/3 - Q
            mean = polar_moment_ratio * size + np.linalg.eigvalsh(second)[0]
        inertia = mean * np.eye(3) - second
        require_plausible(inertia)
        return inertia

    def in_principal_axes(self) -> "GravityField":
        """The field turned into the principal axes about the origin, z that of the largest moment and x of the least.

        Their directions are arbitrary where moments are equal.
        """
        return self.rotated(principal_frame(-self._reduced_quadrupole())[1])

    def _reduced_quadrupole(self) -> np.ndarray:
        """Q - tr(Q)/3 1 (3, 3), from degree 2."""
        if self.degree < 2:
            raise ValueError(f"a tensor needs a field to degree 2 at least, and this one ends at {self.degree}")
        cosine, sine = self.mass * self.radius**2 * self.normalized("unnorm")[:, 2, :3]
        z, x, y = 2 / 3 * cosine[0], 2 * cosine[2] - cosine[0] / 3, -2 * cosine[2] - cosine[0] / 3
        return np.array([[x, 2 * sine[2], cosine[1]], [2 * sine[2], y, sine[1]], [cosine[1], sine[1], z]])

    def __add__(self, other: "GravityField") -> "GravityField":
        """The field of both bodies together, to the lower of their degrees; ValueError for another radius."""
        if not isinstance(other, GravityField):
            return NotImplemented
        if self.radius != other.radius or self.mass + other.mass == 0:
            raise ValueError("fields that are added need one reference radius, see with_radius, and a mass together")
        last, mass = min(self.degree, other.degree) + 1, self.mass + other.mass
        mine, theirs = (field.coefficients[:, :last, :last] * (field.mass / mass) for field in (self, other))
        return GravityField(mass, self.radius, mine + theirs)

    def _sum_over_degrees(self, points: np.ndarray) -> np.ndarray:
        """Sum of r^l P_lm (C_lm cos m longitude + S_lm sin m longitude) at points (N, 3)."""
        factors = (self.coefficients[0] - 1j * self.coefficients[1]) * _scale(self.degree)
        total = np.zeros(len(points))
        for start in range(0, len(points), _TOGETHER):
            part = slice(start, start + _TOGETHER)
            for degree, harmonics in enumerate(_integrals(points[None, part], self.degree)):
                total[part] += (factors[degree, : degree + 1] @ harmonics).real
        return total


@with_quantities()
def gravity_field(
    coefficients: Array, mass: float, radius: float, normalization: str = "4pi", csphase: int = 1
) -> GravityField:
    """The field with published C_lm and S_lm (2, L + 1, L + 1), in any of the conventions, as of pyshtools' arrays.

    >>> moon = np.zeros((2, 3, 3))
    >>> moon[0] = [[1, 0, 0], [0, 0, 0], [-2.0321568464e-4, 0, 2.2382963e-5]]  # J2 and C22 of Williams et al. 2014
    >>> field = gravity_field(moon, 7.346e22, 1738e3, "unnorm")
    >>> tensor = field.inertia_tensor(polar_moment_ratio=0.392728 + 2.032157e-4 / 3)
    >>> print((np.diag(tensor) / (field.mass * field.radius**2)).round(5))  # A, B and C
    [0.39255 0.39264 0.3928 ]
    """
    values = np.array(coefficients, dtype=float)
    degree = values.shape[-1] - 1
    if values.ndim != 3 or values.shape != (2, degree + 1, degree + 1) or not np.isfinite(values).all():
        raise ValueError("coefficients must be finite numbers of the shape (2, L + 1, L + 1): C_lm and S_lm")
    degree = _checked(degree, radius, mass)
    return GravityField(float(mass), float(radius), np.tril(values) * _convention(degree, normalization, csphase))


@with_quantities()
def particle_field(
    mass: Array, position: Array, degree: int, radius: float, origin: Array | None = None
) -> GravityField:
    """The field of point masses (N,) at positions (N, 3) about an origin (3,), or about their centre of mass.

    >>> rod = particle_field(np.ones(2), [[0, 0, 1], [0, 0, -1]], degree=4, radius=1.0)
    >>> print(f"{rod.zonal_harmonic(2):.3f} {rod.zonal_harmonic(4):.3f}")  # all of it at the poles
    -1.000 -1.000
    """
    degree = _checked(degree, radius)
    mass, position = np.asarray(mass, dtype=float), np.asarray(position, dtype=float)
    if mass.ndim != 1 or position.shape != (len(mass), 3) or mass.sum() == 0:
        raise ValueError("particles need masses (N,), which do not add up to 0, and positions (N, 3)")
    if not (np.isfinite(mass).all() and np.isfinite(position).all()):
        raise ValueError("a particle has a mass or a position that is not finite: leave it out")
    centre = centre_of_mass(mass, position) if origin is None else np.asarray(origin, dtype=float)
    require_components(origin=centre)
    moments = _moments(mass, (position - centre)[None] / radius, degree)
    return GravityField(float(mass.sum()), float(radius), _coefficients(moments / mass.sum()))


@with_quantities()
def mesh_field(
    vertices: Array, faces: Array, degree: int, radius: float, mass: float | None = None,
    density: float | None = None, origin: Array | None = None,
) -> GravityField:  # fmt: skip
    """The field of the homogeneous body inside a closed mesh, exactly, about an origin (3,) or its centre of mass.

    Vertices (V, 3), faces (F, 3), mass, density and errors as of `mesh.mesh_body`. Each face is the base of a
    tetrahedron whose apex is the origin. 5120 faces take 0.2 s to degree 50.

    >>> from astroinertia.inertia.mesh import icosphere
    >>> vertices, faces = icosphere(3)
    >>> field = mesh_field(vertices * (2.0, 2.0, 1.0), faces, degree=4, radius=2.0, mass=1.0)
    >>> print(f"{field.zonal_harmonic(2):.3f} {field.zonal_harmonic(4):.3f}")  # of the spheroid 0.150, -0.048
    0.149 -0.048
    """
    degree = _checked(degree, radius)
    body = mesh_body(vertices, faces, mass=mass, density=density)
    centre = body.centre if origin is None else np.asarray(origin, dtype=float)
    require_components(origin=centre)
    corners = (np.asarray(vertices, dtype=float) - centre) / radius
    a, b, c = (corners[np.asarray(faces)[:, k]] for k in range(3))
    volumes = (a * np.cross(b, c)).sum(-1)  # six of them
    moments = _moments(volumes, np.stack([a, b, c]), degree) / (np.arange(degree + 1) + 3)[:, None]
    return GravityField(float(body.mass), float(radius), _coefficients(moments / (volumes.sum() / 6)))


@with_quantities()
def ellipsoid_field(mass: float, semi_axes: Array, degree: int, radius: float) -> GravityField:
    """The field of a homogeneous ellipsoid with semi-axes (3,) along x, y and z, about its centre, in closed form.

    It is that of any confocal ellipsoid of the same mass (MacMillan 1930, Theory of the Potential, section 39), so of
    the disc with the semi-axes (a^2 - c^2)^(1/2), (b^2 - c^2)^(1/2) and 0, in which a harmonic of degree l is
    P_lm(0) rho^l exp(i m phi). For a >= b >= c all terms have one sign. Balmino 1994, Celestial Mechanics 60, 331, has
    the same from the axes.

    >>> field = ellipsoid_field(1.0, (3.0, 2.0, 1.0), degree=2, radius=3.0)
    >>> print(field.normalized("unnorm")[0, 2].round(6))  # (2 c^2 - a^2 - b^2)/(10 R^2), 0, (a^2 - b^2)/(20 R^2)
    [-0.122222  0.        0.027778]
    """
    degree = _checked(degree, radius, mass)
    a, b, c = np.asarray(semi_axes, dtype=float)
    if not all(0 <= axis < np.inf for axis in (a, b, c)):
        raise ValueError("the semi-axes of an ellipsoid must be finite numbers, 0 or above")
    wide, narrow = np.sqrt(complex((a - c) * (a + c))) / radius, np.sqrt(complex((b - c) * (b + c))) / radius
    plus, minus = (wide + narrow) / 2, (wide - narrow) / 2  # x + i y = plus w + minus w*, w in the unit circle
    moments = np.zeros((degree + 1, degree + 1), complex)
    for n in range(degree // 2 + 1):
        # Mean of |w|^(2 n) in a homogeneous ball seen from above, times the share of P_lm(0)/(l + m)!.
        square = 3 / (2 * n + 3) * math.prod(2 * k / (2 * k + 1) for k in range(1, n + 1))
        for q in range(n + 1):
            terms = (
                math.comb(n + q, q + i) * math.comb(n - q, i) * plus ** (2 * n - q - 2 * i) * minus ** (q + 2 * i)
                for i in range(n - q + 1)
            )
            equator = (-1) ** (n - q) / (4.0**n * math.factorial(n - q) * math.factorial(n + q))
            moments[2 * n, 2 * q] = square * equator * sum(terms).real
    return GravityField(float(mass), float(radius), _coefficients(moments))


@with_quantities()
def layered_field(densities: Array, semi_axes: Array, degree: int, radius: float) -> GravityField:
    """The field of homogeneous layers between ellipsoids, from the inside out: densities (n,), semi_axes (n, 3).

    The sum of the whole ellipsoids of the steps in density. ValueError for negative densities, and where an ellipsoid
    does not contain the one before. Layers of other shapes are sums of `mesh_field`s of the
    steps likewise.

    >>> core_and_mantle = layered_field((11.0, 4.4), [(3.47, 3.47, 3.46), (6.38, 6.38, 6.36)], 4, 6.38)
    >>> print(f"{core_and_mantle.zonal_harmonic(2):.6f}")  # not far from the Earth's 0.001083
    0.001075
    """
    axes, values = np.asarray(semi_axes, dtype=float), np.asarray(densities, dtype=float)
    if axes.shape != (len(values), 3) or not len(values):
        raise ValueError("layers need densities (n,) and semi-axes (n, 3)")
    if not ((values >= 0) & (values < np.inf)).all() or not values.any():
        raise ValueError("the densities of layers must be finite, not negative and not all 0")
    if not (np.isfinite(axes).all() and (axes > 0).all() and (np.diff(axes, axis=0) >= 0).all()):
        raise ValueError("the semi-axes of layers must be above 0, and none may shrink outwards")
    masses = 4 / 3 * np.pi * (values - np.append(values[1:], 0.0)) * axes.prod(-1)
    parts = [ellipsoid_field(1.0, each, degree, radius).coefficients for each in axes]
    total = float(masses.sum())
    return GravityField(total, float(radius), np.tensordot(masses / total, parts, 1))


@with_quantities()
def zonal_field(mass: float, equatorial_radius: float, zonal_harmonics: Array) -> GravityField:
    """The field of a figure of revolution about z with J2, J4, J6, ... (n,) for its equatorial radius.

    >>> from astroinertia.bodies.figures import figure_of_density
    >>> figure = figure_of_density([1.0], [1.0], small_m=0.05)
    >>> field = zonal_field(figure.mass, figure.equatorial_radius, figure.zonal_harmonics)
    >>> print(field.degree, f"{field.zonal_harmonic(4) / field.zonal_harmonic(2) ** 2:.4f}")  # -15/7, a spheroid
    20 -2.1429
    """
    values = np.zeros((2, 2 * len(zonal_harmonics) + 1, 2 * len(zonal_harmonics) + 1))
    values[0, 0, 0], values[0, 2::2, 0] = 1.0, -np.asarray(zonal_harmonics, dtype=float)
    return gravity_field(values, mass, equatorial_radius, "unnorm")


@with_quantities()
def inertia_field(inertia: Array, mass: float, radius: float) -> GravityField:
    """The field to degree 2 of a body with an inertia tensor (3, 3) about its centre of mass.

    >>> field = inertia_field(np.diag([0.8, 0.8, 1.0]), mass=1.0, radius=2.0)
    >>> print(f"{field.zonal_harmonic(2):.3f}")  # (C - A)/(M R^2)
    0.050
    """
    require_plausible(inertia)
    values = np.zeros((2, 3, 3))
    values[0, 0, 0] = 1.0
    places = ([0, 0, 1, 0, 1], 2, [0, 1, 1, 2, 2])
    values[places] = degree_two_moments(np.asarray(inertia, dtype=float)) / (mass * radius**2)
    return gravity_field(values, mass, radius, "unnorm")


@with_quantities()
def degree_two_moments(inertia: Array) -> Array:
    """C20, C21, S21, C22, S22 (..., 5), not normalised and times M R^2, of inertia tensors (..., 3, 3).

    Source: Hofmann-Wellenhof & Moritz 2006, Physical Geodesy, eq. 2-85.

    >>> print(degree_two_moments(np.diag([1.0, 2.0, 2.5])))  # -(C - (A + B)/2) and (B - A)/4
    [-1.    0.    0.    0.25  0.  ]
    """
    xx, yy, zz = (inertia[..., k, k] for k in range(3))
    xy, xz, yz = inertia[..., 0, 1], inertia[..., 0, 2], inertia[..., 1, 2]
    values = [0.5 * (xx + yy) - zz, 0.0 - xz, 0.0 - yz, 0.25 * (yy - xx), 0.0 - 0.5 * xy]
    return namespace(inertia).stack(values, axis=-1)


def _checked(degree: int, radius: float, mass: float = 0.0) -> int:
    """The degree, a whole number of whatever type; ValueError for what a field cannot have."""
    if not 0 <= degree <= MAX_DEGREE or degree % 1 != 0:
        raise ValueError(f"the degree must be a whole number from 0 to {MAX_DEGREE}, not {degree!r:.40}")
    if not 0 < radius < np.inf:
        raise ValueError(f"the reference radius must be positive, not {radius:g}")
    if not np.isfinite(mass):
        raise ValueError(f"the mass of a field must be a finite number, not {mass:g}")
    return int(degree)


def _orders(degree: int) -> tuple[np.ndarray, np.ndarray]:
    """(l - m)! and (l + m)! (L + 1, L + 1), of which m > l is not used."""
    factorials = np.array([float(math.factorial(n)) for n in range(2 * degree + 1)])
    n, m = np.indices((degree + 1, degree + 1))
    return factorials[abs(n - m)], factorials[n + m]


def _scale(degree: int) -> np.ndarray:
    """The "4pi" harmonic over P_lm/(l + m)!, (L + 1, L + 1)."""
    less, more = _orders(degree)
    n, m = np.indices(less.shape)
    return np.sqrt(np.where(m > 0, 2.0, 1.0) * (2 * n + 1)) * np.sqrt(less) * np.sqrt(more)


def _convention(degree: int, normalization: str, csphase: int) -> np.ndarray:
    """A "4pi" coefficient over that of a convention, (L + 1, L + 1)."""
    if normalization not in NORMALIZATIONS:
        raise ValueError(f"normalization must be one of {', '.join(NORMALIZATIONS)}, not {normalization!r:.40}")
    if csphase not in (1, -1):
        raise ValueError(f"csphase must be 1 or -1, not {csphase!r:.40}")
    less, more = _orders(degree)
    n, m = np.indices(less.shape)
    schmidt = np.sqrt(1 / (2 * n + 1.0))
    factor = {
        "4pi": np.ones(less.shape),
        "ortho": np.full(less.shape, (4 * np.pi) ** -0.5),
        "schmidt": schmidt,
        "unnorm": schmidt * np.sqrt(more / np.where(m > 0, 2.0, 1.0)) / np.sqrt(less),
    }[normalization]
    return factor * np.where(m % 2, csphase, 1)


def _coefficients(moments: np.ndarray) -> np.ndarray:
    """ "4pi" C_lm and S_lm (2, L + 1, L + 1) of mean R_lm (L + 1, L + 1) of a mass, lengths in R."""
    degree = len(moments) - 1
    values = moments * (_scale(degree) / (2 * np.arange(degree + 1) + 1)[:, None])
    return np.stack([values.real, values.imag])


def _moments(weights: np.ndarray, corners: np.ndarray, degree: int) -> np.ndarray:
    """Sum over simplices with corners (k + 1, N, 3) of weights (N,) and the integrals of R_lm, (L + 1, L + 1)."""
    moments = np.zeros((degree + 1, degree + 1), complex)
    for start in range(0, len(weights), _TOGETHER):
        part = slice(start, start + _TOGETHER)
        for n, integrals in enumerate(_integrals(corners[:, part], degree)):
            moments[n, : n + 1] += integrals @ weights[part]
    return moments


def _integrals(corners: np.ndarray, degree: int) -> Iterator[np.ndarray]:
    """Integrals of R_lm (l + 1, N), m from 0 on, over simplices with corners (k + 1, N, 3), by degree from 0 on.

    The measure is that of the barycentric coordinates: of R_00 they are 1/k!. One corner is a point: R_lm there.
    """
    shapes = [np.full((1, corners.shape[1]), 1 / math.factorial(k), complex) for k in range(len(corners))]
    yield shapes[-1]
    for n in range(1, degree + 1):
        lower: Any = 0.0
        for k, corner in enumerate(corners):
            lower = shapes[k] = (lower + _along_gradient(corner, shapes[k])) / (n + k)
        yield lower


def _along_gradient(vector: np.ndarray, harmonics: np.ndarray) -> np.ndarray:
    """a . grad of R_lm, m = 0 to l, (l + 1, N), for vectors a (N, 3), from the R_(l-1)m (l, N).

    d/dz R_lm = R_(l-1)m, (d/dx - i d/dy) R_lm = R_(l-1)(m-1), (d/dx + i d/dy) R_lm = -R_(l-1)(m+1), and of m = -1 it is
    minus the conjugate.
    """
    half = 0.5 * (vector[:, 0] + 1j * vector[:, 1])
    result = np.empty((len(harmonics) + 1, harmonics.shape[1]), complex)
    result[-1] = 0.0
    np.multiply(vector[:, 2], harmonics, out=result[:-1])
    result[1:] += half * harmonics
    result[: len(harmonics) - 1] -= half.conj() * harmonics[1:]
    if len(harmonics) > 1:
        result[0] -= (half.conj() * harmonics[1]).conj()
    return result
