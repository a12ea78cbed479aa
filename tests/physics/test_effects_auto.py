"""What `effects = "auto"` leaves out changes the observables by less than was asked, and what it turns on by more.

Each scene of tests/data/effects_auto is run with what was chosen, and with all that was left out switched on as well.
"""

import tomllib
from pathlib import Path

import jax
import numpy as np
import pytest

import astroinertia
from astroinertia.build.assemble import prepare
from astroinertia.scene.auto import accuracy_of
from astroinertia.scene.load import load_file
from astroinertia.scene.options import effect_options
from tests.evolve import reached

SCENES = Path(__file__).parent.parent / "data" / "effects_auto"
EXPECTED = tomllib.loads((SCENES / "expected.toml").read_text())
QUICK = ("crab_in_a_century", "cold_dust_before_its_bounce")
# Where switching off what looks small is itself a run that goes on; without pressure and viscosity the cloud is dust.
SMALL = {
    "cold_cloud_past_its_bounce": "viscosity",
    "star_that_cools_slowly": "cooling",
    "earth_in_a_century": "gravity_gradient",
    "crab_in_a_century": "dipole_braking",
    "tumbling_asteroid": "gravity_gradient",
    "thick_liquid_for_long": "shear_viscosity",
    "comet_past_jupiter": "tide",
}


def observables(scene):
    """I_zz and the angular velocity I^-1 L at the end."""
    with jax.enable_x64(True):
        prepared = prepare(scene)
        last = reached(prepared.evolution, prepared.outputs.end)[-1]
    inertia, momentum = np.asarray(last["inertia_tensor"]), np.asarray(last["angular_momentum"])
    return inertia[2, 2], np.linalg.solve(inertia, momentum)


def change(scene, one, other):
    """By what part they differ: I_zz, and the angular velocity of what turns at first, its direction included."""
    turns = scene.body.rotation is not None or scene.body.velocity_gradient is not None
    rotation = np.linalg.norm(other[1] - one[1]) / np.linalg.norm(one[1]) if turns else 0.0
    tensor = 0.0 if scene.model == "rigid" else abs(other[0] / one[0] - 1.0)  # of rigid bodies it only turns
    return max(rotation, tensor)


def with_the_others(scene):
    """The scene with what was left out switched on."""
    off = [kind for kind, reason in scene.reasons.items() if reason.startswith("off: ")]
    plain = {
        kind: effect_options({kind: {}}, scene.dimensionless)[kind] for kind in off if kind not in scene.candidates
    }
    added = {kind: scene.candidates.get(kind, plain.get(kind)) for kind in off}
    return scene.model_copy(update={"effects": {**scene.effects, **added}})


def without(scene, kind):
    kept = {other: options for other, options in scene.effects.items() if other != kind}
    return scene.model_copy(update={"effects": kept})


def compared(name):
    scene = load_file(SCENES / f"{name}.toml")
    assert set(scene.effects) == set(EXPECTED[name]["on"])
    chosen = observables(scene)
    more = change(scene, chosen, observables(with_the_others(scene)))
    small = SMALL.get(name)
    less = None if small is None else change(scene, chosen, observables(without(scene, small)))
    return accuracy_of(scene), more, less


@pytest.mark.parametrize("name", QUICK)
def test_what_is_left_out_is_less_than_asked_and_what_looks_small_is_more(name):
    asked, more, less = compared(name)
    assert more < asked
    assert less is None or less > asked


@pytest.mark.full
@pytest.mark.parametrize("name", [name for name in EXPECTED if name not in QUICK])
def test_the_same_of_the_longer_scenes(name, result):
    asked, more, less = compared(name)
    result(asked=asked, left_out=more, small_looking=less)
    assert more < asked
    assert less is None or less > asked


def test_a_run_keeps_the_reasons_in_its_file(tmp_path):
    scene = load_file(SCENES / "crab_in_a_century.toml")
    attributes = str(astroinertia.open(astroinertia.run_scene(scene, tmp_path / "crab")).attrs)
    assert "dipole_braking: on: torque over L omega" in attributes and "constant_torque: off: " in attributes
