"""Characteristic numbers of a particle table, from the particles themselves, in the units of its scene."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.inertia import tensor
from astroinertia.scene.initial_body import ascending, unit
from astroinertia.scene.scales import code_units
from astroinertia.scene.schema import Scene

_MOST = 3000  # particles whose pairs are summed; of more, as many spread evenly over the table, with all of the mass


def of_table(scene: Scene) -> dict[str, Any]:
    """What effects.characteristic.Characteristic takes of a body that is the user's own particles, as they move.

    mass; radius of the homogeneous sphere with their trace of Q; |W| by direct sums without softening; energies of the
    motion that neither swells nor shrinks the body, and of heat, where the table has velocities and energies.
    """
    body: Any = scene.body
    path, units = body.path(scene), code_units(scene)
    stamp = path.stat().st_mtime_ns
    numbers = _numbers(path, stamp, units, body.velocity_unit)
    dimensions = {
        "mass": "mass", "radius": "length", "moments": "moment_of_inertia", "second_moment": "moment_of_inertia",
        "gravitational": "energy", "thermal_energy": "energy", "rotational": "energy", "spin": "angular_velocity",
        "expansion": "angular_velocity", "central_density": "density",
    }  # fmt: skip

    def in_units(name: str, value: Any) -> Any:
        if name not in dimensions or value is None:
            return value
        return tuple(units.to_si(np.array(value), dimensions[name])) if isinstance(value, tuple) else float(
            units.to_si(value, dimensions[name]))  # fmt: skip

    given = {name: in_units(name, value) for name, value in numbers.items()}
    fluid: Any = scene.equation_of_state
    if given["thermal_energy"] is not None and fluid is not None:
        given["triple_pressure"] = 3.0 * (fluid.first_gamma - 1.0) * given["thermal_energy"]
    return given


@lru_cache(maxsize=4)
def _numbers(path: Path, stamp: int, units: Any, velocity_unit: float | None) -> dict[str, Any]:
    """The same in code units, in which G = 1; stamp: when the file was written."""
    from astroinertia.sph.table import in_code_units, read_table  # only where there is a file to open

    table = in_code_units(read_table(path), path, units, velocity_unit)
    mass, total = table.mass, float(table.mass.sum())
    place = table.position - mass @ table.position / total
    moving = table.velocity - mass @ table.velocity / total
    inertia, second = tensor.inertia_tensor(mass, place), tensor.second_moment(mass, place)
    mixed = np.einsum("n,ni,nj->ij", mass, place, moving)
    momentum = tensor.axial_vector(mixed)
    spin = np.linalg.pinv(inertia, hermitian=True) @ momentum
    rate, trace = float(np.linalg.norm(spin)), float(np.trace(second))
    expansion = float(np.trace(mixed)) / trace
    kinetic = 0.5 * float(mass @ (moving**2).sum(axis=1))
    energy = table.internal_energy
    radius = float(np.sqrt(5.0 / 3.0 * trace / total))
    distance = np.sort(np.linalg.norm(place, axis=1))
    inner = max(1, len(distance) // 10)
    return {
        "mass": total, "radius": radius, "moments": ascending(np.linalg.eigvalsh(inertia)), "second_moment": trace,
        "gravitational": _attraction(mass, place), "spin": rate, "spin_axis": unit(spin) if rate > 0.0 else (0, 0, 1.0),
        "rotational": max(kinetic - 0.5 * expansion**2 * trace, 0.0), "expansion": expansion,
        "thermal_energy": None if energy is None else float(mass @ energy),
        "central_density": 0.1 * total / (4.0 / 3.0 * np.pi * float(distance[inner]) ** 3) if distance[inner] else None,
    }  # fmt: skip


def _attraction(mass: np.ndarray, place: np.ndarray) -> float:
    """|W| of points; of coincident ones nothing."""
    every = -(-len(mass) // _MOST)
    chosen, at = mass[::every], place[::every]
    chosen = chosen * (mass.sum() / chosen.sum())
    found = 0.0
    for k in range(1, len(chosen)):
        distance = np.linalg.norm(at[:k] - at[k], axis=1)
        found += float(chosen[k] * (chosen[:k][distance > 0] / distance[distance > 0]).sum())
    return found * len(chosen) / (len(chosen) - 1) if every > 1 else found
