"""Point masses beside a fluid: their virial tensor and their tides against exact sums, wherever they stand."""

import math
from fractions import Fraction

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

from astroinertia.gravity import point_masses


@pytest.mark.parametrize("softening", [0.0, 1e-3])
@pytest.mark.parametrize("distance", [1e8, 1e3, 3.0, 1e-2, 1e-6, 1e-12])
def test_the_virial_tensor_of_a_point_is_that_of_its_pull_from_far_away_to_the_centre_of_mass(distance, softening):
    random = np.random.default_rng(3)
    mass, position = random.uniform(0.5, 1.5, 12), random.normal(size=(12, 3))
    centre = mass @ position / mass.sum()
    place = centre + distance * np.array([[0.6, -0.48, 0.64]])
    found = point_masses.virial(np, mass, position, centre, np.array([2.0]), place, np.array([softening**2]))
    middle = [sum(Fraction(m) * Fraction(x) for m, x in zip(mass, axis, strict=True)) for axis in position.T]
    middle = [total / sum(map(Fraction, mass)) for total in middle]
    sums = [[Fraction(0)] * 3 for _ in range(3)]
    for m, x in zip(mass, position, strict=True):
        away = [Fraction(a) - Fraction(b) for a, b in zip(x, place[0], strict=True)]
        squared = sum(d * d for d in away) + Fraction(softening) ** 2
        root = Fraction(_root(squared.numerator, squared.denominator), 10**60)
        for i in range(3):
            for j in range(3):
                sums[i][j] -= Fraction(m) * 2 * (Fraction(x[i]) - middle[i]) * away[j] / (squared * root)
    exact = np.array([[float(value) for value in row] for row in sums])
    assert np.abs(found - exact).max() < 1e-11 * np.abs(exact).max()


@pytest.mark.parametrize("apart", [1e8, 1e4, 10.0, 1e-4, 1e-9])
def test_tides_are_the_difference_of_two_pulls_to_rounding_from_far_away_to_beside_the_point(apart):
    """By mpmath, as the difference is written: by 1e-8 off in energy far away, and by 1e-3 or infinite beside it."""
    place = np.array([3.0, 1.0, -2.0]) * max(1.0, apart)
    position = (place if apart < 1.0 else 0.0) + min(apart, 1.0) * np.array([[0.48, 0.6, 0.64], [-0.3, 0.2, 0.9]])
    mass, pull = np.array([1.5, 0.5]), np.array([2.5])
    found = point_masses.tidal_attraction(np, position, pull, place[None], 1e-30)
    energy = point_masses.tidal_energy(np, mass, position, pull, place[None], 1e-30)
    with mpmath.workdps(60):
        there, soft = mpmath.matrix(place), mpmath.mpf(1e-30)
        squared, potential = mpmath.fdot(there, there) + soft, mpmath.mpf(0)
        for m, at, acceleration in zip(mass, position, found, strict=True):
            at = mpmath.matrix(at)
            near = mpmath.fdot(at - there, at - there) + soft
            exact = -2.5 * ((at - there) / mpmath.sqrt(near) ** 3 + there / mpmath.sqrt(squared) ** 3)
            assert mpmath.norm(mpmath.matrix(acceleration) - exact) < 2e-15 * mpmath.norm(exact)
            slope = mpmath.fdot(at, there) / mpmath.sqrt(squared) ** 3
            potential -= 2.5 * m * (1 / mpmath.sqrt(near) - 1 / mpmath.sqrt(squared) - slope)
    assert energy == pytest.approx(float(potential), rel=1e-13, abs=0.0)


def test_a_particle_at_a_point_without_softening_has_no_energy_and_no_pull_in_any_units():
    mass, position, place = (
        np.array([2.0, 3.0]),
        np.array([[1.0, 0.0, 0.0], [5.0, 0.0, 0.0]]),
        np.array([[1.0, 0.0, 0.0]]),
    )
    for length in (1.0, 1e3):
        there = np.array([7.0]), length * place, 0.0
        assert point_masses.potential_energy(np, mass, length * position, *there) == pytest.approx(
            -21.0 / (4.0 * length)
        )
        found = point_masses.specific_potential(np, length * position, *there)
        np.testing.assert_allclose(found, [0.0, -7.0 / (4.0 * length)], rtol=1e-15)
        assert not point_masses.attraction(np, length * position, *there)[0].any()
    slope = jax.grad(lambda at: point_masses.specific_potential(jnp, at, *there).sum())(jnp.asarray(position))
    assert np.isfinite(slope).all()


def _root(numerator, denominator):
    """The square root of a fraction, times 10^60."""
    return math.isqrt(numerator * 10**120 // denominator)
