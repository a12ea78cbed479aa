"""Stars from codes of stellar evolution, in a scene."""

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from astroinertia.scene.body_kinds.stretched import Stretched, Unknown
from astroinertia.scene.dimensional import Mass, Real
from astroinertia.scene.initial_body import PlanLine


class ProfileBody(Unknown, Stretched):
    """A star from a code of stellar evolution: shells with mass, density, pressure and rotation."""

    kind: Literal["profile"]
    rank: ClassVar[int] = 10
    models: ClassVar[tuple[str, ...]] = ("sph",)
    structure: ClassVar[str] = "spheres.progenitor"
    rotates_itself: ClassVar[bool] = True
    file: Annotated[str, Field(min_length=1, max_length=512)] = Field(
        description="stellar profile, relative to the scene: MESA profile.data, KEPLER presupernova file or .csv with "
        "units"
    )
    inner_mass: Mass | None = Field(default=None, description="take only what lies within this enclosed mass")
    rotation_factor: Annotated[Real, Field(ge=-1e6, le=1e6)] = Field(
        default=1.0, description="shells turn about z at this many times the file's rate, where it tells one"
    )
    mean_molecular_weight: Annotated[Real, Field(gt=0.1, le=300.0)] | None = Field(
        default=None, description="of the ideal gas whose pressure is taken where a file has temperatures but none"
    )
    relax: bool = Field(default=False, description="must be false: a profile is placed as it is")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.relax:
            raise ValueError("has relax = true, but a profile is placed as the file has it.")
        if self.rotation is not None and "rotation_factor" in self.model_fields_set:
            raise ValueError("has a table rotation, which takes the place of the file's, and a rotation_factor.")
        return self

    def check(self, scene: Any) -> None:
        """Its file is in SI and sets no units."""
        super().check(scene)
        if scene.units in (None, "SI") or scene.dimensionless:
            raise ValueError("[units] with mass and length is needed for a body of kind profile.")

    def describe(self, scene: Any) -> list[PlanLine]:
        """Its file and what is taken of it."""
        part = "all of it"
        if self.inner_mass is not None:
            part = f"the inner {scene.shown(self.inner_mass, 'mass')}"
        lines: list[PlanLine] = [("kind", f"profile from {self.file}", part), ("particles", f"{self.particles}")]
        if self.rotation is None:
            lines.append(("shells turn", f"{self.rotation_factor:g} times as fast as the file says", "about z"))
        return [*lines, ("placement", self.placement, f"seed {self.seed}, not settled first")]
