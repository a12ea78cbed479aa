"""What a particle run carries from step to step, and the physics and numerics that it has all along."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from astroinertia.effects.effect import Effect
from astroinertia.engines.pytree import pytree
from astroinertia.ledger.moments import Ledger
from astroinertia.ledger.regions import RegionLedger
from astroinertia.models.sph.heat import Exchange
from astroinertia.sph.fluid import Fluid

Array = Any
PAIR_TERMS = ("gradient_terms", "neighbour_terms", "all_pair_terms")  # of effects


@pytree
@dataclass(frozen=True)
class Problem:
    """The physics and the numerics of a particle run, in code units.

    eta sets h = eta (m/rho)^(1/3); smoothing_tolerance is the relative error allowed in h. The step is the least of
    courant times the effects' own limits, acceleration_factor sqrt(h/|a|), energy_factor u/|du/dt| and max_timestep.
    """

    effects: tuple[Effect, ...]
    equation_of_state: Any
    eta: float
    courant: float
    acceleration_factor: float
    energy_factor: float
    max_timestep: float
    engine: Any = field(metadata={"static": True})
    kernel: str = field(metadata={"static": True})
    smoothing_tolerance: float = field(metadata={"static": True})

    @property
    def effect_names(self) -> tuple[str, ...]:
        """The kinds of the effects, in the order of the ledger's rows."""
        return tuple(effect.kind for effect in self.effects)

    @property
    def fixed_length(self) -> Any | None:
        """The smoothing length that an effect asks all particles to keep; None where lengths follow the density."""
        return next((length for effect in self.effects if (length := effect.fixed_length) is not None), None)

    def standard_density(self, material: Array | None) -> Array | None:
        """That of particles of those materials (N,) where densities are sums of standard volumes; None elsewhere."""
        standards = getattr(self.equation_of_state, "standards", None)
        return None if standards is None else self.engine.xp.asarray(standards)[material]

    def terms(self, name: str) -> tuple:
        """The pair terms of all effects: their gradient_terms, neighbour_terms or all_pair_terms, by that name.

        One that several effects list stands once.
        """
        return self._terms[name]

    @cached_property
    def _terms(self) -> dict[str, tuple]:
        # Other effects come by dataclasses.replace: with_fields would keep these terms.
        return {
            name: tuple(dict.fromkeys(term for effect in self.effects for term in getattr(effect, name)))
            for name in PAIR_TERMS
        }

    def matter(self, material: Array | None) -> Any:
        """The equation of state of particles, which may be of several materials, (N,) or None."""
        eos = self.equation_of_state
        return eos if material is None else eos.of(material)


@pytree
@dataclass(frozen=True)
class Arrangement:
    """How particles are sorted: the engine's arrangement, and {kind: what an effect needs for sums of its own}."""

    pairs: Any
    own: dict[str, Any]


@pytree
@dataclass(frozen=True)
class Rates:
    """What changes a state, one entry an effect in each tuple (None where it has no such part).

    acceleration (N, 3), drag (3, 3) acting on the velocity, heating (N,) du/dt; entropy_rate (N,) is the sum of the
    heating and of the gains of `exchange`, in terms of the entropy function; timestep is the longest step allowed from
    here; total is the sum of the accelerations, (N, 3); exchange, that of heat with the surroundings, if there is any.
    """

    acceleration: tuple[Array | None, ...]
    drag: tuple[Array | None, ...]
    heating: tuple[Array | None, ...]
    entropy_rate: Array
    timestep: Array
    fluid: Fluid
    total: Array | None = None
    exchange: Exchange | None = None


@pytree
@dataclass(frozen=True)
class State:
    """Everything that a run carries from step to step, in code units; rates belong to the present positions.

    points: {effect: point masses beside the fluid}, which move with it.
    regions: the ledger of each region of the body, whose members memory holds under member_key(name), (N,).
    material (N,) numbers what particles are of, in an equation of state of several materials; None with any other.
    remainder (N, 3) is what rounding has left of the places: the sum with `position` is where particles are, to twice
    the digits. Only drifts know of it. A place that is rounded at each step alone errs the same way each time while
    its velocity stays the same, and the angular momentum with the square of the time.
    """

    time: Array
    step: Array
    identity: Array
    mass: Array
    position: Array
    remainder: Array
    velocity: Array
    entropy: Array
    smoothing_length: Array
    memory: dict[str, Array]
    ledger: Ledger
    rates: Rates
    points: dict[str, Any] = field(default_factory=dict)
    regions: dict[str, RegionLedger] = field(default_factory=dict)
    material: Array | None = None

    def members(self, active: Array | None = None) -> dict[str, Array]:
        """1 for the members of each region and 0 for the others, of all particles or of some, (n,)."""
        return {name: rows(self.memory[member_key(name)], active) for name in self.regions}


def without_gradients(state: State) -> State:
    """The state without the sums of the pass before the forces: a quarter of it, which nothing but records asks for."""
    return replace(state, rates=replace(state.rates, fluid=replace(state.rates.fluid, gradients={})))


def member_key(name: str) -> str:
    """The name in a state's memory of which particles a region holds: 1 for members, 0 for the others."""
    return f"region.{name}"


def rows(array: Array, active: Array | None) -> Array:
    """The rows of active particles; all of them where that is None."""
    return array if active is None else array.take(active, axis=0)
