"""Polytropes as particles at equilibrium, in one call: how well do so many particles stand for the exact body?

Everything is in units of the body's mass, of its radius at rest, and G = 1. Tests: tests/physics/test_relax.py.
"""

from dataclasses import asdict
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.build.sph import engine_of
from astroinertia.effects import catalogue
from astroinertia.matter import gases
from astroinertia.models.sph import relaxation
from astroinertia.models.sph.evaluate import potential_energies
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.state import Problem, State
from astroinertia.sph import profiles
from astroinertia.sph.kernels import KERNELS, eta_for_neighbours
from astroinertia.sph.placement import place

_STABLE_GAMMA = 5 / 3
# Courant and Monaghan's own factors; a relaxed body is evolved with them unless a scene says otherwise.
_TIMESTEP = {"courant": 0.3, "acceleration_factor": 0.25, "energy_factor": 0.25, "max_timestep": 1.0}


def gas_of_polytrope(index: float, count: int) -> tuple[gases.Ideal, np.ndarray]:
    """The gas that holds a polytrope up stably, and the entropies (N,) of its shells of equal mass from the centre out.

    Its exponent is 1 + 1/n with one entropy for all, or 5/3 with an entropy that rises outwards where the index itself
    is neutral (n = 3) or too close to it. ValueError for index 0, which no gas resembles.

    >>> print(f"{gas_of_polytrope(1.5, 4)[0].gamma:.4f}")  # 1 + 1/n, with one entropy for all
    1.6667
    """
    star = Polytrope(index)
    if index <= 0:
        raise ValueError("a polytrope of index 0 is incompressible: no gas relaxes to it")
    gamma = max(star.gamma, _STABLE_GAMMA)
    return gases.ideal(gamma), star.entropy_function((np.arange(count) + 0.5) / count, gamma)


def polytrope_problem(
    index: float, count: int, kernel: str = "quintic", precision: str = "float64", order: str = "second",
    neighbours: float | None = None,
) -> Problem:  # fmt: skip
    """The physics of a polytrope on its own: gravity and the pressure of the gas that holds it up.

    order: of the errors of density and gravity in the smoothing length; neighbours: their number, the kernel's own if
    not given.
    """
    return Problem(
        effects=tuple(catalogue.build(kind, {"order": order}) for kind in ("gravity", "pressure")),
        equation_of_state=gas_of_polytrope(index, count)[0],
        eta=KERNELS[kernel].eta if neighbours is None else eta_for_neighbours(KERNELS[kernel], neighbours),
        engine=engine_of("numba_cpu", precision, kernel),
        kernel=kernel,
        smoothing_tolerance=1e-6,
        **_TIMESTEP,
    )


def relaxed_polytrope(
    index: float,
    particles: int,
    rotation: relaxation.Rotation | None = None,
    kernel: str = "quintic",
    placement: str = "glass",
    seed: int = 1,
    precision: str = "float64",
    order: str = "fourth",
    neighbours: float | None = None,
    **options: Any,
) -> xr.Dataset:
    """Return a polytrope of so many particles at equilibrium, at rest or in rotation, and what it is worth.

    Particles have mass, position, velocity, entropy, density and smoothing_length. moment_of_inertia (i, j),
    gravitational_energy, central_density and rotational_to_gravitational describe the body; those whose exact value at
    rest is known carry it as the attribute `exact_at_rest`. order: of the errors of density and gravity in the
    smoothing length, "second" or "fourth", which has a fifth of the errors of a body at rest, but is stiff against
    shear: what is to ring or to be drawn out by a tide is settled with second. Other options go to
    models.sph.relaxation.relax, which raises NumericalError where no equilibrium is reached.
    """
    star, profile = Polytrope(index), profiles.polytrope(index)
    problem = polytrope_problem(index, particles, kernel, precision, order, neighbours)
    position, mass = place(profile, particles, placement, seed), np.full(particles, 1 / particles)
    entropy = np.empty(particles)
    entropy[np.argsort(np.linalg.norm(position, axis=1), kind="stable")] = gas_of_polytrope(index, particles)[1]
    relaxed = relaxation.relax(
        problem,
        mass,
        position,
        entropy,
        target_density=lambda enclosed: profile.density(profile.radius(enclosed)),
        rotation=rotation,
        **options,
    )
    state, _ = initial_state(problem, mass, relaxed.position, relaxed.velocity, entropy)
    dataset = _dataset(problem, star, state)
    dataset.attrs |= {
        "title": f"polytrope of index {index:g}, relaxed",
        "units": "M = G = 1, R = 1 at rest",
        "kernel": kernel,
        "order": order,
        "neighbours": 4 / 3 * np.pi * (KERNELS[kernel].support * problem.eta) ** 3,
        "gamma": problem.equation_of_state.gamma,
        "placement": placement,
        "seed": seed,
        **{f"relaxation_{name}": value for name, value in asdict(relaxed.report).items()},
    }
    return dataset


def _dataset(problem: Problem, star: Polytrope, state: State) -> xr.Dataset:
    fluid, mass = state.rates.fluid, np.asarray(state.mass)
    back = np.argsort(np.asarray(state.identity))
    x = np.asarray(state.position) - mass @ state.position / mass.sum()
    squared = (x**2).sum(axis=1)
    inertia = mass @ squared * np.eye(3) - (mass[:, None] * x).T @ x
    energy = float(potential_energies(problem, state)["gravity"])
    kinetic = 0.5 * float(mass @ (np.asarray(state.velocity) ** 2).sum(axis=1))
    particle = {
        "mass": state.mass,
        "entropy": state.entropy,
        "density": fluid.density,
        "smoothing_length": fluid.smoothing_length,
    }
    vectors = {"position": state.position, "velocity": state.velocity}
    whole = {
        "gravitational_energy": (energy, star.gravitational_energy),
        "central_density": (_central(squared, np.asarray(fluid.density)), star.central_density),
    }
    return xr.Dataset(
        {name: ("particle", np.asarray(array)[back]) for name, array in particle.items()}
        | {name: (("particle", "i"), np.asarray(array)[back]) for name, array in vectors.items()}
        | {name: ((), value, {"exact_at_rest": exact}) for name, (value, exact) in whole.items()}
        | {
            "moment_of_inertia": (("i", "j"), inertia, {"exact_at_rest": star.moment_of_inertia}),
            "rotational_to_gravitational": ((), kinetic / abs(energy)),
        },
        coords={"i": list("xyz"), "j": list("xyz")},
    )


def _central(squared_radius: np.ndarray, density: np.ndarray) -> float:
    """The density where a straight line in r^2 through the innermost fiftieth of the mass begins."""
    inner = np.argsort(squared_radius)[: max(40, len(density) // 50)]
    return float(np.polynomial.Polynomial.fit(squared_radius[inner], density[inner], 1)(0.0))
