"""Steps that are predicted, by a pilot run with few particles, against those that a run with more of them takes."""

import jax
import pytest

from astroinertia.build.assemble import outputs_of, prepare
from astroinertia.costs import pilot
from astroinertia.scene import load
from astroinertia.scene.plan import code_units
from astroinertia.storage import cache

CLOUD = """
name = "cloud"
units = "code"
[body]
kind = "power_law"
exponent = 1.0
particles = 300
mass = 1.0
radius = 1.0
relax = false
specific_internal_energy = 0.05
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[effects.gravity]
[effects.pressure]
[effects.viscosity]
[time]
end = 1.2
"""
GAS = CLOUD.replace('"power_law"\nexponent', '"dyson"\ngamma').replace("gamma = 1.0\n", "gamma = 1.6666666666666667\n")
GAS = GAS.replace("[effects.gravity]\n", "").replace("end = 1.2", "end = 2.0")


@pytest.mark.full
@pytest.mark.parametrize("text", [CLOUD, GAS], ids=["a collapse with a bounce", "an expansion"])
def test_steps_of_more_particles_are_predicted_within_a_factor(text, tmp_path, monkeypatch):
    """Five times the particles: what sound limits takes 1.7 times the steps, which a mere repetition would miss."""
    monkeypatch.setattr(cache, "cache_directory", lambda: tmp_path)  # a pilot of its own
    scene = load.loads(text, ["body.particles=1500"])
    found = pilot.run(scene)
    assert found is not None and found.reached == 1.0
    with jax.enable_x64(True):
        body, end = prepare(scene).evolution, outputs_of(scene, code_units(scene)).end
        while body.time < end * (1.0 - 1e-14):
            body.advance(end)
    predicted = found.counts(1500).steps
    assert predicted / 1.25 < body.steps < 1.25 * predicted
    assert body.steps > 1.3 * len(found.length)
