"""Derivatives that are carried along with an affine body."""

import jax
import numpy as np
import pytest

from astroinertia.engines.variational import SIDES, derivative
from astroinertia.models.ellipsoid.evolution import Ellipsoid
from astroinertia.models.ellipsoid.variation import advance
from tests.coasting import coasting

STEP = 1e-4


@pytest.mark.slow
def test_a_short_push_is_in_the_derivative() -> None:
    """By the strength of a push, which is the momentum that a body of unit mass gets over how long it lasts."""

    def momentum(body: Ellipsoid) -> float:
        return body.record(None)["momentum"][0]

    with jax.enable_x64(True):
        body, *four = (coasting(7.0 + side * STEP) for side in (0.0, *SIDES))
        advance(body, four, STEP, 10.0)
        assert momentum(body) == pytest.approx(7e-3, rel=1e-12)
        slope, _ = derivative(np.array([momentum(one) for one in four]), STEP)
        assert slope == pytest.approx(1e-3, rel=1e-9)
