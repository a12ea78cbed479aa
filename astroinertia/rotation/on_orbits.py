"""Companions of a particle fluid that keep to the orbits of point masses, whatever the fluid does."""

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from astroinertia.engines.pytree import pytree
from astroinertia.rotation.ephemeris import Ephemeris

Array = Any


@pytree
@dataclass(frozen=True)
class OnOrbits:
    """Companions on given orbits: mass (n,), and where they are now, (n, 3), as gravity.point_masses.PointMasses.

    Places are relative to the body of mass body_mass, a point to the orbits; or, with `inertial`, to the centre of mass
    of all, at rest. Tests: tests/physics/test_companions.py.
    """

    of_body: ClassVar[bool] = False

    orbits: Ephemeris
    body_mass: Array
    mass: Array
    position: Array
    velocity: Array
    inertial: bool = field(metadata={"static": True})

    def drifted(self, dt: Array, time: Array) -> "OnOrbits":
        """Where they are at `time`."""
        position, velocity = self.orbits.position(time), self.orbits.velocity(time)
        if self.inertial:
            position, velocity = (vectors + self._body(vectors) for vectors in (position, velocity))
        return replace(self, position=position, velocity=velocity)

    def body(self, xp: Any) -> tuple[Array, Array]:
        """Place and velocity of the body now, (3,)."""
        if not self.inertial:
            return xp.zeros(3), xp.zeros(3)
        # Relative to the centre of mass of all, M x + sum M_k x_k = 0.
        return -(self.mass @ self.position) / self.body_mass, -(self.mass @ self.velocity) / self.body_mass

    def _body(self, relative: Array) -> Array:
        return -(self.mass @ relative) / (self.body_mass + self.mass.sum())


def on_orbits(xp: Any, orbits: Ephemeris, body_mass: float, inertial: bool) -> OnOrbits:
    """Companions at the start of their orbits."""
    mass, time = xp.asarray(orbits.mass), xp.asarray(orbits.start)
    nowhere = xp.zeros((mass.shape[0], 3))
    begun = OnOrbits(orbits, xp.asarray(body_mass), mass, nowhere, nowhere, inertial)
    return begun.drifted(xp.zeros(()), time)
