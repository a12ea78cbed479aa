"""Where equal-mass particles are put so that they sample a mass profile with little noise.

    lattice   a hexagonal close-packed lattice, stretched along radii until it carries the profile (Herant 1994,
              MmSAI 65, 1013): least noise, but directions are preferred
    glass     points repelled by their neighbours to the spacing that the target density asks for (Diehl et al. 2015,
              PASA 32, e048), held to the profile by their ranks in radius: isotropic, the choice for evolution
    random    independent points, for tests of noise only

All give exactly the number asked for, centred, with the second moment of the profile along every axis to round-off.
Tests: tests/unit/sph/test_initial_particles.py.
"""

import numpy as np
from scipy.spatial import KDTree

from astroinertia.errors import SceneError
from astroinertia.orbits.kepler import eccentric_anomaly
from astroinertia.sph.profiles import Profile
from astroinertia.storage import cache

PLACEMENTS = ("glass", "lattice", "random")
_GLASS_STEPS = 60
_GLASS_NEIGHBOURS = 36
_FLAT = 1e-12  # of the mean squares along axes, the least over the largest: below that, points lie in a plane
_GLASS_VERSION = 1  # part of the cache key: raise it when the glass itself changes


def place(profile: Profile, count: int, placement: str = "glass", seed: int = 0) -> np.ndarray:
    """Return positions (N, 3) in the unit sphere that carry the profile; ValueError on a bad count or placement.

    The result depends on the arguments alone. Glasses are kept in the user's cache.
    """
    if count < 4 or count % 1 != 0:
        raise ValueError(f"a body needs a whole number of at least 4 particles, not {count!r}")
    if placement == "lattice":
        points = _lattice(profile, count, seed)
    elif placement == "glass":
        points = _cached_glass(profile, count, seed)
    elif placement == "random":
        points = _random(profile, count, seed)
    else:
        raise ValueError(f"placement must be one of {', '.join(PLACEMENTS)}, not {placement!r}")
    return isotropised(points, profile.second_moment)


def isotropised(points: np.ndarray, second_moment: float) -> np.ndarray:
    """Return points (N, 3) mapped affinely so that their mean is 0 and the mean of x (x) x is second_moment times 1.

    SceneError for points in a plane, which no such map can spread.
    """
    for _ in range(2):  # the second time takes away the round-off of the first
        points = points - points.mean(axis=0)
        values, vectors = np.linalg.eigh(points.T @ points / len(points))
        if not values[0] > _FLAT * values[2]:
            raise SceneError(
                "[body] particles lie on a line or in a plane, so strongly does the density rise inwards: it needs "
                "more of them, or a profile that is less steep."
            )
        points = points @ ((vectors * np.sqrt(second_moment / values)) @ vectors.T)
    return points - points.mean(axis=0)


def azimuthal_mode(points: np.ndarray, mode: int, amplitude: float) -> np.ndarray:
    """Return angles (N,) about z to turn points (N, 3) by, so that their density goes as 1 + amplitude cos(mode phi).

    The new angle p of a point at phi has as much of the circle behind it: p + (amplitude/mode) sin(mode p) = phi, which
    is Kepler's equation of p + pi, for 0 <= amplitude < 1.
    """
    angle = mode * np.arctan2(points[:, 1], points[:, 0])
    wanted = np.mod(angle + np.pi, 2 * np.pi) - np.pi
    opposite = np.where(wanted < 0, wanted + np.pi, wanted - np.pi)
    return (eccentric_anomaly(np, opposite, amplitude) - opposite) / mode


def turned(vectors: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return vectors (N, 3), each turned about z by its angle (N,)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y, z = vectors.T
    return np.stack([x * cosine - y * sine, x * sine + y * cosine, z], axis=1)


def _directions(generator: np.random.Generator, count: int) -> np.ndarray:
    directions = generator.normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1)[:, None]


def _rotation(generator: np.random.Generator) -> np.ndarray:
    q, r = np.linalg.qr(generator.normal(size=(3, 3)))
    return q * np.sign(np.diag(r))


def _random(profile: Profile, count: int, seed: int) -> np.ndarray:
    generator = np.random.default_rng(seed)
    return _directions(generator, count) * profile.radius(generator.random(count))[:, None]


