"""The regions that a scene may ask for, each with a ledger of its own: validated and frozen, in SI (or code units)."""

from typing import Literal, Self

from pydantic import Field, model_validator

from astroinertia.scene.dimensional import Density, Mass
from astroinertia.scene.fluids import Part

MOST_REGIONS = 16
REGION_NAME = r"^[A-Za-z][A-Za-z0-9_]{0,31}$"


class Region(Part):
    """A part of the body with its own inertia tensor and ledger; one of innermost_mass, density_above and bound."""

    innermost_mass: Mass | None = Field(
        default=None, description="the innermost particles that have this mass together"
    )
    density_above: Density | None = Field(default=None, description="what is at least this dense")
    bound: bool = Field(
        default=False,
        description="true: what its own gravity binds, and that of sinks, in the frame of its centre (Springel et al. "
        "2001)",
    )
    centre: Literal["densest", "centre_of_mass"] = Field(
        default="densest",
        description="what innermost_mass is about: the densest point (the mean of the 32 particles about the densest "
        "one, weighted by mass and density), or the body's centre of mass",
    )
    internal_energy: bool = Field(
        default=False, description="with bound: the internal energy counts against being bound, beside the kinetic one"
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        criteria = (self.innermost_mass is not None) + (self.density_above is not None) + self.bound
        if criteria != 1:
            raise ValueError("needs exactly one of innermost_mass, density_above and bound = true.")
        if "centre" in self.model_fields_set and self.innermost_mass is None:
            raise ValueError("has a centre, which only innermost_mass uses.")
        if self.internal_energy and not self.bound:
            raise ValueError("has internal_energy, which only bound uses.")
        return self

    def description(self, mass: str = "", density: str = "") -> str:
        """What it is, in words; the quantities as written for a person."""
        if self.innermost_mass is not None:
            about = "densest point" if self.centre == "densest" else "centre of mass"
            return f"the innermost {mass} about the {about}"
        if self.density_above is not None:
            return f"what is denser than {density}"
        return f"what is bound to itself{', internal energy counted' if self.internal_energy else ''}"
