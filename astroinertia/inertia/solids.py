"""Closed forms of homogeneous solids and thick shells as bodies: see `astroinertia.inertia.shapes`."""

import math
from typing import Any

from astroinertia.inertia.body import Body
from astroinertia.inertia.mean_squares import body_of, body_of_simplices, checked, checked_points, refuse
from astroinertia.inertia.plates import polygon_plate
from astroinertia.process.quantities import with_quantities

Array = Any

GOLDEN_RATIO = (1 + math.sqrt(5)) / 2
# <x^2> of the regular solids by number of faces, over the square of an edge: half their moment coefficients, which are
# 1/20, 1/6, 1/10, (39 phi + 28)/150 and phi^2/10 (Satterly 1958, Mathematical Gazette 42, 11).
_REGULAR_SOLIDS = {4: 1 / 40, 6: 1 / 12, 8: 1 / 20, 12: (39 * GOLDEN_RATIO + 28) / 300, 20: GOLDEN_RATIO**2 / 20}


@with_quantities()
def box(mass: Array, length: Array, width: Array, height: Array) -> Body:
    """A cuboid, length along x, width along y, height along z: <x^2> = l^2/12 and so on; faces at x = -l/2 and l/2.

    Source: Machinery's Handbook, 31st ed. (2020), p. 253, prism.

    >>> print(np.diag(box(12.0, 1.0, 2.0, 3.0).inertia))  # m (b^2 + c^2) / 12 and so on
    [13. 10.  5.]
    """
    xp, (mass, x, y, z) = checked(mass, length=length, width=width, height=height)
    return body_of(xp, mass, x**2 / 12, y**2 / 12, z**2 / 12)


@with_quantities()
def hollow_box(mass: Array, length: Array, width: Array, height: Array, wall: Array) -> Body:
    """A closed box with walls of one thickness, outer sizes as for `box`; a wall of 0 is the limit of a thin shell.

    The difference of two boxes, outer sides a, b, c and inner ones a', b', c', with the common factor 2 wall taken out,
    so that thin walls lose no digits. The mass is that of the walls; walls thicker than half a side are a ValueError.

    >>> print(f"{hollow_box(6.0, 2.0, 2.0, 2.0, 0.999).inertia[2, 2]:.4f}")  # all wall, a cube: m a^2 / 6
    4.0000
    """
    xp, (mass, *outer, wall) = checked(mass, ("wall",), length=length, width=width, height=height, wall=wall)
    for side in outer:
        refuse(2 * wall > side, "the walls of a hollow box must not be thicker than half of its smallest side")
    inner = [side - 2 * wall for side in outer]

    def square(k: int) -> Array:
        """(a^3 bc - a'^3 b'c') / (12 (abc - a'b'c')) for the side a = outer[k], with 2 wall divided out."""
        a, b, c = (outer[(k + step) % 3] for step in range(3))
        a_in, c_in = inner[k], inner[(k + 2) % 3]
        ends = b * c / (b * c + a_in * (b + c_in))  # share of the volume; b + c' is (bc - b'c') / (2 wall)
        return (a_in**2 + a * (a + a_in) * ends) / 12

    return body_of(xp, mass, *map(square, range(3)))


@with_quantities()
def solid_sphere(mass: Array, radius: Array) -> Body:
    """A solid sphere: <x^2> = r^2/5, so I = 2 m r^2/5 about every diameter, and 7 m r^2/5 about a tangent, at x = r.

    Source: Machinery's Handbook, 31st ed. (2020), p. 253, sphere.

    >>> print(f"{solid_sphere(5.0, 2.0).inertia[2, 2]:.4f}")  # (2/5) m R^2
    8.0000
    """
    xp, (mass, radius) = checked(mass, radius=radius)
    square = radius**2 / 5
    return body_of(xp, mass, square, square, square)