def _lattice(profile: Profile, count: int, seed: int) -> np.ndarray:
    # Unit cell volume sqrt(1/2) for unit spacing, so this radius holds `count` sites; the seed turns and shifts them.
    generator = np.random.default_rng(seed)
    radius = (3 * count * np.sqrt(0.5) / (4 * np.pi)) ** (1 / 3)
    reach = int(np.ceil(radius / np.sqrt(2 / 3))) + 2
    i, j, k = (axis.ravel() for axis in np.meshgrid(*[np.arange(-reach - 1, reach + 2)] * 3, indexing="ij"))
    odd = k % 2
    sites = np.stack(
        [i + 0.5 * (j % 2) + 0.5 * odd, np.sqrt(3) / 2 * j + odd / np.sqrt(12), np.sqrt(2 / 3) * k], axis=1
    )
    sites = (sites - generator.random(3) * [1.0, np.sqrt(3), 2 * np.sqrt(2 / 3)]) @ _rotation(generator).T
    distance = np.linalg.norm(sites, axis=1)
    nearest = np.argsort(distance, kind="stable")[:count]
    sites, distance = sites[nearest], distance[nearest]
    mass = np.minimum((distance / radius) ** 3, 1 - 0.25 / count)
    return sites / distance[:, None] * profile.radius(mass)[:, None]


def _cached_glass(profile: Profile, count: int, seed: int) -> np.ndarray:
    key = cache.content_key(profile=profile.name, count=count, seed=seed, version=_GLASS_VERSION)
    stored = cache.load("glass", key)
    if stored is not None and stored.get("position", np.empty(0)).shape == (count, 3):
        return stored["position"]
    points = glass(profile, count, seed)
    cache.save("glass", key, {"position": points})
    return points


def glass(profile: Profile, count: int, seed: int) -> np.ndarray:
    """Points (N, 3) of the unit sphere, repelled by their neighbours to the spacing that the profile asks for."""
    generator = np.random.default_rng(seed)
    ranked_radii = profile.radius((np.arange(count) + 0.5) / count)
    neighbours = min(_GLASS_NEIGHBOURS, count - 1)
    # A golden spiral through the shells: low discrepancy from the first step on.
    height = 1 - 2 * np.mod(np.arange(count) * 0.7548776662466927 + generator.random(), 1.0)
    angle = 2 * np.pi * np.mod(np.arange(count) * 0.5698402909980532 + generator.random(), 1.0)
    ring = np.sqrt(1 - height**2)
    points = np.stack([ring * np.cos(angle), ring * np.sin(angle), height], axis=1) * ranked_radii[:, None]
    outermost = ranked_radii[-1]
    for iteration in range(_GLASS_STEPS):
        radius = np.linalg.norm(points, axis=1)
        spacing = (1 / (count * profile.density(np.minimum(radius, outermost)))) ** (1 / 3)
        distance, index = (np.asarray(array)[:, 1:] for array in KDTree(points).query(points, k=neighbours + 1))
        distance = np.maximum(distance, 1e-12)
        reach = spacing[:, None] + spacing[index]
        push = np.maximum(1 - distance / reach, 0.0) ** 2
        toward = (points[:, None, :] - points[index]) / distance[..., None]
        step = 0.6 * (1 - iteration / _GLASS_STEPS) + 0.05
        move = step * spacing[:, None] * np.einsum("ij,ijk->ik", push, toward)
        size = np.linalg.norm(move, axis=1)
        points = points + move * np.minimum(1.0, 0.3 * spacing / np.maximum(size, 1e-300))[:, None]
        points = _held_to_ranks(points, ranked_radii, 0.3)
    return _held_to_ranks(points, ranked_radii, 1.0)


def _held_to_ranks(points: np.ndarray, ranked_radii: np.ndarray, share: float) -> np.ndarray:
    radius = np.maximum(np.linalg.norm(points, axis=1), 1e-300)
    target = np.empty_like(radius)
    target[np.argsort(radius, kind="stable")] = ranked_radii
    return points * (1 + share * (target / radius - 1))[:, None]
