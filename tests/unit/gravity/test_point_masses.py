"""Point masses beside a fluid: their virial tensor against exact sums, wherever they stand."""

import math
from fractions import Fraction

import numpy as np
import pytest

from astroinertia.gravity import point_masses


@pytest.mark.parametrize("softening", [0.0, 1e-3])
@pytest.mark.parametrize("distance", [1e3, 3.0, 1e-2, 1e-6, 1e-12])
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


def _root(numerator, denominator):
    """The square root of a fraction, times 10^60."""
    return math.isqrt(numerator * 10**120 // denominator)
