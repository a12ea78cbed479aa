"""What a giant impact leaves: the planet, what orbits it, and what is lost.

The body is the largest clump of condensed particles in contact. To the planet belongs whatever is bound to it and has
an orbit that meets it: to fall back nothing hinders but pressure, of which rarefied matter has next to none.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from astroinertia.inertia.tensor import inertia_tensor
from astroinertia.process.quantities import with_quantities

Array = Any

_REACH = 2.0  # mean distances (m/rho)^(1/3) of particles in contact
_MOST_ROUNDS = 100


@dataclass(frozen=True)
class Remnant:
    """Who belongs where, each (N,) bool, and what the body is like.

    body: the largest clump in contact; planet: the body and what falls back to it; disc: what is bound, with a
    pericentre outside the body; escaped: the rest. Of the body equatorial_radius, flattening 1 - c/a, angular_velocity
    (3,) I^-1 L, and moment_ratio I/(M R^2) with the mean moment and the radius of equal volume. About its centre the
    angular_momentum (3,) of planet and disc: planet_angular_momentum, disc_angular_momentum. In the units given.
    """

    body: np.ndarray
    planet: np.ndarray
    disc: np.ndarray
    escaped: np.ndarray
    equatorial_radius: float
    flattening: float
    angular_velocity: np.ndarray
    moment_ratio: float
    planet_angular_momentum: np.ndarray
    disc_angular_momentum: np.ndarray


@with_quantities(condensed="kg m-3")
def remnant(
    mass: Array, position: Array, velocity: Array, density: Array, condensed: float,
    gravitational_constant: float = 1.0,
) -> Remnant:  # fmt: skip
    """Part particles (N,), (N, 3) into planet, disc and what escapes; what is denser than `condensed` has a surface.

    Orbits are those about a point of the planet's mass at the body's centre; which mass that is, is found in rounds. In
    any units of this G; that of SI where what is given has units. ValueError where nothing is so dense.
    """
    if not (density > condensed).any():
        raise ValueError(f"no particle is denser than {condensed:g}: the densest has {density.max():g}")
    body = _largest_clump(mass, position, density, density > condensed)
    share = mass[body] / mass[body].sum()
    x, v = position - share @ position[body], velocity - share @ velocity[body]
    volume = (mass[body] / density[body]).sum()
    least, *others = np.linalg.eigvalsh((share[:, None] * x[body]).T @ x[body])
    axis_ratio = math.sqrt(least / np.mean(others))
    equal = (3 * volume / (4 * math.pi)) ** (1 / 3)
    radius = equal * axis_ratio ** (-1 / 3)
    planet = body
    for _ in range(_MOST_ROUNDS):
        energy, nearest = _orbits(x, v, gravitational_constant * mass[planet].sum())
        meets = body | (np.linalg.norm(x, axis=1) < radius) | ((energy < 0) & (nearest < radius))
        if (meets == planet).all():
            break
        planet = meets
    disc, escaped = ~planet & (energy < 0), ~planet & (energy >= 0)
    inertia, momenta = inertia_tensor(mass[body], x[body]), mass[:, None] * np.cross(x, v)
    return Remnant(
        body, planet, disc, escaped, radius, 1 - axis_ratio, np.linalg.solve(inertia, momenta[body].sum(axis=0)),
        float(np.trace(inertia) / 3 / (mass[body].sum() * equal**2)),
        momenta[planet].sum(axis=0), momenta[disc].sum(axis=0),
    )  # fmt: skip


def _largest_clump(mass: np.ndarray, position: np.ndarray, density: np.ndarray, solid: np.ndarray) -> np.ndarray:
    """The solid particles (N,) bool that hang together with most others: the heaviest such clump."""
    where = np.flatnonzero(solid)
    spacing = np.cbrt(mass / density)[where]
    first, second = KDTree(position[where]).query_pairs(_REACH * spacing.max(), output_type="ndarray").T
    apart = np.linalg.norm(position[where[first]] - position[where[second]], axis=1)
    near = apart < _REACH * 0.5 * (spacing[first] + spacing[second])
    links = coo_array((np.ones(near.sum()), (first[near], second[near])), shape=(len(where), len(where)))
    clump = connected_components(links, directed=False)[1]
    body = np.zeros(len(mass), dtype=bool)
    body[where[clump == np.bincount(clump, weights=mass[where]).argmax()]] = True
    return body


def _orbits(x: np.ndarray, v: np.ndarray, parameter: float) -> tuple[np.ndarray, np.ndarray]:
    """Specific energies and pericentres (N,) of orbits about a point of that G M."""
    energy = 0.5 * (v**2).sum(axis=1) - parameter / np.maximum(np.linalg.norm(x, axis=1), 1e-300)
    squared = (np.cross(x, v) ** 2).sum(axis=1)
    eccentricity = np.sqrt(np.maximum(1 + 2 * energy * squared / parameter**2, 0.0))
    return energy, squared / (parameter * (1 + eccentricity))
