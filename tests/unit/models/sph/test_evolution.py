"""Particles under way: steps meet the times at which effects begin and end."""

import itertools
import math
import weakref
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
import pytest

from astroinertia.effects import Effect, catalogue, pytree
from astroinertia.effects.gradients import VELOCITY_GRADIENT
from astroinertia.engines.terms import COMMON
from astroinertia.errors import NumericalError
from astroinertia.models.checkpoint import flattened
from astroinertia.models.protocol import GivenUp
from astroinertia.models.sph import block_step
from astroinertia.models.sph.evolution import Particles
from tests.ball import ball, state_of
from tests.pairs import BruteEngine

END = 0.4


@pytree
@dataclass(frozen=True, eq=False)
class Push(Effect):
    """A uniform acceleration from one time to another."""

    begin: Any
    until: Any

    kind: ClassVar[str] = "push"
    external: ClassVar[bool] = True

    def acceleration(self, xp, fluid):
        acts = (fluid.time >= self.begin) & (fluid.time < self.until)
        return xp.zeros_like(fluid.position) + xp.where(acts, 1.0, 0.0) * xp.asarray([1.0, 0.0, 0.0])

    def breaks(self, start, end):
        return tuple(time for time in (self.begin, self.until) if start < time <= end)

    def during(self, start, end):
        acts = self.begin < 0.5 * (start + end) < self.until
        return replace(self, begin=-math.inf if acts else math.inf, until=math.inf)


@pytree
@dataclass(frozen=True, eq=False)
class Switched(Effect):
    """A uniform acceleration from one time to another, which `during` alone says."""

    begin: Any
    until: Any
    strength: Any = 1.0

    kind: ClassVar[str] = "switched"
    external: ClassVar[bool] = True

    def acceleration(self, xp, fluid):
        return xp.zeros_like(fluid.position) + self.strength * xp.asarray([1.0, 0.0, 0.0])

    def breaks(self, start, end):
        return tuple(time for time in (self.begin, self.until) if start < time <= end)

    def during(self, start, end):
        return replace(self, strength=1.0 if self.begin < 0.5 * (start + end) < self.until else 0.0)


def moved(effect: Any, longest: float, base_step: Any, unit: float = 1.0) -> Particles:
    """Particles that move freely but for an effect, at END, in steps of about that length; in other units of time."""
    position = ball(60)
    velocity = np.random.default_rng(2).normal(size=position.shape) / unit
    problem, state, arrangement = state_of(effect, position=position, velocity=velocity - velocity.mean(axis=0))
    problem = replace(problem, max_timestep=np.float64(longest * unit))
    state = replace(state, rates=replace(state.rates, timestep=problem.max_timestep))
    body = Particles(problem, state, arrangement, END * unit, base_step)
    while body.time < body.end * (1.0 - 1e-14):
        body.advance(body.end)
    return body


@pytest.mark.slow
@pytest.mark.parametrize("base_step", [None, block_step.step])
def test_damping_lasts_to_second_order_of_the_step_as_long_as_it_is_to_last(base_step: Any) -> None:
    damping = catalogue.build("damping", {"time_scale": 0.3, "until": 0.22})
    begun = moved(catalogue.build("damping", {"time_scale": 1e9}), 0.1, base_step).state
    slowed = math.exp(-0.22 / 0.3)
    errors = []
    for longest in (0.034, 0.017, 0.0085):
        now = moved(damping, longest, base_step).state
        ratios = now.velocity[np.argsort(now.identity)] / begun.velocity[np.argsort(begun.identity)]
        errors.append(float(np.abs(ratios - slowed).max()))
    assert errors[0] < 1e-3
    assert all(3.0 < a / b < 5.5 for a, b in itertools.pairwise(errors)), errors


@pytest.mark.slow
def test_it_ends_where_a_step_ends_in_any_unit_of_time() -> None:
    """A step that ends just there, by rounding before or after it, has the damping to its end, and the next none."""
    speeds = []
    for unit in (1.0, 3.0**-0.5, 7.0**-0.5, 1.7, math.pi, 11.0**0.5):
        damping = catalogue.build("damping", {"time_scale": 0.3 * unit, "until": 0.2 * unit})
        speeds.append(np.linalg.norm(moved(damping, 0.02, None, unit).state.velocity, axis=1) * unit)
    assert np.allclose(speeds, speeds[0], rtol=1e-12, atol=0.0)


def test_an_effect_that_begins_and_ends_acts_from_one_time_to_the_other() -> None:
    body = moved(Push(0.111, 0.333), 0.05, None)
    gained = body.state.velocity.mean(axis=0)
    assert np.allclose(gained, [0.222, 0.0, 0.0], rtol=0.0, atol=1e-14)
    assert math.isclose(body.state.ledger.impulse.total[0, 0], 0.222, rel_tol=1e-13)


