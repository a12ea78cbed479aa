"""Heat exchanged with the surroundings over a step: exact for linear laws, however stiff, and accounted for exactly."""

import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.models.sph.heat import entropy_after, exchange_of, exchanged_energies

MASS = np.array([0.5, 1.5, 2.0, 0.7])
UNIT = np.array([0.8, 1.1, 0.3, 2.0])  # dA/du
START = np.array([1.0, 0.2, 3.0, 0.0])  # u
GAINS = (np.array([0.3, 0.1, 0.0, 0.4]), np.array([0.0, 0.2, 0.1, 0.0]))
DECAYS = (np.array([1.0, 1e-7, 0.0, 2.0]), np.array([0.5, 1e-6, 0.0, 1e8]))
PAIRS = np.array([0.2, -0.1, 0.5, 0.1])  # du/dt of pairs


def after(xp: Any, dt: float) -> tuple[Any, list[Any]]:
    """u after dt, and what each effect added to the energy."""
    exchange = exchange_of([None, *zip(GAINS, DECAYS, strict=True)], xp.asarray(UNIT))
    assert exchange is not None
    gained = dt * UNIT * (PAIRS + sum(GAINS))
    given = (xp.asarray(MASS), xp.asarray(START * UNIT), xp.asarray(gained), xp.asarray(dt))
    return entropy_after(xp, exchange, *given[1:]) / UNIT, exchanged_energies(xp, exchange, *given)


def exact(dt: float) -> np.ndarray:
    decay, rate = sum(DECAYS), PAIRS + sum(GAINS)
    x = decay * dt
    gone = -np.expm1(-x)
    return START * np.exp(-x) + rate * np.where(x > 0.0, gone / np.where(decay > 0.0, decay, 1.0), dt)


@pytest.mark.slow
@pytest.mark.parametrize("dt", [1e-9, 1e-3, 0.7, 50.0])
@pytest.mark.parametrize("engine", ["numpy", "jax"])
def test_linear_laws_are_exact_and_every_effect_owns_its_share(dt: float, engine: str) -> None:
    with jax.enable_x64(True):
        found, added = after(np if engine == "numpy" else jnp, dt)
    assert np.allclose(found, exact(dt), rtol=1e-11, atol=0.0)
    assert float(added[0]) == 0.0
    # What the internal energy gains is what pairs and effects have added, to rounding of what passed through.
    gained = MASS @ (np.asarray(found) - START)
    passed = MASS @ (np.abs(START) + dt * (np.abs(PAIRS) + sum(GAINS)))
    assert abs(gained - dt * MASS @ PAIRS - sum(map(float, added))) <= 1e-15 * passed


def test_the_shares_go_by_the_decays() -> None:
    """Without heat, what two effects take is as their k."""
    exchange = exchange_of([(0.0 * UNIT, 2.0 + 0.0 * UNIT), (0.0 * UNIT, 6.0 + 0.0 * UNIT)], UNIT)
    assert exchange is not None
    one, other = exchanged_energies(np, exchange, MASS, START * UNIT, 0.0 * UNIT, np.float64(0.3))
    assert other == pytest.approx(3.0 * one, rel=1e-14)
    assert one + other == pytest.approx(MASS @ START * math.expm1(-2.4), rel=1e-14)


def test_without_any_effect_there_is_no_exchange() -> None:
    assert exchange_of([None, None], UNIT) is None
