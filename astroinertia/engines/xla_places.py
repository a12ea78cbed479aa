"""Fields of particles as the tiles of the xla engine gather them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import jax.numpy as jnp

from astroinertia.engines.pytree import pytree

Array = Any


@pytree
@dataclass(frozen=True)
class Places:
    """Fields of particles as tiles gather them: positions and masses side by side, every other field by itself.

    Pairs then read a field from contiguous memory; with all fields side by side, each read stepped over the others and
    a pass of many fields took nearly twice as long (measured on CPU). The last place stands for empty ones: a copy of a
    particle, so that pairs stay finite, but without mass.

    points: (N + 1, 4). scalars: {name: (N + 1,)} in the type of pairs. vectors: {name: three of (N + 1,)}.
    """

    points: Array
    scalars: dict[str, Array]
    vectors: dict[str, list[Array]]
    single: bool = field(metadata={"static": True})

    @property
    def dtype(self) -> Any:
        """The type that pairs are computed in."""
        return jnp.float32 if self.single else jnp.float64

    @property
    def empty(self) -> int:
        """The number of the empty place, N."""
        return len(self.points) - 1

    def tile(self, target: Array, source: Array) -> tuple[dict[str, Array], dict[str, Array], tuple[Array, Array]]:
        """Fields of targets (C, S) and sources (C, B) as pairs want them, and their masses in full precision.

        In float32 vectors are relative to the first particle of the leaf, which keeps their differences exact to
        rounding. In float64 they are not: a pair then has the same separation in both of its tiles, to the last digit.
        """
        fields, masses = [], []
        for place in (target, source):
            mine = {name: array[place] for name, array in self.scalars.items()}
            for name in ("position", *self.vectors):
                vector = self._vector(name, place)
                relative = vector - self._vector(name, target[:, :1]) if self.dtype == jnp.float32 else vector
                mine[name] = relative.astype(self.dtype)
            fields.append(mine)
            masses.append(self.points[place][:, :, 3])
        return fields[0], fields[1], (masses[0], masses[1])

    def _vector(self, name: str, place: Array) -> Array:
        if name == "position":
            return self.points[place][:, :, :3]
        return jnp.stack([component[place] for component in self.vectors[name]], axis=2)


def places_of(precision: str, fields: Mapping[str, Array]) -> Places:
    """Fields (N,) and (N, 3), "position" and "mass" among them, and an empty place after the last."""
    single = precision == "mixed"
    places = {name: jnp.concatenate([array, array[:1]]) for name, array in fields.items()}
    mass = places.pop("mass").at[-1].set(0.0)
    points = jnp.concatenate([places.pop("position"), mass[:, None]], axis=1)
    places["mass"] = mass
    scalars = {
        name: array.astype(jnp.float32 if single else jnp.float64) for name, array in places.items() if array.ndim == 1
    }
    vectors = {name: list(array.T) for name, array in places.items() if array.ndim == 2}
    return Places(points, scalars, vectors, single)
