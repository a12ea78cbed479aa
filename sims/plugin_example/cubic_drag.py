"""An effect from outside the package: drag in proportion to the cube of the speed."""

from dataclasses import dataclass
from typing import Any, ClassVar

from astroinertia.effects import REQUIRED, Dimension, Effect, positive, pytree


@pytree
@dataclass(frozen=True, eq=False)
class CubicDrag(Effect):
    """Drag a = -k |v|^2 v of a medium that is at rest in the inertial frame.

    A free particle has v(t) = v0/sqrt(1 + 2 k v0^2 t). What the fluid loses goes to the medium, as work of this effect.
    """

    k: Any

    kind: ClassVar[str] = "cubic_drag"
    external: ClassVar[bool] = True
    source: ClassVar[str] = "the equation of motion in closed form"
    options: ClassVar = {"k": positive(Dimension(0, -2, 1), REQUIRED, "acceleration over the cube of the speed")}

    def rate(self, fluid):
        """k |v|^2 of each particle, (N,)."""
        return self.k * (fluid.velocity**2).sum(axis=1)

    def acceleration(self, xp, fluid):
        """-k |v|^2 v, (N, 3); velocities are those that are predicted for the end of the step: second order."""
        return -self.rate(fluid)[:, None] * fluid.velocity

    def virial(self, xp, fluid):
        """V = -k sum m |v|^2 (x - c) (x) v, (3, 3)."""
        return -((fluid.mass * self.rate(fluid))[:, None] * (fluid.position - fluid.centre)).T @ fluid.velocity

    def timestep(self, xp, fluid):
        """1/(k |v|^2), (N,), the time in which the speed would fall to nothing."""
        return 1.0 / xp.maximum(self.rate(fluid), 1e-30)
