"""The user's own particles in a scene."""

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from astroinertia.scene.body_kinds.stretched import Unknown
from astroinertia.scene.dimensional import Speed
from astroinertia.scene.initial_body import Body, PlanLine
from astroinertia.scene.source import file_of_scene
from astroinertia.units import shown as readable


class TableBody(Unknown, Body):
    """The user's own particles."""

    kind: Literal["table"]
    rank: ClassVar[int] = 9
    models: ClassVar[tuple[str, ...]] = ("sph", "rigid")
    structure: ClassVar[str] = ""
    placing: ClassVar[str] = "placing.of_table"
    moments_from: ClassVar[str] = "rigid.of_table"
    turns_with_axis: ClassVar[bool] = False
    boxed: ClassVar[bool] = True
    without_heat: ClassVar[str] = "a table without a column u"
    particles: ClassVar[None] = None
    file: Annotated[str, Field(min_length=1, max_length=512)] = Field(
        description="particle table (.csv .npz .nc .h5), relative to the scene: mass x y z and, if wanted, vx vy vz u; "
        "or a snapshot of GADGET or SWIFT (.hdf5), or a dump of Phantom"
    )
    velocity_unit: Speed | None = Field(
        default=None,
        description="unit of the velocities of a snapshot that states no units: its masses and lengths are in those of "
        "[units], and so are velocities, with G = 1, without it",
    )
    relax: bool = Field(default=False, description="settle the particles to equilibrium before the start")

    def path(self, scene: Any) -> Path:
        """Where its file is."""
        return file_of_scene(scene.origin, self.file)

    def check(self, scene: Any) -> None:
        """A file that states no units has them in the scene; `load` takes those of files where all state them."""
        super().check(scene)
        if scene.units not in (None, "SI"):
            return
        from astroinertia.sph.table import units_for  # only where there is a file to open

        tables = [body for body in (scene.bodies or (scene.body,)) if isinstance(body, TableBody)]
        path = next(
            (path for path in (table.path(scene) for table in tables) if units_for(path, scene.units == "SI") is None),
            self.path(scene),
        )
        snapshot = path.suffix.lower() == ".hdf5"
        raise ValueError(
            '[units] with mass and length (or units = "code") is needed for a body of kind table, whose file '
            f'{readable(path.name)} states no units; a table in SI takes units = "SI", and '
            + (
                'a snapshot in those of GADGET [units] mass = "1e10 Msun", length = "1 kpc" and [body] '
                'velocity_unit = "1 km/s".'
                if snapshot
                else 'columns may have units: in CSV "x (km)", in HDF5 and netCDF as the attribute units.'
            )
        )

    def describe(self, scene: Any) -> list[PlanLine]:
        """What is in its file."""
        from astroinertia.scene.plan_table import table_lines  # only where there is a file to open

        return table_lines(self, scene)
