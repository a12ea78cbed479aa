"""What the run loop, the archive and the progress line need of a model: one body under way, whatever evolves it."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

Record = dict[str, Any]
SAME_TIME = 1e-12  # share of a time by which two differ that are meant to be the same


class GivenUp(Exception):
    """A step under way has been given up: the body is what it was before it."""


def never() -> bool:
    """No step is given up."""
    return False


class Figures(NamedTuple):
    """What a run tells while it goes, in code units; NaN where a model has no such thing.

    total_energy is less what has come from outside without a static potential, so that a change of it is an error;
    energy_scale is the largest of the energies, against which it is judged. limited_by is what sets the time step, in
    words; limited_at the distance from the centre of mass and the density where that is, if it is anywhere; note is
    what else there is to say.
    """

    total_energy: float
    energy_scale: float
    ledger_closure: float
    density_max: float
    limited_by: str = ""
    limited_at: tuple[float, float] | None = None
    note: str = ""


class Evolution(Protocol):
    """A body at some time of its evolution, in code units.

    A module build/<model>.py makes one: `evolution(scene, units)` at time 0, `resumed(scene, units, arrays)` from a
    checkpoint, which goes on bit for bit as if it had never stopped.
    """

    effects: tuple[str, ...]
    """The rows of the ledger."""
    absent: Mapping[str, str]
    """Quantities that the model has, but not of this body, each with the reason."""
    approximation: str
    """What of the model is exact for this body, or what it approximates, in one sentence."""
    meets_times: bool
    """Whether `advance` meets the time it is given, however many calls it takes, or takes one step towards it."""

    @property
    def time(self) -> float:
        """Now."""
        ...

    @property
    def steps(self) -> int:
        """Time steps since the start."""
        ...

    @property
    def resumable(self) -> bool:
        """Whether a checkpoint taken now is one that can be gone on from bit for bit."""
        ...

    def advance(self, until: float, most: float = math.inf) -> None:
        """Go on towards a time and never past it, for some seconds at most, so that a run can be stopped in between.

        And no further than to `most` steps since the start, of which there are fewer now. Where else it pauses follows
        from the state alone. NumericalError, in one sentence, where it cannot go on.
        """
        ...

    def record(self, opening_potential: float | None) -> Record:
        """One row of the headline series under the names of observables.quantities.RECORDED.

        opening_potential is the static part of the energy at time 0, None in the first record.
        """
        ...

    def look(self, opening_potential: float | None) -> Record:
        """The same row for who only looks: it changes nothing of what is recorded later, and regions are not in it."""
        ...

    def snapshot(self) -> Record | None:
        """The particles, if the model has any."""
        ...

    def arrays(self) -> dict[str, np.ndarray]:
        """The state, for a checkpoint."""
        ...

    def figures(self) -> Figures:
        """What the progress line shows."""
        ...


@runtime_checkable
class Through(Protocol):
    """What an evolution may offer besides: many records in one call, where each takes little time."""

    def through(
        self, times: Sequence[float] | np.ndarray, opening_potential: float | None, most: float
    ) -> list[Record]:
        """Go through output times, ascending, and give the record of each of the first of them that were met.

        For about a second at most, and no further than to `most` steps since the start, of which there are fewer now.
        What is done on the way follows from the state and the times alone, so that it is the same wherever a call
        begins. No records where `advance` must see to something first.
        """
        ...


@runtime_checkable
class GivesUp(Protocol):
    """What an evolution may offer besides: to give up a step that takes long, so that a run need not wait for it."""

    to_give_up: Callable[[], bool]
    """Asked between the parts of a step before which `resumable` was true; if so, `advance` raises GivenUp."""


@runtime_checkable
class RunsOut(Protocol):
    """What an evolution may offer besides: to be over before the end of its run."""

    @property
    def over(self) -> str:
        """Why nothing is left to evolve, in words that a sentence may end with; empty while something is."""
        ...


@runtime_checkable
class Rehearsed(Protocol):
    """What an evolution may offer besides: to have compiled whatever its run may come to, as `warm` asks for."""

    def rehearse(self) -> None:
        """Do once what later steps may have to do; the state stays what it is."""
        ...
