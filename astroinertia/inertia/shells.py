"""Closed forms of thin shells as bodies: see `astroinertia.inertia.shapes`.

All have the same mass per area everywhere, but for `homoeoid_shell`.
"""

from typing import Any

from astroinertia.inertia.body import Body
from astroinertia.inertia.mean_squares import body_of, checked, checked_points, refuse
from astroinertia.process.quantities import with_quantities

Array = Any


@with_quantities()
def spherical_shell(mass: Array, radius: Array) -> Body:
    """A thin sphere: <x^2> = r^2/3, so I = 2 m r^2/3 about every diameter.

    Source: Machinery's Handbook, 31st ed. (2020), p. 238, thin spherical shell.

    >>> print(f"{spherical_shell(3.0, 2.0).inertia[2, 2]:.4f}")  # (2/3) m R^2
    8.0000
    """
    xp, (mass, radius) = checked(mass, radius=radius)
    square = radius**2 / 3
    return body_of(xp, mass, square, square, square)


@with_quantities()
def homoeoid_shell(mass: Array, semi_axes: Array) -> Body:
    """The thin layer between two similar ellipsoids, semi-axes (..., 3) along x, y, z: <x^2> = a^2/3 and so on.

    It is thickest at the tips of the longest axis; a shell with the same mass per area has no elementary closed form.
    Source: the rate of the solid ellipsoid's tensor as it grows in proportion.

    >>> print(np.diag(homoeoid_shell(3.0, (2.0, 2.0, 2.0)).inertia))  # of a sphere: (2/3) m R^2
    [8. 8. 8.]
    """
    xp, mass, axes = checked_points(mass, semi_axes, (3,), "the semi-axes of an ellipsoid")
    xp, (mass, a, b, c) = checked(mass, semi_axis_x=axes[..., 0], semi_axis_y=axes[..., 1], semi_axis_z=axes[..., 2])
    return body_of(xp, mass, a**2 / 3, b**2 / 3, c**2 / 3)


@with_quantities()
def thin_tube(mass: Array, radius: Array, height: Array) -> Body:
    """A thin cylinder along z with open ends: <x^2> = r^2/2, <z^2> = h^2/12; its ends are at z = -h/2 and h/2.

    Source: Machinery's Handbook, 31st ed. (2020), p. 237, thin hollow cylinder.

    >>> print(f"{thin_tube(3.0, 2.0, 5.0).inertia[2, 2]:.4f}")  # m R^2, whatever the height
    12.0000
    """
    xp, (mass, radius, height) = checked(mass, radius=radius, height=height)
    return body_of(xp, mass, radius**2 / 2, radius**2 / 2, height**2 / 12)


@with_quantities()
def closed_can(mass: Array, radius: Array, height: Array) -> Body:
    """A thin cylinder along z with both ends closed: <x^2> = r^2 (2h + r)/(4(h + r)), <z^2> = h^2 (h + 3r)/(12(h + r)).

    Source: the sum of a thin tube and two discs, by area.

    >>> print(f"{closed_can(3.0, 2.0, 2.0).inertia[2, 2] / (3.0 * 2.0**2):.4f}")  # lids and wall weigh the same: 3/4
    0.7500
    """
    xp, (mass, r, h) = checked(mass, radius=radius, height=height)
    lids = r / (h + r)  # share of the area; without cubes of the sizes, which may overflow or vanish
    across = r**2 * (2 - lids) / 4
    return body_of(xp, mass, across, across, h**2 * (1 + 2 * lids) / 12)


@with_quantities()
def cone_shell(mass: Array, radius: Array, height: Array) -> Body:
    """A thin cone without its base: <x^2> = r^2/4, <z^2> = h^2/18; rim at z = -h/3, apex at z = 2h/3.

    Source: Meriam & Kraige (2012), Table D/4, conical shell.

    >>> print(f"{cone_shell(3.0, 2.0, 5.0).inertia[2, 2]:.4f}")  # m R^2 / 2
    6.0000
    """
    xp, (mass, radius, height) = checked(mass, radius=radius, height=height)
    return body_of(xp, mass, radius**2 / 4, radius**2 / 4, height**2 / 18)


@with_quantities()
def frustum_shell(mass: Array, base_radius: Array, top_radius: Array, height: Array) -> Body:
    """A thin cone cut off parallel to its rim, open at both ends, radii R below and r above.

    <x^2> = (R^2 + r^2)/4, <z^2> = h^2 (R^2 + 4Rr + r^2) / (18 (R + r)^2); the lower rim is at
    z = -h (R + 2r) / (3 (R + r)). Source: the integral over the wall, whose area per height grows as the radius.

    >>> print(f"{frustum_shell(3.0, 2.0, 1.0, 5.0).inertia[2, 2]:.4f}")  # m (R^2 + r^2) / 2
    7.5000
    """
    xp, (mass, r, t, height) = checked(
        mass, ("base_radius", "top_radius"), base_radius=base_radius, top_radius=top_radius, height=height
    )
    refuse((r == 0) & (t == 0), "one of the radii of a frustum must be above 0")
    across = (r**2 + t**2) / 4
    top = t / (r + t)  # without fourth powers of the sizes, which may overflow or vanish
    return body_of(xp, mass, across, across, height**2 * (1 + 2 * top * (1 - top)) / 18)


@with_quantities()
def torus_shell(mass: Array, ring_radius: Array, tube_radius: Array) -> Body:
    """A thin ring-shaped tube, R to the middle of the tube, a of the tube: <x^2> = R^2/2 + 3a^2/4, <z^2> = a^2/2.

    A tube wider than the ring is a ValueError. Source: the integral over the surface, a (R + a cos t) dt.

    >>> print(f"{torus_shell(3.0, 2.0, 1.0).inertia[2, 2]:.4f}")  # m (R^2 + (3/2) r^2)
    16.5000
    """
    xp, (mass, ring, tube) = checked(mass, ring_radius=ring_radius, tube_radius=tube_radius)
    refuse(tube > ring, "the tube of a torus must not be wider than its ring")
    across = ring**2 / 2 + 3 * tube**2 / 4
    return body_of(xp, mass, across, across, tube**2 / 2)


@with_quantities()
def hemispherical_shell(mass: Array, radius: Array) -> Body:
    """Half of a thin sphere without a floor: <x^2> = r^2/3, <z^2> = r^2/12; rim at z = -r/2.

    Source: Meriam & Kraige (2012), Table D/4, hemispherical shell.

    >>> print(f"{hemispherical_shell(3.0, 2.0).inertia[2, 2]:.4f}")  # (2/3) m R^2, as the whole sphere
    8.0000
    """
    return spherical_cap_shell(mass, radius, height=radius)


@with_quantities()
def spherical_cap_shell(mass: Array, radius: Array, height: Array) -> Body:
    """The part of a thin sphere on one side of a plane, h from rim to top, at most 2r: rim at z = -h/2.

    <x^2> = h (3r - h)/6, <z^2> = h^2/12. Source: Archimedes: the area of a sphere is spread evenly over its height.

    >>> print(f"{spherical_cap_shell(3.0, 2.0, 2.0).inertia[2, 2]:.4f}")  # as high as R: half a sphere
    8.0000
    """
    xp, (mass, r, h) = checked(mass, radius=radius, height=height)
    refuse(h > 2 * r, "the height of a spherical cap must not exceed the diameter of its sphere")
    across = h * (3 * r - h) / 6
    return body_of(xp, mass, across, across, h**2 / 12)
