"""Gradients of the pressure from a matrix: what they keep exactly, where they are right, and what refuses them."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.build.assemble import prepare
from astroinertia.effects.catalogue import build
from astroinertia.effects.kinds.pressure import contact
from astroinertia.engines import numba_cpu, xla
from astroinertia.errors import SceneError
from astroinertia.matter.gases import Ideal
from astroinertia.models.sph.evaluate import evaluated, internal_energy, virial_tensors
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.state import Problem
from astroinertia.models.sph.step import step
from astroinertia.scene import load
from tests.ball import ball, state_of

pytestmark = pytest.mark.usefixtures("steps_differ")

INTEGRAL = build("pressure", {"gradients": "integral"})
KERNEL = build("pressure", {})


def disordered(effect, engine=None, count=600):
    """A ball of unequal entropies, contacts among them, and random velocities: problem, state, order of placing."""
    random = np.random.default_rng(5)
    position = ball(count)
    velocity = random.normal(size=position.shape) + np.cross([0.0, 0.0, 1.0], position)
    entropy = np.where(position[:, 0] > 0.0, 0.2, 0.5) * random.uniform(0.9, 1.1, len(position))
    problem, state, arrangement = state_of(
        effect, position=position, velocity=velocity, entropy=entropy, engine=engine or numba_cpu.Engine("float64")
    )
    return problem, state, arrangement, np.argsort(np.asarray(state.identity))


def total_energy(problem, state):
    """Kinetic and internal."""
    return 0.5 * float(state.mass @ (state.velocity**2).sum(axis=1)) + float(internal_energy(problem, state))


@pytest.mark.slow
def test_momentum_and_angular_momentum_are_exact():
    """Net force and torque are rounding of their terms, and the virial tensor of the pairs is that of the forces."""
    problem, state, arrangement, _ = disordered(INTEGRAL)
    force = state.mass[:, None] * state.rates.total
    torque = np.cross(state.position, force)
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * np.abs(force).sum()
    assert np.abs(torque.sum(axis=0)).max() < 1e-14 * np.abs(torque).sum()
    paired = virial_tensors(problem, arrangement, state.rates.fluid)["pressure"]
    np.testing.assert_allclose(paired, state.position.T @ force, rtol=1e-12, atol=1e-13)


@pytest.mark.slow
def test_heat_is_what_the_work_has_more_than_that_of_the_kernels_gradients():
    """The kernel's force is the gradient of the internal energy at constant entropy: power and heat differ by rounding.

    The heat has either sign, and is small beside the compression.
    """
    _, state, _, order = disordered(INTEGRAL)
    _, other, _, back = disordered(KERNEL)
    mass, velocity = state.mass[order], state.velocity[order]
    power = mass @ (velocity * (state.rates.total[order] - other.rates.total[back])).sum(axis=1)
    heat = mass * state.rates.heating[0][order]
    assert other.rates.heating[0] is None
    assert abs(power + heat.sum()) < 1e-13 * np.abs(heat).sum()
    assert heat.min() < 0.0 < heat.max()


@pytest.mark.parametrize("effect", [INTEGRAL, KERNEL], ids=["integral", "kernel"])
def test_energy_is_kept_to_the_order_of_the_step(effect):
    """Half of the step, a fourth of the error: heat that is missing or late would not fall like that."""
    problem, first, arrangement, _ = disordered(effect)
    errors = []
    for count in (8, 16):
        state = first
        for _ in range(count):
            state = step(problem, arrangement, state, 0.01 / count)
        errors.append(abs(total_energy(problem, state) - total_energy(problem, first)))
    assert 3.3 < errors[0] / errors[1] < 5.0
    assert errors[0] < 1e-4 * total_energy(problem, first)


def uniform_flow(effect, gradient, count) -> Any:
    """Particles of a jittered lattice with a pressure 1 + gradient.x, which expand: state, and those inside."""
    position, pressure_at = ball(count), lambda x: 1.0 + x @ gradient
    problem, state, _ = state_of(
        effect, position=position, velocity=position, entropy=1.0, engine=numba_cpu.Engine("float64")
    )
    entropy = pressure_at(state.position) / state.rates.fluid.density ** (5 / 3)
    state, _ = initial_state(problem, state.mass, state.position, state.velocity, entropy)
    return state, np.linalg.norm(state.position, axis=1) < 0.5


def test_uniform_expansion_is_exact_however_particles_lie():
    """Its heat is nothing but the smallest eigenvalue: at constant entropy compression is exact there too."""
    state, inside = uniform_flow(INTEGRAL, np.zeros(3), 900)
    rate = 3.0 * state.rates.fluid.pressure / state.rates.fluid.density
    assert np.abs(state.rates.heating[0] / rate)[inside].max() < 2e-5
    sheared = replace(state, velocity=state.velocity * [1.0, -1.0, 0.0])
    problem, *_ = state_of(
        INTEGRAL, position=ball(100), velocity=ball(100), entropy=1.0, engine=numba_cpu.Engine("float64")
    )
    other, _ = initial_state(problem, sheared.mass, sheared.position, sheared.velocity, sheared.entropy)
    assert np.abs(other.rates.heating[0] / rate)[inside].max() > 1e-3


@pytest.mark.full
def test_disorder_pushes_less_than_with_the_kernels_gradients():
    """rms errors of a linear pressure's push, and of its part that goes with the gradient: 0.90 and 0.89 of those."""
    gradient = np.array([0.3, -0.2, 0.1])
    exact = -gradient / (3.0 / (4.0 * np.pi))
    errors = {}
    for name, effect in (("integral", INTEGRAL), ("kernel", KERNEL)):
        up, inside = uniform_flow(effect, gradient, 2500)
        down, _ = uniform_flow(effect, -gradient, 2500)
        wrong = up.rates.total - exact, 0.5 * (up.rates.total - down.rates.total) - exact
        errors[name] = np.array([np.sqrt((error[inside] ** 2).sum(axis=1).mean()) for error in wrong])
    assert errors["integral"] / errors["kernel"] == pytest.approx([0.90, 0.89], abs=0.02)


