"""Densities of fourth order in the smoothing length, and gravity whose softening takes nothing from the binding.

Forces against differences of the energies, densities against profiles that are known, both engines and both kinds of
steps against each other.
"""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.effects.catalogue import build
from astroinertia.engines.numba_cpu import Engine
from astroinertia.engines.xla import Engine as XlaEngine
from astroinertia.models.sph import evaluate
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.record import energy_budget
from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.step import step
from astroinertia.sph import profiles
from astroinertia.sph.density import density, own_share
from astroinertia.sph.fourth_order import limited, sharpened, smoothed
from astroinertia.sph.kernels import KERNELS, OWN_SHARE_NEIGHBOURS, eta_for_neighbours, neighbour_number
from astroinertia.sph.placement import place
from tests.ball import ball, state_of
from tests.benchmarks.own_share import needed_share, settled
from tests.pairs import BruteEngine

FOURTH = {"order": "fourth"}


def solved(kernel, position, mass, neighbours):
    """Positions, and the densities that an engine solves for, in its order."""
    eta = eta_for_neighbours(KERNELS[kernel], neighbours)
    engine, guess = Engine(), np.full(len(mass), 0.1)
    order, arrangement = engine.arrange(position, guess)
    return position[order], density(engine, arrangement, kernel, position[order], mass, guess, eta, 1e-11, False), eta


@pytest.mark.parametrize("kernel", ["wendland_c2", "quintic"])
def test_the_error_of_a_density_falls_with_the_fourth_power_of_the_smoothing_length(kernel):
    """A dense lattice of waves: 2nd and 4th order, as h is doubled at the same particles."""
    side = 40
    x = (np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) + 0.5) / side
    mass = (1.0 + 0.2 * np.cos(2 * np.pi * x[:, 0])) / len(x)  # equal spacing: rho follows the masses
    errors = {"second": [], "fourth": []}
    shape = KERNELS[kernel]
    inside = np.flatnonzero(np.linalg.norm(x - 0.5, axis=1) < 1.0 / side)
    exact = 1.0 + 0.2 * np.cos(2 * np.pi * x[inside, 0])
    for h in (0.23 / shape.support, 0.46 / shape.support):
        q = np.linalg.norm(x[inside][:, None] - x[None], axis=2) / h
        rho = (mass * shape.w(np, q)).sum(axis=1) / h**3
        slope = -(mass * (3 * shape.w(np, q) + q * shape.dw(np, q))).sum(axis=1) / h**4
        contrast = 2.5 - 1.5 * (1 + h / (3 * rho) * slope)
        errors["second"].append(np.abs(rho / exact - 1).max())
        errors["fourth"].append(np.abs(rho * contrast / exact - 1).max())
    order = {name: np.log2(pair[1] / pair[0]) for name, pair in errors.items()}
    assert 1.7 < order["second"] < 2.1
    assert 3.4 < order["fourth"] < 4.3
    assert errors["fourth"][0] < 0.1 * errors["second"][0]


@pytest.mark.full
def test_the_centre_of_a_polytrope_has_its_density():
    """n = 3, 1000 particles: 5 % too low with the kernel's sum, within 1 % with the fourth order, at 113 neighbours.

    They are a glass still: with Wendland C2 on 74 neighbours one has 1.3 % more of the particle itself
    than gas at rest.
    """
    profile = profiles.polytrope(3.0)
    position, found, eta = solved("quintic", place(profile, 1000), np.full(1000, 1e-3), 113.0)
    fourth, _ = sharpened(np, found.density, found.grad_h, own_share(np, "quintic", eta))
    radius = np.linalg.norm(position, axis=1)
    exact = profile.density(radius)
    centre = radius < 0.1
    assert (found.density / exact)[centre].mean() - 1.0 < -0.04
    assert abs((fourth / exact)[centre].mean() - 1.0) < 0.01
    shell = (radius > 0.1) & (radius < 0.3)
    assert abs((fourth / exact)[shell].mean() - 1.0) < 0.01


@pytest.mark.full
@pytest.mark.parametrize(
    "kernel",
    [
        "wendland_c2",
        "quintic",
        "wendland_c4",
        "wendland_c6",
    ],
)
def test_the_share_of_the_particle_itself_is_that_of_settled_gas(kernel):
    """The table against another sample of gas nearly at rest, to 1e-3 near the kernel's own neighbours.

    A glass, which was measured before, has 1.6e-3 to 0.013 more. As much as it is off, settled bodies are too small,
    and no number of particles mends that.
    """
    own = neighbour_number(KERNELS[kernel], KERNELS[kernel].eta)
    k = int(np.argmin(np.abs(np.array(OWN_SHARE_NEIGHBOURS) - own)))
    state = settled(kernel, OWN_SHARE_NEIGHBOURS[k], seed=8, steps=300)
    assert needed_share(state) == pytest.approx(KERNELS[kernel].own_share[k], abs=1e-3)


