"""Sums of many arrays at once are as exact as NumPy's, and have derivatives forwards and backwards."""

import math

import jax
import numpy as np
import pytest

from astroinertia.engines.xla_sums import sums

pytestmark = pytest.mark.usefixtures("float64")


@pytest.mark.parametrize("count", [0, 1, 2, 3, 99, 1_000_003])
def test_sums_of_a_million_terms_are_right_to_round_off(count):
    # In one row, a million terms lose 2.8e-14, in parts 5e-16: a ledger that adds such sums at each step left 3e-12 in
    # 1200 of them.
    positive, signed = np.random.default_rng(0).random(count), np.random.default_rng(2).normal(size=count)
    for terms, found in zip((positive, signed), sums([positive, signed]), strict=True):
        assert abs(float(found) - math.fsum(terms)) <= 3e-15 * math.fsum(np.abs(terms))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_sums_along_any_axis_of_several_are_those_of_numpy(axis):
    first, second = np.random.default_rng(3).normal(size=(2, 5, 6, 7))
    for terms, found in zip((first, second), sums([first, second], axis), strict=True):
        np.testing.assert_allclose(found, terms.sum(axis=axis), rtol=1e-14, atol=1e-14)


@pytest.mark.slow
def test_derivatives_are_those_of_sums_forwards_and_backwards():
    def norm(x):
        total, square = sums([x, x * x])
        return total * square

    x = np.random.default_rng(4).normal(size=17)
    expected = (x**2).sum() + 2 * x.sum() * x
    np.testing.assert_allclose(jax.grad(norm)(x), expected, rtol=1e-13)
    np.testing.assert_allclose(jax.jacfwd(norm)(x), expected, rtol=1e-13)
