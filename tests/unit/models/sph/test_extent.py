"""Radii and the ellipsoid of particles: right for bodies made to order, at every size, little moved by a stray one."""

import numpy as np
import pytest

from astroinertia.models.sph.extent import _DIRECTIONS, _LAYER, _outer_radii, enclosing, extent

AXES = np.array([1.3, 1.0, 0.6])


def homoeoids(shells: int, directions: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of a body whose surfaces of equal density are similar ellipsoids, m(s) = s^2, turned about two axes."""
    number = np.arange(directions)
    height, angle = 1.0 - (2.0 * number + 1.0) / directions, np.pi * (1.0 + 5.0**0.5) * number
    across = np.sqrt(1.0 - height**2)
    direction = np.stack([across * np.cos(angle), across * np.sin(angle), height], axis=-1)
    level = ((np.arange(shells) + 0.5) / shells) ** 0.5
    turned, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    return (level[:, None, None] * direction * AXES @ turned.T).reshape(-1, 3), turned


def test_the_ellipsoid_is_that_of_the_surfaces_of_equal_density() -> None:
    position, turned = homoeoids(400, 100)
    mass = np.full(len(position), 1.0 / len(position))
    found = extent(mass, position)
    exact = turned @ np.diag(0.99 * AXES**2) @ turned.T
    np.testing.assert_allclose(found["enclosing_ellipsoid"], exact, atol=3e-3)
    radius = np.linalg.norm(position, axis=1)
    assert found["half_mass_radius"] == pytest.approx(np.median(radius), rel=1e-4)
    assert (radius < found["radius_enclosing_99"]).mean() == pytest.approx(0.99, abs=1e-4)


def test_all_scales_with_the_body_to_round_off() -> None:
    position, _ = homoeoids(20, 15)
    mass = np.random.default_rng(1).uniform(0.5, 2.0, len(position))
    large, small = extent(mass, position), extent(3.0 * mass, 1e-4 * position)
    for name, power in (("half_mass_radius", 1), ("radius_enclosing_99", 1), ("enclosing_ellipsoid", 2)):
        np.testing.assert_allclose(small[name], 1e-4**power * np.asarray(large[name]), rtol=1e-12)


def test_one_particle_that_flies_off_changes_little() -> None:
    position, _ = homoeoids(40, 25)
    mass = np.full(len(position), 1e-3)
    before = extent(mass, position)
    position[-1] = [50.0, 0.0, 0.0]
    after = extent(mass, position - position.mean(axis=0))
    size = [np.linalg.det(found["enclosing_ellipsoid"]) ** (1 / 6) for found in (before, after)]
    assert size[1] == pytest.approx(size[0], rel=0.03)  # while the radius by second moments grows by 3.7


def test_masses_count_and_bodies_without_a_volume_have_no_ellipsoid() -> None:
    np.testing.assert_allclose(enclosing(np.array([1.0, 2.0, 1.0]), np.array([3.0, 1.0, 2.0]), (0.5,)), 1.0 + 1 / 1.5)
    flat = np.random.default_rng(2).normal(size=(50, 3)) * [1.0, 1.0, 0.0]
    assert np.isnan(extent(np.ones(50), flat)["enclosing_ellipsoid"]).all()
    assert np.isnan(extent(np.ones(2), flat[:2])["enclosing_ellipsoid"]).all()


@pytest.mark.parametrize("heavy", [1.0, 1e6])  # of a particle near the centre: the layer begins within the first block
def test_radii_of_many_particles_are_those_of_plain_sums_over_all(heavy: float) -> None:
    random = np.random.default_rng(5)
    toward = random.normal(size=(3, 9000)) * np.array([[3.0], [2.0], [1.0]])
    mass, level = random.uniform(0.5, 1.5, 9000), np.sort(random.exponential(size=9000))
    toward /= np.linalg.norm(toward, axis=0)
    mass[10] *= heavy
    found = _outer_radii(mass, level, toward)
    for way, radii in zip(_DIRECTIONS, found, strict=True):
        counted = mass * (way @ toward) ** 8
        middle = np.cumsum(counted) - 0.5 * counted
        np.testing.assert_allclose(radii, np.interp(np.array(_LAYER) * counted.sum(), middle, level), rtol=1e-9)
