"""Particles with their derivative beside them: what is no derivative is refused."""

import numpy as np
import pytest

from astroinertia.effects import catalogue
from astroinertia.engines.variational import SIDES
from astroinertia.models.sph import variation
from astroinertia.models.sph.evolution import Particles
from tests.ball import ball, state_of


def test_a_parameter_that_moves_the_end_of_an_effect_is_refused() -> None:
    position = ball(60)

    def body(side: float) -> Particles:
        damping = catalogue.build("damping", {"time_scale": 0.3, "until": 0.2 + 1e-3 * side})
        return Particles(*state_of(damping, position=position, velocity=np.zeros_like(position)), end=0.4)

    with pytest.raises(ValueError, match="the times at which effects begin or end differ"):
        variation.advance(body(0.0), [body(side) for side in SIDES], 1e-3, 0.4)
