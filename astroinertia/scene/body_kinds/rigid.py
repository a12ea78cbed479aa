"""Bodies of which only the moments are known, in a scene."""

import math
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from astroinertia.scene.dimensional import Length, Mass, Moment, NumberNotNegative
from astroinertia.scene.fluids import as_tuple
from astroinertia.scene.initial_body import (
    UNIT_MATRIX,
    Body,
    Matrix,
    PlanLine,
    ascending,
    at_right_angles,
    exactly_one,
    numbers,
)

_HOMOGENEOUS = 0.4  # I/(M R^2) where nothing is known of the inside
Moments = Annotated[tuple[Moment, Moment, Moment], BeforeValidator(as_tuple)]
MomentRatios = Annotated[tuple[NumberNotNegative, NumberNotNegative, NumberNotNegative], BeforeValidator(as_tuple)]


class RigidBody(Body):
    """A body of which only the mass and the inertia tensor are known."""

    kind: Literal["rigid"]
    rank: ClassVar[int] = 8
    models: ClassVar[tuple[str, ...]] = ("rigid", "scaling")
    structure: ClassVar[str] = ""
    moments_from: ClassVar[str] = "rigid.of_solid"
    solid: ClassVar[bool] = True
    particles: ClassVar[None] = None
    mass: Mass = Field(description="total mass")
    radius: Length | None = Field(default=None, description="a radius, for moment_ratios and I/(M R^2)")
    moments: Moments | None = Field(default=None, description="principal moments of inertia; or give moment_ratios")
    moment_ratios: MomentRatios | None = Field(default=None, description="principal moments over mass radius^2")
    axes_at_start: Matrix = Field(
        default=UNIT_MATRIX, description="directions of the principal axes at the start, one a row, at right angles"
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        exactly_one(self, "moments", "moment_ratios")
        if self.moment_ratios is not None and self.radius is None:
            raise ValueError("needs a radius, for it has moment_ratios.")
        a, b, c = sorted(self.moments or self.moment_ratios or ())
        if c <= 0.0:
            raise ValueError("needs moments of which two at least are positive.")
        if c > (a + b) * (1.0 + 1e-12):
            raise ValueError("needs moments of which none is larger than the sum of the others.")
        at_right_angles(self.axes_at_start)
        if np.linalg.det(self.axes_at_start) < 0.0:
            raise ValueError("needs axes_at_start that are right-handed.")
        return self

    @property
    def unit_length(self) -> float:
        """Its radius, or a radius of gyration."""
        if self.radius is not None:
            return self.radius
        assert self.moments is not None
        return math.sqrt(max(self.moments) / self.mass)

    def characteristic(self) -> dict[str, Any]:
        """By its moments; without a radius, as of a homogeneous body."""
        if self.moments is not None:
            moments = np.asarray(self.moments, dtype=float)
        else:
            assert self.radius is not None
            moments = np.asarray(self.moment_ratios, dtype=float) * self.mass * self.radius**2
        rows = self.rows_at_start
        radius = math.sqrt(moments.max() / self.mass / _HOMOGENEOUS) if self.radius is None else self.radius
        turning = self.turning(rows.T @ np.diag(moments) @ rows, None)
        return {"mass": self.mass, "radius": radius, "moments": ascending(moments), **turning}

    def describe(self, scene: Any) -> list[PlanLine]:
        """Its mass and moments."""
        lines: list[PlanLine] = [("kind", "rigid"), ("mass", scene.shown(self.mass, "mass"))]
        if self.radius is not None:
            lines.append(("radius", scene.shown(self.radius, "length")))
        if self.moments is not None:
            moments = ", ".join(scene.shown(moment, "moment_of_inertia") for moment in self.moments)
            return [*lines, ("principal moments", moments)]
        assert self.moment_ratios is not None
        return [*lines, ("principal moments", numbers(self.moment_ratios), "over mass radius^2")]
