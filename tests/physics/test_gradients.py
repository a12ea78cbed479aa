"""Derivatives through time: how a run's moment of inertia answers to its initial rotation rate and to gamma.

Fifty steps of 500 particles are differentiated in reverse mode, each stored and computed again, the dependence of
smoothing lengths (implicitly) and of the time step included, and compared to central differences.
"""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.effects.catalogue import build
from astroinertia.engines.xla import Engine
from astroinertia.ledger.moments import open_ledger
from astroinertia.matter.gases import Ideal
from astroinertia.models.sph.evaluate import evaluated
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.state import Problem
from astroinertia.models.sph.step import advance

COUNT, STEPS = 500, 50
KINDS = ("gravity", "pressure", "viscosity")
RATE, GAMMA = 0.7, 5 / 3
WIDTHS = (1e-5, 1e-6)
BAR = 1e-5


def ball():
    """The 500 points nearest the middle of a shaken lattice, in the unit sphere, with equal masses."""
    random = np.random.default_rng(2)
    points = np.stack(np.meshgrid(*[np.arange(-6.0, 7.0)] * 3), -1).reshape(-1, 3)
    points = points + 0.1 * random.normal(size=points.shape)
    nearest = points[np.argsort(np.linalg.norm(points, axis=1))[:COUNT]]
    return np.full(COUNT, 1.0 / COUNT), nearest / np.linalg.norm(nearest, axis=1).max()


def problem(gamma, kinds):
    options = {"viscosity": {"switch": "none", "limiter": "none"}}
    return Problem(
        effects=tuple(build(kind, options.get(kind, {})) for kind in kinds),
        equation_of_state=Ideal(gamma),
        eta=1.2,
        courant=0.3,
        acceleration_factor=0.25,
        energy_factor=0.25,
        max_timestep=1.0,
        # Margins for all 50 steps: lists that go stale are no error, but slow.
        engine=Engine(motion=0.3, growth=0.3),
        kernel="cubic",
        smoothing_tolerance=1e-13,
    )


@pytest.mark.full
@pytest.mark.parametrize("kinds", [KINDS])
def test_inertia_answers_to_rotation_and_gamma_as_central_differences_say(kinds):
    with jax.enable_x64(True):
        mass, position = ball()
        still = np.zeros_like(position)
        opening, arrangement = initial_state(problem(GAMMA, kinds), mass, position, still, np.full(COUNT, 0.2))
        opening = replace(opening, rates=replace(opening.rates, fluid=None))

        def run(parameters):
            rate, gamma = parameters
            here = problem(gamma, kinds)
            x, y, _ = opening.position.T
            velocity = rate * jnp.stack([-y, x, jnp.zeros_like(x)], axis=1)
            ledger = open_ledger(jnp, opening.mass, opening.position, velocity, len(kinds))
            state = replace(opening, velocity=velocity, ledger=ledger)
            state = evaluated(here, arrangement, state, jnp.zeros(()))
            state = advance(here, arrangement, state, STEPS)
            x, y, _ = (state.position - state.mass @ state.position / state.mass.sum()).T
            return state.mass @ (x * x + y * y), state.time

        at = jnp.array([RATE, GAMMA])
        compiled = jax.jit(run)
        (_, end), gradient = jax.jit(jax.value_and_grad(run, has_aux=True))(at)
        inertia_at_start = float(mass @ (position[:, :2] ** 2).sum(axis=1))
        assert abs(float(compiled(at)[0]) / inertia_at_start - 1.0) > 0.1  # the body moves
        for parameter in range(2):
            for width in WIDTHS:
                ahead, behind = (compiled(at.at[parameter].add(sign * width)) for sign in (1.0, -1.0))
                difference = (ahead[0] - behind[0]) / (2.0 * width)
                assert abs(float(gradient[parameter] / difference) - 1.0) < BAR
                # The time step depends on the parameters: so does the time reached.
                assert abs(float(ahead[1] - behind[1])) / (2.0 * width) > 1e-3 * float(end)
