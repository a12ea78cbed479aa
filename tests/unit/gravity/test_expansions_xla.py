"""Harmonic expansions: shifts are exact, and fields converge to those of points."""

import jax
import numpy as np
import pytest

from astroinertia.gravity import expansions_xla as expansions
from astroinertia.gravity.expansions import harmonic

pytestmark = pytest.mark.usefixtures("float64")

POINT, AROUND = np.array([0.1, -0.2, 0.15]), np.array([-0.1, 0.15, 0.2])  # of a source and a target, about centres
BETWEEN = np.array([0.6, -0.8, 1.1])  # of the target's centre from the source's


def harmonics(order, point):
    return np.asarray(expansions.harmonics(order, list(point)))


def test_harmonics_are_monomials_without_their_squares_of_z():
    """x^a/a! with z^2 replaced by -(x^2 + y^2) in what is multiplied with D_a."""
    x, y, z = POINT
    expected = {
        (0, 0, 0): 1.0, (1, 0, 0): x, (0, 1, 0): y, (0, 0, 1): z, (1, 1, 0): x * y, (1, 1, 1): x * y * z,
        (2, 0, 0): (x**2 - z**2) / 2.0, (0, 2, 0): (y**2 - z**2) / 2.0, (1, 0, 1): x * z,
        (3, 0, 0): x**3 / 6.0 - x * z**2 / 2.0, (2, 0, 1): x**2 * z / 2.0 - z**3 / 6.0,
        (1, 2, 0): x * y**2 / 2.0 - x * z**2 / 2.0,
    }  # fmt: skip
    found = dict(zip(harmonic(3), harmonics(3, POINT), strict=True))
    for a, value in expected.items():
        assert found[a] == pytest.approx(value, abs=1e-17), a


@pytest.mark.slow
def test_there_are_as_many_as_harmonic_polynomials_and_they_are_harmonic():
    order, step = 5, 1e-3
    assert len(harmonics(order, POINT)) == len(harmonic(order)) == (order + 1) ** 2
    around = [harmonics(order, POINT + side * unit) for unit in step * np.eye(3) for side in (-1, 1)]
    assert np.abs(sum(around) - 6.0 * harmonics(order, POINT)).max() < 1e-2 * step**2


@pytest.mark.parametrize("order", [2, 5])
def test_moments_of_a_point_are_shifted_to_those_about_the_new_centre(order):
    by = np.array([0.3, -0.1, 0.2])
    found = expansions.moments_shifted(order, jax.numpy.asarray(harmonics(order, -POINT)), list(by))
    np.testing.assert_allclose(found, harmonics(order, by - POINT), rtol=0.0, atol=1e-15)


@pytest.mark.full
def test_a_field_converges_to_that_of_a_point_and_shifted_ones_are_the_same():
    """Errors fall as (0.54/1.49)^p here: to an eighth for two orders more."""
    distance = np.linalg.norm(BETWEEN)
    arm = BETWEEN + AROUND - POINT
    potential, force = 1.0 / np.linalg.norm(arm), -arm / np.linalg.norm(arm) ** 3
    errors = []
    for order in (3, 5, 7):
        # In units of the distance, at which directions are unit vectors.
        moments = dict(zip(harmonic(order), harmonics(order, -POINT / distance), strict=True))
        local = expansions.local(order, list(BETWEEN / distance), moments)
        local, weights = jax.numpy.stack(list(local.values())), harmonics(order, AROUND / distance)
        found = np.array([float(slope @ weights) for slope in expansions.gradient(order, local)]) / distance**2
        errors.append(np.linalg.norm(found - force) / np.linalg.norm(force))
        assert float(local @ weights) / distance == pytest.approx(potential, rel=2.0 * 0.4 ** (order + 1))
        there = expansions.local_shifted(order, local, list(AROUND / distance))
        assert float(there[0]) == pytest.approx(float(local @ weights), rel=1e-14)
        for slope, component in zip(expansions.gradient(order, there), found, strict=True):
            assert float(slope[0]) / distance**2 == pytest.approx(component, rel=1e-12)
    assert errors[0] < 0.05 and errors[1] < 0.2 * errors[0] and errors[2] < 0.2 * errors[1], errors