@with_quantities()
def thick_spherical_layer(mass: Array, outer_radius: Array, inner_radius: Array) -> Body:
    """A sphere with a concentric hollow: <x^2> = (R^5 - r^5) / (5 (R^3 - r^3)); r = R is the thin shell.

    R - r is divided out, so that thin layers lose no digits.
    Source: Machinery's Handbook, 31st ed. (2020), p. 238, hollow sphere.

    >>> print(f"{thick_spherical_layer(3.0, 2.0, 1.9999).inertia[2, 2]:.2f}")  # thin: (2/3) m R^2
    8.00
    """
    xp, (mass, outer, inner) = checked(mass, ("inner_radius",), outer_radius=outer_radius, inner_radius=inner_radius)
    refuse(inner > outer, "the inner radius of a spherical layer must not exceed its outer radius")
    square = _fifth_over_third(outer, inner) / 5
    return body_of(xp, mass, square, square, square)


@with_quantities()
def layered_sphere(masses: Array, outer_radii: Array) -> Body:
    """Homogeneous concentric layers, from the middle out: masses (..., n) and outer radii (..., n).

    I is the sum of those of the layers, each between its own radius and the one before. Radii that do not grow
    outwards, no layer, and other numbers of masses than of radii are a ValueError. Source: `thick_spherical_layer`.

    >>> print(f"{layered_sphere((1.0, 7.0), (1.0, 2.0)).inertia[2, 2]:.4f}")  # of one density: (2/5) 8 2^2
    12.8000
    """
    xp, masses, radii = checked_points(masses, outer_radii, (None,), "the outer radii of layers")
    if not radii.shape[-1] or masses.shape[-1:] != radii.shape[-1:]:
        raise ValueError(
            f"layers are one or more, each with a mass and an outer radius; here masses are of shape {masses.shape} "
            f"and outer radii of shape {radii.shape}"
        )
    inner = xp.concatenate([xp.zeros_like(radii[..., :1]), radii[..., :-1]], axis=-1)
    refuse(inner >= radii, "the outer radii of layers must be positive and grow outwards")
    _, (masses, outer, inner) = checked(masses, ("inner_radius",), outer_radius=radii, inner_radius=inner)
    square = _fifth_over_third(outer, inner) / 5
    layers = body_of(xp, masses, square, square, square)
    return Body(masses.sum(-1), layers.centre[..., 0, :], layers.inertia.sum(-3))


@with_quantities()
def ellipsoid(mass: Array, semi_axes: Array) -> Body:
    """A solid ellipsoid with semi-axes (..., 3) along x, y, z: <x^2> = a^2/5 and so on.

    Source: Machinery's Handbook, 31st ed. (2020), p. 254, ellipsoid.

    >>> print(np.diag(ellipsoid(5.0, (3.0, 2.0, 1.0)).inertia))  # m (b^2 + c^2) / 5 and so on
    [ 5. 10. 13.]
    """
    xp, mass, axes = checked_points(mass, semi_axes, (3,), "the semi-axes of an ellipsoid")
    xp, (mass, a, b, c) = checked(mass, semi_axis_x=axes[..., 0], semi_axis_y=axes[..., 1], semi_axis_z=axes[..., 2])
    return body_of(xp, mass, a**2 / 5, b**2 / 5, c**2 / 5)


@with_quantities()
def cylinder(mass: Array, radius: Array, height: Array) -> Body:
    """A solid cylinder along z: <x^2> = r^2/4, <z^2> = h^2/12; its ends are at z = -h/2 and h/2.

    Source: Machinery's Handbook, 31st ed. (2020), p. 253, cylinder.

    >>> print(f"{cylinder(3.0, 2.0, 5.0).inertia[2, 2]:.4f}")  # m R^2 / 2, whatever the height
    6.0000
    """
    xp, (mass, radius, height) = checked(mass, radius=radius, height=height)
    return body_of(xp, mass, radius**2 / 4, radius**2 / 4, height**2 / 12)


@with_quantities()
def thick_cylinder(mass: Array, outer_radius: Array, inner_radius: Array, height: Array) -> Body:
    """A tube with a thick wall and open ends, along z: <x^2> = (R^2 + r^2)/4, <z^2> = h^2/12; r = R is the thin tube.

    Source: Machinery's Handbook, 31st ed. (2020), p. 253, hollow cylinder.

    >>> print(f"{thick_cylinder(3.0, 2.0, 1.0, 5.0).inertia[2, 2]:.4f}")  # m (R^2 + r^2) / 2
    7.5000
    """
    xp, (mass, outer, inner, height) = checked(
        mass, ("inner_radius",), outer_radius=outer_radius, inner_radius=inner_radius, height=height
    )
    refuse(inner > outer, "the inner radius of a tube must not exceed its outer radius")
    square = (outer**2 + inner**2) / 4
    return body_of(xp, mass, square, square, height**2 / 12)


