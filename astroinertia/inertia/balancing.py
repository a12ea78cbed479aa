"""Balancing of rotors: unbalance in two planes, corrections that cancel it, and the best of discrete holes.

The rotor spins about z through the origin. Its unbalance is two vectors (2,) across the axis, which turn with it: the
static one, U = sum m (x, y) = M (c_x, c_y), and the dynamic one, D = sum m z (x, y) = -(I_xz, I_yz) about the origin.
It runs without forces on its bearings if and only if both are zero, whatever I_xy, I_xx and I_yy are. Two masses in two
planes can always do that (Norton 2012, Design of Machinery, 5th ed., section 12.3; ISO 21940-11).
Any consistent units. Checked by tests/unit/inertia/test_balancing.py.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from astroinertia.inertia.body import Body
from astroinertia.inertia.tensor import namespace
from astroinertia.process.known import is_known
from astroinertia.process.positive import refuse_negative
from astroinertia.process.quantities import with_quantities

Array = Any

MOST_COMBINATIONS = 2_000_000
"""Of the holes in one half of the search; more would not fit in the memory of a small machine."""


@dataclass(frozen=True)
class Holes:
    """A choice of masses for holes: mass (n,), the residual in both planes (2, 2) and its norm.

    >>> print(Holes(mass=np.array([0.01]), residual=np.zeros((2, 2)), size=0.0).size)
    0.0
    """

    mass: np.ndarray
    residual: np.ndarray
    size: float


@with_quantities()
def unbalance_of_body(body: Body) -> tuple[Array, Array]:
    """Static and dynamic unbalance U and D, (..., 2) each, of a body that spins about z through the origin.

    >>> from astroinertia.inertia import shapes
    >>> wheel = shapes.disc(10.0, 0.3) + shapes.point(0.02, (0.3, 0.0, 0.0))
    >>> print(unbalance_of_body(wheel)[0])  # m r of what is stuck to its rim
    [0.006 0.   ]
    """
    xp = namespace(*vars(body).values())
    inertia = body.about(xp.zeros(3))
    return xp.asarray(body.mass)[..., None] * body.centre[..., :2], -inertia[..., :2, 2]


@with_quantities(unbalance="kg m")
def unbalance_of_measurements(unbalance: Array, planes: Array) -> tuple[Array, Array]:
    """U and D, (2,) each, from vectors m r (n, 2) measured in planes at z (n,).

    >>> print(unbalance_of_measurements(np.array([[0.01, 0.0], [0.01, 0.0]]), np.array([-0.1, 0.1]))[0])
    [0.02 0.  ]
    """
    xp = namespace(unbalance, planes)
    unbalance, planes = xp.asarray(unbalance), xp.asarray(planes)
    if unbalance.shape != (*planes.shape, 2):
        raise ValueError(f"each of the planes {planes.shape} needs a vector of two components, not {unbalance.shape}")
    return unbalance.sum(0), planes @ unbalance


@with_quantities()
def phasors(size: Array, angle: Array) -> Array:
    """Vectors (..., 2) of length `size` at `angle` from x towards y, in radians.

    >>> print(phasors(2.0, np.pi / 2).round(12))
    [0. 2.]
    """
    xp = namespace(size, angle)
    return xp.asarray(size)[..., None] * xp.stack([xp.cos(angle), xp.sin(angle)], axis=-1)


@with_quantities(static="kg m", dynamic="kg m2")
def two_plane_equivalent(static: Array, dynamic: Array, planes: Sequence[float]) -> Array:
    """The vectors m r in two planes that are the same unbalance, (..., 2 planes, 2).

    static, dynamic: U and D (..., 2); planes: their two z. Planes at one place are a ValueError. At the places of the
    bearings and times the rate squared they are the forces on them.

    >>> print(two_plane_equivalent(np.array([0.006, 0.0]), np.zeros(2), (-0.1, 0.1)).tolist())  # half in each
    [[0.003, 0.0], [0.003, 0.0]]
    """
    first, second = planes
    if is_known(first) and is_known(second) and first == second:
        raise ValueError(f"two planes are needed, and both are at {first:g}")
    xp = namespace(static, dynamic, first, second)
    share = (dynamic - first * static) / (second - first)
    return xp.stack([static - share, share], axis=-2)


@with_quantities(static="kg m", dynamic="kg m2")
def two_plane_correction(static: Array, dynamic: Array, planes: Sequence[float]) -> Array:
    """Vectors m r to be added in two planes to balance a rotor, (..., 2 planes, 2): minus its equivalent there.

    >>> print(two_plane_correction(np.array([0.006, 0.006]), np.zeros(2), (-0.1, 0.1)).tolist())  # its opposite
    [[-0.003, -0.003], [-0.003, -0.003]]
    """
    return -two_plane_equivalent(static, dynamic, planes)


@with_quantities(correction="kg m")
def correction_masses(correction: Array, radii: Array, remove: bool = False) -> tuple[Array, Array]:
    """Masses (..., 2) and angles (..., 2) in radians, from x towards y, of corrections m r (..., 2, 2) at two radii.

    With `remove` the masses are taken away, on the side opposite to where they would be added; both are positive.
    A radius that is not positive is a ValueError.

    >>> correction = two_plane_correction(np.array([-0.006, 0.0]), np.zeros(2), (-0.1, 0.1))
    >>> mass, angle = correction_masses(correction, np.array([0.3, 0.3]))
    >>> print(mass, abs(np.degrees(angle)))  # 10 g in each plane, opposite
    [0.01 0.01] [0. 0.]
    """
    xp = namespace(correction, radii)
    correction, radii = xp.asarray(correction), xp.asarray(radii)
    if is_known(radii) and not (radii > 0).all():
        raise ValueError("the radii of the corrections must be positive")
    sign = -1.0 if remove else 1.0
    mass = xp.hypot(correction[..., 0], correction[..., 1]) / radii
    return mass, xp.arctan2(sign * correction[..., 1], sign * correction[..., 0])


@with_quantities(static="kg m", dynamic="kg m2", rate="rad/s", bearings="m")
def bearing_forces(static: Array, dynamic: Array, rate: Array, bearings: Sequence[float]) -> Array:
    """Forces (..., 2 bearings, 2) of a rotor on bearings at two z when it turns at `rate` (rad per time).

    Components along the rotor's own x and y, which turn with it; weight is left out.

    >>> print(bearing_forces(np.array([0.006, 0.0]), np.zeros(2), 100.0, (-0.1, 0.1)))  # m r w^2 = 60 N, shared
    [[30.  0.]
     [30.  0.]]
    """
    forces = two_plane_equivalent(static, dynamic, bearings)
    xp = namespace(forces, rate)
    rate = xp.asarray(rate, dtype=xp.result_type(forces, rate))
    return rate[..., None, None] ** 2 * forces


@with_quantities(rate="rad/s")
def permissible_unbalance(mass: Array, rate: Array, grade: float = 6.3) -> Array:
    """The residual static unbalance m G/w that a balance quality grade allows a rotor, (...,): SI, kg m.

    grade: G in mm/s, of the greatest service rate w in rad/s: 6.3 for fans, pumps and general machinery, 2.5 for gas
    turbines, 0.4 for spindles of grinders, 40 for a car's wheels. In two planes as far from the centre of mass each may
    have half of it. ValueError for a negative mass or grade. Source: ISO 21940-11:2016 (before, ISO 1940-1:2003).

    >>> rate = 2 * np.pi * 3000 / 60  # a pump's rotor of 30 kg at 3000 revolutions a minute
    >>> print(f"{1e6 * permissible_unbalance(30.0, rate):.0f} g mm")
    602 g mm
    """
    refuse_negative(**{name: value for name, value in {"mass": mass, "grade": grade}.items() if is_known(value)})
    return mass * (1e-3 * grade) / abs(rate)


@with_quantities(unbalance="kg m", rate="rad/s")
def balance_grade(unbalance: Array, mass: Array, rate: Array) -> Array:
    """The balance quality grade G = w |U|/m in mm/s of a rotor, (...,), from its static unbalance U (..., 2) in kg m.

    ValueError for a negative mass. Source: as for `permissible_unbalance`, whose inverse it is.

    >>> print(f"{balance_grade(np.array([0.003, 0.004]), 30.0, 100.0):.2f}")  # e = |U|/m is a sixth of a millimetre
    16.67
    """
    xp = namespace(unbalance, mass, rate)
    if is_known(mass):
        refuse_negative(mass=mass)
    unbalance = xp.asarray(unbalance)
    return 1e3 * xp.hypot(unbalance[..., 0], unbalance[..., 1]) * abs(rate) / mass


@with_quantities(static="kg m", dynamic="kg m2")
def best_holes(
    static: Array,
    dynamic: Array,
    planes: Sequence[float],
    radii: Array,
    angle: Array,
    position: Array,
    masses: Sequence[float],
    most: int | None = None,
) -> Holes:
    """The masses for given holes that leave the least unbalance in two planes, of all choices.

    static, dynamic: U and D, (2,); planes: the two z in which what is left is judged; radii, angle (radians), position
    (z): of the holes, (n,) each; masses: what any hole can be given, negative to remove, besides nothing; most: how
    many holes may be used, all of them where it is not given. The residual is that of U and D in the planes, and its
    size the root of its squares' sum. Exact: all sums of one half of the holes are looked up in those of the other
    (Horowitz & Sahni 1974, J. ACM 21, 277). More than MOST_COMBINATIONS sums in a half are a ValueError.

    >>> radii, angle, place = np.full(4, 0.3), np.pi * np.array([0, 1, 0, 1]), np.array([-0.1, -0.1, 0.1, 0.1])
    >>> holes = best_holes(np.array([0.006, 0.0]), np.zeros(2), (-0.1, 0.1), radii, angle, place, (0.01,))
    >>> print(holes.mass)  # added opposite
    [0.   0.01 0.   0.01]
    """
    holes = phasors(np.asarray(radii, dtype=float), np.asarray(angle, dtype=float))
    influence = two_plane_equivalent(holes, np.asarray(position, dtype=float)[:, None] * holes, planes).reshape(-1, 4)
    start = two_plane_equivalent(np.asarray(static), np.asarray(dynamic), planes).reshape(4)
    values = np.setdiff1d(np.asarray(masses, dtype=float), 0.0)
    if not (len(influence) and len(values)) or (most is not None and most < 0):
        raise ValueError("at least one hole and one mass for it are needed, and no fewer than 0 may be used")
    middle, limit = len(influence) // 2, len(influence) if most is None else most
    if _count(len(influence) - middle, len(values), limit) > MOST_COMBINATIONS:
        raise ValueError(f"{len(influence)} holes with {len(values)} masses for each are too many to try all choices")
    one, other = (_choices(len(half), values, limit) for half in (influence[:middle], influence[middle:]))
    used = np.count_nonzero(one, axis=1), np.count_nonzero(other, axis=1)
    # Where few may be used, what one half uses the other lacks: each number is tried by itself.
    splits = (
        [(one, other)]
        if limit >= len(influence)
        else [(one[used[0] == k], other[used[1] <= limit - k]) for k in range(limit + 1)]
    )
    choices = [_nearest(start, influence[:middle], influence[middle:], *split) for split in splits if len(split[0])]
    mass = min(choices, key=lambda choice: np.linalg.norm(start + choice @ influence))
    residual = start + mass @ influence
    return Holes(mass, residual.reshape(2, 2), float(np.linalg.norm(residual)))


def _nearest(start: np.ndarray, half: np.ndarray, others: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    distance, index = KDTree(other @ others).query(-(start + one @ half))
    best = int(np.argmin(distance))
    return np.concatenate([one[best], other[np.atleast_1d(index)[best]]])


def _count(places: int, values: int, most: int) -> int:
    return sum(math.comb(places, k) * values**k for k in range(min(most, places) + 1))


def _choices(places: int, values: np.ndarray, most: int) -> np.ndarray:
    """All ways to give at most so many of the places one of the values, the others 0."""
    parts = []
    for k in range(min(most, places) + 1):
        where = np.array(list(itertools.combinations(range(places), k)), dtype=int)
        what = np.array(list(itertools.product(values, repeat=k)))
        part = np.zeros((len(where), len(what), places))
        np.put_along_axis(part, np.broadcast_to(where[:, None], (len(where), len(what), k)), what[None], axis=2)
        parts.append(part.reshape(len(where) * len(what), places))
    return np.concatenate(parts)
