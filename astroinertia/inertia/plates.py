"""Closed forms of points, rods, rings and flat plates, homogeneous, as bodies: see `astroinertia.inertia.shapes`."""

import math
from typing import Any

from astroinertia.inertia.body import Body
from astroinertia.inertia.mean_squares import body_of, body_of_simplices, checked, checked_points, refuse
from astroinertia.process.quantities import with_quantities

Array = Any


@with_quantities()
def point(mass: Array, position: Array = (0.0, 0.0, 0.0)) -> Body:
    """A point mass (...,) at a position (..., 3): no inertia about itself, m (|x|^2 1 - x x) about the origin.

    Source: the definition (Goldstein, Poole & Safko 2002, eq. 5.8).

    >>> print(point(2.0, (0.0, 3.0, 0.0)).about((0.0, 0.0, 0.0))[2, 2])  # m r^2
    18.0
    """
    xp, mass, place = checked_points(mass, position, (3,), "the position of a point mass")
    mass = xp.broadcast_to(mass, xp.broadcast_shapes(mass.shape, place.shape[:-1]))
    none = xp.zeros_like(mass)
    return body_of(xp, mass, none, none, none).translated(place)


@with_quantities()
def rod(mass: Array, length: Array) -> Body:
    """A thin rod along z: <z^2> = l^2/12; its ends are at z = -l/2 and l/2, and I about an end is m l^2/3.

    Source: Meriam & Kraige (2012), Engineering Mechanics: Dynamics, Table D/4.

    >>> print(f"{rod(3.0, 2.0).inertia[0, 0]:.4f}")  # m l^2 / 12
    1.0000
    """
    xp, (mass, length) = checked(mass, length=length)
    none = xp.zeros_like(mass)
    return body_of(xp, mass, none, none, length**2 / 12)


@with_quantities()
def hoop(mass: Array, radius: Array) -> Body:
    """A thin ring in the plane z = 0: <x^2> = <y^2> = r^2/2; I_zz = m r^2, and 2 m r^2 about an axis through its edge.

    Source: the definition; every part is at r from the axis.

    >>> print(f"{hoop(3.0, 2.0).inertia[2, 2]:.4f}")  # m R^2
    12.0000
    """
    xp, (mass, radius) = checked(mass, radius=radius)
    return body_of(xp, mass, radius**2 / 2, radius**2 / 2, xp.zeros_like(mass))


@with_quantities()
def disc(mass: Array, radius: Array) -> Body:
    """A thin disc in the plane z = 0: <x^2> = <y^2> = r^2/4; its edge is at x = r.

    Source: Machinery's Handbook, 31st ed. (2020), p. 236, thin circular disk.

    >>> print(f"{disc(3.0, 2.0).inertia[2, 2]:.4f}")  # m R^2 / 2
    6.0000
    """
    xp, (mass, radius) = checked(mass, radius=radius)
    return body_of(xp, mass, radius**2 / 4, radius**2 / 4, xp.zeros_like(mass))


@with_quantities()
def annulus(mass: Array, outer_radius: Array, inner_radius: Array) -> Body:
    """A thin disc in the plane z = 0 with a central hole: <x^2> = <y^2> = (R^2 + r^2)/4; the hole may fill it (a hoop).

    Source: Machinery's Handbook, 31st ed. (2020), p. 236, thin flat circular ring.

    >>> print(f"{annulus(3.0, 2.0, 1.0).inertia[2, 2]:.4f}")  # m (R^2 + r^2) / 2
    7.5000
    """
    xp, (mass, outer, inner) = checked(mass, ("inner_radius",), outer_radius=outer_radius, inner_radius=inner_radius)
    refuse(inner > outer, "the inner radius of an annulus must not exceed its outer radius")
    square = (outer**2 + inner**2) / 4
    return body_of(xp, mass, square, square, xp.zeros_like(mass))


