"""Sinks that a scene has from the start: validated and frozen, in SI (or code units)."""

from collections.abc import Callable

from pydantic import Field

from astroinertia.scene.dimensional import Mass
from astroinertia.scene.fluids import Part
from astroinertia.scene.places import Position, Velocity

MOST_SINKS = 100


class Sink(Part):
    """A sink that is there from the start, such as a star amid its disc (with the effect sinks)."""

    mass: Mass = Field(description="its mass at the start")
    position: Position | None = Field(default=None, description="where it is; at the origin without it")
    velocity: Velocity | None = Field(default=None, description="its velocity; at rest without it")

    def plan_line(self, shown: Callable[[float, str], str]) -> tuple[str, str, str]:
        """The line of the plan: name, mass and where it is, with quantities as `shown` writes them."""
        place = ", ".join(shown(x, "length") for x in self.position or (0.0, 0.0, 0.0))
        return ("mass", shown(self.mass, "mass"), f"at ({place})")