def test_a_contact_is_where_densities_alone_differ():
    """Nothing in waves of one entropy, isothermal layers and shocks; all across a contact; the same from both sides."""
    at = {
        "wave": (1.0, 1.2, 1.0, 1.2 ** (5 / 3)),
        "isothermal": (1.0, 3.0, 1.0, 3.0),
        "strong shock": (4.0, 1.0, 100.0, 1.0),
        "contact": (1.0, 1.25, 2.0, 2.0),
        "nothing at all": (1.0, 1.0, 0.0, 0.0),
    }
    found = {name: float(contact(np, *values)) for name, values in at.items()}
    assert found == pytest.approx(
        {"wave": 0.0, "isothermal": 0.0, "strong shock": 0.0, "contact": 1.0, "nothing at all": 0.0}, abs=1e-12
    )
    assert contact(np, 1.0, 1.05, -2.0, -2.0) == pytest.approx(contact(np, 1.05, 1.0, -2.0, -2.0), rel=1e-14)
    assert 0.0 < contact(np, 1.0, 1.05, -2.0, -2.0) < 1.0


@pytest.mark.parametrize("shape", ["a pair", "a line", "a plane", "pairs in one place"])
def test_neighbours_that_leave_a_direction_out_give_no_infinite_push(shape):
    """Forces are finite and opposite, also where the matrix is singular."""
    grid = np.stack(np.meshgrid(*[np.arange(6.0)] * 2, indexing="ij"), axis=-1).reshape(-1, 2) * 0.1
    flat = np.column_stack([grid, np.zeros(len(grid))])
    pairs = np.repeat(flat[:6], 2, axis=0)
    position = {"a pair": flat[:2], "a line": flat[:6], "a plane": flat, "pairs in one place": pairs}[shape]
    problem = Problem(
        effects=(INTEGRAL,), equation_of_state=Ideal(5 / 3), eta=0.8 if len(position) == 2 else 0.9, courant=0.3,
        acceleration_factor=0.3, energy_factor=0.3, max_timestep=0.1, engine=numba_cpu.Engine("float64"),
        kernel="cubic", smoothing_tolerance=1e-10,
    )  # fmt: skip
    count = len(position)
    state: Any = initial_state(problem, np.ones(count), position, 0 * position, np.ones(count))[0]
    assert np.isfinite(state.rates.total).all() and np.isfinite(state.rates.heating[0]).all()
    assert np.abs(state.rates.total.sum(axis=0)).max() <= 1e-12 * np.abs(state.rates.total).sum()