@with_quantities()
def elliptic_disc(mass: Array, semi_axis_x: Array, semi_axis_y: Array) -> Body:
    """A thin elliptic plate in the plane z = 0: <x^2> = a^2/4, <y^2> = b^2/4.

    Source: the disc, stretched, which multiplies mean squares by the squares of the stretches.

    >>> print(np.diag(elliptic_disc(4.0, 2.0, 1.0).inertia))  # m b^2, m a^2 and m (a^2 + b^2), over 4
    [1. 4. 5.]
    """
    xp, (mass, a, b) = checked(mass, semi_axis_x=semi_axis_x, semi_axis_y=semi_axis_y)
    return body_of(xp, mass, a**2 / 4, b**2 / 4, xp.zeros_like(mass))


@with_quantities()
def rectangular_plate(mass: Array, length: Array, width: Array) -> Body:
    """A thin plate in the plane z = 0, length along x and width along y: <x^2> = l^2/12, <y^2> = w^2/12.

    About its edge along y, at x = l/2: I_yy = m l^2/3. Source: Meriam & Kraige (2012), Table D/4, the parallelepiped.

    >>> print(np.diag(rectangular_plate(12.0, 2.0, 1.0).inertia))  # m b^2, m a^2 and m (a^2 + b^2), over 12
    [1. 4. 5.]
    """
    xp, (mass, length, width) = checked(mass, length=length, width=width)
    return body_of(xp, mass, length**2 / 12, width**2 / 12, xp.zeros_like(mass))


@with_quantities()
def regular_polygon_plate(mass: Array, radius: Array, corners: int) -> Body:
    """A thin regular polygon in the plane z = 0, radius R from centre to corner.

    <x^2> = <y^2> = R^2 (2 + cos(2 pi/n))/12. corners: n, at least 3, an int.
    Source: the n triangles about the centre, as in `polygon_plate`.

    >>> print(f"{regular_polygon_plate(6.0, 1.0, 4).inertia[2, 2]:.4f}")  # a square: m a^2 / 6 with a^2 = 2
    2.0000
    """
    if not (3 <= corners < math.inf and corners == int(corners)):
        raise ValueError(f"a polygon must have a whole number of at least 3 corners, not {corners}")
    xp, (mass, radius) = checked(mass, radius=radius)
    square = radius**2 * (2 + math.cos(2 * math.pi / corners)) / 12
    return body_of(xp, mass, square, square, xp.zeros_like(mass))


@with_quantities()
def triangle_plate(mass: Array, vertices: Array) -> Body:
    """A thin triangle with its corners (..., 3, 3) anywhere in space, row by row; it stays where they are.

    <x x> about the centroid is sum v v / 12 over the corners. Source: Eberly (2002), Polyhedral Mass Properties.

    >>> plate = triangle_plate(3.0, [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0]])
    >>> print(plate.centre.round(12), f"{plate.inertia[2, 2]:.4f}")  # m (sum of squared sides) / 36
    [1. 1. 0.] 3.0000
    """
    _, mass, corners = checked_points(mass, vertices, (3, 3), "the corners of a triangle")
    return body_of_simplices(mass, corners[..., None, :, :])


@with_quantities()
def polygon_plate(mass: Array, vertices: Array) -> Body:
    """A thin simple polygon in the plane z = 0 with corners (..., n, 2) in order, either way round; it stays in place.

    It need not be convex, and must not cross itself, which is not checked; one without area is a ValueError.
    Source: triangles from a point within its corners, with signed areas (Bourke 1988).

    >>> print(f"{polygon_plate(12.0, [[0, 0], [2, 0], [2, 1], [0, 1]]).inertia[2, 2]:.4f}")  # m (a^2 + b^2) / 12
    5.0000
    """
    xp, mass, corners = checked_points(mass, vertices, (None, 2), "the corners of a polygon")
    if corners.shape[-2] < 3:
        raise ValueError(f"a polygon must have at least 3 corners, not {corners.shape[-2]}")
    middle = xp.broadcast_to(corners.mean(-2, keepdims=True), corners.shape)
    following = xp.roll(corners, -1, axis=-2)
    one, two = corners - middle, following - middle
    areas = one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]
    rounding = 8 * xp.finfo(areas.dtype).eps * abs(areas).sum(-1)
    refuse(abs(areas.sum(-1)) <= rounding, "the corners of a polygon enclose no area")
    flat = xp.stack([middle, corners, following], axis=-2)
    return body_of_simplices(mass, xp.concatenate([flat, xp.zeros_like(flat[..., :1])], -1), areas)
