"""Limits of the step: by matter that is still apart, against pairs of bodies; by energy, for as long as it lasts."""

import math
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.build.assemble import prepare
from astroinertia.engines.elementwise import elementwise
from astroinertia.models.sph.limits import (
    DEPTH,
    GROUPS,
    contact_limit,
    contacts,
    doubling,
    limiting,
    timestep_limits,
    towards,
)
from astroinertia.models.sph.record import timestep_limit
from astroinertia.scene import load

SUPPORT = 2.0


def limit(position, velocity, h, step=1e9, xp=np):
    position, velocity = np.asarray(position, dtype=float), np.asarray(velocity, dtype=float)
    h = np.broadcast_to(np.asarray(h, dtype=float), len(position))
    with jax.enable_x64(True):
        return float(contact_limit(xp, *(xp.asarray(a) for a in (position, velocity, h)), SUPPORT, step))


@pytest.mark.parametrize("xp", [np, pytest.param(jnp, marks=pytest.mark.full)], ids=["numpy", "jax"])
def test_two_particles_may_step_until_they_are_half_a_smoothing_length_deep(xp):
    gap = 10.0 - SUPPORT * 0.2
    found = limit([[0, 0, 0], [10, 0, 0]], [[3, 0, 0], [-1, 0, 0]], [0.1, 0.2], xp=xp)
    assert found == pytest.approx((gap + DEPTH * 0.2) / 4.0, rel=1e-14)
    assert limit([[0, 0, 0], [10, 0, 0]], [[-3, 0, 0], [1, 0, 0]], 0.1, xp=xp) == np.inf  # they part
    # What is within reach already has its signal velocity to limit it, and goes no deeper.
    assert limit([[0, 0, 0], [0.1, 0, 0]], [[1, 0, 0], [-1, 0, 0]], 0.2, xp=xp) == pytest.approx(DEPTH * 0.2 / 2.0)


def test_nothing_is_looked_for_where_the_step_takes_nothing_deep():
    position, velocity = [[0, 0, 0], [0.3, 0, 0]], [[1, 0, 0], [-1, 0, 0]]
    assert limit(position, velocity, 0.1, step=0.024) == np.inf
    assert limit(position, velocity, 0.1, step=0.026) == pytest.approx((0.1 + DEPTH * 0.1) / 2.0)


def test_each_particle_is_limited_by_what_it_meets_itself():
    """Two that approach each other fast, and two far from them that do so slowly; one that flies off from all."""
    problem: Any = SimpleNamespace(kernel="wendland_c2")
    place = np.array([[0.0, 0, 0], [10, 0, 0], [0, 900, 0], [10, 900, 0], [0, 0, -5000]])
    velocity = np.array([[3.0, 0, 0], [-3, 0, 0], [0.5, 0, 0], [-0.5, 0, 0], [0, 0, -1]])
    gap, h = 10.0 - SUPPORT * 0.1, np.full(5, 0.1)
    found = contacts(problem, place, velocity, h, 100.0)
    soon, late = (gap + DEPTH * 0.1) / 6.0, (gap + DEPTH * 0.1) / 1.0
    assert found[:4] == pytest.approx([soon, soon, late, late], rel=1e-12)
    assert found[4] > 100.0
    assert found.min() == limit(place, velocity, h)
    assert np.isinf(contacts(problem, place, velocity, h, 0.008)).all()


def test_many_particles_in_groups_never_step_past_the_first_contact_of_all_pairs():
    # Sorted along the line between two bodies, as leaves would have them.
    generator = np.random.default_rng(2)
    count, speed, apart, h = 4 * GROUPS, 50.0, 6.0, 0.05
    first = (np.arange(count) < count // 2)[:, None]
    position = generator.uniform(-1.0, 1.0, (count, 3)) + np.where(first, 0.0, apart) * [1.0, 0.0, 0.0]
    velocity = np.where(first, speed, -speed) * [1.0, 0.0, 0.0]
    order = np.argsort(position[:, 0])
    found = limit(position[order], velocity[order], h)
    between = position[count // 2 :, None] - position[None, : count // 2]
    across, along = np.linalg.norm(between[..., 1:], axis=2), between[..., 0]
    reach = SUPPORT * h
    touching = along - np.sqrt(np.maximum(reach**2 - across**2, 0.0))
    meet = touching[across < reach].min() / (2.0 * speed)
    assert 0.25 * meet < found < meet + DEPTH * h / (2.0 * speed)


def test_it_does_not_depend_on_the_frame_nor_on_the_origin():
    position, velocity = np.random.default_rng(4).normal(size=(2, 100, 3))
    here = limit(position, velocity, 0.01)
    assert limit(position + 100.0, velocity - 1000.0, 0.01) == pytest.approx(here, rel=1e-9)


@pytest.mark.parametrize("xp", [np, pytest.param(jnp, marks=pytest.mark.full)], ids=["numpy", "jax"])
def test_matter_without_energy_does_not_limit_the_step(xp: Any) -> None:
    """A cold solid's energy is zero but for the error of its table, of either sign: no step may be negative by that."""
    energy = xp.asarray([2.0, 2.0, -1e-5, 0.0, -1e-5])
    heating = xp.asarray([-0.5, 0.5, -1e-99, -0.5, 0.5])
    pull = xp.asarray(np.outer([0.0, 3.0, 3.0, 3.0, 3.0], [0.0, 0.6, 0.8]))
    found = np.asarray(elementwise(xp, doubling, xp.asarray(np.full(5, 0.5)), pull, energy, heating, 0.25)[0])
    assert np.allclose(found, [1.0, 0.25 * (2.0 + 1.5) / 0.5, np.inf, np.inf, 0.25 * (1.5 - 1e-5) / 0.5], rtol=1e-6)


def test_steps_to_a_time_are_no_more_than_needed_and_none_is_a_small_remainder() -> None:
    for way in (1e-3, 0.4, 1.0, 1.01, 2.0 + 1e-14, 3.3, 7.2):
        left, steps = way, []
        while left > 1e-12:
            steps.append(towards(left, 1.0))
            left -= steps[-1]
        assert len(steps) == math.ceil(way * (1.0 - 1e-12)) and sum(steps) == pytest.approx(way, rel=1e-14)
        assert max(steps) <= 1.0 + 1e-12 and min(steps) > min(way, 0.5) * (1.0 - 1e-12)
    assert towards(math.inf, 0.3) == 0.3 and towards(0.3, math.inf) == 0.3


BALL = """
name = "ball"
units = "code"
body = {kind = "uniform", particles = 400, mass = 1, radius = 1, relax = false, placement = "random"}
effects = {gravity = {}, pressure = {}}
time = {end = 1}
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
"""


def test_the_progress_line_names_the_criterion_and_the_place() -> None:
    body: Any = prepare(load.loads(BALL)).evolution
    limits = timestep_limits(body.problem, body.state.rates)
    name, particle = limiting(limits)
    assert particle is not None
    assert float(limits[name][particle]) == float(body.state.rates.timestep)
    limit, figures = timestep_limit(body.problem, body.state), body.figures()
    assert figures.limited_by == name
    assert figures.limited_at == (limit["timestep_limit_radius"], limit["timestep_limit_density"])
    assert limit["timestep_limit_density"] == body.state.rates.fluid.density[particle]
    assert limiting({**limits, "longest": np.float64(1e-9)}) == ("longest", None)