@pytree
@dataclass(frozen=True, eq=False)
class Watch(Push):
    """Notes whether an array is held by anybody while forces are evaluated."""

    watched: Any = field(default=None, metadata={"static": True})
    noted: Any = field(default=None, metadata={"static": True})

    def acceleration(self, xp, fluid):
        if self.watched:
            self.noted.append(self.watched[0]() is not None)
        return super().acceleration(xp, fluid)


def test_unsorted_particles_take_no_memory_while_forces_are_evaluated() -> None:
    """They and the sorted ones took half as much again as a step without a sort does."""
    effect = Watch(-math.inf, math.inf, [], [])
    position = ball(60)
    problem, state, arrangement = state_of(effect, position=position, velocity=np.zeros_like(position))
    problem = replace(problem, max_timestep=np.float64(0.01))
    state = replace(state, rates=replace(state.rates, timestep=problem.max_timestep))
    body = Particles(problem, state, arrangement, END)
    effect.watched.append(weakref.ref(body.state.rates.fluid.position))
    del state, arrangement
    assert body.resumable
    body.advance(END)
    assert effect.noted == [False]


@pytree
@dataclass(frozen=True, eq=False)
class Gradients(Watch):
    """The same, with a pass before the forces."""

    gradient_terms: ClassVar[tuple] = (VELOCITY_GRADIENT,)


def test_the_gradients_of_one_step_take_no_memory_in_the_next() -> None:
    """They were a quarter of what is held between steps; records have them until then."""
    effect = Gradients(-math.inf, math.inf, [], [])
    position = ball(60)
    problem, state, arrangement = state_of(effect, position=position, velocity=np.zeros_like(position))
    problem = replace(problem, max_timestep=np.float64(0.01))
    state = replace(state, rates=replace(state.rates, timestep=problem.max_timestep))
    body = Particles(problem, state, arrangement, END)
    del state
    body.advance(END)
    assert not body.resumable  # no sort comes, which would leave them behind anyway
    effect.watched.append(weakref.ref(body.state.rates.fluid.gradients[COMMON]["velocity"]))
    body.advance(END)
    assert effect.noted == [False]


class Turning(BruteEngine):
    """Sorts particles the other way round."""

    def arrange(self, position, smoothing_length):
        return np.arange(len(position))[::-1], None


def test_a_base_step_that_is_given_up_leaves_particles_as_they_were_and_keeps_none_of_them_twice() -> None:
    position = ball(60)
    effect = Push(-math.inf, math.inf)
    problem, state, arrangement = state_of(effect, position=position, velocity=position, engine=Turning())
    before, kept = flattened(state), weakref.ref(state.rates.fluid.velocity)
    before = {name: array.copy() for name, array in before.items()}
    identity, held = [], []

    def given_up(problem: Any, arrangement: Any, state: Any, *_: Any) -> Any:
        identity.append(state.identity)
        held.append(kept() is not None)
        raise GivenUp

    body = Particles(problem, state, arrangement, END, given_up)
    del state
    with pytest.raises(GivenUp):
        body.advance(END)
    assert np.array_equal(identity[0], before[".identity"][::-1])
    assert held == [False]
    assert body.arrangement is arrangement
    after = body.arrays()
    assert before.keys() == after.keys()
    for name, array in before.items():
        assert np.array_equal(array, after[name]), name


@pytest.mark.slow
@pytest.mark.parametrize("base_step", [None, block_step.step])
@pytest.mark.parametrize(("begin", "until"), [(-1.0, 0.13), (0.0, 0.13), (0.13, 0.27), (0.13, END), (0.13, 9.0)])
def test_an_effect_that_during_alone_switches_acts_then_and_at_no_other_time(begin, until, base_step) -> None:
    lasts = min(until, END) - max(begin, 0.0)
    body = moved(Switched(begin, until), 0.034, base_step)
    still = moved(Switched(9.0, 10.0), 0.034, base_step)
    speed, still_speed = (each.state.velocity.mean(axis=0)[0] for each in (body, still))
    assert speed - still_speed == pytest.approx(lasts, rel=1e-12)
    mass = float(np.asarray(body.state.mass).sum())
    pushed = mass if until > END else 0.0  # at the end of the run
    assert body.look(None)["force"][0, 0] == pytest.approx(pushed, rel=1e-12, abs=1e-14)


def test_a_step_that_falls_to_nothing_is_a_share_of_the_run_in_any_units() -> None:
    place = ball(60)
    problem, state, arrangement = state_of(
        catalogue.build("damping", {"time_scale": 1.0}), position=place, velocity=0.0 * place
    )
    for unit in (1.0, 1e9):
        fallen = replace(state, rates=replace(state.rates, timestep=np.float64(3e-15 * unit)))
        body = Particles(problem, fallen, arrangement, unit)
        with pytest.raises(NumericalError, match=r"the time step fell to 3\.00e-15 of the length of the run"):
            body.advance(unit)
