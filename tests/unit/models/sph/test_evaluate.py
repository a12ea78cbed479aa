"""One evaluation: what its passes over neighbours share, and that it goes when they are done."""

import weakref
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from astroinertia.effects import Effect, catalogue, pytree
from astroinertia.models.sph.evaluate import evaluated
from tests.ball import ball, state_of
from tests.pairs import BruteEngine


class Lists:
    """Lists of neighbours that hold for smoothing lengths, (N,)."""

    def __init__(self, length: np.ndarray) -> None:
        self.length = length


class Listing(BruteEngine):
    """Notes the lists that sums over neighbours are handed, and has those that were made last."""

    def __init__(self) -> None:
        self.handed: list[np.ndarray] = []
        self.last: Any = None

    def listed(self, arrangement, kernel, position, length, targets=None):
        lists = Lists(length)
        self.last = weakref.ref(lists)
        return lists

    def neighbour_sums(self, arrangement, kernel, terms, fields, virial=False):
        self.handed.append(arrangement.length)
        return super().neighbour_sums(arrangement, kernel, terms, fields, virial=virial)


@pytree
@dataclass(frozen=True, eq=False)
class Expansions(Effect):
    """Sums of its own, which note whether there are lists of neighbours beside them."""

    noted: Any = field(metadata={"static": True})

    kind: ClassVar[str] = "expansions"

    def own_sums(self, engine, arrangement, own, fluid, before, virial):
        self.noted.append(engine.last() is not None)
        return {}


def evaluated_with_longer_lengths() -> tuple[Listing, list[bool], Any]:
    engine, noted = Listing(), []
    effects = (catalogue.build(kind, {}) for kind in ("pressure", "viscosity"))
    position = ball(60)
    problem, state, arrangement = state_of(
        *effects, Expansions(noted), position=position, velocity=0.0 * position, engine=engine
    )
    engine.handed.clear()
    noted.clear()
    shorter = replace(state, smoothing_length=0.8 * state.smoothing_length)
    return engine, noted, evaluated(problem, arrangement, shorter, np.float64(0.0))


def test_gradients_and_forces_share_lists_for_the_lengths_that_were_solved_for() -> None:
    """Those for the lengths before may not hold: each pass would make others for itself."""
    engine, _, state = evaluated_with_longer_lengths()
    assert len(engine.handed) == 2
    for length in engine.handed:
        assert np.array_equal(length, state.smoothing_length)


def test_lists_of_neighbours_take_no_memory_beside_expansions() -> None:
    _, noted, _ = evaluated_with_longer_lengths()
    assert noted == [False]
