"""The affine body on its way from record to record."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.effects import Effect, pytree
from astroinertia.models.ellipsoid.affine_body import Problem
from astroinertia.models.ellipsoid.evolution import started
from tests.evolve import advanced


@pytree
@dataclass(frozen=True, eq=False)
class Burn(Effect):
    """A uniform acceleration along x, from one time to another."""

    strength: Any
    begin: Any
    until: Any

    kind: ClassVar[str] = "burn"
    external: ClassVar[bool] = True

    def affine_push(self, body: Any) -> Any:
        """M g while it lasts."""
        lasts = (self.begin <= body.time) & (body.time < self.until)
        return body.mass * jnp.where(lasts, self.strength, 0.0) * jnp.eye(3)[0]

    def breaks(self, start: float, end: float) -> tuple[float, ...]:
        """When it begins and ends."""
        return tuple(float(time) for time in (self.begin, self.until) if start < time <= end)

    def during(self, start: float, end: float) -> Self:
        """With or without it, the ends included."""
        lasts = self.begin <= 0.5 * (start + end) < self.until
        return replace(self, begin=-np.inf, until=np.inf if lasts else -np.inf)


@pytest.mark.parametrize("times", [(10.0,), (1.0, 5.0, 5.0005, 5.001, 5.001 * (1.0 + 1e-15), 10.0)])
def test_steps_end_where_an_effect_begins_and_ends(times: tuple[float, ...]) -> None:
    """A push of a thousandth of a time: steps of a body that coasts are far longer."""
    problem = Problem((Burn(7.0, 5.0, 5.001),), 1.0, 1.0, 0.2, -0.6)
    with jax.enable_x64(True):
        body = started(
            problem, np.eye(3), 1e-3 * np.eye(3), 0.0, tolerance=1e-10, density=1.0, approximation="of a test"
        )
        for time in times:
            advanced(body, time)
            assert body.time == time
        assert body.record(None)["momentum"] == pytest.approx([7e-3, 0.0, 0.0], rel=1e-12)
        assert body.record(None)["centre_of_mass"][0] == pytest.approx(7e-3 * (10.0 - 5.0005), rel=1e-12)
