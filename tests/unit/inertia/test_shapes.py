"""Closed forms of shapes against quadrature, random points, a published table, and what scaling demands."""

import inspect
import json
from fractions import Fraction
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.spatial import ConvexHull
from scipy.stats import qmc

from astroinertia.inertia import shapes
from astroinertia.inertia.mesh import icosphere

TABLE = json.loads((Path(__file__).parents[2] / "reference" / "solids.json").read_text())
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)

POLYGON = np.array([[0.0, 0.0], [2.0, 0.1], [1.1, 0.6], [1.4, 2.0], [0.2, 1.3]])  # not convex
TETRAHEDRON = np.array([[0.2, 0.1, -0.3], [1.5, 0.0, 0.2], [0.4, 1.2, 0.1], [0.3, 0.5, 1.9]])
SIZES = {
    "point": ([1.0, 2.0, -0.5],),
    "rod": (1.7,),
    "hoop": (0.9,),
    "disc": (0.9,),
    "annulus": (1.1, 0.4),
    "elliptic_disc": (1.2, 0.5),
    "rectangular_plate": (1.2, 0.5),
    "regular_polygon_plate": (1.3,),
    "triangle_plate": (TETRAHEDRON[:3],),
    "polygon_plate": (POLYGON,),
    "box": (1.2, 0.5, 2.0),
    "hollow_box": (1.2, 0.5, 2.0, 0.1),
    "solid_sphere": (1.4,),
    "thick_spherical_layer": (1.4, 0.9),
    "layered_sphere": ([0.5, 0.9, 1.4],),
    "ellipsoid": ([1.0, 1.4, 0.6],),
    "cylinder": (0.8, 2.5),
    "thick_cylinder": (0.8, 0.3, 2.5),
    "elliptic_cylinder": (0.8, 0.5, 2.5),
    "capsule": (0.8, 1.5),
    "cone": (0.9, 1.7),
    "frustum": (1.2, 0.5, 1.7),
    "rectangular_pyramid": (1.2, 0.5, 2.0),
    "paraboloid": (0.9, 1.7),
    "torus": (1.4, 0.5),
    "hemisphere": (1.4,),
    "spherical_cap": (1.4, 0.5),
    "spherical_sector": (1.4, 0.5),
    "tetrahedron": (TETRAHEDRON,),
    "regular_polyhedron": (1.3,),
    "prism": (POLYGON, 0.7),
    "spherical_shell": (1.4,),
    "homoeoid_shell": ([1.0, 1.4, 0.6],),
    "thin_tube": (0.8, 2.5),
    "closed_can": (0.8, 2.5),
    "cone_shell": (0.9, 1.7),
    "frustum_shell": (1.2, 0.5, 1.7),
    "torus_shell": (1.4, 0.5),
    "hemispherical_shell": (1.4,),
    "spherical_cap_shell": (1.4, 0.5),
}
COUNTS = {"regular_polygon_plate": (7,), "regular_polyhedron": (12,)}
MASSES = {"layered_sphere": np.array([1.0, 0.4, 2.0])}


def body(name, mass=2.0, scale=1.0, sizes=None):
    sizes = SIZES[name] if sizes is None else sizes
    scaled = [scale * (size if hasattr(size, "dtype") else np.asarray(size, float)) for size in sizes]
    return getattr(shapes, name)(MASSES.get(name, 1.0) * mass, *scaled, *COUNTS.get(name, ()))


def test_every_shape_is_in_these_tests():
    assert sorted(SIZES) == sorted(shapes.__all__)


@pytest.mark.parametrize("row", TABLE, ids=lambda row: f"{row['shape']} {row['source'].split(', ', 3)[-1]}")
def test_published_table(row):
    sizes = row["sizes"]
    found = getattr(shapes, row["shape"])(3.0, **sizes)
    point = [eval(each, {}, sizes) for each in row.get("point", ["0", "0", "0"])]
    expected = 3.0 * eval(row["moment_per_mass"], {}, sizes)
    np.testing.assert_allclose(found.moment(row["axis"], point), expected, rtol=1e-14)