@with_quantities()
def elliptic_cylinder(mass: Array, semi_axis_x: Array, semi_axis_y: Array, height: Array) -> Body:
    """A solid cylinder along z with an elliptic section: <x^2> = a^2/4, <y^2> = b^2/4, <z^2> = h^2/12.

    Source: Meriam & Kraige (2012), Table D/4, elliptical cylinder.

    >>> print(f"{elliptic_cylinder(4.0, 2.0, 1.0, 5.0).inertia[2, 2]:.4f}")  # m (a^2 + b^2) / 4
    5.0000
    """
    xp, (mass, a, b, height) = checked(mass, semi_axis_x=semi_axis_x, semi_axis_y=semi_axis_y, height=height)
    return body_of(xp, mass, a**2 / 4, b**2 / 4, height**2 / 12)


@with_quantities()
def capsule(mass: Array, radius: Array, length: Array) -> Body:
    """A cylinder along z, length l (0 or more), with a hemisphere on each end; tips at z = -l/2 - r and l/2 + r.

    With s = 4r/(3l + 4r), the hemispheres' share of the volume: <x^2> = (1 - s) r^2/4 + s r^2/5,
    <z^2> = (1 - s) l^2/12 + s (r^2/5 + l^2/4 + 3 l r/8). Source: the sum of its parts (centroid of a hemisphere 3r/8).

    >>> print(f"{capsule(5.0, 2.0, 0.0).inertia[2, 2]:.4f}")  # without its cylinder a sphere: (2/5) m R^2
    8.0000
    """
    xp, (mass, r, length) = checked(mass, ("length",), radius=radius, length=length)
    ends = 4 * r / (3 * length + 4 * r)
    across = (1 - ends) * r**2 / 4 + ends * r**2 / 5
    along = (1 - ends) * length**2 / 12 + ends * (r**2 / 5 + length**2 / 4 + 3 * length * r / 8)
    return body_of(xp, mass, across, across, along)


@with_quantities()
def cone(mass: Array, radius: Array, height: Array) -> Body:
    """A solid right circular cone: <x^2> = 3 r^2/20, <z^2> = 3 h^2/80; base at z = -h/4, apex at z = 3h/4.

    Source: Machinery's Handbook, 31st ed. (2020), p. 237, cone (there about apex, base and centre line).

    >>> body = cone(10.0, 2.0, 4.0)
    >>> print(body.centre, f"{body.inertia[2, 2]:.4f}")  # 3 m R^2 / 10
    [0. 0. 0.] 12.0000
    """
    xp, (mass, radius, height) = checked(mass, radius=radius, height=height)
    across = 3 * radius**2 / 20
    return body_of(xp, mass, across, across, 3 * height**2 / 80)


@with_quantities()
def frustum(mass: Array, base_radius: Array, top_radius: Array, height: Array) -> Body:
    """A cone cut off parallel to its base, radii R below and r above; the base is at z = -h (R^2 + 2Rr + 3r^2)/(4 S).

    S = R^2 + Rr + r^2; <x^2> = 3 (R^5 - r^5) / (20 (R^3 - r^3)), with R - r divided out;
    <z^2> = 3 h^2 (R^4 + 4R^3 r + 10R^2 r^2 + 4R r^3 + r^4) / (80 S^2).
    Source: Machinery's Handbook, 31st ed. (2020), p. 237, frustum of cone (there about the large end).

    >>> print(f"{frustum(3.0, 2.0, 2.0, 5.0).inertia[2, 2]:.4f}")  # of equal radii a cylinder: m R^2 / 2
    6.0000
    """
    xp, (mass, r, t, height) = checked(
        mass, ("base_radius", "top_radius"), base_radius=base_radius, top_radius=top_radius, height=height
    )
    refuse((r == 0) & (t == 0), "one of the radii of a frustum must be above 0")
    unit = xp.maximum(r, t)
    across = 3 * _fifth_over_third(unit, xp.minimum(r, t)) / 20
    r, t = r / unit, t / unit  # whose fourth powers neither overflow nor vanish
    quartic = r**4 + 4 * r**3 * t + 10 * r**2 * t**2 + 4 * r * t**3 + t**4
    along = 3 * height**2 * quartic / (80 * (r**2 + r * t + t**2) ** 2)
    return body_of(xp, mass, across, across, along)


