"""Lists of neighbours before a step: made for where it evaluates the forces, and made again where they do not hold."""

import math
from dataclasses import replace

import jax
import numpy as np
import pytest

from astroinertia.effects.catalogue import build
from astroinertia.engines.xla import Engine
from astroinertia.models.sph import listed_step
from astroinertia.models.sph.evolution import Particles
from astroinertia.models.sph.sorting import rearranged, stale
from astroinertia.models.sph.step import step
from tests.ball import ball, state_of


@pytest.fixture(scope="module")
def body():
    with jax.enable_x64(True):
        position = ball(60)
        start = state_of(
            build("pressure", {}), position=position, velocity=5.0 * position[:, [1, 2, 0]], engine=Engine()
        )
        yield Particles(*start, end=1.0)


def test_lists_hold_where_a_step_ends_that_is_shortened_to_meet_a_time(body):
    allowed = float(body.state.rates.timestep)
    dt = body.begin(0.5 * allowed, math.inf)
    assert dt == 0.5 * allowed
    assert not stale(body.problem, body.arrangement, body.state, dt)
    # So far that lists made for a step of the allowed length would not have held.
    assert stale(body.problem, body.arrangement, body.state, np.float64(allowed))


@pytest.mark.slow
@pytest.mark.parametrize(("share", "steps"), [(1.0, 1), (0.85, 2), (0.6, 3), (0.02, listed_step.ATTEMPTS + 1)])
def test_a_step_that_outgrows_its_lists_is_taken_again_with_longer_ones(body, monkeypatch, share, steps):
    problem, dt = body.problem, np.float64(body.state.rates.timestep)
    state, arrangement = rearranged(problem, body.state, dt)
    wanted = step(problem, arrangement, state, dt)
    length = state.smoothing_length.at[7].multiply(share)  # one that has come to be so much longer
    state, arrangement = rearranged(problem, state, dt, length)
    taken = []
    monkeypatch.setattr(listed_step, "step", lambda *arguments: taken.append(step(*arguments)) or taken[-1])
    found, arrangement = listed_step.listed_step(problem, arrangement, state, dt)
    assert len(taken) == steps
    covered = not problem.engine.stale(arrangement.pairs, found.position, found.smoothing_length)
    assert covered == (steps <= listed_step.ATTEMPTS)
    order, before = (np.argsort(np.asarray(of.identity)) for of in (found, wanted))
    for name in ("position", "velocity", "smoothing_length"):
        here, there = np.asarray(getattr(found, name))[order], np.asarray(getattr(wanted, name))[before]
        assert np.abs(here - there).max() < 1e-11 * np.abs(there).max(), name


@pytest.mark.full
def test_without_a_caller_that_looks_lengths_are_solved_for_whatever_the_lists_hold(body):
    state, dt = body.state, np.float64(body.state.rates.timestep)
    short, arrangement = rearranged(body.problem, state, dt, 0.6 * state.smoothing_length)
    held = replace(arrangement, pairs=body.problem.engine.held(arrangement.pairs))
    lengths = [np.asarray(step(body.problem, of, short, dt).smoothing_length) for of in (arrangement, held)]
    assert np.all(lengths[1] <= 0.6 * 1.04 * np.asarray(short.smoothing_length) * (1 + 1e-12))
    assert np.all(lengths[0] > 0.8 * np.asarray(short.smoothing_length))
