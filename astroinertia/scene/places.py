"""Where bodies are at first and how they move: one by one, or two of them on an orbit (SI or code units)."""

from collections.abc import Callable
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, model_validator

from astroinertia.scene.dimensional import Length, Place, Real, SpeedComponent
from astroinertia.scene.fluids import Part, as_tuple

MOST_BODIES = 20

Position = Annotated[tuple[Place, Place, Place], BeforeValidator(as_tuple)]
Velocity = Annotated[tuple[SpeedComponent, SpeedComponent, SpeedComponent], BeforeValidator(as_tuple)]


class Orbit(Part):
    """Two bodies on an orbit about their centre of mass, as point masses, in the x-y plane: on their way inwards."""

    pericentre: Length = Field(
        description="least distance of the centres, towards +x from the first body to the second"
    )
    eccentricity: Annotated[Real, Field(ge=0.0, le=1e6)] = Field(
        default=0.0, description="eccentricity: below 1 an ellipse, 1 a parabola, above 1 a hyperbola"
    )
    separation: Length | None = Field(
        default=None, description="distance of the centres at time 0; without it, they begin at the pericentre"
    )

    @model_validator(mode="after")
    def _reaches(self) -> Self:
        if self.separation is None:
            return self
        if self.separation < self.pericentre:
            raise ValueError("has a separation that is less than the pericentre.")
        farthest = self.pericentre * (1.0 + self.eccentricity)  # (1 - e) times the apocentre
        if self.separation * (1.0 - self.eccentricity) > farthest * (1.0 + 1e-12):
            raise ValueError("has a separation that is beyond the apocentre.")
        return self

    def plan_lines(self, shown: Callable[[float, str], str]) -> list[tuple[str, str, str]]:
        """The lines of the plan: name, value and why, with quantities as `shown` writes them."""
        separation = self.pericentre if self.separation is None else self.separation
        return [
            ("pericentre", shown(self.pericentre, "length"), f"eccentricity {self.eccentricity:g}"),
            ("separation", shown(separation, "length"), "at time 0, on the way in"),
        ]


def place_lines(position: Any, velocity: Any, shown: Callable[[float, str], str]) -> list[tuple[str, str]]:
    """The lines of the plan on a body that is not at rest at the origin."""
    vectors = (("position", position, "length"), ("velocity", velocity, "velocity"))
    return [
        (f"{name} of its centre", f"({', '.join(shown(x, dimension) for x in vector)})")
        for name, vector, dimension in vectors
        if vector is not None
    ]
