"""A ball of a few hundred particles, and its state with given effects on the plain reference engine."""

import math
from typing import Any

import numpy as np

from astroinertia.matter.gases import Ideal
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.state import Problem
from tests.pairs import BruteEngine


def ball(count: int = 300, seed: int = 3) -> np.ndarray:
    """Points of a jittered lattice within the unit ball, (N, 3): disordered, but evenly spaced."""
    side = (4.0 * math.pi / 3.0 / count) ** (1 / 3)
    steps = np.arange(-1.0 + side / 3, 1.0, side)
    grid = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    grid = grid + np.random.default_rng(seed).uniform(-0.2, 0.2, grid.shape) * side
    return grid[np.linalg.norm(grid, axis=1) < 1.0]


def state_of(
    *listed: Any,
    position: np.ndarray,
    velocity: np.ndarray,
    entropy: float | np.ndarray = 0.5,
    engine: Any = None,
) -> tuple[Problem, Any, Any]:
    problem = Problem(
        effects=listed,
        equation_of_state=Ideal(5 / 3),
        eta=1.2,
        courant=0.3,
        acceleration_factor=0.3,
        energy_factor=0.3,
        max_timestep=0.1,
        engine=engine or BruteEngine(),
        kernel="cubic",
        smoothing_tolerance=1e-13,
    )
    mass = np.full(len(position), 1.0 / len(position))
    state, arrangement = initial_state(problem, mass, position, velocity, np.zeros(len(position)) + entropy)
    return problem, state, arrangement
