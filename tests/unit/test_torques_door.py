"""Torques from outside the package on rigid bodies."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import astroinertia
from astroinertia.effects import Dimension, Effect, positive, pytree
from astroinertia.errors import SceneError
from astroinertia.scene.load import loads


@pytree
@dataclass(frozen=True, eq=False)
class Weak(Effect):
    """A torque of one component."""

    kind: ClassVar[str] = "weak"
    models: ClassVar = ("rigid",)

    def torque(self, body: Any) -> Any:
        """Its size alone."""
        return (body.angular_velocity**2).sum()


def test_a_torque_of_a_wrong_shape_is_said_in_a_sentence(tmp_path: Path) -> None:
    body = '[body]\nkind = "rigid"\nmass = 1.0\nradius = 1.0\nmoment_ratios = [0.3, 0.4, 0.5]\n'
    scene = f'name = "weak"\nmodel = "rigid"\nunits = "code"\n{body}[effects]\n[time]\nend = 1.0\n'
    with pytest.raises(SceneError, match=r"the effect 'weak' gave a torque of the shape \(\), not \(3,\)"):
        astroinertia.run_scene(loads(scene), tmp_path / "run", effects=[Weak()])


@pytree
@dataclass(frozen=True, eq=False)
class Friction(Effect):
    """A torque against the rotation, in a class that says nothing else of it."""

    c: Any = 0.5
    kind: ClassVar[str] = "friction"
    models: ClassVar = ("rigid",)
    external: ClassVar[bool] = True
    options: ClassVar = {"c": positive(Dimension(1, 2, -1), 0.5, "torque over the angular velocity")}

    def torque(self, body):
        """-c omega."""
        return -self.c * body.angular_velocity


@pytest.mark.slow
def test_a_torque_of_ones_own_may_follow_the_spin_in_both_integrators(tmp_path: Path) -> None:
    body = '[body]\nkind = "rigid"\nmass = 1.0\nradius = 1.0\nmoment_ratios = [0.4, 0.4, 0.5]\n'
    text = f'name = "slow"\nmodel = "rigid"\nunits = "code"\n{body}rotation = {{rate = 1.0}}\n[effects]\n'
    for integrator in ("splitting", "adaptive"):
        scene = loads(f"{text}[time]\nend = 2.0\n", [f'numerics.integrator="{integrator}"'], effects=[Friction()])
        found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / integrator))
        expected = 0.5 * np.exp(-0.5 / 0.5 * found.time.values)
        assert found.angular_momentum.sel(i="z").values == pytest.approx(expected, rel=1e-10), integrator