@pytest.mark.full
def test_both_engines_have_the_same_forces_and_heat():
    problem, one, _, order = disordered(INTEGRAL, count=300)
    with jax.enable_x64(True):
        # In one program: the first state of xla compiles hundreds of small ones.
        problem = replace(problem, engine=xla.Engine(precision="float64"))
        dense = replace(one, smoothing_length=1.1 * one.smoothing_length)
        dense, arrangement = rearranged(problem, jax.tree.map(jnp.asarray, dense))
        other = jax.jit(evaluated)(problem, arrangement, dense, jnp.zeros(()))
        back = np.argsort(np.asarray(other.identity))
        total, heating = np.asarray(other.rates.total)[back], np.asarray(other.rates.heating[0])[back]
    scale = np.abs(one.rates.total).max()
    assert np.abs(one.rates.total[order] - total).max() < 1e-11 * scale
    assert np.abs(one.rates.heating[0][order] - heating).max() < 1e-11 * np.abs(heating).max()


SCENE = """
name = "ball"
units = "code"
[body]
kind = "polytrope"
index = 1.5
particles = 300
mass = 1.0
radius = 1.0
[equation_of_state]
kind = "{kind}"
gamma = 1.6666666666666667
{constant}
[effects.gravity]
[effects.pressure]
gradients = "{gradients}"
order = "{order}"
[time]
end = 0.2
[numerics]
timesteps = "{steps}"
"""


def body_of(kind="ideal", gradients="integral", order="second", steps="global") -> Any:
    """The particles of a scene."""
    constant = 'constant = "from body"' if kind == "polytropic" else ""
    return prepare(
        load.loads(SCENE.format(kind=kind, constant=constant, gradients=gradients, order=order, steps=steps))
    ).evolution


def test_what_has_no_such_gradients_refuses_them():
    with pytest.raises(SceneError, match=r'\[effects.pressure\] gradients = "integral" is for order = "second"'):
        body_of(order="fourth")
    with pytest.raises(SceneError, match=r"\[effects.pressure\] as it is set needs matter that can be warm"):
        body_of(kind="polytropic")


@pytest.mark.full
def test_bodies_settle_with_the_kernels_gradients():
    """Those have a potential: the particles of a body are the same with both."""
    one, other = (body_of(gradients=gradients).state for gradients in ("integral", "kernel"))
    np.testing.assert_array_equal(one.position, other.position)
    assert np.abs(one.rates.total - other.rates.total).max() > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("steps", ["global", "individual"])
def test_the_ledger_has_the_heat_in_the_row_of_pressure(steps):
    """What the body gains as heat and work is what the rows say, with both kinds of steps."""
    body = body_of(steps=steps)
    before = float(internal_energy(body.problem, body.state))
    while body.time < body.end * (1 - 1e-12):
        body.advance(body.end)
    rows = dict(zip(body.problem.effect_names, np.asarray(body.state.ledger.heating.value), strict=True))
    gained = float(internal_energy(body.problem, body.state)) - before
    assert rows["pressure"] == pytest.approx(gained, rel=1e-10, abs=1e-14)
    assert rows["gravity"] == 0.0
