"""Radii and the ellipsoid of particles: right for bodies made to order, at every size, little moved by a stray one."""

import numpy as np
import pytest

from astroinertia.models.sph.extent import enclosing, extent

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


def test_all_turns_with_the_body_to_round_off() -> None:
    random = np.random.default_rng(5)
    mass, position = random.uniform(0.5, 1.5, 150), random.normal(size=(150, 3)) * [1.3, 1.0, 1.0]
    as_it_is = extent(mass, position)
    for _ in range(3):
        turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
        turned = extent(mass, position @ turn.T)
        expected = turn @ as_it_is["enclosing_ellipsoid"] @ turn.T
        np.testing.assert_allclose(turned["enclosing_ellipsoid"], expected, atol=1e-12)
        assert turned["half_mass_radius"] == pytest.approx(as_it_is["half_mass_radius"], rel=1e-13)


def test_what_is_the_same_along_all_axes_is_a_sphere() -> None:
    lattice = np.stack(np.meshgrid(*[np.arange(-7.0, 8.0)] * 3), axis=-1).reshape(-1, 3)
    lattice = lattice[(lattice**2).sum(axis=1) < 50.0]
    found = np.asarray(extent(np.ones(len(lattice)), lattice)["enclosing_ellipsoid"])
    np.testing.assert_allclose(found, found[0, 0] * np.eye(3), atol=1e-11)


def test_the_shape_is_that_of_the_outermost_where_it_is_not_the_same_throughout() -> None:
    """Rounder towards the centre: the second moments alone say 0.73."""
    random = np.random.default_rng(6)
    direction = random.normal(size=(20000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    level = random.uniform(size=20000) ** 0.5
    position = level[:, None] * direction
    position[:, 2] *= 1.0 - 0.4 * level**2  # 0.62 in the layer
    polar, *_, equatorial = np.sqrt(np.linalg.eigvalsh(extent(np.ones(20000), position)["enclosing_ellipsoid"]))
    assert polar / equatorial == pytest.approx(0.62, abs=0.03)


@pytest.mark.parametrize("share", [0.3, 0.85, 0.95])
def test_the_direction_of_a_heavy_particle_near_the_centre_is_of_no_account(share: float) -> None:
    position, _ = homoeoids(20, 25)
    mass = np.full(len(position), (1.0 - share) / len(position))
    found = [
        extent(np.append(mass, share), np.concatenate([position, [place]]))["enclosing_ellipsoid"]
        for place in ([0.0, 0.0, 0.0], [1e-9, 0.0, 0.0], [1e-3, 1e-3, 0.0])
    ]
    np.testing.assert_allclose(found[1], found[0], atol=1e-8)
    np.testing.assert_allclose(found[2], found[0], atol=0.01)
