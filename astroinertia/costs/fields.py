"""What given fields do to a body, at six points of each of its spheres.

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
    """Effects that follow from place, on a body with that centre (3,) and velocity (3,) of it, in code units."""

    effects: tuple[Any, ...]
    centre: np.ndarray
    velocity: np.ndarray

    def inward(self, radius: np.ndarray) -> np.ndarray:
        """The mean acceleration towards the centre (K,) over spheres of those radii (K,)."""
        return -np.einsum("kpi,pi->k", self._acceleration(radius), AXES) / len(AXES)

    def bulk(self, radius: np.ndarray) -> np.ndarray:
        """The size of the mean acceleration (K,) over spheres of those radii (K,): what carries them along."""
        return np.linalg.norm(self._acceleration(radius).mean(axis=1), axis=1)

    def timesteps(self, radius: np.ndarray, speed: np.ndarray, sound: np.ndarray) -> dict[str, float]:
        """The time steps that the effects ask for, where they ask for one, by their kinds: of spheres (K,) that grow at
        that speed, with that speed of sound.
        """
        place = self._places(radius)
        velocity = (self.velocity + speed[:, None, None] * AXES).reshape(-1, 3)
        fluid = SimpleNamespace(position=place, velocity=velocity, sound_speed=np.repeat(sound, len(AXES)))
        asked = {effect.kind: effect.timestep(np, fluid) for effect in self.effects}
        return {kind: float(limit) for kind, limit in asked.items() if limit is not None}

    def _acceleration(self, radius: np.ndarray) -> np.ndarray:
        fluid = SimpleNamespace(position=self._places(radius))
        return np.sum([effect.acceleration(np, fluid) for effect in self.effects], axis=0).reshape(-1, len(AXES), 3)

    def _places(self, radius: np.ndarray) -> np.ndarray:
        return (self.centre + radius[:, None, None] * AXES).reshape(-1, 3)


def effects_that(scene: Scene, trait: str) -> tuple[Any, ...]:
    """The effects of a scene whose classes have a trait, in code units."""
    units, entries = code_units(scene), scene.entries
    return tuple(
        catalogue.build(kind, options_in_code_units(options, entries[kind].options, units), entries)
        for kind, options in scene.effects.items()
        if getattr(entries[kind].made, trait)
    )


def fields(scene: Scene) -> Fields | None:
    """Those of a scene; None where it has none."""
    units, body = code_units(scene), scene.body
    found = effects_that(scene, "follows_place")
    centre, velocity = (
        np.asarray(units.to_code(np.asarray(getattr(body, name, None) or (0.0, 0.0, 0.0)), dimension))
        for name, dimension in (("position", "length"), ("velocity", "velocity"))
    )
    return Fields(found, centre, velocity) if found else None
