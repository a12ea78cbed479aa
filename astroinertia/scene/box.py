"""The periodic box that a scene may ask for, and what can be in one."""

from collections.abc import Callable
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from astroinertia.scene.dimensional import Length
from astroinertia.scene.fluids import Part, as_tuple

Lengths = Annotated[tuple[Length, Length, Length], BeforeValidator(as_tuple)]


class Box(Part):
    """A box that repeats itself for ever: what leaves through one face acts from beyond the opposite one."""

    lengths: Lengths = Field(description="lengths of the box along x, y and z")
    periodic: Literal["xyz", "xy", "xz", "yz", "x", "y", "z"] = Field(
        default="xyz", description="axes along which it repeats itself; along the others there is no end"
    )

    @property
    def repeats(self) -> tuple[bool, bool, bool]:
        """Whether it repeats itself along x, y and z."""
        return "x" in self.periodic, "y" in self.periodic, "z" in self.periodic

    def plan_line(self, shown: Callable[[float, str], str]) -> tuple[str, str, str]:
        """What a plan says of it; `shown` writes a quantity."""
        sides = " x ".join(shown(length, "length") for length in self.lengths)
        return "lengths", sides, f"repeats itself along {', '.join(self.periodic)}"
