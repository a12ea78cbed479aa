"""What matter allows of a time step, against particles themselves."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from astroinertia.build.assemble import prepare
from astroinertia.costs import machine, plan_lines
from astroinertia.costs.prediction import predict
from astroinertia.effects import Effect, pytree
from astroinertia.models.sph.limits import timestep_limits
from astroinertia.scene import load

SCENE = """
name = "ball"
units = "code"
[body]
kind = "uniform"
particles = 400
mass = 1.0
radius = 1.0
relax = false
placement = "random"
specific_internal_energy = 0.9
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[effects.gravity]
[effects.pressure]
[time]
end = 1.0
"""


KEPT = SCENE.replace("[effects.gravity]\n[effects.pressure]", "[effects.gravity]\nsoftening = 0.05")


@pytest.mark.slow
@pytest.mark.parametrize("text", [SCENE, KEPT], ids=["adapting", "kept"])
def test_limits_at_first_are_about_those_of_the_body(text, tmp_path, monkeypatch):
    """A uniform ball: each criterion within the scatter of a random one, also where smoothing lengths are stated."""
    monkeypatch.setenv("ASTROINERTIA_CACHE", str(tmp_path / "cache"))
    scene = load.loads(text)
    cost = predict(scene, machine.shipped())
    assert cost is not None and set(cost.first) == {"acceleration", *scene.effects}
    body: Any = prepare(scene).evolution
    found = timestep_limits(body.problem, body.state.rates)
    for name, expected in cost.first.items():
        if text is KEPT and name == "gravity":  # a particle alone in its kernel sees itself
            continue
        assert np.median(found[name]) == pytest.approx(expected, rel=0.6), name
    (line,) = (line for line in plan_lines.lines(scene, cost) if line.name == "time step at first")
    assert all(name in line.value for name in cost.first)


@pytree
@dataclass(frozen=True, eq=False)
class Diffusion(Effect):
    """Something that has half of the smoothing length's time to diffuse."""

    kind: ClassVar[str] = "diffusion"
    limited_by_density: ClassVar[bool] = True

    def timestep(self, xp, fluid):
        """h^2/2."""
        return 0.5 * fluid.smoothing_length**2


def test_an_effect_of_the_users_own_limits_predicted_steps_as_it_says():
    scene = load.loads(SCENE.replace("[time]", "[effects.diffusion]\n[time]"), effects=[Diffusion])
    alone = load.loads(SCENE.replace("[time]", "[effects.shear_viscosity]\nkinematic_viscosity = 0.25\n[time]"))
    own, stated = (predict(each, machine.shipped()) for each in (scene, alone))
    assert own is not None and stated is not None
    assert own.first["diffusion"] == pytest.approx(stated.first["shear_viscosity"])  # h^2/(8 nu)
