"""Bodies of rigid limbs whose joints are moved from inside: skaters, divers, cats.

A free body keeps its L whatever its joints do. In the axes of its trunk L = I w + h, with h the angular momentum of the
limbs' motion relative to the trunk: so the trunk turns with w = I^-1 (R^T L - h), also where L = 0 and h is not. The
limbs are a tree, each turning about one hinge. Source: Kane & Scher (1969), International Journal of Solids and
Structures 5, 663. Any consistent units, angles in radians. Checked by tests/unit/inertia/test_jointed.py.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from astroinertia.inertia.body import Body
from astroinertia.inertia.tensor import inertia_from_second_moment, second_moment_from_inertia
from astroinertia.process.quantities import InputError, with_quantities
from astroinertia.process.vectors import of_any_length

Array = Any

_TOLERANCE = 1e-10


@with_quantities(joint="m")
@dataclass(frozen=True)
class Limb:
    """A rigid part as it is with all joints at 0, the point (3,) and axis (3,) of its hinge, and what it hangs on.

    parent: the index of an earlier limb, or None for the trunk, whose joint does not move.

    >>> from astroinertia.inertia import shapes
    >>> arm = Limb(shapes.rod(4.0, 0.7).translated((0.2, 0.0, 0.0)), (0.2, 0.0, 0.35), (0.0, 1.0, 0.0), parent=0)
    >>> print(arm.parent)
    0
    """

    body: Body
    joint: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    parent: int | None = None


@dataclass(frozen=True)
class Posture:
    """The limbs at their places, in the axes of the trunk: each one's body, and the whole.

    relative_momentum: h (3,), about the centre of mass, of the motion that the joints' rates make.
    inertia_rate: dI/dt (3, 3) about the centre of mass, in the trunk's axes.
    """

    parts: list[Body]
    whole: Body
    relative_momentum: np.ndarray
    inertia_rate: np.ndarray


@with_quantities(angles="rad", rates="rad/s")
def posture(limbs: Sequence[Limb], angles: Array, rates: Array = 0.0) -> Posture:
    """Where the limbs are with joints at `angles` (limbs,), and how they move with rates (limbs,).

    The first limb is the trunk; its angle and rate have no meaning here and must be 0.

    >>> from astroinertia.inertia import shapes
    >>> trunk = Limb(shapes.cylinder(50.0, 0.15, 1.0))
    >>> arm = Limb(shapes.rod(5.0, 0.8).translated((0.2, 0.0, 0.1)), (0.2, 0.0, 0.5), (0.0, 1.0, 0.0), parent=0)
    >>> down, out = (posture([trunk, arm], [0.0, angle]).whole.moment((0, 0, 1)) for angle in (0.0, -np.pi / 2))
    >>> print(f"{down:.3f} {out:.3f}")  # kg m2: an arm that is stretched out
    0.744 2.466
    """
    angles = np.asarray(angles, dtype=float)
    rates = np.broadcast_to(np.asarray(rates, dtype=float), angles.shape)
    if angles.shape != (len(limbs),):
        raise InputError(f"angles must be one for each of the {len(limbs)} limbs, not an array of {angles.shape}")
    if limbs[0].parent is not None or angles[0] or rates[0]:
        raise InputError("the first of the limbs is the trunk: it has no parent, and its angle and rate are 0")
    turned, moved, spins, drifts, parts = [np.eye(3)], [np.zeros(3)], [np.zeros(3)], [np.zeros(3)], [limbs[0].body]
    # x -> turned x + moved, and its velocity spins x (place) + drifts, of limb after limb.
    for index, limb in enumerate(limbs[1:], 1):
        if limb.parent is None or not 0 <= limb.parent < index:
            raise InputError(f"the parent of limb {index} must be the index of a limb before it, not {limb.parent}")
        above = limb.parent
        hinge, axis = turned[above] @ np.asarray(limb.joint) + moved[above], np.asarray(limb.axis, dtype=float)
        if not axis.any():
            raise InputError(f"the axis of limb {index} must not be the vector 0")
        axis = of_any_length(axis)
        axis = turned[above] @ (axis / np.linalg.norm(axis))
        turned.append(Rotation.from_rotvec(angles[index] * axis).as_matrix() @ turned[above])
        moved.append(hinge - turned[index] @ np.asarray(limb.joint))
        spins.append(spins[above] + rates[index] * axis)
        drifts.append(drifts[above] - rates[index] * np.cross(axis, hinge))
        body = limb.body.rotated(turned[index], about=np.zeros(3)).translated(moved[index])
        parts.append(body)
    whole = reduce(add, parts)
    velocities = [np.cross(spin, part.centre) + drift for spin, drift, part in zip(spins, drifts, parts, strict=True)]
    drift = sum(part.mass * velocity for part, velocity in zip(parts, velocities, strict=True)) / whole.mass
    momentum, mixed = np.zeros(3), np.zeros((3, 3))
    for part, spin, velocity in zip(parts, spins, velocities, strict=True):
        lever = part.centre - whole.centre
        momentum += part.inertia @ spin + part.mass * np.cross(lever, velocity - drift)
        turning = second_moment_from_inertia(part.inertia) @ np.cross(spin, np.eye(3))
        mixed += part.mass * np.outer(lever, velocity - drift) + turning
    grown = mixed + mixed.T
    return Posture(parts, whole, momentum, inertia_from_second_moment(grown))


@with_quantities()
def free_turning(
    limbs: Sequence[Limb],
    joints: Callable[[float], tuple[Array, Array]],
    times: Array,
    angular_momentum: Array = (0.0, 0.0, 0.0),
) -> tuple[np.ndarray, np.ndarray]:
    """Attitudes (T, 3, 3) of the trunk, to space, and its angular velocities (T, 3) in its own axes, at `times` (T,).

    joints: a function of the time that returns angles and rates (limbs,) each; angular_momentum: L (3,) in space, which
    is kept. The trunk's axes are those of space at times[0]. Relative error 1e-10.

    >>> from astroinertia.inertia import shapes
    >>> limbs = [Limb(shapes.disc(1.0, 1.0)), Limb(shapes.disc(1.0, 1.0), parent=0)]  # two wheels on one axle
    >>> half = lambda t: ([0.0, np.pi * t], [0.0, np.pi])  # half a turn of the one against the other, without L
    >>> attitudes, _ = free_turning(limbs, half, [0.0, 1.0])
    >>> print(attitudes[-1].round(6)[0, 0])  # turns the first back by a quarter
    0.0
    """
    times, momentum = np.asarray(times, dtype=float), np.asarray(angular_momentum, dtype=float)
    steps = np.diff(times)
    if (steps > 0).any() and (steps < 0).any():
        raise InputError("times must go one way, forwards or back")

    def spin(time: float, attitude: Rotation) -> np.ndarray:
        now = posture(limbs, *joints(time))
        return np.linalg.solve(now.whole.inertia, attitude.inv().apply(momentum) - now.relative_momentum)

    def rate(time: float, quaternion: np.ndarray) -> np.ndarray:
        w = spin(time, Rotation.from_quat(quaternion))
        vector, scalar = quaternion[:3], quaternion[3]
        return 0.5 * np.append(scalar * w + np.cross(vector, w), -vector @ w)

    start = Rotation.identity().as_quat()
    if times[-1] == times[0]:  # which is no way to go
        quaternions = np.tile(start, (len(times), 1))
    else:
        path = solve_ivp(rate, (times[0], times[-1]), start, "DOP853", times, rtol=_TOLERANCE, atol=_TOLERANCE)
        quaternions = path.y.T
    attitudes = Rotation.from_quat(quaternions)
    return attitudes.as_matrix(), np.array([spin(time, one) for time, one in zip(times, attitudes, strict=True)])
