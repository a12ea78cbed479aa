"""Point masses beside a fluid: what they do to it, what it does to them, and how they move with it.

Each is softened as Plummer's sphere: a = -M d/(d^2 + s^2)^(3/2) with d = x - X. What the fluid does to a point is
summed from the same products, so that momentum and angular momentum of both together stay.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from astroinertia.engines.pytree import pytree

Array = Any
NEVER = 1e-60  # the square of a rate, in code units, that limits nothing
BESIDE = -0.5  # q below which a particle is so near a point that its own pull is most of the tide
UNNOTICED = 1e-3  # of the speed of sound: a pass that changes a velocity by less need not be resolved


@pytree
@dataclass(frozen=True)
class PointMasses:
    """Point masses that move with a fluid by the same kicks and drifts: mass (n,), and (n, 3) in an inertial frame.

    softening is their own. of_body: whether they are part of the body that the fluid is, as stars amid their gas are.
    """

    of_body: ClassVar[bool] = False

    mass: Array
    position: Array
    velocity: Array
    softening: Array

    def drifted(self, dt: Array, time: Array) -> "PointMasses":
        """Where they are dt later, at `time`."""
        return replace(self, position=self.position + dt * self.velocity)

    def by_each_other(self, xp: Any, everyone: Iterable["PointMasses"]) -> Array:
        """Their accelerations by all point masses, themselves among these, (n, 3)."""
        total = xp.zeros_like(self.position)
        for other in everyone:
            soft = self.softening**2 + other.softening**2
            total = total + attraction(xp, self.position, other.mass, other.position, soft, alone=other is self)
        return total

    def meeting_time(self, xp: Any, everyone: Iterable["PointMasses"], sound_speed: Array) -> Array:
        """The shortest time scale of the orbit or the pass of two point masses, one of these among them, a scalar.

        sound_speed: of the coldest of the fluid; a pass that changes velocities by less than UNNOTICED of it is no
        limit.
        """
        rate, noticed = xp.zeros(()), (UNNOTICED * sound_speed) ** 2
        for other in everyone:
            for k in range(other.mass.shape[0]):
                away, relative = self.position - other.position[k], self.velocity - other.velocity[k]
                squared = xp.sum(away**2, axis=1) + self.softening**2 + other.softening**2
                same = xp.arange(len(squared)) == (k if other is self else -1)
                squared = xp.where(same | (squared <= 0.0), 1.0, squared)
                mass = self.mass + other.mass[k]
                pair = xp.maximum(mass / squared**1.5, passing_rate(xp, away, relative, squared, mass, noticed))
                rate = xp.maximum(rate, xp.max(xp.where(same, 0.0, pair), initial=0.0))
        return 1.0 / xp.sqrt(rate + NEVER)

    def energy(self, xp: Any, everyone: Iterable["PointMasses"]) -> Array:
        """Kinetic energy, and half of the potential energy with all point masses."""
        total = 0.5 * xp.sum(self.mass * xp.sum(self.velocity**2, axis=1))
        for other in everyone:
            soft = self.softening**2 + other.softening**2
            total = total + 0.5 * potential_energy(
                xp, self.mass, self.position, other.mass, other.position, soft, alone=other is self
            )
        return total


def attraction(
    xp: Any, position: Array, mass: Array, place: Array, softening_squared: Array, alone: bool = False
) -> Array:
    """Accelerations (N, 3) at positions (N, 3) by points of that mass (n,) at places (n, 3).

    alone: both are the same points, none of which acts on itself.
    """
    total = xp.zeros_like(position)
    for k in range(mass.shape[0]):
        away, weight = _weight(xp, position, place[k], softening_squared, k if alone else None)
        total = total - mass[k] * weight[:, None] * away
    return total


def reaction(xp: Any, weight: Array, position: Array, place: Array, softening_squared: Array) -> Array:
    """Accelerations (n, 3) of points at places (n, 3) by particles (N, 3), their masses or these times a span, (N,)."""
    rows = []
    for k in range(place.shape[0]):
        away, w = _weight(xp, position, place[k], softening_squared)
        rows.append(xp.sum((weight * w)[:, None] * away, axis=0))
    return xp.stack(rows) if rows else xp.zeros_like(place)


def potential_energy(
    xp: Any, weight: Array, position: Array, mass: Array, place: Array, softening_squared: Array, alone: bool = False
) -> Array:
    """-sum m M/(d^2 + s^2)^(1/2) of particles (N,), (N, 3) and points (n,), (n, 3)."""
    total = xp.zeros(())
    for k in range(mass.shape[0]):
        distance = _softened_distance(xp, position, place[k], softening_squared)
        share = xp.where(xp.arange(len(distance)) == k, 0.0, weight) if alone else weight
        total = total - mass[k] * xp.sum(share / distance)
    return total


def specific_potential(xp: Any, position: Array, mass: Array, place: Array, softening_squared: Array) -> Array:
    """-sum M/(d^2 + s^2)^(1/2) at positions (N, 3) of points (n,), (n, 3): (N,)."""
    total = xp.zeros(position.shape[0])
    for k in range(mass.shape[0]):
        total = total - mass[k] / _softened_distance(xp, position, place[k], softening_squared)
    return total


def virial(
    xp: Any, weight: Array, position: Array, centre: Array, mass: Array, place: Array, softening_squared: Array
) -> Array:
    """V = -sum m w x' (x) x' - sum m (w - w_c) x' (x) (c - X) for each point, the second being the torque and more.

    c is the centre of mass, x' = x - c, w = M/(d^2 + s^2)^1.5 and w_c its value at c, no larger than at the nearest
    particle: what is uniform over the body has no moment. (N,), (N, 3), (3,), (n,), (n, 3): (3, 3).
    """
    total = xp.zeros((3, 3))
    for k in range(mass.shape[0]):
        _, at_centre = _weight(xp, centre[None], place[k], softening_squared)
        _, w = _weight(xp, position, place[k], softening_squared)
        growth = _growth(excess(xp, position - centre, place[k] - centre, softening_squared), at_centre / w)
        total = total - mass[k] * central_moment(xp, weight, position, centre, place[k], w, at_centre, growth)
    return total


def central_moment(
    xp: Any, mass: Array, position: Array, centre: Array, place: Array, weight: Array, at_centre: Array, growth: Array
) -> Array:
    """Sum m w x' (x) x' + sum m (w - w_c) x' (x) (c - X) of the weights w (N,) of a pull -w d towards X, (3, 3).

    at_centre (1,): their value at c; growth (N,): that over w, less one, from a form that does not cancel far away,
    where weights differ in their last digits only. Symbols as in `virial`.
    """
    relative, nearest = position - centre, xp.max(weight)
    rise = xp.where(at_centre <= nearest, -growth * weight, weight - nearest)
    symmetric = xp.einsum("n,ni,nj->ij", mass * weight, relative, relative)
    return symmetric + xp.outer((mass * rise) @ relative, centre - place)


def tidal_attraction(xp: Any, position: Array, mass: Array, place: Array, softening_squared: Array) -> Array:
    """`attraction` less that at the origin, which falls freely, (N, 3).

    -M [x + ((1 + q)^1.5 - 1) X]/(d^2 + s^2)^1.5 does not cancel far away (Battin 1999, Astrodynamics, eq. 8.62), and
    the difference itself does not near a point.
    """
    total = xp.zeros_like(position)
    for k in range(mass.shape[0]):
        away, weight = _weight(xp, position, place[k], softening_squared)
        at_origin = (xp.sum(place[k] ** 2) + softening_squared) ** -1.5
        q = excess(xp, position, place[k], softening_squared)
        far = weight[:, None] * (position + _growth(q, at_origin / weight)[:, None] * place[k])
        near = weight[:, None] * away + at_origin * place[k]
        total = total - mass[k] * xp.where((q < BESIDE)[:, None], near, far)
    return total


def tidal_energy(xp: Any, weight: Array, position: Array, mass: Array, place: Array, softening_squared: Array) -> Array:
    """`potential_energy` less its value and its slope at the origin.

    -M/D times (q/(1 + r))^2 (1/2 + 1/r) - x^2/(2 D^2), r = (1 + q)^(1/2): the terms of first order are not in it.
    """
    total = xp.zeros(())
    for k in range(mass.shape[0]):
        squared = xp.sum(place[k] ** 2) + softening_squared
        distance = xp.sum((position - place[k]) ** 2, axis=1) + softening_squared
        root = xp.sqrt(xp.where(distance > 0.0, distance, 1.0) / squared)
        curved = (excess(xp, position, place[k], softening_squared) / (1.0 + root)) ** 2 * (0.5 + 1.0 / root)
        beyond = curved - 0.5 * xp.sum(position**2, axis=1) / squared
        total = total - mass[k] * (weight @ beyond) / xp.sqrt(squared)
    return total


def excess(xp: Any, position: Array, place: Array, softening_squared: Array) -> Array:
    """q of d^2 + s^2 = (X^2 + s^2) (1 + q) at positions (N, 3) from where a point is at X, (3,): (N,)."""
    squared = xp.sum(place**2) + softening_squared
    return (xp.sum(position**2, axis=1) - 2.0 * position @ place) / xp.where(squared > 0.0, squared, 1.0)


def orbital_time(xp: Any, position: Array, mass: Array, place: Array, softening_squared: Array) -> Array:
    """((d^2 + s^2)^1.5/M)^(1/2) of each particle and the point that it is shortest for, (N,)."""
    rate = xp.zeros(position.shape[0])
    for k in range(mass.shape[0]):
        squared = xp.sum((position - place[k]) ** 2, axis=1) + softening_squared
        rate = xp.maximum(rate, mass[k] / squared**1.5)
    return 1.0 / xp.sqrt(rate + NEVER)


def passing_rate(
    xp: Any, away: Array, relative: Array, squared: Array, mass: Array, noticed_squared: Array
) -> Array:  # fmt: skip
    """The square of the rate w/(d^2 + s^2)^(1/2) at which points pass each other, (N,).

    away, relative: their separations and relative velocities w, (N, 3); squared: d^2 + s^2, (N,); mass: what attracts,
    () or (N,). On a straight line they come as near as b = |d x w|/w, or are there already and go away, and the
    velocity changes by M/(b w) or so (Binney & Tremaine 2008, eq. 1.30). Where that is below a speed, noticed_squared
    its square, the rate is lower by as much. Tests: tests/unit/effects/test_passes.py.
    """
    speed_squared = xp.sum(relative**2, axis=1)
    approach = xp.minimum(xp.sum(away * relative, axis=1), 0.0)
    moment = xp.maximum(squared * speed_squared - approach**2, 0.0)  # (b w)^2
    strength = mass**2
    unnoticed = xp.maximum(strength, noticed_squared * moment)
    return speed_squared / squared * strength / (unnoticed + NEVER)


def _weight(xp: Any, position: Array, place: Array, softening_squared: Array, alone: int | None = None) -> Any:
    away = position - place
    squared = xp.sum(away**2, axis=1) + softening_squared
    weight = xp.where(squared > 0.0, squared, 1.0) ** -1.5
    return away, weight if alone is None else xp.where(xp.arange(len(weight)) == alone, 0.0, weight)


def _growth(q: Array, ratio: Array) -> Array:
    """(1 + q)^1.5 - 1, where `ratio` is (1 + q)^1.5 to rounding."""
    return q * (3.0 + q * (3.0 + q)) / (1.0 + ratio)


def _softened_distance(xp: Any, position: Array, place: Array, softening_squared: Array) -> Array:
    """(d^2 + s^2)^(1/2) of positions (N, 3) from a point, and infinite where that is nothing: (N,).

    A particle at the point, which that pulls nowhere, has no energy with it; any length would be one of other units.
    """
    squared = xp.sum((position - place) ** 2, axis=1) + softening_squared
    return xp.sqrt(xp.where(squared > 0.0, squared, xp.inf))
