"""Accelerations are the exact gradients of the energies, through smoothing lengths that follow the positions.

The energy is differentiated with respect to positions by reverse mode through the xla engine, h and the softening
included; -dE/dx must be m a to rounding. A wrong or missing grad-h or zeta term shows at the level of per cents.
"""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.effects.catalogue import build
from astroinertia.engines.xla import Engine
from astroinertia.matter import cold_matter, gases
from astroinertia.models.sph.evaluate import effect_accelerations, evaluated, internal_energy, potential_energies
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.state import Problem
from astroinertia.sph.kernels import KERNELS
from tests.pairs import BruteEngine

pytestmark = pytest.mark.usefixtures("float64")

COUNT = 90
OPTIONS = {
    "gravity": {},
    "pressure": {},
    "tide": {"mass": 3.0, "position": (4.0, 1.0, 0.0), "softening": 0.1},
    "external_field": {"quadratic": ((1.0, 0.2, 0.1), (0.2, 0.5, -0.3), (0.1, -0.3, -0.4))},
}
EQUATIONS_OF_STATE = {
    "ideal": gases.Ideal(5 / 3),
    "isothermal": gases.Isothermal(0.7),
    "hybrid": cold_matter.Hybrid(nuclear_density=0.5, gamma_1=1.325, gamma_2=2.5, gamma_thermal=1.5, constant=0.3),
}


def problem(kernel, equation_of_state, kinds):
    return Problem(
        effects=tuple(build(kind, OPTIONS[kind]) for kind in kinds),
        equation_of_state=EQUATIONS_OF_STATE[equation_of_state],
        eta=KERNELS[kernel].eta,
        courant=0.3,
        acceleration_factor=0.25,
        energy_factor=0.25,
        max_timestep=1.0,
        engine=Engine(support=KERNELS[kernel].support),
        kernel=kernel,
        smoothing_tolerance=1e-13,
    )


def body():
    """A clustered, uneven cloud: masses, positions, velocities, entropies."""
    random = np.random.default_rng(5)
    size = np.where(random.random(COUNT) < 0.4, 0.2, 1.0)
    position = size[:, None] * random.normal(size=(COUNT, 3)) * (1.0, 0.8, 0.6)
    mass = random.uniform(0.5, 1.5, COUNT) / COUNT
    return mass, position, random.normal(size=(COUNT, 3)), random.uniform(0.2, 0.4, COUNT)


def energy_and_force(problem, kind):
    """-dE/dx by differentiation of one effect's energy, m a as the effect has it, each (N, 3), and the energy.

    The particles are sorted with lengths of plain sums: one program then solves for its own, evaluates and
    differentiates.
    """
    mass, position, velocity, entropy = body()
    plain = replace(problem, engine=BruteEngine())
    opening = initial_state(plain, mass, position, velocity, entropy)[0]
    opening = replace(opening, smoothing_length=1.1 * opening.smoothing_length)
    opening = replace(opening, rates=replace(opening.rates, fluid=None), memory={})
    opening, arrangement = rearranged(problem, jax.tree.map(jnp.asarray, opening))

    def energy(position):
        moved = evaluated(problem, arrangement, replace(opening, position=position), jnp.zeros(()))
        value = internal_energy(problem, moved) if kind == "pressure" else potential_energies(problem, moved)[kind]
        return value, dict(zip(problem.effect_names, effect_accelerations(jnp, moved.rates), strict=True))[kind]

    (value, acceleration), gradient = jax.jit(jax.value_and_grad(energy, has_aux=True))(opening.position)
    return -gradient, opening.mass[:, None] * acceleration, value


@pytest.mark.full
@pytest.mark.parametrize(
    ("kernel", "equation_of_state"),
    [("quintic", "isothermal"), ("wendland_c4", "hybrid")],
)
def test_pressure_is_the_gradient_of_the_internal_energy(kernel, equation_of_state):
    expected, force, _ = energy_and_force(problem(kernel, equation_of_state, ("pressure",)), "pressure")
    assert jnp.max(jnp.abs(force - expected)) < 1e-11 * jnp.max(jnp.abs(force))


@pytest.mark.full
@pytest.mark.parametrize("kernel", ["cubic", "wendland_c6"])
def test_gravity_is_the_gradient_of_its_energy(kernel):
    expected, force, value = energy_and_force(problem(kernel, "ideal", ("gravity",)), "gravity")
    assert value < 0
    assert jnp.max(jnp.abs(force - expected)) < 1e-11 * jnp.max(jnp.abs(force))


@pytest.mark.parametrize("kind", [pytest.param("tide", marks=pytest.mark.full), "external_field"])
def test_an_outer_field_is_the_gradient_of_its_energy(kind):
    expected, force, _ = energy_and_force(problem("cubic", "ideal", (kind,)), kind)
    assert jnp.max(jnp.abs(force - expected)) < 1e-11 * jnp.max(jnp.abs(force))


@pytest.mark.full
@pytest.mark.parametrize("kind", ["pressure", "gravity"])
def test_the_terms_of_variable_smoothing_lengths_matter(kind, monkeypatch):
    """Without Omega and zeta the same test fails by far: it can see them."""
    fields = type(build(kind, {})).fields

    def plain(self, xp, fluid):
        return fields(self, xp, replace(fluid, grad_h=xp.ones_like(fluid.grad_h), zeta=0.0 * fluid.density))

    monkeypatch.setattr(type(build(kind, {})), "fields", plain)
    expected, force, _ = energy_and_force(problem("cubic", "ideal", (kind,)), kind)
    assert jnp.max(jnp.abs(force - expected)) > 1e-3 * jnp.max(jnp.abs(force))
