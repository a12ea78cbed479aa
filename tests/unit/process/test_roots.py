"""Roots between two ends: as near as is asked for, however far the ends are apart."""

import math

import numpy as np
import pytest

from astroinertia.process.roots import bisected, root_between


def found(*errors):
    """The root of x^2 - 2, and at how many places the function was asked for."""
    places = []
    root = root_between(lambda x: places.append(x) or x * x - 2.0, 0.0, 2.0, *errors)
    return root, len(places)


def test_a_root_is_as_near_as_is_asked_for():
    (rough, few), (near, more) = found(1e-3, 1e-3), found()
    assert 1e-12 < abs(rough - math.sqrt(2.0)) <= 3e-3
    assert near == pytest.approx(math.sqrt(2.0), rel=2e-15)
    assert few < more


def test_small_roots_keep_their_digits():
    """More than a hundred steps from the far end, where the function is flat until the root is near."""
    root = root_between(lambda x: x**3 - 1e-270, 0.0, 1.0, 1e-300, 1e-14)
    assert root == pytest.approx(1e-90, rel=2e-14)


def test_ends_on_one_side_are_refused():
    with pytest.raises(ValueError, match="different signs"):
        root_between(lambda x: x * x + 1.0, -1.0, 1.0)


def test_many_roots_at_once_are_those_of_each():
    squares = np.array([2.0, 3.0, 1e-8])
    roots = bisected(lambda x: x * x < squares, np.zeros(3), np.full(3, 2.0), 60)
    np.testing.assert_allclose(roots, np.sqrt(squares), rtol=1e-12)
