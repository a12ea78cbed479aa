"""Exact gradients of what layered bodies give, by every parameter of a layer, against finite differences to 1e-6."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.bodies.clairaut import hydrostatic_figure, love_number
from astroinertia.bodies.layered import constant_layers, linear_layers


def by_differences(function, at, step=3e-3):
    """Central differences extrapolated twice: an error of order step^6."""
    at = np.asarray(at, dtype=float)
    out = []
    for k in range(len(at)):

        def central(h, k=k):
            shift = h * np.eye(len(at))[k] * at[k]
            return (float(function(at + shift)) - float(function(at - shift))) / (2 * h * at[k])

        one, two, four = (central(step * n) for n in (1, 2, 4))
        out.append((64 * one - 20 * two + four) / 45)
    return np.array(out)


# Of layers of constant density; linear ones, flattening, pressure and the other pairs: test-full.
QUANTITIES = ("moment_ratio", "k2", "k5", "flattening", "pressure")
FEW = {("moment_ratio", "constant"), ("k5", "constant")}
PAIRS = [
    pytest.param(quantity, kind, marks=() if (quantity, kind) in FEW else pytest.mark.full)
    for quantity in QUANTITIES
    for kind in ("constant", "linear")
]


@pytest.mark.parametrize(("quantity", "kind"), PAIRS)
def test_gradients_are_those_of_finite_differences(quantity, kind):
    """By every parameter of a layered body: three radii and the densities."""
    of_body = {
        "moment_ratio": lambda body: body.moment_ratio,
        "k2": love_number,
        "k5": lambda body: love_number(body, 5),
        "flattening": lambda body: hydrostatic_figure(body, 0.1).flattening,
        "pressure": lambda body: body.pressure(0.0),
    }[quantity]

    def value(parameters):
        radii, rest = parameters[:3], parameters[3:]
        if kind == "constant":
            return of_body(constant_layers(radii, rest))
        return of_body(linear_layers(radii, rest[:3], rest[3:]))

    at = [0.3, 0.8, 1.3, 9.0, 4.0, 2.0] + ([] if kind == "constant" else [8.0, 3.0, 1.5])
    with jax.enable_x64(True):
        exact = np.asarray(jax.jit(jax.grad(value))(jnp.array(at)))
        compiled = jax.jit(value)
        measured = by_differences(compiled, at)
    np.testing.assert_allclose(exact, measured, rtol=1e-6, atol=1e-9 * np.abs(exact).max())
