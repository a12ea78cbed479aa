"""The torque of companions on a body that is no sphere, to its quadrupole."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import Characteristic, Effect, Entry, pytree
from astroinertia.effects.characteristic import Neighbour
from astroinertia.effects.measure import TURNS, Found, Measure, Options, dot, size, within_all
from astroinertia.inertia.tensor import second_moment_from_inertia


@pytree
@dataclass(frozen=True, eq=False)
class GravityGradient(Effect):
    """tau = sum over companions of 3 M/r^3 n cross (I n), each a point mass M at r n from the centre of mass (G = 1).

    MacCullagh's formula: the body's field to its quadrupole, which leaves out terms of the order of its radius over r
    (Murray & Dermott 1999, Solar System Dynamics, section 5.2; Goldstein, Poole & Safko 2002, eq. 5.86 and 5.88).
    Checked by tests/unit/effects/kinds/test_gravity_gradient.py.
    """

    kind: ClassVar[str] = "gravity_gradient"
    external: ClassVar[bool] = True
    follows_spin: ClassVar[bool] = False

    @property
    def potential_moves(self):
        """Yes, with the companions."""
        return True

    def torque(self, body):
        """About the centre of mass, in inertial axes; None without companions."""
        if body.companions is None:
            return None
        weight, towards = _field(body)
        return jnp.sum(3.0 * weight * jnp.cross(towards, towards @ body.inertia), axis=0)

    def potential(self, body):
        """-sum M/(2 r^3) (tr I - 3 n . I n), at the present places of the companions."""
        if body.companions is None:
            return None
        weight, towards = _field(body)
        along = jnp.sum(towards * (towards @ body.inertia), axis=-1)
        return -0.5 * weight[:, 0] @ (jnp.trace(body.inertia) - 3.0 * along)

    def rigid_virial(self, body):
        """Q T with the tidal tensor T = sum M/r^3 (3 n (x) n - 1) and the second moment Q."""
        if body.companions is None:
            return None
        weight, towards = _field(body)
        tidal = 3.0 * (weight * towards).T @ towards - jnp.sum(weight) * jnp.eye(3)
        return second_moment_from_inertia(body.inertia) @ tidal

    def frequency(self, body):
        """Of the swing of the longest axis about the direction of the companions, all on one side."""
        if body.companions is None:
            return None
        least, middle, largest = jnp.sort(body.principal_moments)
        return jnp.sqrt(3.0 * jnp.sum(_field(body)[0]) * (largest - least) / middle)


def quadrupole_attraction(body: Any) -> Any:
    """Accelerations of companions by the body's quadrupole, (N, 3): 3/(2 r^4) [(5 n . I n - tr I) n - 2 I n].

    The forces are the slope of the effect's potential, and with its torque leave the angular momentum of all as it is.
    Checked by tests/unit/effects/kinds/test_gravity_gradient.py.
    """
    place = body.companions.position(body.time)
    square = jnp.sum(place**2, axis=-1, keepdims=True)
    towards = place / jnp.sqrt(square)
    turned = towards @ body.inertia
    along = jnp.sum(towards * turned, axis=-1, keepdims=True)
    return 1.5 / square**2 * ((5.0 * along - jnp.trace(body.inertia)) * towards - 2.0 * turned)


def _field(body: Any) -> tuple[Any, Any]:
    """M/r^3 (N, 1) and the directions n (N, 3) of the companions now."""
    place = body.companions.position(body.time)
    square = jnp.sum(place**2, axis=-1, keepdims=True)
    return jnp.asarray(body.companions.mass)[:, None] / square**1.5, place / jnp.sqrt(square)


def gradient_turn(body: Characteristic, other: Neighbour) -> float:
    """The angle, in rad, by which the torque of another body on the figure moves the axis in the run.

    A figure that turns about its largest moment is averaged over its rotation: (3/2) (G M'/(a^3 (1 - e^2)^(3/2)))
    (H/omega) sin eps cos eps t with H = 1 - (A + B)/(2 C), and the rest, of B - A, acts as long as the body shows the
    other one the same side, 1/(2 |omega - n|). One that tumbles is not averaged.
    """
    assert body.moments is not None and body.spin is not None
    least, middle, largest = body.moments
    strength = 1.5 * body.gravitational_constant * other.mass
    strength /= other.distance**3 * (1.0 - other.eccentricity**2) ** 1.5
    if not body.spin:
        return strength * (largest - least) / largest * body.end**2
    cosine = min(1.0, abs(dot(body.spin_axis, other.normal)) / (size(body.spin_axis) * size(other.normal)))
    oblique = cosine * math.sqrt(1.0 - cosine**2)
    if body.wobble > 0.1:
        return strength / body.spin * (largest - least) / largest * body.end * max(oblique, body.wobble)
    relative = 2.0 * abs(body.spin - other.rate)
    lasts = body.end if relative * body.end < 1.0 else 1.0 / relative
    steady = (1.0 - (least + middle) / (2.0 * largest)) * oblique * body.end
    return strength / body.spin * (steady + (middle - least) / largest * lasts)


def _size(body: Characteristic, options: Options) -> Found:
    if not body.neighbours:
        return 0.0, 0.0
    assert body.spin is not None
    turn = sum(gradient_turn(body, other) for other in body.neighbours)
    return turn / max(body.spin * body.end, 1e-300), within_all(turn)


ENTRY = Entry(
    "the torque of companions on a body that is no sphere, to its quadrupole",
    {},
    "body", "Murray & Dermott 1999, section 5.2", ("rigid",), colour="blue", auto="always",
    size=Measure(
        "torque over L omega", "(3/2) (G M'/a^3) (H/omega) sin eps cos eps t, and what of B - A is not averaged out",
        "Murray & Dermott 1999, 5.2; Goldreich 1966", _size, (*TURNS, "neighbours"),
    ),
    made=GravityGradient, rank=23,
)  # fmt: skip
