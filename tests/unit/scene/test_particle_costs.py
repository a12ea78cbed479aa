"""What a plan says of a particle run beforehand, against the run itself."""

import numpy as np
import pytest

from astroinertia.build.assemble import prepare
from astroinertia.models.sph.limits import limiting, timestep_limits
from astroinertia.models.sph.record import timestep_limit
from astroinertia.scene import load, particle_costs
from astroinertia.scene.plan import code_units, plan, smoothing

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


@pytest.mark.slow
def test_limits_at_first_are_about_those_of_the_body() -> None:
    """A uniform ball whose sound is as fast as the virial speed: each criterion within the scatter of a random ball."""
    scene = load.loads(SCENE)
    first = particle_costs.first_limits(
        scene.numerics, scene.effects, 1.0, 1.0, 400, smoothing(scene)[0], code_units(scene).gravitational_constant
    )
    body = prepare(scene).evolution
    found = timestep_limits(body.problem, body.state.rates)
    for name, expected in first.items():
        assert np.median(found[name]) == pytest.approx(expected, rel=0.6), name
    lines = {line.name: line.value for line in plan(scene).sections["model and numerics"]}
    assert all(name in lines["its limits at first"] for name in first)


def test_the_progress_line_names_the_criterion_and_the_place() -> None:
    body = prepare(load.loads(SCENE)).evolution
    limits = timestep_limits(body.problem, body.state.rates)
    name, particle = limiting(limits)
    assert particle is not None
    assert float(limits[name][particle]) == float(body.state.rates.timestep)
    limit, figures = timestep_limit(body.problem, body.state), body.figures()
    assert figures.limited_by == name
    assert figures.limited_at == (limit["timestep_limit_radius"], limit["timestep_limit_density"])
    assert limit["timestep_limit_density"] == body.state.rates.fluid.density[particle]
    assert limiting({**limits, "longest": np.float64(1e-9)}) == ("longest", None)
