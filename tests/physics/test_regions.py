"""Regions of a run: their ledgers close at every record, with global and individual steps, flux row and all."""

import subprocess
import sys
import textwrap
from functools import cache

import numpy as np
import pytest

from astroinertia import dataset
from astroinertia.build import sph
from astroinertia.inertia.tensor import axial_vector
from astroinertia.ledger import regions as region_ledger
from astroinertia.ledger.moments import weighted_outer
from astroinertia.run.loop import run_scene
from astroinertia.scene import load
from astroinertia.units import DIMENSIONLESS
from tests.evolve import prepared

pytestmark = pytest.mark.usefixtures("steps_differ")

SCENE = """
name = "parts"
units = "code"
[body]
kind = "polytrope"
index = 1.5
particles = 200
mass = 1.0
radius = 1.0
relax = false
pressure_fraction = 0.3
[body.rotation]
rate = 0.5
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[effects.viscosity]
[regions.core]
innermost_mass = 0.4
[regions.middle]
innermost_mass = 0.4
centre = "centre_of_mass"
[regions.dense]
density_above = 1.2
[regions.remnant]
bound = true
[regions.everything]
innermost_mass = 5.0
[regions.nothing]
density_above = 1e9
[time]
end = 10.0
max_steps = 40
[output]
series_steps = 1
"""
COARSE = ("output.series_steps=7",)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The dataset of the scene with settings, each made once."""

    @cache
    def made(*settings):
        return dataset.open(run_scene(load.loads(SCENE, settings), tmp_path_factory.mktemp("runs") / "run"))

    return made


@pytest.mark.parametrize(
    "settings",
    [
        pytest.param((), marks=pytest.mark.full),
        pytest.param(COARSE, marks=pytest.mark.full),
        ("numerics.timesteps=individual", "time.max_steps=12"),
    ],
    ids=["every_step", "every_seventh", "individual"],
)
def test_change_of_a_region_is_what_acts_on_it_and_what_crosses_its_edge(run, settings):
    """Free motion leaves L alone, so that its change is that of effects and the flux row: an identity of the file.

    Q and I close through the ledger. Round-off is 1e-15 of the largest; 1e-12 leaves room for more steps.
    """
    data = run(*settings)
    assert data["region_ledger_closure"].max() < 1e-13
    momentum = data["region_angular_momentum"].transpose("time", "region", "i").values
    impulse = data["region_mixed_impulse"].sum("effect").transpose("time", "region", "i", "j").values
    flux = data["region_flux_angular_momentum"].transpose("time", "region", "i").values
    turned, size = momentum - momentum[0], np.abs(momentum).max()
    assert np.abs(turned - axial_vector(impulse) - flux).max() < 1e-13 * size
    mass = data["region_mass"].values
    assert np.abs(mass - mass[0] - data["region_flux_mass"].values).max() < 1e-13
    assert np.abs(flux).max() > 0.05 * size  # matter has crossed an edge


def test_closure_breaks_without_the_flux_row(monkeypatch):
    start = prepared(SCENE)
    none = region_ledger.Flux(np.zeros(()), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)))
    closures = {}
    for name, replaced in (("with", region_ledger.crossing), ("without", lambda *_: none)):
        monkeypatch.setattr(region_ledger, "crossing", replaced)
        body = prepared(SCENE) if name == "without" else start
        for _ in range(10):
            body.advance(10.0)
            record = body.record(None)
        closures[name] = dict(zip((r.name for r in body.regions.regions), record["region_ledger_closure"], strict=True))
    assert closures["with"]["dense"] < 1e-13
    assert closures["without"]["dense"] > 1e-3
    assert closures["without"]["everything"] < 1e-13  # nothing crosses there


def test_second_moments_of_a_region_follow_from_the_particles_kicked_and_drifted():
    """One step, from the particles themselves: dQ of those that were in, and the flux of those that came and went."""
    body = prepared(SCENE)
    for _ in range(5):
        body.advance(10.0)
        body.record(None)
    before, row = body.state, body.record(None)
    body.advance(10.0)
    after, new = body.state, body.record(None)
    for k, region in enumerate(body.regions.regions):
        member = {int(i): m for i, m in zip(before.identity, before.memory[f"region.{region.name}"], strict=True)}
        chosen = np.array([member[int(i)] > 0 for i in after.identity])
        if not chosen.any():
            continue
        mass, position = after.mass[chosen], after.position[chosen]
        position = position - (mass @ position) / mass.sum()
        matter = weighted_outer(mass, position, position) - row["region_second_moment"][k]
        crossed = new["region_flux_second_moment"][k] - row["region_flux_second_moment"][k]
        change = new["region_second_moment"][k] - row["region_second_moment"][k]
        assert np.abs(change - matter - crossed).max() < 1e-14


@pytest.mark.full
def test_a_region_of_everything_is_the_body(run):
    data = run().sel(region="everything")
    for name in (
        "second_moment", "mixed_moment", "kinetic_tensor", "inertia_tensor", "angular_momentum", "angular_velocity",
        "mixed_impulse", "gravitational_energy", "rotational_to_gravitational", "mean_radius", "density_max",
    ):  # fmt: skip
        own, whole = data[f"region_{name}"], data[name]
        assert np.abs(own - whole).max() <= 1e-12 * np.abs(whole).max(), name
    # By direct summation here and by the effects' own routes there.
    virial = np.abs(data["region_virial_tensor"] - data["virial_tensor"]).max()
    assert virial < 1e-10 * np.abs(data["virial_tensor"]).max()
    assert not np.any(data["region_flux_mass"])


def test_an_empty_region_is_reported_as_empty(run):
    data = run().sel(region="nothing")
    assert not np.any(data["region_mass"]) and not np.any(data["region_second_moment"])
    assert np.isnan(data["region_angular_velocity"]).all() and np.isnan(data["region_centre"]).all()


def test_the_state_does_not_depend_on_its_regions():
    """Bit for bit: who looks at parts of a body changes nothing in it."""
    plain = SCENE[: SCENE.index("[regions.core]")] + SCENE[SCENE.index("[time]") :]
    one, other = prepared(SCENE), prepared(plain)
    for _ in range(5):
        for body in (one, other):
            body.advance(10.0)
            body.record(None)
    assert np.array_equal(one.state.position, other.state.position)
    assert not other.state.regions and not any(name.startswith("region") for name in other.state.memory)


@pytest.mark.parametrize("steps", ["global", "individual"])
def test_regions_go_on_from_a_checkpoint_bit_for_bit(steps):
    scene = load.loads(SCENE, [f"numerics.timesteps={steps}"])
    body = sph.evolution(scene, DIMENSIONLESS)
    while body.steps < 16:
        body.advance(10.0)
    body.record(None)
    other = sph.resumed(scene, DIMENSIONLESS, body.arrays())
    for each in (body, other):
        for _ in range(3):
            each.advance(10.0)
    one, two = body.record(0.0), other.record(0.0)
    for name in one:
        np.testing.assert_array_equal(one[name], two[name], err_msg=name)


def test_scenes_without_regions_import_nothing_of_them():
    script = """
        import sys
        from astroinertia.build.assemble import prepare
        from astroinertia.scene import load
        text = {text!r}
        plain = text[: text.index("[regions.core]")] + text[text.index("[time]") :]
        prepare(load.loads(plain)).evolution.advance(1.0)
        print("astroinertia.models.sph.regions" in sys.modules)
        prepare(load.loads(text))
        print("astroinertia.models.sph.regions" in sys.modules)
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script).format(text=SCENE)], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["False", "True"]
