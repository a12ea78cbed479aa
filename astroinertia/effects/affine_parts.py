"""What an effect may do to a body whose matter moves as x = centre + F xi."""

from __future__ import annotations

from typing import Any


class AffineParts:
    """The parts of an effect on an affine body.

    `body` has time, mass, second_moment (q of the sphere F = 1 along an axis), sphere_energy (its W), deformation F and
    rate dF/dt (3, 3), centre and velocity (3,), pressure_slope (dU/dJ), and conservative (d2F/dt2 by gravity and
    pressure alone, a function of F and dF/dt).
    """

    def affine_force(self, body: Any) -> Any | None:
        """G = sum m a (x) xi, (3, 3), of an affine body: its share of q d2F/dt2."""
        return None

    def affine_push(self, body: Any) -> Any | None:
        """Net force (3,) on an affine body."""
        return None

    def affine_virial(self, body: Any) -> Any | None:
        """V = sum m (x - centre) (x) a, (3, 3), of an affine body, by a route of its own; F G^T where there is none."""
        return None

    def affine_potential(self, body: Any) -> Any | None:
        """Scalar that the force on an affine body derives from, where there is one."""
        return None

    def affine_heating(self, body: Any) -> Any | None:
        """Energy per time that an affine body is heated by."""
        return None
