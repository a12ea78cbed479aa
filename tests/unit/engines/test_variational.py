"""Derivatives along an evolution: their order, what they refuse, and what they carry on."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.engines.variational import SIDES, beside, derivative, pushed, slopes


def four(function, at, step):
    return [function(at + side * step) for side in SIDES]


def test_a_derivative_is_of_fourth_order():
    errors = [abs(derivative(four(np.exp, 0.3, step), step)[0] - np.exp(0.3)) for step in (0.2, 0.1)]
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.02)


def test_slopes_of_a_tree_leave_what_is_no_real_number():
    def tree(p):
        return {"x": np.array([p**2, np.inf]), "count": np.array([3, 4]), "name": np.bool_(True)}

    slope, jump = slopes(four(tree, 2.0, 1e-3), 1e-3)
    np.testing.assert_allclose(slope["x"], [4.0, 0.0], rtol=1e-9)
    assert slope["count"] is None and slope["name"] is None
    assert jump < 1e-9
    moved = beside(tree(2.0), slope, 1e-3)
    np.testing.assert_allclose(moved["x"], [4.004, np.inf], rtol=1e-12)
    assert moved["count"].tolist() == [3, 4]


def test_jumps_are_seen_and_other_structures_refused():
    step = 1e-4
    assert slopes(four(lambda p: np.float64(p > 2.00003), 2.0, step), step)[1] > 0.1
    with pytest.raises(ValueError, match="whole numbers"):
        slopes(four(lambda p: np.int64(p > 2.00003), 2.0, step), step)
    with pytest.raises(ValueError, match="one structure"):
        slopes(four(lambda p: np.zeros(2 + (p > 2.00003)), 2.0, step), step)
    with pytest.raises(ValueError, match="one structure"):
        slopes(four(lambda p: (p,) if p > 2.00003 else [p], 2.0, step), step)


def test_a_function_pushes_the_derivative_of_what_moves():
    with jax.enable_x64(True):
        tree = {"x": jnp.array([1.0, 2.0]), "count": jnp.array(3)}
        slope = {"x": np.array([0.5, 0.0]), "count": None}
        value, along = pushed(lambda t: jnp.sum(t["x"] ** t["count"]), tree, slope)
    assert float(value) == 9.0
    assert float(along) == pytest.approx(1.5)  # 3 x^2 dx of the first
