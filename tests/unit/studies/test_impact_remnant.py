"""What is left of a giant impact, on bodies put together from parts that are known."""

import numpy as np
import pytest

from astroinertia.sph import profiles
from astroinertia.sph.placement import place
from astroinertia.studies.impact_remnant import remnant

BALL, RATE = 400, 0.3
DENSE = 3 / (4 * np.pi)


@pytest.fixture(scope="module")
def scattered():
    """A ball that turns, a moonlet of the same density, a ring, what falls back and what flies off; G = M = R = 1."""
    ball = place(profiles.uniform(), BALL)
    moonlet = 0.1 * place(profiles.uniform(), 16) + [4.0, 0.0, 0.0]
    angle = np.linspace(0, 2 * np.pi, 20, endpoint=False)
    ring = 3.0 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    falls, flies = np.array([[0.0, 2.5, 0.0]]), np.array([[0.0, 0.0, 2.0]])
    about = np.array([0.0, 0.0, 1.0])
    velocity = [
        RATE * np.cross(about, ball), np.tile([0.0, 0.5, 0.0], (16, 1)), np.cross(about, ring) / 3**1.5,
        np.array([[0.3, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.3]]),
    ]  # fmt: skip
    position = np.concatenate([ball, moonlet, ring, falls, flies])
    mass = np.concatenate([np.full(BALL, 1 / BALL), np.full(38, 1e-5)])
    density = np.concatenate([np.full(BALL, DENSE), np.full(16, 1.6e-4 * DENSE / 1e-3), np.full(22, 1e-4)])
    return mass, position, np.concatenate(velocity), density


def test_everyone_is_where_they_belong(scattered):
    left = remnant(*scattered, condensed=0.1 * DENSE)
    groups = np.repeat(["ball", "moonlet", "ring", "falls", "flies"], [BALL, 16, 20, 1, 1])
    assert (left.body == (groups == "ball")).all()  # the moonlet is as dense, but not in contact
    assert (left.planet == np.isin(groups, ["ball", "falls"])).all()
    assert (left.disc == np.isin(groups, ["moonlet", "ring"])).all()
    assert (left.escaped == (groups == "flies")).all()


def test_figures_of_the_body_are_those_of_a_ball_that_turns(scattered):
    left = remnant(*scattered, condensed=0.1 * DENSE)
    np.testing.assert_allclose(left.angular_velocity, [0, 0, RATE], atol=1e-12)
    assert left.moment_ratio == pytest.approx(0.4, rel=1e-12)
    assert left.equatorial_radius == pytest.approx(1.0, rel=1e-12)
    assert left.flattening == pytest.approx(0.0, abs=1e-12)
    # The ball's own 0.4 M R^2 Omega, less what the particle that falls back brings: m r v against the spin.
    assert left.planet_angular_momentum[2] == pytest.approx(0.4 * RATE - 1e-5 * 2.5 * 0.3, rel=1e-12)
    ring, moonlet = 20e-5 * 3**0.5, 16e-5 * 4.0 * 0.5
    assert left.disc_angular_momentum[2] == pytest.approx(ring + moonlet, rel=1e-6)


def test_a_moving_remnant_in_other_units_is_the_same(scattered):
    mass, position, velocity, density = scattered
    here = remnant(mass, position, velocity, density, 0.1 * DENSE)
    scale, heavy, constant = 6.4e6, 6e24, 6.6743e-11
    rate = np.sqrt(constant * heavy / scale**3)
    there = remnant(
        heavy * mass, scale * position + 1e8, scale * rate * velocity - 2e4, density * heavy / scale**3,
        0.1 * DENSE * heavy / scale**3, constant,
    )  # fmt: skip
    assert (there.disc == here.disc).all()
    np.testing.assert_allclose(there.angular_velocity, rate * here.angular_velocity, atol=1e-10 * rate)
    assert there.moment_ratio == pytest.approx(here.moment_ratio, rel=1e-9)


def test_nothing_that_is_condensed_is_no_planet():
    with pytest.raises(ValueError, match="no particle is denser than 5: the densest has 1"):
        remnant(np.ones(3), np.eye(3), np.zeros((3, 3)), np.ones(3), 5.0)
