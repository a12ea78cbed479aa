"""The step that energy allows: as long as what is there lasts, and none for matter that has none to lose."""

from types import SimpleNamespace
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.models.sph.limits import energy_limit


@pytest.mark.parametrize("xp", [np, jnp], ids=["numpy", "jax"])
def test_matter_without_energy_does_not_limit_the_step(xp: Any) -> None:
    """A cold solid's energy is zero but for the error of its table, of either sign: no step may be negative by that."""
    energy = xp.asarray([2.0, 2.0, -1e-5, 0.0, -1e-5])
    heating = xp.asarray([-0.5, 0.5, -1e-99, -0.5, 0.5])
    pull = xp.asarray(np.outer([0.0, 3.0, 3.0, 3.0, 3.0], [0.0, 0.6, 0.8]))
    fluid: Any = SimpleNamespace(internal_energy=energy, smoothing_length=xp.asarray(np.full(5, 0.5)))
    found = np.asarray(energy_limit(xp, fluid, heating, pull, 0.25))
    assert np.allclose(found, [1.0, 0.25 * (2.0 + 1.5) / 0.5, np.inf, np.inf, 0.25 * (1.5 - 1e-5) / 0.5], rtol=1e-6)
