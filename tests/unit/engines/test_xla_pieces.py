"""Functions of JAX in pieces: the same values, and nothing compiled twice."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.effects.catalogue import build
from astroinertia.engines import xla_pieces
from astroinertia.engines.xla import Engine
from astroinertia.engines.xla_pieces import in_pieces
from astroinertia.models.sph.step import step
from tests.ball import ball, state_of

pytestmark = pytest.mark.usefixtures("float64")

OFFSETS = np.arange(3.0)


@partial(jax.jit, static_argnames="power")
def swept(power, array, factor):
    """A pass: a loop with a reverse derivative."""
    return jax.lax.scan(lambda carry, _: (factor * carry + array**power, None), array, None, length=3)[0]


def some_work(tree, extra):
    """Passes one after the other, of the same program and of another, with numbers, constants and results between."""
    first = swept(2, jnp.sin(tree["a"]) + OFFSETS, 0.5)
    second = swept(2, first + extra, 0.5)
    unused = swept(3, first, 0.1)
    third = swept(3, jnp.where(second > 0.0, unused, first), 0.1)
    return {"sum": third.sum(), "same": tree["a"], "number": 1.0, "none": None, "first": (first, third)}


@pytest.fixture(scope="module")
def compilations():
    """Durations in the order in which XLA has compiled programs since."""
    found = []

    def heard(event, duration, **_):
        if event == "/jax/core/compile/backend_compile_duration":
            found.append(duration)

    jax.monitoring.register_event_duration_secs_listener(heard)  # for good: not all versions can take it back
    return found


def added(found, function):
    """How many a call adds."""
    before = len(found)
    function()
    return len(found) - before


@pytest.mark.slow
def test_values_and_structures_are_those_of_the_function():
    arguments = {"a": np.linspace(0.1, 1.0, 3)}, 0.25
    found, wanted = in_pieces(some_work)(*arguments), some_work(*arguments)
    assert jax.tree.structure(found) == jax.tree.structure(wanted)
    jax.tree.map(partial(np.testing.assert_allclose, rtol=1e-14), found, wanted)


@pytest.mark.slow
def test_a_call_compiles_what_none_before_it_has(compilations):
    def work(tree, extra):
        return some_work(tree, extra)

    def more_work(tree, extra):
        return swept(2, tree["a"] + extra, 0.5)

    arguments = {"a": jnp.linspace(0.1, 1.0, 3)}, jnp.asarray(0.25)
    xla_pieces._function.cache_clear()
    assert added(compilations, lambda: in_pieces(work)(*arguments)) >= 4  # two passes, and what is around them
    assert xla_pieces._function.cache_info().misses == 2
    assert added(compilations, lambda: in_pieces(work)(*arguments)) == 0
    assert added(compilations, lambda: in_pieces(more_work)(*arguments)) == 1  # a sum; its pass there was
    other_shapes = {"a": jnp.ones((3, 3))}, jnp.asarray(0.25)
    assert added(compilations, lambda: in_pieces(work)(*other_shapes)) >= 4


@pytest.mark.slow
def test_within_a_program_it_is_a_part_of_it_and_has_derivatives():
    array = jnp.linspace(0.1, 1.0, 3)

    def total(work, a):
        return work({"a": a}, 0.25)["sum"]

    slope = jax.jit(jax.grad(partial(total, in_pieces(some_work))))(array)
    np.testing.assert_allclose(slope, jax.grad(partial(total, some_work))(array), rtol=1e-13)


@pytest.mark.full
def test_a_step_of_particles_is_that_of_one_program_and_has_the_passes_of_the_first_state(compilations):
    position = ball(60)
    pressure, engine = build("pressure", {}), Engine()
    problem, state, arrangement = state_of(pressure, position=position, velocity=position[:, [1, 2, 0]], engine=engine)
    passes = xla_pieces._function.cache_info().misses
    one = step(problem, arrangement, state, state.rates.timestep)
    assert xla_pieces._function.cache_info().misses == passes > 0
    assert added(compilations, lambda: step(problem, arrangement, one, one.rates.timestep)) == 0
    whole = jax.jit(step)(problem, arrangement, state, state.rates.timestep)
    for name in ("position", "velocity", "entropy", "smoothing_length"):
        here, there = (np.asarray(getattr(of, name)) for of in (one, whole))
        assert np.abs(here - there).max() < 1e-12 * np.abs(there).max(), name
