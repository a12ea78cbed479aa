"""Drifts of many steps: what rounding leaves of a place is carried along."""

from fractions import Fraction

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.engines.elementwise import elementwise
from astroinertia.models.sph.kick_drift import moved


@pytest.mark.parametrize("xp", [np, jnp], ids=["numpy", "jax"])
def test_places_keep_their_digits_over_many_equal_steps(xp):
    """A place far out moves by the same fraction of its last digit in every step: rounded alone, it errs each time."""
    steps, dt, start, velocity = 4000, 0.01, 1000.0, np.array([[0.7, -0.3, 1e-9]])
    with jax.enable_x64(True):
        drift = (lambda *given: elementwise(np, moved, *given)) if xp is np else jax.jit(
            lambda *given: elementwise(jnp, moved, *given)
        )  # fmt: skip
        place, left = xp.full((1, 3), start), xp.zeros((1, 3))
        alone = start
        for _ in range(steps):
            place, left = drift(place, left, xp.asarray(velocity), dt)
            alone += dt * velocity[0, 0]
    exact = [Fraction(start) + steps * Fraction(dt) * Fraction(v) for v in velocity[0]]
    digit = np.spacing(start)
    for found, rest, wanted in zip(np.asarray(place)[0], np.asarray(left)[0], exact, strict=True):
        # The increments themselves are rounded: to 1e-16 of a way of at most 40 in all.
        assert abs(float(Fraction(float(found)) - wanted)) < 0.6 * digit
        assert abs(float(Fraction(float(found)) + Fraction(float(rest)) - wanted)) < 0.1 * digit
    assert abs(float(Fraction(alone) - exact[0])) > 100 * digit  # what a place that is rounded alone would err
