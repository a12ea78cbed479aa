"""Matter on which nothing acts flies on as it began, in every model that has particles or a shape."""

import numpy as np
import pytest

import astroinertia
from astroinertia.scene import load

pytestmark = pytest.mark.usefixtures("steps_differ")

NOTHING = """
name = "nothing"
units = "code"
[body]
kind = "uniform"
particles = 60
mass = 1.0
radius = 1.0
relax = false
[body.rotation]
rate = 0.5
[equation_of_state]
kind = "ideal"
[effects]
[time]
end = 1.0
max_steps = 12
[output]
series_every = 0.5
snapshot_every = 0.5
"""
ROCK = """
name = "rock"
[body]
kind = "uniform"
particles = 60
mass = "1e15 kg"
radius = "44 km"
relax = false
[body.rotation]
rate = "1e-4 rad/s"
[equation_of_state]
kind = "materials"
materials = [{ name = "rock", tillotson = "basalt" }]
[effects.gravity]
[effects.pressure]
[regions.core]
innermost_mass = "5e14 kg"
[time]
end = "100 s"
max_steps = 12
[output]
series_every = "50 s"
"""
PARTS = "[regions.core]\ninnermost_mass = 0.5\n[regions.dense]\ndensity_above = 0.1\n"


@pytest.mark.parametrize(
    ("settings", "parts"),
    [
        (["numerics.timesteps=global"], PARTS),
        (["numerics.timesteps=individual"], PARTS),
        pytest.param(["model=ellipsoid"], "", marks=pytest.mark.full),
    ],
    ids=["global", "individual", "ellipsoid"],
)
def test_a_body_on_which_nothing_acts_flies_apart_at_its_own_speed(tmp_path, settings, parts):
    scene = load.loads(NOTHING + parts, settings)
    found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run"))
    second, mixed, kinetic = (found[name].values for name in ("second_moment", "mixed_moment", "kinetic_tensor"))
    time = found["time"].values[-1]
    assert time > 0.0
    ahead = second[0] + time * (mixed[0] + mixed[0].T) + time**2 * kinetic[0]
    assert np.abs(second[-1] - ahead).max() < 1e-13 * np.abs(ahead).max()
    assert found["ledger_closure"].max() < 1e-14
    assert found["virial_tensor"].shape[1] == 0 or not np.abs(found["virial_tensor"].values).any()


@pytest.mark.full
def test_regions_of_matter_whose_entropy_is_not_linear_in_heat_are_followed_by_global_steps(tmp_path):
    """A kick took the entropies of such matter for velocities."""
    found = astroinertia.open(astroinertia.run_scene(load.loads(ROCK, ["numerics.timesteps=global"]), tmp_path / "run"))
    assert float(found["region_ledger_closure"].max()) < 1e-13
