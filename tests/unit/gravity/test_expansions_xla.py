"""Harmonic expansions: shifts are exact, and fields converge to those of points."""

import jax
import numpy as np
import pytest

from astroinertia.gravity import expansions_xla as expansions
from astroinertia.gravity.expansions import harmonic

POINT, AROUND = np.array([0.1, -0.2, 0.15]), np.array([-0.1, 0.15, 0.2])  # of a source and a target, about centres
BETWEEN = np.array([0.6, -0.8, 1.1])  # of the target's centre from the source's


@pytest.fixture(autouse=True)
def _x64():
    with jax.enable_x64(True):
        yield


def harmonics(order, point):
    return expansions.harmonics(order, list(point))


def close(found, expected):
    assert sorted(found) == sorted(expected)
    for a, value in expected.items():
        assert float(found[a]) == pytest.approx(float(value), abs=1e-15)


def test_there_are_as_many_as_harmonic_polynomials_and_they_are_harmonic():
    order, step = 5, 1e-3
    assert list(harmonics(order, POINT)) == list(harmonic(order)) and len(harmonic(order)) == (order + 1) ** 2
    around = [harmonics(order, POINT + side * unit) for unit in step * np.eye(3) for side in (-1, 1)]
    for a, value in harmonics(order, POINT).items():
        assert abs(float(sum(each[a] for each in around)) - 6.0 * float(value)) < 1e-2 * step**2


@pytest.mark.parametrize("order", [2, 5])
def test_moments_of_a_point_are_shifted_to_those_about_the_new_centre(order):
    by = np.array([0.3, -0.1, 0.2])
    close(expansions.moments_shifted(order, harmonics(order, -POINT), list(by)), harmonics(order, by - POINT))


def test_a_field_converges_to_that_of_a_point_and_shifted_ones_are_the_same():
    """Errors fall as (0.54/1.49)^p here: to an eighth for two orders more."""
    distance = np.linalg.norm(BETWEEN)
    arm = BETWEEN + AROUND - POINT
    potential, force = 1.0 / np.linalg.norm(arm), -arm / np.linalg.norm(arm) ** 3
    errors = []
    for order in (3, 5, 7):
        # In units of the distance, at which directions are unit vectors.
        moments = harmonics(order, -POINT / distance)
        local = expansions.local(order, list(BETWEEN / distance), moments | {(0, 0, 0): np.float64(1.0)})
        given, weights = expansions.with_two_z(local), harmonics(order, AROUND / distance)
        found = np.array([float(expansions.gradient(order, given, axis, weights)) for axis in range(3)]) / distance**2
        errors.append(np.linalg.norm(found - force) / np.linalg.norm(force))
        assert float(expansions.field(given, weights)) / distance == pytest.approx(
            potential, rel=2.0 * 0.4 ** (order + 1)
        )
        there = expansions.local_shifted(order, local, list(AROUND / distance))
        assert float(there[0, 0, 0]) == pytest.approx(float(expansions.field(given, weights)), rel=1e-14)
        for unit, component in zip(expansions.UNITS, found, strict=True):
            assert float(expansions.with_two_z(there)[unit]) / distance**2 == pytest.approx(component, rel=1e-12)
    assert errors[0] < 0.05 and errors[1] < 0.2 * errors[0] and errors[2] < 0.2 * errors[1], errors