def line(start, end):
    """A straight curve (distance from the axis, z) of a parameter in -1..1."""
    return lambda t: tuple(a + (t + 1) / 2 * (b - a) for a, b in zip(start, end, strict=True))


def arc(radius, start, end, centre=(0.0, 0.0)):
    """A piece of a circle, from one angle above the plane z = 0 to another."""

    def curve(t):
        angle = start + (t + 1) / 2 * (end - start)
        return centre[0] + radius * jnp.cos(angle), centre[1] + radius * jnp.sin(angle)

    return curve


UP, LATITUDE = np.pi / 2, np.arcsin(0.9 / 1.4)  # of the rim of the cap of height 0.5 on a sphere of radius 1.4
DOME = arc(1.4, LATITUDE, UP)
SHELLS_OF_REVOLUTION = {  # the curves that are swept, and the height of the centre of mass in their frame
    "hoop": ([arc(1e-9, 0, 4 * UP, centre=(0.9, 0.0))], 0.0),
    "disc": ([line((0, 0), (0.9, 0))], 0.0),
    "annulus": ([line((0.4, 0), (1.1, 0))], 0.0),
    "spherical_shell": ([arc(1.4, -UP, UP)], 0.0),
    "thin_tube": ([line((0.8, -1.25), (0.8, 1.25))], 0.0),
    "closed_can": ([line((0, 0), (0.8, 0)), line((0.8, 0), (0.8, 2.5)), line((0.8, 2.5), (0, 2.5))], 1.25),
    "cone_shell": ([line((0.9, 0), (0, 1.7))], 1.7 / 3),
    "frustum_shell": ([line((1.2, 0), (0.5, 1.7))], 1.7 * 2.2 / (3 * 1.7)),
    "torus_shell": ([arc(0.5, 0, 4 * UP, centre=(1.4, 0.0))], 0.0),
    "hemispherical_shell": ([arc(1.4, 0, UP)], 0.7),
    "spherical_cap_shell": ([DOME], 0.9 + 0.25),
}
SOLIDS_OF_REVOLUTION = {  # curves that are walked downwards cut out of the solid
    "solid_sphere": ([arc(1.4, -UP, UP)], 0.0),
    "thick_spherical_layer": ([arc(1.4, -UP, UP), arc(0.9, UP, -UP)], 0.0),
    "cylinder": ([line((0.8, 0), (0.8, 2.5))], 1.25),
    "thick_cylinder": ([line((0.8, 0), (0.8, 2.5)), line((0.3, 2.5), (0.3, 0))], 1.25),
    "capsule": (
        [arc(0.8, -UP, 0, (0, -0.75)), line((0.8, -0.75), (0.8, 0.75)), arc(0.8, 0, UP, (0, 0.75))],
        0.0,
    ),
    "cone": ([line((0.9, 0), (0, 1.7))], 1.7 / 4),
    "frustum": ([line((1.2, 0), (0.5, 1.7))], 1.7 * (1.44 + 1.2 + 0.75) / (4 * (1.44 + 0.6 + 0.25))),
    "paraboloid": ([lambda t: (0.9 * jnp.sqrt((1 - t) / 2), 0.85 * (t + 1))], 1.7 / 3),
    "torus": ([arc(0.5, -UP, 3 * UP, centre=(1.4, 0.0))], 0.0),
    "hemisphere": ([arc(1.4, 0, UP)], 3 * 1.4 / 8),
    "spherical_cap": ([DOME], 1.4 - 0.5 * (8 * 1.4 - 1.5) / (4 * (3 * 1.4 - 0.5))),
    "spherical_sector": ([line((0, 0), (1.4 * np.cos(LATITUDE), 0.9)), DOME], 3 * 1.4 * (1 + 0.9 / 1.4) / 8),
}


