"""Stars whose rings have the angular momentum of a liquid's: the law, its own star, and the liquid itself."""

import math

import numpy as np
import pytest

from astroinertia.bodies import maclaurin
from astroinertia.bodies.maclaurin_momentum import MomentumLaw
from astroinertia.bodies.rotating_star import RotatingStar, rotating_star, rotating_star_with
from astroinertia.matter.barotropes import polytropic_matter


@pytest.fixture(scope="module")
def soft() -> RotatingStar:
    return rotating_star(polytropic_matter(1.5), 0.25, MomentumLaw())


def test_a_liquid_turns_rigidly() -> None:
    """For n = 0 the law is that of the Maclaurin spheroid, though nothing says so."""
    star = rotating_star(polytropic_matter(0.0), 0.7, MomentumLaw())
    np.testing.assert_allclose(star.field.law.rate(np.linspace(0, 1, 11)), 1.0, atol=1e-5)
    exact = maclaurin.from_axis_ratio(0.7).rotational_to_gravitational
    assert star.rotational_to_gravitational == pytest.approx(exact, rel=1e-4)


def test_rings_have_the_angular_momentum_of_a_liquids(soft: RotatingStar) -> None:
    """j(m) of the star, with mass and momentum within cylinders summed over a mesh of its own."""
    w, z = np.meshgrid((np.arange(400) + 0.5) / 400, (np.arange(300) + 0.5) / 400, indexing="ij")
    mass = (soft.density(w, z) * w).sum(axis=1) * 4 * math.pi / 400**2
    spin = (soft.rotation_rate(w[:, 0]) * w[:, 0] ** 2) * mass
    assert mass.sum() == pytest.approx(1.0, rel=1e-5)
    inside = np.cumsum(mass) - mass / 2
    liquid = 2.5 * soft.angular_momentum * (1 - np.maximum(1 - inside, 0.0) ** (2 / 3)) * mass
    np.testing.assert_allclose(np.cumsum(spin), np.cumsum(liquid), atol=2e-5)
    assert spin.sum() == pytest.approx(soft.angular_momentum, rel=1e-4)


def test_it_is_in_equilibrium_and_differential(soft: RotatingStar) -> None:
    assert soft.virial_error < 1e-9
    assert 0.32 < float(soft.field.law.rate(1.0)) < 0.34  # soft stars keep their outer rings slow
    assert soft.rotation_law.rate(2.0) == pytest.approx(float(soft.field.law.rate(1.0)) / 4)  # j constant outside


def test_the_potential_of_the_law_is_its_integral() -> None:
    squares = np.sin(np.linspace(0, math.pi / 2, 65)) ** 2
    law = MomentumLaw(tuple(1 / (1 + squares))).scaled(2.0)  # j constant for a scale of 2
    w = np.linspace(0, 2, 9)
    np.testing.assert_allclose(law.potential(w), 0.5 * w**2 / (1 + (w / 2) ** 2), rtol=1e-6, atol=1e-12)
    step = 1e-4
    for outside in (1.5, 3.0):
        slope = (law.potential(outside + step) - law.potential(outside - step)) / (2 * step)
        assert slope == pytest.approx(law.rate(outside) ** 2 * outside, rel=1e-6)


@pytest.mark.full
def test_a_star_is_found_by_a_quantity() -> None:
    """Down to where a soft star is a fifth as thick as wide."""
    star = rotating_star_with("rotational_to_gravitational", 0.3, polytropic_matter(1.5), MomentumLaw())
    assert star.rotational_to_gravitational == pytest.approx(0.3, rel=1e-9)
    assert star.virial_error < 1e-7 and 0.2 < star.field.axis_ratio < 0.21
