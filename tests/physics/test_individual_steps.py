"""Individual time steps keep the ledger as global ones do, and come to the same answer."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from astroinertia.build.assemble import prepare
from astroinertia.build.sph import resumed
from astroinertia.errors import SceneError
from astroinertia.models.checkpoint import flattened
from astroinertia.models.sph import block_step, subcycle
from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS, Particles
from astroinertia.models.sph.record import energy_budget, works_from_outside
from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.step import step
from astroinertia.scene import load
from astroinertia.scene.plan import code_units
from astroinertia.sph import rung_costs
from tests.evolve import prepared, reached

pytestmark = pytest.mark.usefixtures("steps_differ")

EVRARD = Path(__file__).parent.parent.parent / "sims" / "evrard.toml"
SETTINGS = ["body.placement=random", "numerics.precision=float64", "numerics.timesteps=individual"]


def start(*settings: str) -> Particles:
    body = prepare(load.load_file(EVRARD, [*SETTINGS, *settings])).evolution
    assert isinstance(body, Particles)
    return body


def advanced(body: Particles, end: float, every: float) -> list[dict]:
    """Records at every multiple of `every`, with the largest sum |m v| so far."""
    records = [body.record(None)]
    opening, largest = records[0]["potential_energy"], 0.0
    while body.time < end * (1 - 1e-12):
        until = min(end, (np.floor(body.time / every * (1 + 1e-12)) + 1) * every)
        while body.time < until * (1 - 1e-14):
            body.advance(until)
            speed = np.linalg.norm(body.state.velocity, axis=1)
            largest = max(largest, float(body.state.mass @ speed))
        records.append(body.record(opening) | {"largest_momentum": largest, "note": body.note})
    return records


def test_a_collapse_keeps_the_ledger_and_comes_to_the_same_shape(monkeypatch: pytest.MonkeyPatch) -> None:
    """Evrard's collapse through its bounce: as with global steps, with fewer evaluations.

    A base step ends before its time where the steps of few particles would be twice as many.
    """
    ends_early, early = block_step._ends_early, []
    monkeypatch.setattr(block_step, "_ends_early", lambda *which: early.append(ends_early(*which)) or early[-1])
    one, other = (advanced(start("body.particles=200", choice), 1.2, 0.1) for choice in (
        "numerics.timesteps=individual", "numerics.timesteps=global"
    ))  # fmt: skip
    first, last = one[0], one[-1]
    assert 1 <= sum(early) < len(early) / 4
    energy = abs(first["total_energy"])
    assert np.linalg.norm(last["momentum"] - first["momentum"]) <= 1e-13 * last["largest_momentum"]
    assert np.abs(last["angular_momentum"] - first["angular_momentum"]).max() <= 1e-13
    assert max(record["ledger_closure"] for record in one) <= 1e-13
    lost = last["total_energy"] - first["total_energy"]
    assert abs(lost - last["integration_energy_error"]) <= 1e-13 * energy
    assert max(abs(r["total_energy"] - first["total_energy"]) for r in one) <= 1e-3 * energy
    assert max(last["virial_mismatch"]) <= 1e-12
    assert max(float(record["note"].split()[-1]) for record in one[1:]) > 2.0
    for mine, theirs in zip(one, other, strict=True):
        assert mine["time"] == pytest.approx(theirs["time"], rel=1e-12)
        assert mine["inertia_tensor"][2, 2] == pytest.approx(theirs["inertia_tensor"][2, 2], rel=2e-3)


def test_one_rung_for_all_is_the_global_step() -> None:
    """With a longest step that all particles can take, both schemes are the same to round-off: in gas that is driven
    together, with the heat of viscosity that a trace-free stress keeps.
    """
    body = start("body.particles=200", "numerics.max_timestep=1e-3", "effects.viscosity.stress=trace_free")
    state, arrangement = rearranged(body.problem, body.state)
    noise = np.random.default_rng(3).normal(size=(200, 3))
    mine = theirs = replace(state, velocity=0.3 * noise - 2.0 * state.position)
    for _ in range(5):
        mine, _, taken = block_step.step(body.problem, arrangement, mine, 1.0)
        theirs = step(body.problem, arrangement, theirs, theirs.rates.timestep)
        assert taken.counts.tolist() == [200]
    for name in ("time", "position", "velocity", "smoothing_length"):
        np.testing.assert_allclose(getattr(mine, name), getattr(theirs, name), rtol=1e-11, atol=1e-13, err_msg=name)
    np.testing.assert_allclose(mine.entropy, theirs.entropy, rtol=1e-7)
    for name in ("viscous_heating", "viscous_pressure"):
        assert theirs.memory[name].max() > 0.0
        np.testing.assert_allclose(mine.memory[name], theirs.memory[name], rtol=1e-6, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("scheme", ["global", "individual"])
def test_steps_are_no_longer_than_a_share_of_the_free_fall_time(scheme: str) -> None:
    """factor (G rho)^(-1/2) of the densest particle, which other limits of this cloud are far above at first."""
    body = start("body.particles=100", f"numerics.timesteps={scheme}", "numerics.free_fall_factor=1e-3")
    for _ in range(4):
        before, densest = body.time, float(np.max(body.state.rates.fluid.density))
        body.advance(1.0)
        assert body.time - before == pytest.approx(1e-3 / np.sqrt(densest), rel=1e-9)


def test_what_is_taken_out_of_the_body_moves_as_it_would_within(monkeypatch: pytest.MonkeyPatch) -> None:
    """A base step with as many parts taken out as there can be, and with none: the same to round-off."""
    taken = []
    part_of = subcycle.part_of
    monkeypatch.setattr(subcycle, "part_of", lambda block, depth: taken.append(depth) or part_of(block, depth))
    ends = []
    for share in (0.9, 0.0):
        monkeypatch.setattr(subcycle, "PART", share)
        monkeypatch.setattr(subcycle, "WORTH", 0)
        body = start("body.particles=300")
        while body.time < 0.6:
            body.advance(1.0)
        ends.append((body.state, len(taken)))
    (one, parts), (other, same) = ends
    assert 0 < parts == same
    for name in ("time", "position", "velocity", "smoothing_length", "entropy"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-9, atol=1e-11, err_msg=name)


def test_steps_of_one_interval_for_all_are_sorted_as_rarely_as_global_ones_and_go_on_the_same() -> None:
    settings = [*SETTINGS, "body.particles=200", "numerics.max_timestep=1e-3"]
    scene, whole, states, pauses = load.load_file(EVRARD, settings), start(*settings), {}, []
    for number in range(STEPS_BETWEEN_SORTS + 4):
        if whole.resumable:
            pauses.append(number)
            states[number] = {name: array.copy() for name, array in whole.arrays().items()}
        whole.advance(1.0)
    assert pauses == [0, STEPS_BETWEEN_SORTS]
    again = resumed(scene, code_units(scene), states[STEPS_BETWEEN_SORTS])
    assert again.resumable
    while again.steps < whole.steps:
        again.advance(1.0)
    for name, array in flattened(whole.state).items():
        np.testing.assert_array_equal(array, flattened(again.state)[name], err_msg=name)


def test_the_same_bits_again_and_after_a_checkpoint() -> None:
    scene = load.load_file(EVRARD, [*SETTINGS, "body.particles=200"])
    whole, again = start("body.particles=200"), start("body.particles=200")
    for _ in range(12):
        whole.advance(1.0)
    for _ in range(6):
        again.advance(1.0)
    again = resumed(scene, code_units(scene), {name: array.copy() for name, array in again.arrays().items()})
    for _ in range(6):
        again.advance(1.0)
    for name, array in flattened(whole.state).items():
        np.testing.assert_array_equal(array, flattened(again.state)[name], err_msg=name)


EXTERNAL = """
[effects.rotating_frame]
rate = 0.4
[effects.tide]
mass = 3.0
position = [4.0, 1.0, 0.0]
period = 10.0
[effects.damping]
time_scale = 3.0
[effects.target_tensor]
stiffness = 0.3
axis_ratios = [2.0, 1.0, 1.0]
[effects.cooling]
time_scale = 2.0
heating_rate = 0.1
"""
SHEAR = """
[effects.shear_viscosity]
kinematic_viscosity = 0.003
"""


# With a further pair force, whose loops are compiled for this alone: test-full.
@pytest.mark.parametrize(
    "shear", ["", pytest.param(SHEAR, marks=pytest.mark.full)], ids=["without shear", "with shear"]
)
def test_the_ledger_closes_with_effects_from_outside_and_on_the_whole_body(
    shear: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From a rotating frame to cooling: closure, and an owner for every loss of energy.

    Steps differ in each base step, as no time is to be met: those for all, as before such a time, have heat by its
    rate, which is work but for the error of the step (2.4e-5 with 4 of 28).
    """
    monkeypatch.setattr(rung_costs, "PAYS", 0.0)
    path = tmp_path / "scene.toml"
    path.write_text(EVRARD.read_text() + EXTERNAL + shear)
    body = prepare(load.load_file(path, [*SETTINGS, "body.particles=300"])).evolution
    assert isinstance(body, Particles)
    first = body.record(None)
    while body.time < 0.8:
        body.advance(body.end)
    last = body.record(first["potential_energy"])
    names = list(body.effects)
    assert last["ledger_closure"] <= 1e-13
    # The tide's potential moves: what it gives comes from outside, like what is damped, heated and drawn to a shape.
    outside = works_from_outside(body.problem, energy_budget(body.problem, body.state)["potential"])
    owned = (last["work"] + last["heating"])[outside].sum() + last["integration_energy_error"]
    held = [
        sum(each[name] for name in ("kinetic_energy", "internal_energy", "potential_energy")) for each in (first, last)
    ]
    assert abs(held[1] - held[0] - owned) <= 1e-12 * abs(held[0])
    coriolis = np.linalg.norm(last["impulse"][names.index("target_tensor")])
    assert coriolis <= 1e-13
    assert last["heating"][names.index("cooling")] > 1e-2  # cold gas, which is heated
    if shear:
        viscosity = names.index("shear_viscosity")
        assert last["heating"][viscosity] == pytest.approx(-last["work"][viscosity], rel=1e-12)
        assert last["heating"][viscosity] > 1e-3