@with_quantities()
def rectangular_pyramid(mass: Array, length: Array, width: Array, height: Array) -> Body:
    """A right pyramid on a rectangle: <x^2> = l^2/20, <y^2> = w^2/20, <z^2> = 3 h^2/80; base at z = -h/4.

    Source: Machinery's Handbook, 31st ed. (2020), p. 253, pyramid, rectangular base.

    >>> print(f"{rectangular_pyramid(20.0, 2.0, 1.0, 3.0).inertia[2, 2]:.4f}")  # m (a^2 + b^2) / 20
    5.0000
    """
    xp, (mass, length, width, height) = checked(mass, length=length, width=width, height=height)
    return body_of(xp, mass, length**2 / 20, width**2 / 20, 3 * height**2 / 80)


@with_quantities()
def paraboloid(mass: Array, radius: Array, height: Array) -> Body:
    """A solid of revolution under a parabola: <x^2> = r^2/6, <z^2> = h^2/18; flat base of radius r at z = -h/3.

    Source: Machinery's Handbook, 31st ed. (2020), p. 254, paraboloid.

    >>> print(f"{paraboloid(3.0, 2.0, 5.0).inertia[2, 2]:.4f}")  # m R^2 / 3
    4.0000
    """
    xp, (mass, radius, height) = checked(mass, radius=radius, height=height)
    return body_of(xp, mass, radius**2 / 6, radius**2 / 6, height**2 / 18)


@with_quantities()
def torus(mass: Array, ring_radius: Array, tube_radius: Array) -> Body:
    """A solid ring, R from the axis to the middle of the tube, a of the tube: <x^2> = R^2/2 + 3a^2/8, <z^2> = a^2/4.

    A tube wider than the ring is a ValueError. Source: Machinery's Handbook, 31st ed. (2020), p. 254, torus.

    >>> print(f"{torus(4.0, 2.0, 1.0).inertia[2, 2]:.4f}")  # m (R^2 + (3/4) r^2)
    19.0000
    """
    xp, (mass, ring, tube) = checked(mass, ring_radius=ring_radius, tube_radius=tube_radius)
    refuse(tube > ring, "the tube of a torus must not be wider than its ring")
    across = ring**2 / 2 + 3 * tube**2 / 8
    return body_of(xp, mass, across, across, tube**2 / 4)


@with_quantities()
def hemisphere(mass: Array, radius: Array) -> Body:
    """Half of a solid sphere: <x^2> = r^2/5, <z^2> = 19 r^2/320; flat face at z = -3r/8.

    Source: Meriam & Kraige (2012), Table D/4, hemisphere.

    >>> print(f"{hemisphere(5.0, 2.0).inertia[2, 2]:.4f}")  # (2/5) m R^2, as the whole sphere
    8.0000
    """
    return spherical_cap(mass, radius, height=radius)


@with_quantities()
def spherical_cap(mass: Array, radius: Array, height: Array) -> Body:
    """The part of a solid sphere on one side of a plane, h from the plane to the top, at most 2r; dome along +z.

    <x^2> = h (20r^2 - 15rh + 3h^2) / (20 (3r - h)), <z^2> = h^2 (40r^2 - 24rh + 3h^2) / (80 (3r - h)^2);
    its top is h (8r - 3h) / (4 (3r - h)) above its centre of mass.
    Source: Machinery's Handbook, 31st ed. (2020), p. 254, spherical segment, for I_zz.

    >>> print(f"{spherical_cap(5.0, 2.0, 4.0).inertia[2, 2]:.4f}")  # as high as 2 R: the whole sphere
    8.0000
    """
    xp, (mass, r, h) = checked(mass, radius=radius, height=height)
    refuse(h > 2 * r, "the height of a spherical cap must not exceed the diameter of its sphere")
    steep = h / (3 * r - h)  # apart from the squares: cubes of the sizes may overflow or vanish
    across = steep * (20 * r**2 - 15 * r * h + 3 * h**2) / 20
    along = steep**2 * (40 * r**2 - 24 * r * h + 3 * h**2) / 80
    return body_of(xp, mass, across, across, along)