def test_the_contrast_is_limited_and_taken_back():
    """Small contrasts count in full, large ones change the density by half of it; the kernel's density comes back."""
    contrast = np.array([1.0, 1.01, 0.99, 50.0, -50.0])
    factor, slope = limited(np, contrast)
    np.testing.assert_allclose(factor[:3], contrast[:3], atol=5e-6)
    np.testing.assert_allclose(factor[3:], [1.5, 0.5], atol=1e-4)
    ends = [limited(np, contrast + move)[0] for move in (1e-6, -1e-6)]
    np.testing.assert_allclose((ends[0] - ends[1]) / 2e-6, slope, atol=1e-7)
    rho = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    grad_h = (2.5 - 0.01 - contrast) / 1.5
    sharper, own = sharpened(np, rho, grad_h, 0.01)
    np.testing.assert_allclose(smoothed(np, sharper, own)[0], rho, rtol=1e-14)


@pytest.mark.parametrize("kernel", list(KERNELS))
@pytest.mark.parametrize("kind", ["pressure", "gravity"])
def test_forces_are_gradients_of_the_energy(kind, kernel):
    """sum m a . d against the change of the energy along a random displacement d, for unequal masses, to 1e-6."""
    generator = np.random.default_rng(11)
    position = ball(120)
    direction = generator.normal(size=position.shape)
    mass = generator.uniform(0.7, 1.3, len(position)) / len(position)
    listed = [build(name, FOURTH) for name in {"pressure": ["pressure"], "gravity": ["gravity", "pressure"]}[kind]]
    problem, *_ = state_of(*listed, position=position, velocity=np.zeros_like(position))
    problem = replace(problem, kernel=kernel, eta=KERNELS[kernel].eta)

    def state_at(shift):
        return initial_state(problem, mass, position + shift * direction, 0 * position, np.full(len(mass), 0.4), None)[
            0
        ]

    def energy(shift):
        moved = state_at(shift)
        if kind == "gravity":
            return float(evaluate.potential_energies(problem, moved)["gravity"])
        # Of the entropies that particles have at the start.
        eos = problem.equation_of_state
        return float(mass @ eos.internal_energy(np, moved.rates.fluid.density, start.entropy))

    start = state_at(0.0)
    acceleration = start.rates.acceleration[problem.effect_names.index(kind)]
    work = float((mass[:, None] * acceleration * direction).sum())
    small = 1e-5
    slope = (energy(small) - energy(-small)) / (2 * small)
    scale = float((mass * np.linalg.norm(acceleration, axis=1) * np.linalg.norm(direction, axis=1)).sum())
    assert work == pytest.approx(-slope, abs=1e-6 * scale)


@pytest.mark.full
def test_softening_takes_nothing_from_the_binding_of_a_uniform_sphere():
    """W of 500 particles against -3/5; of 1100: 1.3 % too weak, a seventeenth of that with the fourth order."""
    position = place(profiles.uniform(), 500)
    errors = []
    for options in ({}, FOURTH):
        problem, state, _ = state_of(
            build("gravity", {"method": "direct", **options}), position=position, velocity=0 * position, engine=Engine()
        )
        errors.append(float(evaluate.potential_energies(problem, state)["gravity"]) / -0.6 - 1.0)
    assert errors[0] < -0.005
    assert abs(errors[1]) < 0.25 * abs(errors[0])


@pytest.mark.full
def test_engines_agree():
    """numba and xla against plain sums: accelerations of a ball with both effects, to 1e-10 of the largest."""
    position = ball(200)
    listed = [build("gravity", {"method": "direct", **FOURTH}), build("pressure", FOURTH)]
    with jax.enable_x64(True):
        (_, plain, _), (problem, state, _) = (
            state_of(*listed, position=position, velocity=0 * position, engine=engine)
            for engine in (BruteEngine(), Engine())
        )
        # In one program: the first state of xla compiles hundreds of small ones.
        problem = replace(problem, engine=XlaEngine())
        dense, arrangement = rearranged(problem, jax.tree.map(jnp.asarray, state))
        states = [plain, state, jax.jit(evaluate.evaluated)(problem, arrangement, dense, jnp.zeros(()))]
    sorted_by_name = [
        [np.asarray(a)[np.argsort(np.asarray(state.identity))] for a in state.rates.acceleration] for state in states
    ]
    for other in sorted_by_name[1:]:
        for mine, theirs in zip(sorted_by_name[0], other, strict=True):
            np.testing.assert_allclose(theirs, mine, atol=1e-10 * np.abs(mine).max())


@pytest.mark.slow
def test_energy_and_momentum_are_kept():
    """A ball that falls together and bounces: energy to 1e-3 of the binding, momentum and closure to round-off."""
    position = ball(300)
    listed = [build("gravity", {"method": "direct", **FOURTH}), build("pressure", FOURTH)]
    problem, state, arrangement = state_of(
        *listed, position=position, velocity=0 * position, entropy=0.2, engine=Engine()
    )

    begun = energy_budget(problem, state)["total"]
    while state.time < 2.0:
        state = step(problem, arrangement, state, state.rates.timestep)
    assert abs(energy_budget(problem, state)["total"] - begun) < 1e-3 * 0.6
    assert np.abs(state.mass @ state.velocity).max() < 1e-13


def test_a_softening_that_is_given_has_no_fourth_order():
    with pytest.raises(ValueError, match="softening that follows the density"):
        build("gravity", {"softening": 0.1, **FOURTH})