BALL = """
[[bodies]]
kind = "uniform"
particles = 120
mass = 1.0
radius = 1.0
relax = false
specific_internal_energy = {energy}
position = [{side}3.2, {aside}, 0.0]
velocity = [{other}1.0, 0.0, 0.0]
"""
COLLISION = (
    'name = "collision"\nunits = "code"\n'
    + BALL.format(energy=0.01, side="-", other="", aside=0.0)
    + BALL.format(energy=0.1, side="", other="-", aside=0.1)
    + '[equation_of_state]\nkind = "ideal"\n[effects.pressure]\n[effects.viscosity]\n[time]\nend = 30.0\n'
)


def test_what_is_on_its_way_is_met_as_with_global_steps() -> None:
    """Balls that collide at Mach 6 and 19, in a base step that began long before, are heated as with global ones.

    Heat is right to 0.1 %; with a contact that is looked for only once within the interval up to it, to 2.4 %.
    """
    heat = {}
    for scheme in ("global", "individual"):
        body = prepared(COLLISION, f"numerics.timesteps={scheme}")
        first, last = reached(body, 3.2)
        heat[scheme] = last["internal_energy"]
    assert heat["global"] > 2.5 * first["internal_energy"]
    assert heat["individual"] == pytest.approx(heat["global"], rel=5e-3)


def test_the_xla_engine_refuses_them() -> None:
    with pytest.raises(SceneError, match="needs the engine numba_cpu"):
        load.load_file(EVRARD, ["numerics.engine=xla", "numerics.timesteps=individual"])
