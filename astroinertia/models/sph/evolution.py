"""The particle fluid as the run loop sees it: a state, how its particles are arranged, and a step at a time."""

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from astroinertia.effects.effect import acting
from astroinertia.engines.pytree import mapped
from astroinertia.errors import NumericalError
from astroinertia.models.checkpoint import flattened
from astroinertia.models.protocol import SAME_TIME, Figures, GivenUp, Record, never
from astroinertia.models.sph.evaluate import effect_accelerations, turned
from astroinertia.models.sph.limits import limiting, timestep_limits, total_acceleration, towards
from astroinertia.models.sph.record import (
    energy_budget,
    ledger_closure,
    series_record,
    snapshot_record,
    timestep_limit,
    works_from_outside,
)
from astroinertia.models.sph.sorting import STEPS_BETWEEN_SORTS, in_order, places_of, rearranged, stale
from astroinertia.models.sph.state import Problem, State, without_gradients
from astroinertia.models.sph.step import step
from astroinertia.observables.quantities import TIMESTEP_CRITERIA
from astroinertia.sph.density import mass_around

# A step so much shorter than the run is no longer an evolution in time.
SMALLEST_STEP = 1e-13
FEWEST = 8  # particles that still are a fluid
SPARE = 1.5  # times the mass without which the heaviest particle has no smoothing length

IN_A_BOX: dict[str, str] = dict.fromkeys(
    ("virial_tensor", "virial_mismatch", "torque", "inertia_acceleration", "gw_strain_plus", "gw_strain_cross"),
    "the matter of a periodic box has no place of its own, from which moments of forces could be taken",
)

Between = Callable[[Problem, Any, State], tuple[State, Any]]
BaseStep = Callable[..., tuple[State, Any, Any]]  # block_step.step


def enough(problem: Problem, mass: np.ndarray, taken: float = 0.0) -> bool:
    """Whether particles of masses (N,) still are a fluid, each with a smoothing length, once that much is taken."""
    least = SPARE * mass_around(problem.kernel, problem.eta) * mass.max(initial=0.0)
    return len(mass) >= FEWEST + (taken > 0.0) and mass.sum() - taken > least


