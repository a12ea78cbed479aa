"""Stars from codes of stellar evolution, in a scene."""

from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from astroinertia.errors import SceneError
from astroinertia.scene.body_kinds.stretched import Stretched, Unknown
from astroinertia.scene.dimensional import Mass, Real
from astroinertia.scene.initial_body import PlanLine
from astroinertia.scene.source import file_of_scene


class ProfileBody(Unknown, Stretched):
    """A star from a code of stellar evolution: shells with mass, density, pressure and rotation."""

    kind: Literal["profile"]
    rank: ClassVar[int] = 10
    models: ClassVar[tuple[str, ...]] = ("sph",)
    structure: ClassVar[str] = "spheres.progenitor"
    rotates_itself: ClassVar[bool] = True
    file: Annotated[str, Field(min_length=1, max_length=512)] = Field(
        description="stellar profile, relative to the scene: MESA profile.data or .mod, KEPLER presupernova file or "
        ".csv with units"
    )
    inner_mass: Mass | None = Field(default=None, description="take only what lies within this enclosed mass")
    rotation_factor: Annotated[Real, Field(ge=-1e6, le=1e6)] = Field(
        default=1.0, description="shells turn about z at this many times the file's rate, where it states one"
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

    def shells(self, scene: Any) -> Any:
        """The shells that are taken of its file (sph.progenitor.Progenitor), in SI; SceneError for what is none."""
        return shells_of(file_of_scene(scene.origin, self.file), self.inner_mass, self.mean_molecular_weight)

    def check(self, scene: Any) -> None:
        """Its numbers have units; `load` takes the star's own mass and radius where the scene has none."""
        super().check(scene)
        if scene.units in (None, "SI") or scene.dimensionless:
            raise ValueError("[units] with mass and length is needed for a body of kind profile.")

    def describe(self, scene: Any) -> list[PlanLine]:
        """Its file and what is taken of it."""
        part = "all of it"
        if self.inner_mass is not None:
            part = f"the inner {scene.shown(self.inner_mass, 'mass')}"
        shells = self.shells(scene)
        mass, radius = float(shells.mass[-1]), float(shells.radius[-1])
        lines: list[PlanLine] = [
            ("kind", f"profile from {self.file}", part),
            ("shells", f"{shells.mass.size}", f"{scene.shown(mass, 'mass')} within {scene.shown(radius, 'length')}"),
            (
                "moment of inertia",
                scene.shown(shells.moment_of_inertia, "moment_of_inertia"),
                f"{shells.moment_of_inertia / (mass * radius**2):.6g} M R^2",
            ),
            ("particles", f"{self.particles}"),
        ]
        if self.rotation is None and shells.angular_velocity is None:
            lines.append(("shells turn", "no", "the file states no rotation"))
        elif self.rotation is None:
            mean = self.rotation_factor * shells.angular_momentum / shells.moment_of_inertia
            turn = f"about z, in the mean (L/I) at {mean:.6g} rad/s"
            lines.append(("shells turn", f"{self.rotation_factor:g} times as fast as the file says", turn))
        return [*lines, ("placement", self.placement, f"seed {self.seed}, not settled first")]


def shells_of(path: Path, inner_mass: float | None, mean_molecular_weight: float | None = None) -> Any:
    """The shells of a stellar profile within a mass, of all of it without one; SceneError for what is none."""
    stamp = path.stat().st_mtime_ns if path.exists() else 0
    shells = _read(path, stamp, mean_molecular_weight)
    if inner_mass is None:
        return shells
    try:
        return shells.inner(inner_mass)
    except ValueError as error:
        raise SceneError(f"[body] inner_mass: {error}.") from None


@lru_cache(maxsize=4)  # a file that is written again has another stamp
def _read(path: Path, stamp: int, mean_molecular_weight: float | None) -> Any:
    from astroinertia.sph.progenitor import read_progenitor  # only where there is a file to open

    return read_progenitor(path, mean_molecular_weight)
