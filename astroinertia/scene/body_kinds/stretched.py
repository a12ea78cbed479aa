"""What bodies of a known profile have in common: axes that stretch them, and, of most, a mass and a radius."""

from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, model_validator

from astroinertia.scene.dimensional import Length, Mass, PositiveNumber
from astroinertia.scene.fluids import as_tuple
from astroinertia.scene.initial_body import UNIT_MATRIX, Body, Count, Matrix, Perturbation, at_right_angles

Axes = Annotated[tuple[PositiveNumber, PositiveNumber, PositiveNumber], BeforeValidator(as_tuple)]


def profiles() -> Any:
    """The module that makes profiles (sph.profiles)."""
    from astroinertia.sph import profiles  # with SciPy, which a scene does without until something is asked of it

    return profiles


class Unknown:
    """Of a body whose mass and radius only what it is made from knows."""

    mass = None
    radius = None


class Stretched(Body):
    """A sphere that axes stretch, or particles that they do."""

    particles: Count | None = Field(default=None, description="number of particles (model sph)")
    axes: Axes = Field(default=(1.0, 1.0, 1.0), description="stretch along x, y and z, or along axes_at_start")
    axes_at_start: Matrix = Field(
        default=UNIT_MATRIX, description="directions that axes stretch along, one a row, at right angles"
    )
    perturbation: Perturbation | None = Field(default=None, description="a density that is uneven about the z axis")

    @model_validator(mode="after")
    def _has_right_angles(self) -> Self:
        at_right_angles(self.axes_at_start)
        return self

    @model_validator(mode="after")
    def _uneven_about_its_axis(self) -> Self:
        tilted = self.rotation is not None and any(self.rotation.direction[:2])
        if self.perturbation is not None and tilted:
            raise ValueError("has a perturbation about z, but a rotation about another axis.")
        return self


class Sized(Stretched):
    """One whose mass and radius the scene says."""

    mass: Mass = Field(description="total mass")
    radius: Length = Field(description="radius before the axes stretch it; semi-axes are radius * axes")