class Particles:
    """A fluid of particles under way (models.protocol.Evolution); `end` is that of the run.

    base_step: block_step.step where every particle has a step of its own; a step is then one of the slowest. regions:
    regions.Regions where the scene has any. between: what is done between two steps, accretion.step where there are
    sinks. free_fall_factor: the longest step, over (G rho)^(-1/2) of the densest.
    """

    approximation: ClassVar[str] = "particles: converges to the fluid with their number"
    meets_times: ClassVar[bool] = False

    def __init__(
        self,
        problem: Problem,
        state: State,
        arrangement: Any,
        end: float,
        base_step: BaseStep | None = None,
        regions: Any = None,
        between: Between | None = None,
        free_fall_factor: float | None = None,
    ) -> None:
        self.problem, self.state, self.arrangement, self.end = problem, state, arrangement, end
        self.effects, self.base_step, self.note = problem.effect_names, base_step, ""
        self.regions, self.between, self.free_fall_factor = regions, between, free_fall_factor
        self._split = base_step is not None  # whether the last step was of several intervals, or is not known
        self.evaluations = 0  # of a particle, since this object was made
        self.to_give_up: Callable[[], bool] = never

    @property
    def absent(self) -> Mapping[str, str]:
        """Quantities that have no meaning in a periodic box; elsewhere there is none."""
        return {} if self.problem.engine.bounded else IN_A_BOX

    @property
    def time(self) -> float:
        """Now."""
        return float(self.state.time)

    @property
    def steps(self) -> int:
        """Time steps since the start."""
        return int(self.state.step)

    @property
    def over(self) -> str:
        """Why nothing is left to evolve (models.protocol.RunsOut)."""
        mass = self.state.mass
        few = self.between is not None and not enough(self.problem, mass, mass.max())
        return f"all but {len(self.state.mass)} particles of the gas have been accreted" if few else ""

    @property
    def longest(self) -> float:
        """The longest step, or base step, that the density allows."""
        if self.free_fall_factor is None:
            return math.inf
        return self.free_fall_factor / math.sqrt(np.max(self.state.rates.fluid.density))

    @property
    def resumable(self) -> bool:
        """Whether particles are about to be sorted again."""
        return self._split or self.steps % STEPS_BETWEEN_SORTS == 0

    def advance(self, until: float, most: float = math.inf) -> None:
        """One step, or one base step of individual ones, as long as the state allows, on a way that meets `until`.

        It meets times at which effects begin or end, too. GivenUp where a base step was given up half-way.
        """
        longest = self.longest
        if self.base_step is None:  # individual steps begin with a kick by the gradients that there are
            self.state = without_gradients(self.state)
        unsorted = self.state.identity, self.arrangement
        to_give_up = self.to_give_up if self.resumable else never
        stop, problem = self.stretch(until)
        breaks = stop in self.breaks(until)
        dt = self.begin(stop, longest)
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            if self.base_step is not None:
                try:
                    self.state, self.arrangement, taken = self.base_step(
                        problem, self.arrangement, self.state, stop, longest, to_give_up
                    )
                except GivenUp:
                    identity, self.arrangement = unsorted  # what is saved is sorted when it is gone on with
                    self.state = in_order(self.state, places_of(identity, self.state.identity))
                    raise
                except NumericalError as error:
                    raise self._too_short(error.message) from None
                self.note, self._split = str(taken), taken.ends > 1
                self.evaluations += taken.evaluations
            else:
                self.state, self.arrangement = self._step(problem, dt)
                self.evaluations += len(self.state.mass)
        self.check()
        if breaks and self.has_met(stop):
            self._turn(stop)
        if self.between is not None:
            self.state, self.arrangement = self.between(self.problem, self.arrangement, self.state)

    def rehearse(self) -> None:
        """Take all kinds of steps that the run may come to, so that what they need is compiled; the state stays."""
        from astroinertia.models.sph.rehearsal import rehearse  # no run needs it

        rehearse(*rearranged(self.problem, self.state), self.problem, self.base_step)

    def begin(self, until: float, longest: float) -> np.float64:
        """The length of the coming step, which particles are sorted for where it is due.

        NumericalError where the state allows no step.
        """
        allowed = float(self.state.rates.timestep)
        if not allowed > SMALLEST_STEP * self.end:
            if math.isnan(allowed):
                raise self._diagnosis("the time step is not a number, for the state is no longer finite")
            raise self._too_short(f"the time step fell to {allowed / self.end:.2e} of the length of the run")
        dt = np.float64(towards(until - self.time, min(allowed, longest)))
        if self.resumable or stale(self.problem, self.arrangement, self.state, dt):
            self.state, self.arrangement = rearranged(self.problem, self.state, dt)
        return dt

    def breaks(self, until: float) -> set[float]:
        """Times from now on, up to one, at which an effect begins or ends."""
        latest = until * (1.0 + SAME_TIME)
        return {time for effect in self.problem.effects for time in effect.breaks(self.time, latest)}

    def stretch(self, until: float) -> tuple[float, Problem]:
        """Up to when, `until` at most, all effects are what they are now, and the physics up to then, ends included."""
        stop = min(self.breaks(until), default=until)
        return stop, acting(self.problem, self.time, stop)

    def has_met(self, stop: float) -> bool:
        """Whether it is that time by now."""
        return self.time >= stop * (1.0 - SAME_TIME)

    def _turn(self, time: float) -> None:
        """Go from what acts before a break of the effects, with which the step to it ended, to what acts after it."""
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            self.state = turned(acting(self.problem, time), self.arrangement, self.state, time)
        self.evaluations += len(self.state.mass)

    def _step(self, problem: Problem, dt: np.float64) -> tuple[State, Any]:
        if hasattr(problem.engine, "outgrown"):
            from astroinertia.models.sph.listed_step import listed_step  # only here: numba lists within the step

            return listed_step(problem, self.arrangement, self.state, dt)
        return step(problem, self.arrangement, self.state, dt), self.arrangement

    def check(self) -> None:
        """NumericalError where a step has left numbers."""
        if not np.isfinite(float(self.state.rates.timestep)) or not np.isfinite(
            float(self.state.ledger.kinetic_tensor.value.sum())
        ):
            raise self._diagnosis("the state is no longer finite")

    def record(self, opening_potential: float | None) -> Record:
        """One row of the headline series; regions are judged again for it."""
        record = self.look(opening_potential)
        if self.regions is None:
            return record
        self.state = self.regions.updated(self.state)
        return record | self.regions.record(self.state)

    def look(self, opening_potential: float | None) -> Record:
        """The same without regions, who belongs to them being as it was judged last."""
        return series_record(acting(self.problem, self.time), self.arrangement, self.state, opening_potential)

    def snapshot(self) -> Record:
        """All particles."""
        return snapshot_record(acting(self.problem, self.time), self.state)

    def arrays(self) -> dict[str, np.ndarray]:
        """Every array of the state."""
        return flattened(self.state)

    def figures(self) -> Figures:
        """What the progress line shows."""
        energy = energy_budget(acting(self.problem, self.time), self.state)
        largest = max(energy["kinetic"], abs(energy["internal"]), *map(abs, energy["potential"].values()), 1e-300)
        densest = float(np.max(self.state.rates.fluid.density))
        outside = works_from_outside(self.problem, energy["potential"])
        ledger = self.state.ledger
        brought = float((np.asarray(ledger.work.total) + np.asarray(ledger.heating.total))[outside].sum())
        kept = energy["kinetic"] + energy["internal"] + energy["static"] - brought
        limit = timestep_limit(self.problem, self.state)
        name = (*self.effects, *TIMESTEP_CRITERIA)[int(limit["timestep_limit"])]
        place = float(limit["timestep_limit_radius"]), float(limit["timestep_limit_density"])
        at = None if np.isnan(place[0]) else place
        return Figures(kept, largest, ledger_closure(self.state), densest, name, at, self.note)

    def _too_short(self, what: str) -> NumericalError:
        """What limits the step, and where, as long as everything is still a number."""
        if not np.isfinite(float(self.state.rates.timestep)):
            return self._diagnosis(what)
        criterion, particle = limiting(timestep_limits(self.problem, self.state.rates))
        by = criterion if criterion in self.effects else None
        message = what if by else f"{what} ({criterion})"
        particle = self._most_accelerated() if particle is None else particle
        return NumericalError(message, effect=by, time=self.time, particle=int(self.state.identity[particle]))

    def _diagnosis(self, what: str) -> NumericalError:
        rates, time = self.state.rates, self.time
        accelerations = effect_accelerations(np, mapped(np.asarray, rates))
        for effect, acceleration in zip(self.problem.effects, accelerations, strict=True):
            bad = np.flatnonzero(~np.isfinite(acceleration).all(axis=1))
            if len(bad):
                what = effect.not_finite or what
                return NumericalError(what, effect=effect.kind, time=time, particle=int(self.state.identity[bad[0]]))
        return NumericalError(what, effect=None, time=time, particle=int(self.state.identity[self._most_accelerated()]))

    def _most_accelerated(self) -> int:
        rates = mapped(np.asarray, self.state.rates)
        total = total_acceleration(np, rates, rates.fluid.velocity)
        return int(np.argmax(np.linalg.norm(total, axis=1)))
