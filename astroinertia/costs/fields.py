"""What given fields do to a body, at six points of each of its spheres: they follow from options and place alone.

Six points on the axes have the mean over a sphere exactly where a field is linear in place, or central. Tests:
tests/unit/costs/test_fields.py.
"""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from astroinertia.effects import catalogue
from astroinertia.scene.dimensional import options_in_code_units
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene

AXES = np.concatenate([np.eye(3), -np.eye(3)])


@dataclass(frozen=True)
class Fields:
    """Effects that follow from place, on a body whose centre is at `centre` (3,), in code units."""

    effects: tuple[Any, ...]
    centre: np.ndarray

    def inward(self, radius: np.ndarray) -> np.ndarray:
        """The mean acceleration towards the centre (K,) over spheres of those radii (K,)."""
        return -np.einsum("kpi,pi->k", self._acceleration(radius), AXES) / len(AXES)

    def bulk(self, radius: np.ndarray) -> np.ndarray:
        """The size of the mean acceleration (K,) over spheres of those radii (K,): what carries them along."""
        return np.linalg.norm(self._acceleration(radius).mean(axis=1), axis=1)

    def timesteps(self, radius: np.ndarray) -> dict[str, np.ndarray]:
        """The time steps that the effects ask for, where they ask for one, by their kinds."""
        asked = {effect.kind: effect.timestep(np, self._fluid(radius)) for effect in self.effects}
        return {kind: limit for kind, limit in asked.items() if limit is not None}

    def _acceleration(self, radius: np.ndarray) -> np.ndarray:
        fluid = self._fluid(radius)
        return np.sum([effect.acceleration(np, fluid) for effect in self.effects], axis=0).reshape(-1, len(AXES), 3)

    def _fluid(self, radius: np.ndarray) -> Any:
        return SimpleNamespace(position=(self.centre + radius[:, None, None] * AXES).reshape(-1, 3))


def fields(scene: Scene) -> Fields | None:
    """Those of a scene; None where it has none."""
    units, body = code_units(scene), scene.body
    found = tuple(
        catalogue.build(kind, options_in_code_units(options, scene.entries[kind].options, units), scene.entries)
        for kind, options in scene.effects.items()
        if scene.entries[kind].made.follows_place
    )
    centre = units.to_code(np.asarray(getattr(body, "position", None) or (0.0, 0.0, 0.0)), "length")
    return Fields(found, np.asarray(centre)) if found else None
