"""An initial body that is not of this package: what its class says, and its particles, checked.

Tests: tests/unit/test_body_door.py.
"""

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np

from astroinertia.sph.cells import centres
from astroinertia.units import Option, failure

SHAPES = {"mass": (), "position": (3,), "velocity": (3,), "internal_energy": ()}
"""What `particles` returns, and the shape that one particle has of it."""


class Body:
    """Base of initial bodies of one's own: a frozen dataclass whose fields `options` describes.

    It has `density` and `extent`, from which particles of equal mass are placed, or `particles` of its own. Numbers are
    in code units, G = 1; `mass`, `radius` and `characteristic`, which plans read, must follow from its options alone,
    in whatever units those are. A field or attribute `mass` is the total mass, and sets the scale of `density`; with
    `mass` and `radius` the scene needs no [units].
    """

    kind: ClassVar[str]
    options: ClassVar[Mapping[str, Option]]
    source: ClassVar[str] = ""
    models: ClassVar[tuple[str, ...]] = ("sph", "rigid")

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> Self:
        """The body with those options; ValueError, in a sentence, where they contradict each other."""
        return cls(**options)

    def density(self, position: np.ndarray) -> np.ndarray:
        """Density (N,) at positions (N, 3), zero outside."""
        raise NotImplementedError

    def extent(self) -> Any:
        """Half the sides (3,) of a box about the origin that it lies in."""
        raise NotImplementedError

    def velocity(self, position: np.ndarray) -> np.ndarray:
        """Velocities (N, 3) at positions (N, 3)."""
        return np.zeros_like(position)

    def internal_energy(self, position: np.ndarray) -> np.ndarray | None:
        """Specific internal energies (N,) at positions (N, 3); None where the scene says them."""
        return None

    def characteristic(self) -> Mapping[str, Any]:
        """Numbers of effects.characteristic beside mass and radius, such as `moments` or `spin`."""
        return {}

    def particles(self, count: int, rng: np.random.Generator) -> Mapping[str, np.ndarray]:
        """Of so many particles mass (N,), position (N, 3) and, if wanted, velocity (N, 3) and internal_energy (N,)."""
        position, total = centres(self.density, self.extent(), count, rng)
        mass = getattr(self, "mass", None)
        placed = {"mass": np.full(count, (total if mass is None else mass) / count), "position": position}
        placed["velocity"], energy = self.velocity(position), self.internal_energy(position)
        return placed if energy is None else {**placed, "internal_energy": energy}


def particles(body: Body, count: int, seed: int) -> dict[str, np.ndarray]:
    """The particles of a body, as `particles` returns them, with velocities; ValueError says what is wrong of them."""
    try:
        placed = body.particles(count, np.random.default_rng(seed))
        arrays = {name: np.asarray(array, dtype=float) for name, array in placed.items()}
    except Exception as error:  # whatever the class does
        raise ValueError(f"cannot be placed ({failure(error)})") from error
    if not {"mass", "position"} <= set(arrays) <= set(SHAPES):
        raise ValueError(
            f"has particles with {', '.join(arrays)}: they need mass and position, and may have velocity and "
            "internal_energy"
        )
    arrays.setdefault("velocity", np.zeros_like(arrays["position"]))
    for name, array in arrays.items():
        if array.shape != (expected := (count, *SHAPES[name])):
            raise ValueError(f"has a {name} of the shape {array.shape} for {count} particles, not {expected}")
        if not np.isfinite(array).all():
            raise ValueError(f"has a {name} that is not finite")
    if not (arrays["mass"] > 0.0).all():
        raise ValueError("has a mass that is not positive")
    if (arrays.get("internal_energy", np.zeros(1)) < 0.0).any():
        raise ValueError("has an internal_energy that is negative")
    return arrays
