"""What a tidal disruption leaves: the orbital energies of the debris, and what holds together.

Orbital energies are in the code units of the run, with G = 1.
"""

from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from scipy.spatial.distance import cdist

from astroinertia.effects.kinds.tide import Tide
from astroinertia.process.quantities import with_quantities

Array = Any

_MOST_ROUNDS = 50


@with_quantities(time=None, position=None, velocity=None)
def orbital_energies(tide: Tide, time: float, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Specific energies (N,) about the perturber, |v - V|^2/2 - M/|x - X|, in the tide's falling frame."""
    with jax.enable_x64(True):
        place, speed = jax.jvp(lambda t: tide.place(jnp, SimpleNamespace(time=t)), (float(time),), (1.0,))
    apart, relative = position - np.asarray(place), velocity - np.asarray(speed)
    return 0.5 * (relative**2).sum(axis=1) - tide.mass / np.linalg.norm(apart, axis=1)


@with_quantities(internal_energy="J/kg")
def bound_to_itself(
    mass: Array, position: Array, velocity: Array, density: Array, internal_energy: Array,
    gravitational_constant: float = 1.0,
) -> np.ndarray:  # fmt: skip
    """Which particles are bound to the densest of what is bound, (N,) bool: kinetic, thermal and their own potential.

    Begun with all, and repeated with what is left until nothing more leaves. Sums over all pairs: for thousands. In any
    units of this G; that of SI where what is given has units.

    >>> x, v = np.array([[0.0, 0, 0], [1.0, 0, 0], [9.0, 0, 0]]), np.array([[0.0, 0, 0], [0, 1.0, 0], [0, 3.0, 0]])
    >>> print(bound_to_itself(np.array([1.0, 0.1, 0.1]), x, v, np.array([9.0, 1.0, 1.0]), np.zeros(3)))
    [ True  True False]
    """
    distance = cdist(position, position)
    np.fill_diagonal(distance, np.inf)
    bound = np.ones(len(mass), dtype=bool)
    for _ in range(_MOST_ROUNDS):
        weight = mass * density * bound
        centre = weight @ velocity / weight.sum()
        potential = -gravitational_constant * (mass * bound / distance).sum(axis=1)
        held = 0.5 * ((velocity - centre) ** 2).sum(axis=1) + internal_energy + potential < 0.0
        if (held & bound == bound).all() or not (held & bound).any():
            return held & bound
        bound &= held
    return bound
