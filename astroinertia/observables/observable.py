"""What an observable of a user's own derives from. Tests: tests/unit/test_observables_door.py."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Self

from astroinertia.observables.quantities import BodyState
from astroinertia.units import ALL_MODELS, Dimension, Option


class Observable(ABC):
    """Base of observables that are not of this package: a number, or an array, that is recorded in the headline series.

    A subclass is a frozen dataclass (@dataclass(frozen=True)). Each of its fields is an option, and comes in code units
    (G = 1). The first sentence of its docstring is the comment of the variable in the dataset.
    """

    kind: ClassVar[str]
    """Its name in scenes and in the dataset."""
    long_name: ClassVar[str]
    dims: ClassVar[tuple[str, ...]] = ()
    """Of its value: none of a number, else of "effect", which comes first, "i", "j", "principal" and "mode"."""
    dimension: ClassVar[str | Dimension] = "dimensionless"
    """Of its value, as a name or as Dimension(mass, length, time); "angle" for radians."""
    models: ClassVar[tuple[str, ...]] = ALL_MODELS
    """Those that have it; one of ("sph",) is given the particles."""
    options: ClassVar[Mapping[str, Option]] = {}
    """Each field: its dimension, default, limits and meaning."""
    source: ClassVar[str] = ""
    """Where its equation comes from."""

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> Self:
        """The observable from its options; ValueError, in one sentence, where they contradict each other."""
        return cls(**options)

    @abstractmethod
    def value(self, body: BodyState) -> Any:
        """A real number, or an array of its dims, in code units; NaN where it has no meaning.

        body.particles has arrays of all particles by name, (N,) or (N, 3), where `models` is ("sph",), else None:
        mass, position, velocity, density, smoothing_length, internal_energy, entropy and pressure. Arrays of `body`
        cannot be written to.
        """
