"""What an effect may do to a body that keeps its shape, or changes it as prescribed."""

from __future__ import annotations

from typing import Any, ClassVar


class RigidParts:
    """The parts of an effect on a rigid body.

    `body` has time, mass, attitude (3, 3) (the body's axes as the scene gives them, one a row), moments (3,) (about
    those axes), principal_moments (3,) (ascending, at rest), inertia (3, 3), angular_momentum (3,) and angular_velocity
    (3,), all in inertial axes, about the centre of mass or the pivot; and companions, whose `position` at a time is
    (n, 3).

    A torque is taken for one that depends on the angular velocity or on L. Where it does not, a class says
    `follows_spin: ClassVar[bool] = False`: the integrator "splitting" then takes far less time for it. It says
    `conservative: ClassVar[bool] = True` where its `potential` does not depend on time, so that
    integration_energy_error compares its work with it.
    """

    follows_spin: ClassVar[bool] = False
    """Its torque depends on the angular velocity or on L, or it has a relative rotation: so with a part for either,
    unless its class says that it does not."""
    conservative: ClassVar[bool] = False
    """Its `potential` does not depend on time: what it does to a rigid body is found again there."""

    def torque(self, body: Any) -> Any | None:
        """Torque (3,) on a rigid body about its centre of mass, or its pivot, in inertial axes."""
        return None

    def relative_rotation(self, body: Any) -> Any | None:
        """Angular velocity (3,) by which a rigid body's axes turn beyond I^-1 L: internal forces, which leave L alone.

        Its power, s . (omega cross L), must not be positive: it is the heat that the body gains.
        """
        return None

    def potential(self, body: Any) -> Any | None:
        """Scalar that the torque on a rigid body derives from, where there is one."""
        return None

    def rigid_virial(self, body: Any) -> Any | None:
        """V (3, 3) of a rigid body about its centre of mass; without it, the torque's antisymmetric part alone."""
        return None

    def frequency(self, body: Any) -> Any | None:
        """The largest angular frequency that the torque brings to a rigid body, which steps must resolve."""
        return None

    def impulse(self, body: Any) -> Any | None:
        """What is added to the angular momentum of a rigid body at once, (3,), at one of the breaks."""
        return None
