"""The reaction of the gravitational waves that a body sends out."""

from dataclasses import dataclass
from typing import Any, ClassVar

from astroinertia.bodies import affine_motion
from astroinertia.effects.effect import Effect
from astroinertia.pytree import pytree


@pytree
@dataclass(frozen=True, eq=False)
class RadiationReaction(Effect):
    """a_i = -(2/5) (G/c^5) d5 (Q_ij - tr(Q) delta_ij/3)/dt5 x_j (Burke & Thorne 1970; MTW 1973, eq. 36.8).

    The fifth derivative is that of the motion under gravity and pressure alone, to lowest order in 1/c^5. On average
    over a period the energy falls by (1/5) (G/c^5) (d3 Q/dt3)^2, the quadrupole formula.
    """

    speed_of_light: Any

    kind: ClassVar[str] = "radiation_reaction"
    external: ClassVar[bool] = True

    def affine_force(self, body):
        """q M F, of the acceleration M x."""
        fifth = affine_motion.second_moment_derivatives(
            body.deformation, body.rate, body.second_moment, body.conservative
        )[-1]
        reaction = affine_motion.radiation_reaction_tensor(fifth, self.speed_of_light**-5.0)
        return body.second_moment * reaction @ body.deformation
