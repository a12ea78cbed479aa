"""External fields: gradients of their potentials, and circular orbits."""

import math
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.effects import catalogue
from tests.ball import ball
from tests.unit.points import at


@pytest.mark.parametrize(
    "options",
    [
        {"uniform": (0.3, -0.2, 0.1)},
        {"quadratic": ((1.0, 0.2, 0.1), (0.2, 0.5, -0.3), (0.1, -0.3, -0.4)), "origin": (0.1, 0.2, 0.3)},
        {"circular_speed": 1.4, "core": 0.3, "origin": (0.5, 0.0, -0.5)},
        {"point_mass": 2.0, "softening": 0.1, "origin": (1.5, 0.0, 0.0)},
    ],
    ids=lambda options: next(iter(options)),
)
def test_each_given_field_is_the_gradient_of_its_potential(options: dict[str, Any]) -> None:
    effect, position = catalogue.build("external_field", options), ball(60)
    with jax.enable_x64(True):
        mass = jnp.full(len(position), 1.0 / len(position))

        def energy(x: Any) -> Any:
            return effect.potential_energy(jnp, SimpleNamespace(position=x, mass=mass))

        force = jax.grad(energy)(jnp.asarray(position))
    assert np.allclose(effect.acceleration(np, at(position)) / len(position), -force, rtol=1e-12, atol=1e-16)


def test_circular_orbits_have_the_given_speed() -> None:
    """Far outside its core the logarithmic field holds a particle at the given speed at any radius."""
    effect = catalogue.build("external_field", {"circular_speed": 1.4, "core": 1e-6})
    for radius in (1.0, 10.0, 100.0):
        pull = effect.acceleration(np, at([[radius, 0.0, 0.0]]))[0, 0]
        assert math.isclose(math.sqrt(-pull * radius), 1.4, rel_tol=1e-11)