@pytest.mark.parametrize("name", [*SHELLS_OF_REVOLUTION, *SOLIDS_OF_REVOLUTION])
def test_quadrature_of_bodies_of_revolution(name):
    solid = name in SOLIDS_OF_REVOLUTION
    curves, centre = (SOLIDS_OF_REVOLUTION if solid else SHELLS_OF_REVOLUTION)[name]
    sums = np.zeros(4)
    for curve in curves:
        with jax.enable_x64(True):
            point, slope = jax.jvp(curve, (jnp.asarray(NODES),), (jnp.ones(len(NODES)),))
        (distance, z), slope = np.asarray(point), np.asarray(slope)
        weight = WEIGHTS * (distance**2 * slope[1] if solid else distance * np.hypot(*slope))
        across = distance**2 / (4 if solid else 2)
        sums += [weight.sum(), weight @ z, weight @ across, weight @ z**2]
    _, mean, across, along = sums / sums[0]
    np.testing.assert_allclose(mean, centre, atol=1e-13)
    along -= mean**2
    found = body(name)
    expected = 2.0 * np.diag([across + along, across + along, 2 * across])
    np.testing.assert_allclose(found.inertia, expected, rtol=0, atol=2e-12)
    np.testing.assert_array_equal(found.centre, 0.0)


def inside_polygon(x, y):
    """Whether points lie in POLYGON: a ray from each crosses its edges an odd number of times."""
    (x1, y1), (x2, y2) = POLYGON.T[:, :, None], np.roll(POLYGON, -1, axis=0).T[:, :, None]
    crosses = ((y1 > y) != (y2 > y)) & (x < (x2 - x1) * (y - y1) / (y2 - y1) + x1)
    return crosses.sum(0) % 2 == 1


def regular(vertices):
    """Vertices of a regular body, scaled to the edge of SIZES."""
    vertices = np.asarray(vertices, float)
    distances = np.linalg.norm(vertices[:, None] - vertices, axis=-1)
    return vertices * 1.3 / distances[distances > 1e-9].min()


def in_hull(vertices):
    planes = ConvexHull(vertices).equations
    return lambda x, y, z: (planes[:, :3] @ np.stack([x, y, z]) <= -planes[:, 3:]).all(0)


ICOSAHEDRON = icosphere(0)
REGULAR = {
    4: [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)],
    6: [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)],
    8: np.concatenate([np.eye(3), -np.eye(3)]),
    12: ICOSAHEDRON[0][ICOSAHEDRON[1]].mean(1),
    20: ICOSAHEDRON[0],
}
AXES = np.array([1.0, 1.4, 0.6])
MEMBERS = {  # half-sizes of a box about the place `middle` in which points are drawn, and which of them are in
    "rectangular_plate": ((0.6, 0.25, 0), 0, lambda x, y, z: x == x),
    "elliptic_disc": ((1.2, 0.5, 0), 0, lambda x, y, z: (x / 1.2) ** 2 + (y / 0.5) ** 2 < 1),
    "polygon_plate": ((1, 1, 0), (1, 1, 0), lambda x, y, z: inside_polygon(x, y)),
    "prism": ((1, 1, 0.35), (1, 1, 0), lambda x, y, z: inside_polygon(x, y)),
    "regular_polygon_plate": (
        (1.3, 1.3, 0),
        0,
        lambda x, y, z: np.all(
            [x * np.cos(a) + y * np.sin(a) < 1.3 * np.cos(np.pi / 7) for a in 2 * np.pi * (np.arange(7) + 0.5) / 7], 0
        ),
    ),
    "box": ((0.6, 0.25, 1.0), 0, lambda x, y, z: x == x),
    "hollow_box": (
        (0.6, 0.25, 1.0),
        0,
        lambda x, y, z: (abs(x) > 0.5) | (abs(y) > 0.15) | (abs(z) > 0.9),
    ),
    "ellipsoid": (AXES, 0, lambda *x: sum((p / a) ** 2 for p, a in zip(x, AXES, strict=True)) < 1),
    "elliptic_cylinder": ((0.8, 0.5, 1.25), 0, lambda x, y, z: (x / 0.8) ** 2 + (y / 0.5) ** 2 < 1),
    "rectangular_pyramid": (
        (0.6, 0.25, 1.0),
        (0, 0, 0.5),  # the base at z = -h/4
        lambda x, y, z: np.maximum(abs(x) / 0.6, abs(y) / 0.25) < (1.5 - z) / 2.0,
    ),
    "regular_polyhedron": ((2, 2, 2), 0, in_hull(regular(REGULAR[12]))),
}


