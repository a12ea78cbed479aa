"""Claim: any one argument may be JAX's to be differentiated by, jitted or mapped over, with numpy's for the others."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.inertia import (
    balancing,
    evolution,
    pivoted,
    rolling,
    shapes,
    spin,
    target,
    tensor,
)
from astroinertia.inertia.body import Body

RANDOM = np.random.default_rng(5)
M, X, V, W = np.array([1.0, 2.0, 3.0, 1.5]), RANDOM.normal(size=(4, 3)), RANDOM.normal(size=(4, 3)), np.full(4, 0.7)
ORIGIN, A, ROOT = RANDOM.normal(size=3), np.array([0.2, 1.0, 0.3]), RANDOM.normal(size=(3, 3))
TENSOR, WANTED = ROOT @ ROOT.T, np.diag([3.0, 2.0, 1.0])
BODY = shapes.rod(2.0, 3.0) + shapes.box(3.0, 1.0, 2.0, 0.5).translated(np.array([1.0, 0.5, 0.2]))
HOLE = shapes.disc(0.5, 0.3).translated(ORIGIN)
QUARTER = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
PLANES = np.array([-0.3, 0.5])


def of_body(function):
    """The same function with the body's numbers as its first three arguments."""
    return lambda mass, centre, inertia, *others: function(Body(mass, centre, inertia), *others)


def parts(body):
    return body.mass, body.centre, body.inertia


OWN = parts(BODY)
CASES = {
    "centre_of_mass": (tensor.centre_of_mass, (M, X, W)),
    "inertia_tensor": (tensor.inertia_tensor, (M, X, ORIGIN, W)),
    "mixed_moment": (tensor.mixed_moment, (M, X, V, ORIGIN, -ORIGIN, W)),
    "inertia_rate": (evolution.inertia_rate, (M, X, V, ORIGIN, W)),
    "angular_momentum": (spin.angular_momentum, (M, X, V, ORIGIN, W)),
    "residual_flow": (spin.residual_flow, (M, X, V, W)),
    "target_energy": (
        lambda q, n, k, o, normal: target.target_energy(q, n, k, o, normal=normal),
        (TENSOR, WANTED, 2.0, 0.5, A),
    ),
    "target_matrix": (
        lambda q, n, k, normal: target.target_matrix(q, n, k, normal=normal),
        (TENSOR, WANTED, 2.0, A),
    ),
    "target_energy_gradient": (target.target_energy_gradient, (M, X, WANTED, 2.0)),
    "two_plane_equivalent": (balancing.two_plane_equivalent, (A[:2], ORIGIN[:2], PLANES)),
    "unbalance_of_body": (of_body(balancing.unbalance_of_body), OWN),
    "pendulum_length": (of_body(pivoted.pendulum_length), (*OWN, ORIGIN, A)),
    "pendulum_period": (of_body(pivoted.pendulum_period), (*OWN, ORIGIN, A, 0.4, 9.8)),
    "pivot_impulse": (of_body(pivoted.pivot_impulse), (*OWN, ORIGIN, 2.0, A)),
    "rolling_coefficient": (of_body(rolling.rolling_coefficient), (*OWN, 0.4, A)),
    "flywheel_energy": (of_body(rolling.flywheel_energy), (*OWN, 2.0, A)),
    "flywheel_rates": (rolling.flywheel_rates, (np.array([1.0, 2.0, 1.0]), np.arange(3.0), 2.0, 3.0, 0.1)),
    "rotated": (of_body(lambda body, matrix, about: parts(body.rotated(matrix, about))), (*OWN, QUARTER, ORIGIN)),
    "moment": (of_body(lambda body, axis, point: body.moment(axis, point)), (*OWN, A, ORIGIN)),
    "translated": (of_body(lambda body, by: parts(body.translated(by))), (*OWN, ORIGIN)),
    "sum": (lambda *six: parts(Body(*six[:3]) - Body(*six[3:])), (*OWN, *parts(HOLE))),
}


@pytest.mark.parametrize("name", CASES)
def test_any_one_argument_may_be_traced(name):
    function, given = CASES[name]
    shapes_of_all = [jnp.shape(leaf) for leaf in jax.tree.leaves(function(*given))]
    for place, argument in enumerate(given):

        def traced(one, place=place):
            return function(*given[:place], one, *given[place + 1 :])

        assert [leaf.shape for leaf in jax.tree.leaves(jax.eval_shape(traced, argument))] == shapes_of_all


@pytest.mark.slow
def test_a_list_may_hold_traced_numbers():
    def moment(a):
        return shapes.ellipsoid(1.0, [a, 2.0, 3.0]).translated([0, a, 0]).about([a, 0, 0])[2, 2]  # a^2/5 + 4/5 + 2 a^2

    def of_points(a):
        return tensor.inertia_tensor([1.0, 2.0], [[a, 0, 0], (0, a, 0)], [0, 0, 0])[1, 1]  # a^2

    with jax.enable_x64(True):
        assert jax.grad(moment)(1.5) == pytest.approx(4.4 * 1.5, rel=1e-15)
        assert jax.grad(of_points)(1.5) == pytest.approx(3.0, rel=1e-15)


@pytest.mark.slow
def test_the_place_of_a_bore_is_differentiated():
    plate, bore = shapes.cylinder(3.0, 0.2, 0.02), shapes.cylinder(0.3, 0.06, 0.02)

    def moment(place):
        return (plate - bore.translated(place)).moment(np.array([0.0, 0.0, 1.0]))

    with jax.enable_x64(True):
        slope = jax.grad(moment)(jnp.array([0.1, 0.02, 0.0]))
    # The bore's own moment is less m x^2, and the rest's centre moves off: -2 m M/(M - m) x.
    assert slope == pytest.approx([-2 * 0.3 * 3 / 2.7 * 0.1, -2 * 0.3 * 3 / 2.7 * 0.02, 0.0], rel=1e-12)
