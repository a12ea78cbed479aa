"""What the plan tells of a particle table: what is in its file, read as the run will read it."""

from typing import Any

import numpy as np

from astroinertia.scene.initial_body import PlanLine
from astroinertia.scene.scales import code_units
from astroinertia.scene.schema import Scene
from astroinertia.sph.table import SI, UNKNOWN, Table, in_code_units, read_table


def table_lines(body: Any, scene: Scene) -> list[PlanLine]:
    """Particles, columns, units, mass, extent, velocities and energies of a table; SceneError for what is none."""
    path, units = body.path(scene), code_units(scene)
    raw = read_table(path)
    table = in_code_units(raw, path, units, body.velocity_unit)

    def written(value: float, dimension: str) -> str:
        return scene.shown(float(units.to_si(value, dimension)), dimension)

    mass, total = table.mass, float(table.mass.sum())
    from_centre = table.position - mass @ table.position / total
    about = np.linalg.norm(from_centre, axis=1)
    moving = table.velocity - mass @ table.velocity / total
    least, most = float(mass.min()), float(mass.max())
    each = written(most, "mass") if least == most else f"{written(least, 'mass')} to {written(most, 'mass')}"
    extent = " x ".join(written(float(size), "length") for size in np.ptp(table.position, axis=0))
    lines: list[PlanLine] = [
        ("particles", f"{mass.size}", f"from the table {body.file}, of {each} each"),
        ("columns", " ".join(raw.columns), raw.note),
        ("units of the file", *_units(raw, scene)),
        ("mass", written(total, "mass")),
        ("extent", extent, f"within {written(float(about.max()), 'length')} of the centre of mass"),
    ]
    fastest = written(float(np.linalg.norm(moving, axis=1).max()), "velocity")
    has = "vx" in raw.columns
    lines.append(("velocities", f"up to {fastest}" if has else "none", "about the mean" if has else "at rest"))
    energy = table.internal_energy
    if energy is None:
        return [*lines, ("internal energies", "none", "from the scene, where it has any")]
    low, high = (written(float(value), "specific_energy") for value in (energy.min(), energy.max()))
    return [*lines, ("internal energies", f"{low} to {high}")]


def _units(table: Table, scene: Scene) -> tuple[str, str]:
    own = table.own
    if table.units is None:
        return (
            ("of the scene, G = 1", "") if scene.dimensionless else ("SI", "as all tables but snapshots of other codes")
        )
    if table.units == SI and own is None:
        return "SI", "from the units of its columns"
    if own is None or table.units == UNKNOWN:
        return "none stated", "taken for those of the scene, G = 1"
    if not scene.dimensionless:
        velocity = scene.shown(own.velocity, "velocity")
        return f"{scene.shown(own.mass, 'mass')}, {scene.shown(own.length, 'length')}, {velocity}", "as it states"
    constant = own.in_itself
    return "its own", "in which G = 1" if constant == 1.0 else f"velocities over the root of G, {constant:.6g} in them"