@pytest.mark.parametrize("name", MEMBERS)
def test_random_points_within(name):
    half, middle, inside = MEMBERS[name]
    unit = qmc.Sobol(3, seed=1).random(2**17) * 2 - 1
    points = unit * half + middle
    points = points[inside(*points.T)]
    found = body(name)
    centre = points.mean(0)
    second = (points - centre).T @ (points - centre) / len(points)
    size = np.sqrt(np.trace(second))
    np.testing.assert_allclose(found.centre, centre, rtol=0, atol=2e-3 * size)
    np.testing.assert_allclose(
        found.inertia, 2.0 * (np.trace(second) * np.eye(3) - second), rtol=0, atol=4e-3 * size**2
    )


@pytest.mark.parametrize("faces", REGULAR)
def test_regular_polyhedra_are_their_tetrahedra(faces):
    vertices = regular(REGULAR[faces])
    hull = ConvexHull(vertices)
    corners = np.concatenate([np.zeros((len(hull.simplices), 1, 3)), vertices[hull.simplices]], axis=1)
    volumes = abs(np.linalg.det(corners[:, 1:])) / 6
    parts = shapes.tetrahedron(2.0 * volumes / volumes.sum(), corners)
    total = parts.about(np.zeros(3)).sum(0)
    np.testing.assert_allclose(shapes.regular_polyhedron(2.0, 1.3, faces).inertia, total, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize(
    ("name", "corners"),
    [pytest.param("triangle_plate", TETRAHEDRON[:3], marks=pytest.mark.full), ("tetrahedron", TETRAHEDRON)],
)
def test_random_points_of_simplices(name, corners):
    # Sorted uniform numbers cut 0..1 into shares of the corners that are uniform over the simplex.
    cuts = np.sort(qmc.Sobol(len(corners) - 1, seed=1).random(2**16), axis=1)
    points = np.diff(cuts, axis=1, prepend=0.0, append=1.0) @ corners
    offsets = points - points.mean(0)
    expected = 2.0 * np.mean([(x @ x) * np.eye(3) - np.outer(x, x) for x in offsets], axis=0)
    np.testing.assert_allclose(body(name).centre, corners.mean(0), rtol=1e-15, atol=1e-16)  # z is 0 but for rounding
    np.testing.assert_allclose(body(name).inertia, expected, rtol=0, atol=1e-3 * np.trace(expected))


def test_points_rods_and_homoeoids():
    np.testing.assert_array_equal(shapes.point(2.0, [1.0, 2.0, 2.0]).inertia, 0.0)
    np.testing.assert_allclose(shapes.point(2.0, [1.0, 2.0, 2.0]).moment([1, 0, 0], [0, 0, 0]), 16.0, rtol=1e-15)
    np.testing.assert_allclose(shapes.rod(2.0, 1.5).about([0, 0, 0.75])[0, 0], 2.0 * 1.5**2 / 3, rtol=1e-15)
    # The layer between two similar ellipsoids is the difference of two solids.
    ratio = 1 - 1e-5
    layer = shapes.ellipsoid(1.0, AXES) - shapes.ellipsoid(ratio**3, ratio * AXES)
    shell = shapes.homoeoid_shell(layer.mass, AXES)
    np.testing.assert_allclose(shell.inertia, layer.inertia, rtol=3e-5)


def test_layers_of_a_sphere_add_up_and_hollows_are_holes():
    layers = [shapes.thick_spherical_layer(m, r, q) for m, r, q in ((1.0, 1.0, 0.0), (0.3, 2.0, 1.0), (2.0, 2.5, 2.0))]
    found = shapes.layered_sphere([1.0, 0.3, 2.0], [1.0, 2.0, 2.5])
    np.testing.assert_allclose(found.inertia, sum(each.inertia for each in layers), rtol=1e-14)
    assert found.mass == 3.3
    # Of no mass in all, as a sphere that has only been filled otherwise: I is the difference that it makes.
    filled = shapes.layered_sphere([1.0, -1.0], [1.0, 2.0])
    apart = shapes.solid_sphere(1.0, 1.0).inertia - shapes.thick_spherical_layer(1.0, 2.0, 1.0).inertia
    assert filled.mass == 0.0 and not filled.centre.any()
    np.testing.assert_allclose(filled.inertia, apart, rtol=1e-14)
    for masses, radii in (((), ()), ((1.0, 2.0), (1.0,)), ((1.0,), (1.0, 2.0)), (1.0, (1.0, 2.0))):
        with pytest.raises(
            ValueError, match="layers are one or more, each with a mass and an outer radius; here masses"
        ):
            shapes.layered_sphere(masses, radii)
    hollow = shapes.box(6.0, 1.0, 2.0, 3.0) - shapes.box(0.4 * 1.4 * 2.4, 0.4, 1.4, 2.4)
    np.testing.assert_allclose(shapes.hollow_box(hollow.mass, 1, 2, 3, 0.3).inertia, hollow.inertia, rtol=1e-13)


@pytest.mark.parametrize(
    ("limit", "known"),
    [
        (lambda s: s.annulus(2.0, 0.9, 0.9), lambda s: s.hoop(2.0, 0.9)),
        (lambda s: s.thick_cylinder(2.0, 0.8, 0.8, 2.5), lambda s: s.thin_tube(2.0, 0.8, 2.5)),
        (lambda s: s.thick_spherical_layer(2.0, 1.4, 1.4), lambda s: s.spherical_shell(2.0, 1.4)),
        (lambda s: s.spherical_cap(2.0, 1.4, 2.8), lambda s: s.solid_sphere(2.0, 1.4)),
        (lambda s: s.spherical_sector(2.0, 1.4, 2.8), lambda s: s.solid_sphere(2.0, 1.4)),
        (lambda s: s.spherical_cap_shell(2.0, 1.4, 2.8), lambda s: s.spherical_shell(2.0, 1.4)),
        (lambda s: s.hollow_box(2.0, 1.2, 0.5, 2.0, 0.25), lambda s: s.box(2.0, 1.2, 0.5, 2.0)),
        (lambda s: s.capsule(2.0, 0.8, 0.0), lambda s: s.solid_sphere(2.0, 0.8)),
        (lambda s: s.torus(2.0, 1.4, 1.4), lambda s: s.torus(2.0, 1.4, 1.4 * (1 - 1e-15))),
        (lambda s: s.torus_shell(2.0, 1.4, 1.4), lambda s: s.torus_shell(2.0, 1.4, 1.4 * (1 - 1e-15))),
    ],
)
def test_the_utmost_sizes_are_those_of_other_shapes(limit, known):
    np.testing.assert_allclose(limit(shapes).inertia, known(shapes).inertia, rtol=1e-14, atol=1e-15)


@given(st.integers(1, 15))
def test_thin_walls_lose_no_digits(digits):
    outer, inner = 1.0, 1.0 - 10.0**-digits
    big, small = Fraction(outer), Fraction(inner)
    expected = float(Fraction(2, 5) * (big**5 - small**5) / (big**3 - small**3))
    np.testing.assert_allclose(shapes.thick_spherical_layer(1.0, outer, inner).inertia[0, 0], expected, rtol=1e-15)
    wall = 10.0**-digits
    sides, thin = [Fraction(3), Fraction(2), Fraction(1)], Fraction(wall)
    a, b, c = sides
    p, q, r = (side - 2 * thin for side in sides)
    expected = float((a * b * c * (b**2 + c**2) - p * q * r * (q**2 + r**2)) / (12 * (a * b * c - p * q * r)))
    np.testing.assert_allclose(shapes.hollow_box(1.0, 3.0, 2.0, 1.0, wall).inertia[0, 0], expected, rtol=2e-15)


@given(st.sampled_from(sorted(SIZES)), st.floats(-6, 6), st.floats(-6, 6))
def test_mass_and_length_scale_out(name, mass, length):
    mass, length = 10.0**mass, 10.0**length
    one, other = body(name), body(name, 2.0 * mass, length)
    np.testing.assert_allclose(
        other.inertia / (mass * length**2), one.inertia, rtol=1e-13, atol=1e-14 * abs(one.inertia).max()
    )
    np.testing.assert_allclose(other.centre / length, one.centre, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(other.mass / mass, one.mass, rtol=1e-15)


@pytest.mark.full
@given(st.sampled_from(sorted(SIZES)))
def test_derivatives_by_the_sizes_obey_eulers_identity(name):
    with jax.enable_x64(True):
        sizes = tuple(jnp.asarray(size, float) for size in SIZES[name])
        inertia, change = jax.jvp(jax.jit(lambda *s: body(name, sizes=s).inertia), sizes, sizes)
        inertia, change = np.asarray(inertia), np.asarray(change)
    np.testing.assert_allclose(inertia, body(name).inertia, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(change, 2 * inertia, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("name", SIZES)
def test_batches_and_precision(name):
    scale = np.array([[1.0, 2.0, 0.5], [1.5, 3.0, 0.1]])
    sizes = [s * scale.reshape((2, 3) + (1,) * np.ndim(s)) for s in map(np.asarray, SIZES[name])]
    together = body(name, sizes=sizes)
    assert together.inertia.shape == (2, 3, 3, 3) and together.centre.shape == (2, 3, 3)
    assert together.mass.shape == (2, 3)
    np.testing.assert_allclose(together.inertia[1, 2], body(name, scale=0.1).inertia, rtol=1e-13, atol=1e-16)
    mass = np.asarray(MASSES.get(name, 1.0), np.float32)
    single = getattr(shapes, name)(mass, *(np.asarray(s, np.float32) for s in SIZES[name]), *COUNTS.get(name, ()))
    assert {each.dtype for each in (single.mass, single.centre, single.inertia)} == {np.dtype(np.float32)}


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: shapes.solid_sphere(1.0, -1.0), "the radius of a shape must be finite and above 0, not -1"),
        (lambda: shapes.rod(1.0, np.array([1.0, 0.0])), "the length of a shape must be finite and above 0, not 0"),
        (lambda: shapes.rod(np.nan, 1.0), "the mass of a shape must be finite"),
        (lambda: shapes.annulus(1.0, 1.0, 1.1), "inner radius of an annulus must not exceed"),
        (lambda: shapes.thick_spherical_layer(1.0, 1.0, 1.1), "inner radius of a spherical layer must not exceed"),
        (lambda: shapes.thick_cylinder(1.0, 1.0, 1.1, 1.0), "inner radius of a tube must not exceed"),
        (lambda: shapes.hollow_box(1.0, 1.0, 1.0, 0.2, 0.11), "must not be thicker than half"),
        (lambda: shapes.torus(1.0, 1.0, 1.1), "must not be wider than its ring"),
        (lambda: shapes.spherical_cap(1.0, 1.0, 2.1), "must not exceed the diameter"),
        (lambda: shapes.torus_shell(1.0, 1.0, 1.1), "must not be wider than its ring"),
        (lambda: shapes.spherical_sector(1.0, 1.0, 2.1), "must not exceed the diameter"),
        (lambda: shapes.spherical_cap_shell(1.0, 1.0, 2.1), "must not exceed the diameter"),
        (lambda: shapes.point(1.0, 5.0), "must have shape"),
        (lambda: shapes.layered_sphere([1.0, 1.0], [2.0, 1.0]), "grow outwards"),
        (lambda: shapes.layered_sphere([1.0, 1.0], [2.0, 2.0]), "grow outwards"),
        (lambda: shapes.ellipsoid(1.0, [1.0, 2.0]), r"must have shape \(..., 3\), not \(2,\)"),
        (lambda: shapes.tetrahedron(1.0, np.full((4, 3), np.inf)), "the vertices of a tetrahedron must be finite"),
        (lambda: shapes.polygon_plate(1.0, [[0, 0], [1, 1], [2, 2]]), "enclose no area"),
        (lambda: shapes.polygon_plate(1.0, [[0, 0], [1, 1]]), "at least 3 corners"),
        (lambda: shapes.regular_polyhedron(1.0, 1.0, 10), "4, 6, 8, 12 or 20 faces, not 10"),
        (lambda: shapes.regular_polygon_plate(1.0, 1.0, 2), "at least 3 corners, not 2"),
        (lambda: shapes.regular_polygon_plate(1.0, 1.0, np.inf), "whole number of at least 3 corners, not inf"),
        (lambda: shapes.frustum(1.0, 0.0, 0.0, 1.0), "one of the radii of a frustum"),
        (lambda: shapes.frustum_shell(1.0, 0.0, 0.0, 1.0), "one of the radii of a frustum"),
    ],
)
def test_impossible_sizes_are_refused_with_a_sentence(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()


@pytest.mark.parametrize("name", SIZES)
def test_a_size_that_cannot_be_is_named_as_in_the_signature(name):
    names = list(inspect.signature(getattr(shapes, name)).parameters)[1:]
    for place, (argument, size) in enumerate(zip(names, SIZES[name], strict=False)):
        if np.ndim(size) == 0:
            sizes = [-1.0 if k == place else other for k, other in enumerate(SIZES[name])]
            with pytest.raises(ValueError, match=f"^the {argument.replace('_', ' ')} of a shape must be finite"):
                body(name, sizes=sizes)


def test_polygons_far_away_and_either_way_round_keep_their_digits():
    corners = np.round(POLYGON * 1024) / 1024  # which are moved without rounding
    near = shapes.polygon_plate(1.0, corners)
    for away in (2.0**20, 2.0**40):
        far = shapes.polygon_plate(1.0, corners[::-1] + away)
        np.testing.assert_allclose(far.inertia, near.inertia, rtol=0, atol=1e-15)
        np.testing.assert_allclose(far.centre[:2], near.centre[:2] + away, rtol=2e-16)


@pytest.mark.parametrize("size", [1e18, 1e-18])  # whose squares are numbers of single precision
@pytest.mark.parametrize("name", SIZES)
def test_sizes_in_single_precision_neither_overflow_nor_vanish(name, size):
    mass, *sizes = (np.float32(each) for each in (MASSES.get(name, 1.0), *SIZES[name]))
    scaled = [np.float32(size) * each for each in sizes]
    found = getattr(shapes, name)(2 * mass, *scaled, *COUNTS.get(name, ())).inertia
    assert found.dtype == np.float32
    expected = body(name).inertia
    np.testing.assert_allclose(found.astype(float) / size / size, expected, atol=1e-6 * abs(expected).max())


def test_a_cone_may_stand_on_its_tip():
    up, down = shapes.frustum(2.0, 3.0, 0.5, 4.0), shapes.frustum(2.0, 0.5, 3.0, 4.0)
    np.testing.assert_allclose(up.inertia, down.inertia, rtol=1e-15)
    np.testing.assert_allclose(
        shapes.frustum(2.0, 0.0, 3.0, 4.0).inertia, shapes.cone(2.0, 3.0, 4.0).inertia, rtol=1e-15
    )
    tip_down, tip_up = shapes.frustum_shell(2.0, 0.0, 3.0, 4.0), shapes.cone_shell(2.0, 3.0, 4.0)
    np.testing.assert_allclose(tip_down.inertia, tip_up.inertia, rtol=1e-15)
