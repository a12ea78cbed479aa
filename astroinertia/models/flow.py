"""The particles of a body within a base step of individual time steps, and their intervals."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from astroinertia.engines.pytree import pytree
from astroinertia.integrate.hierarchical import Clock
from astroinertia.integrate.leapfrog import State
from astroinertia.ledger.moments import Ledger
from astroinertia.ledger.regions import RegionLedger
from astroinertia.models import sph
from astroinertia.models.sph import Arrangement, Problem
from astroinertia.sph.fluid import Fluid

Array = Any
FLUID = (
    "mass", "position", "velocity", "entropy", "smoothing_length", "density", "grad_h", "zeta", "pressure",
    "sound_speed", "internal_energy", "thermal_energy", "acceleration",
)  # fmt: skip


@pytree
@dataclass(frozen=True)
class Part(Fluid):
    """Some of a body's particles, which know where the whole of it is."""

    body_centre: Array = None
    body_velocity: Array = None

    @property
    def centre(self) -> Array:
        """Centre of mass of the whole body, (3,)."""
        return self.body_centre

    @property
    def centre_velocity(self) -> Array:
        """Its velocity, (3,)."""
        return self.body_velocity


@dataclass(frozen=True)
class Spans:
    """Half of the interval that ends, and of the one that begins, of each active particle (n,), and their rungs.

    A particle that was woken has nothing to close: its old rung is -1. Nothing is opened at the end of a base step:
    all new rungs are -1.
    """

    base: float
    level: int
    old: Array
    new: Array

    @property
    def opens(self) -> bool:
        """Whether intervals begin."""
        return self.new.min(initial=0) >= 0

    @staticmethod
    def _half(base: float, rung: Array) -> Array:
        return np.where(rung < 0, 0.0, 0.5 * base / 2.0 ** np.maximum(rung, 0))

    @cached_property
    def closing(self) -> Array:
        """Half of the interval that ends, (n,); 0 where there is none."""
        return self._half(self.base, self.old)

    @cached_property
    def opening(self) -> Array:
        """Half of the interval that begins, (n,); 0 where there is none."""
        return self._half(self.base, self.new)


@dataclass
class Tally:
    """Evaluations of particles and ends of intervals so far."""

    evaluations: int = 0
    ends: int = 0


@dataclass
class Flow:
    """Particles within a base step.

    rows: the arrays of a State and of its Fluid under their names (velocity as kicked so far), and `predicted`, the
    velocity now; `ledger_mass` (N,), the mass of particles whose drift this part enters into the ledger, else 0;
    `material`, where there are several; `entropy_rate`; `decay` where heat is exchanged with the surroundings;
    `middle` (N,), the time at the middle of a particle's interval; `limit` (N,), what its interval must
    not exceed, its own and for its neighbours' sake; `own_limit` (N,); `rung` (N,) and `interval` (N,); and with
    prefixes memory, field (of the force terms), distant (accelerations that are not by neighbours), outer (those of
    them by what is outside a nested set) and body (accelerations that come with the base step alone).
    regions: the ledger of each; points: those beside the fluid;
    pairs: the engine's arrangement with lists of neighbours; tally: what was done so far; whole: whether these are all
    particles of the body.
    """

    problem: Problem
    arrangement: Arrangement
    clock: Clock
    begun: float
    rows: dict[str, Array]
    ledger: Ledger
    regions: dict[str, RegionLedger]
    total_mass: float
    centre: Array
    centre_velocity: Array
    tally: Tally
    points: dict[str, Any]
    whole: bool = True
    pairs: Any = None

    @property
    def time(self) -> float:
        """Now."""
        return self.begun + self.clock.elapsed

    @cached_property
    def direct(self) -> Problem:
        """The physics with plain sums over all pairs, for few particles."""
        return replace(self.problem, effects=tuple(effect.direct for effect in self.problem.effects))

    @property
    def count(self) -> int:
        """Number of particles."""
        return len(self.rows["mass"])

    def take(self, name: str, active: Array) -> Array:
        """The rows of active particles (a copy, unless all are active)."""
        array = self.rows[name]
        return array if len(active) == len(array) else array[active]

    def put(self, name: str, active: Array, values: Array) -> None:
        """Change those rows."""
        if len(active) == self.count:
            self.rows[name] = np.array(values)
        else:
            self.rows[name][active] = values

    def under(self, prefix: str) -> dict[str, Array]:
        """The rows with a prefix, under what follows it."""
        dotted = prefix + "."
        return {name[len(dotted) :]: array for name, array in self.rows.items() if name.startswith(dotted)}

    def targets(self, active: Array) -> Array | None:
        """The targets of a pass: None where all are active."""
        return None if len(active) == self.count else active


def opened(problem: Problem, arrangement: Arrangement, state: State, base: float, limits: Array) -> Flow:
    """The particles of a state at the beginning of a base step, not kicked yet."""
    fluid, mass = state.rates.fluid, state.mass
    rows = {name: np.array(getattr(fluid, name)) for name in FLUID if getattr(fluid, name) is not None}
    rows |= {
        "predicted": rows["velocity"],
        "ledger_mass": mass,
        "position": state.position,
        "remainder": state.remainder,
        "velocity": state.velocity.copy(),
        "entropy": state.entropy.copy(),
    }
    rows |= {"identity": state.identity, "entropy_rate": state.rates.entropy_rate.copy()}
    if (exchange := state.rates.exchange) is not None:
        rows["decay"] = np.array(exchange.decay)
    rows |= {f"memory.{name}": array.copy() for name, array in state.memory.items()}
    rows["acceleration"] = sph.total_acceleration(np, state.rates, state.velocity)
    rows |= {} if state.material is None else {"material": state.material}
    rows["entropy_per_heat"] = sph.matter(problem, state.material).state(np, fluid.density, fluid.entropy)[-1]
    rows |= {"limit": limits.copy(), "own_limit": limits.copy(), "middle": np.zeros(len(mass))}
    total = mass.sum()
    centre, velocity = (mass @ state.position) / total, (mass @ state.velocity) / total
    begun = float(state.time)
    ledgers = state.ledger, state.regions
    parts = rows, *ledgers, total, centre, velocity, Tally(), state.points
    return Flow(problem, arrangement, Clock(base), begun, *parts)
