"""Harmonics of gravity fields against closed forms, exact sums and quadrature; the tensor there and back."""

import math
from fractions import Fraction

import numpy as np
import pytest
from astropy import units as u
from scipy.spatial.transform import Rotation
from scipy.special import lpmv, roots_jacobi, sph_harm_y

from astroinertia.errors import AstroinertiaError
from astroinertia.inertia import realise
from astroinertia.inertia.gravity_field import (
    NORMALIZATIONS,
    GravityField,
    ellipsoid_field,
    gravity_field,
    inertia_field,
    layered_field,
    mesh_field,
    particle_field,
)
from astroinertia.inertia.mesh import icosphere, mesh_body
from astroinertia.inertia.tensor import inertia_tensor

TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
TURN = Rotation.from_euler("ZYX", [0.4, -1.1, 2.3]).as_matrix()


def particles(count=20, seed=1):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.5, 1.5, count), rng.normal(size=(count, 3))


def harmonic(n, m, points):
    """r^l times the geodetic harmonics with cosine and sine, by scipy, which has the phase of Condon and Shortley."""
    x, y, z = np.moveaxis(points, -1, 0)
    r = np.sqrt(x**2 + y**2 + z**2)
    polar = np.arccos(np.divide(z, r, out=np.ones_like(r), where=r > 0))
    value = (-1) ** m * sph_harm_y(n, m, polar, np.arctan2(y, x)) * r**n
    value = value * math.sqrt(4 * math.pi * (2 if m else 1))
    return np.stack([value.real, value.imag])