@with_quantities()
def spherical_sector(mass: Array, radius: Array, height: Array) -> Body:
    """A cap of height h with the cone down to the centre of its sphere; h at most 2r, a whole sphere; dome along +z.

    <x^2> = h (3r - h)/10 and, with c = 1 - h/r, <z^2> = r^2 (19 - 26c + 19c^2)/320; the centre of the sphere is
    3r (1 + c)/8 below the centre of mass. Source: Machinery's Handbook, 31st ed. (2020), p. 254, for I_zz.

    >>> print(f"{spherical_sector(5.0, 2.0, 4.0).inertia[2, 2]:.4f}")  # as high as 2 R: the whole sphere
    8.0000
    """
    xp, (mass, r, h) = checked(mass, radius=radius, height=height)
    refuse(h > 2 * r, "the height of a spherical sector must not exceed the diameter of its sphere")
    cosine = 1 - h / r
    across = h * (3 * r - h) / 10
    return body_of(xp, mass, across, across, r**2 * (19 - 26 * cosine + 19 * cosine**2) / 320)


@with_quantities()
def tetrahedron(mass: Array, vertices: Array) -> Body:
    """A solid tetrahedron with its vertices (..., 4, 3) anywhere in space, row by row; it stays where they are.

    <x x> about the centroid is sum v v / 20 over the vertices. Source: Eberly (2002), Polyhedral Mass Properties.

    >>> print(tetrahedron(4.0, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]).centre)  # the mean of the corners
    [0.25 0.25 0.25]
    """
    _, mass, corners = checked_points(mass, vertices, (4, 3), "the vertices of a tetrahedron")
    return body_of_simplices(mass, corners[..., None, :, :])


@with_quantities()
def regular_polyhedron(mass: Array, edge: Array, faces: int) -> Body:
    """A solid tetrahedron, cube, octahedron, dodecahedron or icosahedron (faces: 4, 6, 8, 12, 20): I is isotropic.

    I/(m edge^2) = 1/20, 1/6, 1/10, (39 phi + 28)/150, phi^2/10. Source: Satterly (1958), Mathematical Gazette 42, 11.

    >>> print(f"{regular_polyhedron(6.0, 2.0, 6).inertia[2, 2]:.4f}")  # a cube: m a^2 / 6
    4.0000
    """
    if faces not in _REGULAR_SOLIDS:
        raise ValueError(f"a regular polyhedron has 4, 6, 8, 12 or 20 faces, not {faces}")
    xp, (mass, edge) = checked(mass, edge=edge)
    square = _REGULAR_SOLIDS[faces] * edge**2
    return body_of(xp, mass, square, square, square)


@with_quantities()
def prism(mass: Array, vertices: Array, height: Array) -> Body:
    """A right prism on a simple polygon with corners (..., n, 2) in x and y, from z = -h/2 to h/2; it stays in place.

    The polygon's mean squares, and <z^2> = h^2/12. Source: `polygon_plate`.

    >>> print(f"{prism(12.0, [[0, 0], [2, 0], [2, 1], [0, 1]], 3.0).inertia[2, 2]:.4f}")  # a box: m (a^2 + b^2) / 12
    5.0000
    """
    base = polygon_plate(mass, vertices)
    xp, (mass, height) = checked(base.mass, height=height)
    none = xp.zeros_like(mass)
    upright = body_of(xp, mass, none, none, height**2 / 12)
    return Body(upright.mass, base.centre + upright.centre, base.inertia + upright.inertia)


def _fifth_over_third(large: Array, small: Array) -> Array:
    """(a^5 - b^5) / (a^3 - b^3) without the cancellation, and without dividing by a - b."""
    b = small / large  # the fourth powers of the sizes may overflow or vanish
    return large**2 * (1 + b + b**2 + b**3 + b**4) / (1 + b + b**2)