def exact_moment(n, m, squares):
    """Mean of r^l P_lm cos m longitude/(l + m)! over a homogeneous ellipsoid, by its monomials, as a fraction."""
    total = Fraction(0)
    for k in range((n - m) // 2 + 1):
        scale = Fraction((-1) ** k, 2 ** (2 * k + m) * math.factorial(k + m) * math.factorial(k))
        scale /= math.factorial(n - m - 2 * k)
        for p in range(0, m + 1, 2):  # (x + i y)^m (x^2 + y^2)^k, the real part
            for q in range(k + 1):
                powers = (m - p + 2 * (k - q), p + 2 * q, n - m - 2 * k)
                if not any(power % 2 for power in powers):
                    sign = (-1) ** (p // 2) * math.comb(m, p) * math.comb(k, q)
                    total += scale * sign * mean_of_powers(powers, squares)
    return total


def mean_of_powers(powers, squares):
    """Mean of x^i y^j z^k, i, j and k even, over an ellipsoid with these squares of its semi-axes."""
    value = Fraction(3, sum(powers) + 3)
    for odd in range(3, sum(powers) + 2, 2):
        value /= odd
    for power, square in zip(powers, squares, strict=True):
        value *= square ** (power // 2) * math.prod(range(1, power, 2))
    return value


@pytest.mark.parametrize("axes", ["10 9 7", "6 9 10", "8 8 10", "10 10 5", "10 7 9"])
def test_ellipsoids_are_those_of_exact_arithmetic_to_degree_50(axes: str) -> None:
    a, b, c = (Fraction(int(part), 10) for part in axes.split())
    field = ellipsoid_field(1.0, (float(a), float(b), float(c)), degree=50, radius=1.0)
    for n, m in ((2, 0), (2, 2), (4, 4), (12, 6), (20, 0), (31, 3), (50, 0), (50, 24), (50, 50)):
        exact = exact_moment(n, m, (a * a, b * b, c * c))
        size = Fraction((1 if m == 0 else 2) * math.factorial(n - m) * math.factorial(n + m), 2 * n + 1)
        expected = math.copysign(math.sqrt(exact * exact * size), exact)
        # Terms of one sign lose nothing; with c between a and b they cancel.
        assert field.coefficients[0, n, m] == pytest.approx(
            expected, rel=1e-11, abs=1e-30 if axes != "10 7 9" else 1e-16
        )
    assert not field.coefficients[1].any() and not field.coefficients[:, 1::2].any()


def test_particles_are_the_sums_over_harmonics_to_degree_50() -> None:
    mass, place = particles()
    place[0], place[1] = (0.0, 0.0, 0.0), (0.0, 0.0, -2.0)
    field = particle_field(mass, place, degree=50, radius=4.0, origin=np.zeros(3))
    for n in range(51):
        for m in range(n + 1):
            expected = harmonic(n, m, place / 4.0) @ mass / mass.sum() / (2 * n + 1)
            np.testing.assert_allclose(field.coefficients[:, n, m], expected, rtol=0, atol=1e-15)


def by_quadrature(vertices, faces, orders, radius, nodes):
    """C_lm and S_lm about the origin, from the product of Gauss and Jacobi on the tetrahedra below the faces."""
    (t, wt), (s, ws), (r, wr) = (
        (0.5 + x / 2, w / 2 ** (k + 1)) for k in (2, 1, 0) for x, w in [roots_jacobi(nodes, 0, k)]
    )
    t, s, r = (part.reshape(-1, 1, 1) for part in np.meshgrid(t, s, r, indexing="ij"))
    weights = np.einsum("i,j,k->ijk", wt, ws, wr).ravel()
    a, b, c = (vertices[faces[:, k]] / radius for k in range(3))
    points = t * ((1 - s) * a + s * ((1 - r) * b + r * c))
    weights = weights[:, None] * np.linalg.det(np.stack([a, b, c], axis=1))
    return [(harmonic(n, m, points) * weights).sum((1, 2)) / (2 * n + 1) / weights.sum() for n, m in orders]


def test_a_tetrahedron_beside_the_origin_is_integrated_exactly_to_degree_50() -> None:
    vertices = np.array([[1.0, 0.2, 0.1], [0.3, 0.9, -0.4], [0.2, -0.1, 0.8], [1.1, 0.7, 0.9]])
    faces = TETRAHEDRON if mesh_volume_sign(vertices) > 0 else TETRAHEDRON[:, ::-1]
    field = mesh_field(vertices, faces, degree=50, radius=1.7, mass=3.0, origin=np.zeros(3))
    orders = [(1, 0), (2, 1), (3, 3), (17, 8), (50, 0), (50, 31), (50, 50)]
    expected = by_quadrature(vertices, faces, orders, 1.7, nodes=27)
    for (n, m), value in zip(orders, expected, strict=True):
        np.testing.assert_allclose(field.coefficients[:, n, m], value, rtol=0, atol=1e-15)
    np.testing.assert_allclose(field.centre_of_mass, vertices.mean(0), rtol=1e-14)


def mesh_volume_sign(vertices):
    return np.linalg.det(vertices[1:] - vertices[0])


def bumpy(subdivisions=2):
    vertices, faces = icosphere(subdivisions)
    return vertices * (1 + 0.2 * np.sin(3 * vertices[:, :1] + 5 * vertices[:, 1:2] * vertices[:, 2:])), faces


def test_a_mesh_has_the_coefficients_of_its_tetrahedra_and_the_tensor_of_its_body() -> None:
    vertices, faces = bumpy()
    body = mesh_body(vertices, faces, density=2.0)
    field = mesh_field(vertices, faces, degree=8, radius=1.2, density=2.0)
    orders = [(n, m) for n in range(9) for m in range(n + 1)]
    expected = by_quadrature(vertices - body.centre, faces, orders, 1.2, nodes=6)
    for (n, m), value in zip(orders, expected, strict=True):
        np.testing.assert_allclose(field.coefficients[:, n, m], value, rtol=0, atol=1e-15)
    tensor = field.inertia_tensor(trace=np.trace(body.inertia))
    np.testing.assert_allclose(tensor, body.inertia, rtol=0, atol=1e-14 * abs(body.inertia).max())
    assert field.mass == pytest.approx(float(body.mass), rel=1e-15)


def test_facets_approach_the_ellipsoid_by_the_square_of_their_size() -> None:
    axes = np.array([1.0, 0.8, 0.6])
    exact = ellipsoid_field(1.0, axes, 8, 1.0).coefficients
    errors = []
    for subdivisions in (2, 3, 4):
        vertices, faces = icosphere(subdivisions)
        errors.append(abs(mesh_field(vertices * axes, faces, 8, 1.0, mass=1.0).coefficients - exact).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.3) and errors[1] / errors[2] == pytest.approx(4.0, abs=0.1)


def test_the_potential_outside_is_that_of_the_masses() -> None:
    mass, place = particles()
    field = particle_field(mass, place, degree=50, radius=1.0)
    centre = mass @ place / mass.sum()
    largest = np.linalg.norm(place - centre, axis=1).max()
    points = 3 * largest * np.array([[0.6, 0.0, 0.8], [0.0, 0.0, -1.0], [-0.48, 0.64, 0.6]])
    distances = np.linalg.norm(points[:, None] - (place - centre), axis=2)
    np.testing.assert_allclose(field.potential(points, 2.0), -2.0 * (1 / distances) @ mass, rtol=1e-14)


@pytest.mark.parametrize("normalization", NORMALIZATIONS)
@pytest.mark.parametrize("csphase", [1, -1])
def test_conventions_are_those_of_their_names(normalization: str, csphase: int) -> None:
    """The sum of coefficients times scipy's functions in that convention is the same in each."""
    mass, place = particles()
    field = particle_field(mass, place, degree=7, radius=2.0)
    values = field.normalized(normalization, csphase)
    polar, longitude = 0.7, 2.1
    total = 0.0
    for n in range(8):
        for m in range(n + 1):
            wave = np.array([math.cos(m * longitude), math.sin(m * longitude)])
            ratio = math.factorial(n - m) / math.factorial(n + m)
            two = 2 if m else 1
            factor = {
                "unnorm": 1.0,
                "schmidt": math.sqrt(two * ratio),
                "4pi": math.sqrt(two * (2 * n + 1) * ratio),
                "ortho": math.sqrt(two * (2 * n + 1) * ratio / (4 * math.pi)),
            }[normalization]
            legendre = lpmv(m, n, math.cos(polar)) * (1 if csphase == -1 else (-1) ** m)
            total += values[:, n, m] @ wave * factor * legendre / 3.0**n
    point = 6.0 * np.array(
        [math.sin(polar) * math.cos(longitude), math.sin(polar) * math.sin(longitude), math.cos(polar)]
    )
    assert -field.mass / 6.0 * total == pytest.approx(float(field.potential(point)), rel=1e-14)
    again = gravity_field(values, field.mass, field.radius, normalization, csphase)
    np.testing.assert_allclose(again.coefficients, field.coefficients, rtol=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize("matrix", [TURN, np.diag([1.0, 1.0, -1.0]), -TURN], ids=["turned", "mirrored", "both"])
def test_a_turned_body_has_the_turned_field(matrix: np.ndarray) -> None:
    mass, place = particles()
    field = particle_field(mass, place, degree=50, radius=4.0)
    turned = particle_field(mass, place @ matrix.T, degree=50, radius=4.0)
    np.testing.assert_allclose(field.rotated(matrix).coefficients, turned.coefficients, rtol=0, atol=5e-14)


def test_in_principal_axes_it_is_that_of_the_body_at_rest_in_them() -> None:
    axes = (1.0, 0.8, 0.6)
    upright = ellipsoid_field(1.0, axes, degree=12, radius=1.0)
    turned = upright.rotated(TURN).in_principal_axes()
    np.testing.assert_allclose(turned.coefficients, upright.coefficients, rtol=0, atol=1e-14)


def test_the_tensor_goes_there_and_back() -> None:
    for seed in range(20):
        mass, place = particles(8, seed)
        inertia = inertia_tensor(mass, place, mass @ place / mass.sum())
        total, size = mass.sum(), abs(inertia).max()
        field = inertia_field(inertia, total, 1.5)
        direct = particle_field(mass, place, 2, 1.5).coefficients
        np.testing.assert_allclose(field.coefficients, direct, rtol=0, atol=1e-14)
        largest = np.linalg.eigvalsh(inertia)[-1] / (total * 1.5**2)
        for back in (field.inertia_tensor(largest), field.inertia_tensor(trace=np.trace(inertia))):
            np.testing.assert_allclose(back, inertia, rtol=0, atol=1e-12 * size)
        np.testing.assert_allclose(
            field.with_radius(9.0).inertia_tensor(largest / 36), inertia, rtol=0, atol=1e-12 * size
        )


def test_fields_of_one_origin_add_up() -> None:
    mass, place = particles()
    parts = [particle_field(mass[k::2], place[k::2], 9, 2.0, origin=np.ones(3)) for k in (0, 1)]
    whole = particle_field(mass, place, 9, 2.0, origin=np.ones(3))
    np.testing.assert_allclose((parts[0] + parts[1]).coefficients, whole.coefficients, rtol=0, atol=1e-14)
    np.testing.assert_allclose(1 + whole.centre_of_mass, mass @ place / mass.sum(), rtol=1e-13)
    # A core of density 5 in a mantle of 2, as shells and as meshes of steps in density.
    axes = np.array([[0.5, 0.45, 0.4], [1.0, 0.95, 0.9]])
    layers = layered_field((5.0, 2.0), axes, 4, 1.0)
    steps = [
        ellipsoid_field(rho * 4 / 3 * np.pi * a.prod(), a, 4, 1.0) for rho, a in zip((3.0, 2.0), axes, strict=True)
    ]
    total = steps[0] + steps[1]
    assert layers.mass == pytest.approx(total.mass, rel=1e-15)
    np.testing.assert_allclose(layers.coefficients, total.coefficients, rtol=1e-14, atol=1e-17)


def test_a_body_made_to_order_has_the_field_of_its_tensor() -> None:
    inertia = TURN @ np.diag([0.30, 0.35, 0.4]) @ TURN.T
    planet = realise.layered_ellipsoid(inertia, 1.0, (0.5, 0.2))
    field = planet.gravity_field(degree=6, radius=1.0)
    np.testing.assert_allclose(field.coefficients[:, :3, :3], inertia_field(inertia, 1.0, 1.0).coefficients, atol=1e-12)
    assert abs(field.coefficients[:, 4]).max() > 1e-4


def test_quantities_have_their_units() -> None:
    mass, place = particles()
    plain = particle_field(mass, place, 4, 2.0)
    field = particle_field(mass * u.t, place * u.km, 4, "2 km")
    assert (field.mass, field.radius) == (pytest.approx(1e3 * plain.mass), 2e3)
    np.testing.assert_allclose(field.coefficients, plain.coefficients, rtol=1e-12, atol=1e-15)


PLAIN = GravityField(1.0, 1.0, ellipsoid_field(1.0, (1.0, 1.0, 0.9), 2, 1.0).coefficients)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: ellipsoid_field(1.0, (1, 1, 1), 81, 1.0), "the degree must be a whole number from 0 to 80, not 81"),
        (lambda: ellipsoid_field(1.0, (1, 1, 1), 2.5, 1.0), "the degree must be a whole number from 0 to 80, not 2.5"),
        (lambda: ellipsoid_field(1.0, (1, 1, -1), 2, 1.0), "the semi-axes of an ellipsoid must be finite numbers, 0"),
        (lambda: particle_field([1.0], [[0, 0, 0]], 2, 0.0), "the reference radius must be positive, not 0"),
        (lambda: ellipsoid_field(np.nan, (1, 1, 1), 2, 1.0), "the mass of a field must be a finite number, not nan"),
        (lambda: gravity_field(np.zeros((2, 3, 3)), np.inf, 1.0), "the mass of a field must be a finite number"),
        (
            lambda: particle_field([1.0, np.nan], np.eye(3)[:2], 2, 1.0),
            "a particle has a mass or a position that is not",
        ),
        (lambda: particle_field([1.0, 1.0], np.nan * np.eye(3)[:2], 2, 1.0), "a particle has a mass or a position"),
        (lambda: particle_field([1.0, -1.0], np.eye(3)[:2], 2, 1.0), "particles need masses (N,), which do not add up"),
        (lambda: mesh_field(np.eye(3), [[0, 1, 2]], 2, 1.0, mass=1.0), "the mesh is not closed"),
        (lambda: layered_field((1.0,), [(1, 1, 1), (2, 2, 2)], 2, 1.0), "layers need densities (n,) and semi-axes"),
        (
            lambda: layered_field((1.0, -1.0), [(1, 1, 1), (2, 2, 2)], 2, 1.0),
            "the densities of layers must be",
        ),
        (lambda: layered_field((np.nan,), [(1, 1, 1)], 2, 1.0), "the densities of layers must be"),
        (lambda: layered_field((0.0,), [(1, 1, 1)], 2, 1.0), "the densities of layers must be"),
        (lambda: layered_field((1.0,), [(1, 1, 0)], 2, 1.0), "the semi-axes of layers must be above 0"),
        (
            lambda: layered_field((1.0, 2.0), [(2, 2, 2), (2, 2, 1)], 2, 1.0),
            "the semi-axes of layers must be above 0, and none may shrink",
        ),
        (lambda: gravity_field(np.zeros((3, 3)), 1.0, 1.0), "coefficients must be finite numbers of the shape (2,"),
        (
            lambda: gravity_field(np.zeros((2, 3, 3)), 1.0, 1.0, "full"),
            "normalization must be one of 4pi, ortho, schmidt, unnorm, not 'full'",
        ),
        (lambda: PLAIN.normalized(csphase=0), "csphase must be 1 or -1, not 0"),
        (lambda: PLAIN + PLAIN.with_radius(2.0), "fields that are added need one reference radius"),
        (lambda: PLAIN.rotated(2 * np.eye(3)), "a rotation matrix must be orthogonal"),
        (lambda: PLAIN.inertia_tensor(), "give either polar_moment_ratio or trace"),
        (lambda: ellipsoid_field(1.0, (1, 1, 1), 1, 1.0).inertia_tensor(0.4), "a tensor needs a field to degree 2"),
        (lambda: PLAIN.inertia_tensor(0.06), "no body has these moments"),
        (lambda: inertia_field(np.diag([1.0, 1.0, 3.0]), 1.0, 1.0), "no body has these moments: 1 + 1 < 3"),
    ],
)
def test_what_is_wrong_gets_one_sentence(call, sentence: str) -> None:
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        call()
    assert str(caught.value).startswith(sentence)
    assert isinstance(caught.value, AstroinertiaError) or "fields" in sentence


def test_a_degree_may_be_a_whole_number_of_any_type():
    vertices, faces = icosphere(1.0)  # type: ignore[arg-type]
    for make in (
        lambda degree: particle_field(np.ones(2), [[0, 0, 1], [0, 0, -1]], degree, 1.0),
        lambda degree: mesh_field(vertices, faces, degree, 1.0, mass=1.0),
        lambda degree: layered_field((2.0, 1.0), [(1.0, 1.0, 0.9), (2.0, 2.0, 1.9)], degree, 2.0),
    ):
        np.testing.assert_array_equal(make(4.0).coefficients, make(4).coefficients)
        assert make(np.float64(4.0)).degree == 4
        assert make(4).zonal_harmonic(2.0) == make(4).zonal_harmonic(2)


@pytest.mark.parametrize("degree", [5, -2])
def test_a_degree_that_a_field_has_not_is_refused(degree):
    field = ellipsoid_field(1.0, (3.0, 2.0, 1.0), degree=4, radius=3.0)
    with pytest.raises(ValueError, match=f"the field has the degrees 0 to 4, not {degree}"):
        field.zonal_harmonic(degree)
