"""Sinks keep the ledger of what they accrete, and accrete what theory says."""

import tracemalloc
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import astroinertia
from astroinertia import plots
from astroinertia.build.assemble import prepare
from astroinertia.build.sph import resumed
from astroinertia.cli.main import main
from astroinertia.errors import NumericalError, SceneError
from astroinertia.models.sph import accretion
from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS
from astroinertia.models.sph.record import energy_budget
from astroinertia.models.sph.sinks import no_sinks
from astroinertia.orbits.particles import of_snapshot
from astroinertia.scene import load
from astroinertia.scene.plan import code_units
from astroinertia.studies.angular_momentum import angular_momentum_spectrum
from astroinertia.studies.moments import moments, read_matter
from astroinertia.studies.moments_series import moments_series
from tests.evolve import prepared, reached

pytestmark = pytest.mark.usefixtures("steps_differ")

NAME = 'name = "sinks"\nunits = "code"\n'
PHYSICS = """
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[effects.gravity]
[effects.pressure]
[effects.viscosity]
[time]
end = 30.0
"""
TURNING = """
[body]
kind = "power_law"
exponent = 1.0
particles = 400
mass = 1.0
radius = 1.0
relax = false
specific_internal_energy = 0.02
rotation = { law = "rigid", rate = 0.3 }
velocity_gradient = [[-0.2, 0.0, 0.0], [0.0, -0.1, 0.0], [0.0, 0.0, 0.1]]
"""
CLOUD = NAME + TURNING + PHYSICS + "[effects.sinks]\ndensity = 10.0\nradius = 0.25\nsoftening = 0.02\n"


def moment_vector(tensor: np.ndarray) -> np.ndarray:
    return np.array([tensor[1, 2] - tensor[2, 1], tensor[2, 0] - tensor[0, 2], tensor[0, 1] - tensor[1, 0]])


@pytest.mark.parametrize("timesteps", [pytest.param("global", marks=pytest.mark.full), "individual"])
def test_fluid_and_sinks_keep_mass_momentum_and_angular_momentum(timesteps: str) -> None:
    """A turning cloud collapses into a sink, which takes most of it and spins: all ledgers close to round-off."""
    body = prepared(CLOUD, f"numerics.timesteps={timesteps}")
    first, last = reached(body, 0.9)
    assert last["sink_number"] == 1.0
    assert 0.3 < np.nansum(last["sink_mass"]) < 0.9
    assert last["mass"] + np.nansum(last["sink_mass"]) == pytest.approx(first["mass"], rel=1e-13)
    assert last["accreted_mass"] == pytest.approx(np.nansum(last["sink_mass"]), rel=1e-13)
    assert np.abs(last["system_momentum"] - first["system_momentum"]).max() <= 1e-14
    turning = np.linalg.norm(first["system_angular_momentum"])
    assert np.abs(last["system_angular_momentum"] - first["system_angular_momentum"]).max() <= 1e-13 * turning
    assert np.nansum(last["sink_spin"], axis=0)[2] > 0.1 * turning
    assert last["ledger_closure"] <= 1e-13
    assert max(last["virial_mismatch"]) <= 1e-12
    # What the fluid's angular momentum lost has an owner, too: the rows of the effects, accretion among that of sinks.
    gained = last["angular_momentum"] - first["angular_momentum"]
    assert np.abs(gained - moment_vector(last["mixed_impulse"].sum(axis=0))).max() <= 1e-13 * turning
    taken = moment_vector(last["accreted_mixed_moment"])
    assert np.linalg.norm(taken) > 0.5 * np.linalg.norm(gained)
    energy = abs(first["total_energy"])
    assert abs(last["total_energy"] - first["total_energy"]) <= 5e-3 * energy
    lost = last["total_energy"] - first["total_energy"] - last["integration_energy_error"]
    assert abs(lost) <= 1e-12 * energy


@pytest.mark.full
@pytest.mark.parametrize("part", ["second_moment", "mixed_moment", "shift"])
def test_the_ledger_does_not_close_without_a_row_of_what_sinks_took(part: str, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = accretion.removed

    def without(body: Any, mass: Any, position: Any, velocity: Any) -> Any:
        found = whole(body, mass, position, velocity)
        if part != "shift":
            return replace(found, **{part: 0.0 * getattr(found, part)})
        x = position - body.centre
        return replace(found, second_moment=(mass[:, None] * x).T @ x)

    monkeypatch.setattr(accretion, "removed", without)
    _, last = reached(prepared(CLOUD), 0.6)
    assert last["sink_number"] == 1.0
    assert last["ledger_closure"] > 1e-8


COLD = """
[body]
kind = "power_law"
exponent = 2.0
particles = 1000
mass = 1.0
radius = 1.0
relax = false
specific_internal_energy = 1e-9
"""


def fallen(time: float, radius: float) -> float:
    """The mass within a radius at that time, of a cold sphere rho ~ r^-2 with M = R = G = 1 that began at rest.

    A shell from r falls freely, (r^3/2M)^(1/2) (arccos x^(1/2) + (x (1 - x))^(1/2)) to x r, and M = r within it.
    """
    shells = np.linspace(radius, 1.0, 20000)
    x = radius / shells
    return float(np.interp(time, np.sqrt(shells**2 / 2) * (np.arccos(np.sqrt(x)) + np.sqrt(x * (1 - x))), shells))


@pytest.mark.full
@pytest.mark.parametrize("timesteps", ["global", "individual"])
def test_a_cold_collapse_is_accreted_as_it_falls(timesteps: str) -> None:
    """Without pressure, mass arrives at the sink's radius when theory has it there.

    With 1000 particles the mass was off by up to 0.3% of the whole (three particles, or one base step), with 3000 and a
    radius of 0.1 by 0.2%.
    """
    physics = PHYSICS.replace("[effects.viscosity]", "[effects.viscosity]\nalpha_max = 1e-9\nbeta = 0.0")
    text = NAME + COLD + physics + "[effects.sinks]\ndensity = 6.0\nradius = 0.15\nsoftening = 0.02\n"
    body = prepared(text, f"numerics.timesteps={timesteps}")
    for time in (0.3, 0.6, 0.9):
        while body.time < time * (1 - 1e-14):
            body.advance(time)
        record = body.record(0.0)
        assert record["sink_number"] == 1.0
        assert record["accreted_mass"] == pytest.approx(fallen(time, 0.15), abs=6e-3)
        assert record["ledger_closure"] <= 1e-13
        assert np.linalg.norm(record["sink_position"][0]) <= 6e-3


BALL = """
[[bodies]]
kind = "power_law"
exponent = 1.0
particles = 150
mass = 0.5
radius = 0.5
relax = false
specific_internal_energy = 0.01
"""
TWO = "".join(
    f"{BALL}position = [{side}, 0.0, 0.0]\nvelocity = [0.0, {0.35 * side}, {0.1 * side}]\n" for side in (1.0, -1.0)
)


@pytest.mark.parametrize("timesteps", ["global", "individual"])
def test_two_clouds_become_two_sinks_that_pull_at_each_other(timesteps: str) -> None:
    """Two sinks, and what is left around them, keep the momentum and the angular momentum of all."""
    text = NAME + TWO + PHYSICS + "[effects.sinks]\ndensity = 4.0\nradius = 0.35\nsoftening = 0.02\n"
    text += "[regions.dense]\ndensity_above = 0.2\n"
    body = prepared(text, f"numerics.timesteps={timesteps}")
    first, last = reached(body, 0.33)
    assert last["sink_number"] == 2.0
    assert np.nansum(last["sink_mass"]) > 0.5
    moved = last["sink_velocity"][0] * np.sign(last["sink_position"][0, 0])
    assert moved[0] < -0.02  # towards each other
    turning = np.linalg.norm(first["system_angular_momentum"])
    assert np.abs(last["system_angular_momentum"] - first["system_angular_momentum"]).max() <= 1e-13 * turning
    assert np.abs(last["system_momentum"] - first["system_momentum"]).max() <= 1e-14
    assert last["ledger_closure"] <= 1e-13
    # What a region lost to sinks is among what crossed its edge.
    assert last["region_flux_mass"][0] < -0.4
    assert last["region_ledger_closure"][0] <= 1e-12


HALO = """
[[bodies]]
kind = "power_law"
exponent = 1.0
particles = 60
mass = 0.05
radius = 0.5
relax = false
specific_internal_energy = 1.0
position = [0.0, 2.0, 0.0]
"""
MEETING = NAME + HALO + PHYSICS + "[effects.sinks]\ndensity = 4.0\nradius = 0.35\nsoftening = 0.02\n"
MEETING += "".join(
    f"{BALL}position = [{0.6 * side}, 0.0, 0.0]\nvelocity = [0.0, {0.1 * side}, {0.05 * side}]\n"
    for side in (1.0, -1.0)
)


@pytest.mark.parametrize("timesteps", ["global", "individual"])
def test_two_sinks_that_meet_become_one_that_spins(timesteps: str) -> None:
    """Mass, momentum, angular momentum and energy stay through the merger; the orbit is the spin of the older sink."""
    body, energies = prepared(MEETING, f"numerics.timesteps={timesteps}"), []

    def between(problem: Any, arrangement: Any, state: Any) -> Any:
        done = accretion.step(problem, arrangement, state)
        energies.append([energy_budget(problem, each)["total"] for each in (state, done[0])])
        return done

    body.between, first = between, body.record(None)
    while body.state.points["sinks"].formed < 2:
        body.advance(3.0)
    while len(body.state.points["sinks"].mass) == 2 and body.time < 2.0:
        before, saved = body.record(first["potential_energy"]), body.arrays() if body.resumable else {}
        body.advance(3.0)
        if saved:
            kept = {name: array.copy() for name, array in saved.items()}
    last = body.record(first["potential_energy"])
    assert 1.2 < body.time < 1.6
    assert before["sink_number"] == 2.0
    assert last["sink_number"] == 1.0
    assert np.isfinite(last["sink_mass"]).tolist() == [True] + 15 * [False]
    assert last["sink_mass"][0] == pytest.approx(np.nansum(before["sink_mass"]), rel=1e-12)
    assert last["mass"] + last["sink_mass"][0] == pytest.approx(first["mass"], rel=1e-12)
    assert np.abs(last["system_momentum"] - first["system_momentum"]).max() <= 1e-14
    turning = np.linalg.norm(first["system_angular_momentum"])
    assert np.abs(last["system_angular_momentum"] - first["system_angular_momentum"]).max() <= 1e-12 * turning
    assert np.linalg.norm(last["sink_spin"][0]) > 0.9 * turning
    assert np.linalg.norm(np.nansum(before["sink_spin"], axis=0)) < 0.1 * turning
    assert last["ledger_closure"] <= 1e-13
    energy = abs(first["total_energy"])
    assert abs(energies[-1][1] - energies[-1][0]) <= 1e-12 * energy
    assert abs(last["total_energy"] - first["total_energy"] - last["integration_energy_error"]) <= 1e-12 * energy
    # A run that was ended with two sinks ends with the same bits.
    scene = load.loads(MEETING, [f"numerics.timesteps={timesteps}"])
    again = resumed(scene, code_units(scene), kept)
    assert len(again.state.points["sinks"].mass) == 2
    while again.steps < body.steps:
        again.advance(3.0)
    one, other = body.arrays(), again.arrays()
    for name, array in one.items():
        np.testing.assert_array_equal(array, other[name], err_msg=name)


def test_sinks_that_are_not_to_merge_stay_two() -> None:
    body = prepared(MEETING, 'effects.sinks.merging="never"')
    while body.time < 1.6:
        body.advance(1.6)
    assert body.record(None)["sink_number"] == 2.0


@pytest.mark.parametrize("timesteps", [pytest.param("global", marks=pytest.mark.full), "individual"])
def test_a_run_with_a_sink_resumes_bit_for_bit(timesteps: str) -> None:
    """From a checkpoint with a sink, through more accretion, to the same bits."""
    scene = load.loads(CLOUD, [f"numerics.timesteps={timesteps}", "body.particles=200"])
    bodies = [prepare(scene).evolution for _ in range(2)]
    steps = STEPS_BETWEEN_SORTS if timesteps == "individual" else 2 * STEPS_BETWEEN_SORTS
    for body in bodies:
        for _ in range(steps):
            body.advance(30.0)
    assert bodies[1].record(None)["sink_number"] == 1.0
    bodies[1] = resumed(scene, code_units(scene), {name: array.copy() for name, array in bodies[1].arrays().items()})
    grown = []
    for body in bodies:
        grown.append(len(body.state.mass))
        for _ in range(STEPS_BETWEEN_SORTS // 2):
            body.advance(30.0)
        grown[-1] -= len(body.state.mass)
    assert grown[0] > 0
    one, other = (body.arrays() for body in bodies)
    assert one.keys() == other.keys()
    for name, array in one.items():
        np.testing.assert_array_equal(array, other[name], err_msg=name)


def test_the_dataset_has_sinks_and_the_rate_of_accretion(tmp_path: Path) -> None:
    """Series of sinks with their accretion rate, and snapshots in which accreted particles are absent."""
    settings = ["body.particles=200", "time.end=0.7", "output.series_every=0.05", "output.snapshot_every=0.35"]
    tree = astroinertia.open_tree(astroinertia.run_scene(load.loads(CLOUD, settings), tmp_path / "run"))
    series, snapshots = tree["/"].dataset, tree["/snapshots"].dataset
    assert series["sink_mass"].dims == ("time", "sink")
    gained = (series["accretion_rate"][1:] * series["time"].diff("time").values).sum()
    assert float(gained) == pytest.approx(float(series["accreted_mass"][-1]), rel=1e-12)
    assert float(series["accreted_mass"][-1]) > 0.1
    absent = np.isnan(snapshots["density"].values).sum(axis=1)
    assert absent[0] == 0
    assert absent[-1] / 200 == pytest.approx(float(series["accreted_mass"][-1]), rel=1e-9)
    # What is left is drawn and summed.
    tensors = moments_series(snapshots)["inertia_tensor"].values
    taken = series["time"].values.searchsorted(snapshots["snapshot_time"].values)
    np.testing.assert_allclose(tensors, series["inertia_tensor"].values[taken], rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(moments(read_matter(tmp_path / "run"))["inertia_tensor"], tensors[-1], atol=1e-14)
    assert np.isfinite(angular_momentum_spectrum(snapshots)).all()
    assert 200 - absent[-1] == of_snapshot(snapshots.isel(snapshot_time=-1), 1.0).N
    for command in (["show", "--only", "density"], ["view"], ["report"], ["movie"]):  # a report has all pictures
        assert main([*command, str(tmp_path / "run")]) == 0, command


@pytest.mark.parametrize(
    ("settings", "more", "message"),
    [
        (["numerics.engine=xla"], "", "needs the engine numba_cpu"),
        (["effects.sinks.radius=0.05"], "", "radius must be at least .* times as large"),
        ([], "[effects.rotating_frame]\nrate = 0.1\n", "rotating_frame. acts on the fluid alone"),
        (
            [],
            '[effects.companions]\n[[companions]]\nname = "moon"\nmass = 0.1\nsemi_major_axis = 8.0\n',
            'only if their motion is "live"',
        ),
    ],
)
def test_what_sinks_cannot_do_is_refused_in_one_sentence(settings: list[str], more: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        prepared(CLOUD + more, *settings)


def test_too_many_sinks_end_a_run_with_a_reason() -> None:
    text = NAME + TWO + PHYSICS + "[effects.sinks]\ndensity = 4.0\nradius = 0.35\nnumber = 1\n"
    with pytest.raises(NumericalError, match=r"raise .effects.sinks. number"):
        reached(prepared(text), 0.9)


@pytest.mark.parametrize("timesteps", ["global", "individual"])
def test_a_run_whose_gas_is_accreted_ends_with_a_result_that_says_so(timesteps: str, tmp_path: Path, capsys) -> None:
    """A few particles stay, mass and angular momentum are all there, and to go on with the run leaves the same file."""
    (tmp_path / "cloud.toml").write_text(CLOUD)
    settings = ["body.particles=200", f"numerics.timesteps={timesteps}", "output.series_every=0.2"]
    options = [option for setting in settings for option in ("--set", setting)]
    assert main(["run", str(tmp_path / "cloud.toml"), "--output", str(tmp_path / "run"), *options]) == 0
    assert "before its end: all but 8 particles of the gas have been accreted" in capsys.readouterr().out
    file = next((tmp_path / "run").glob("*.nc"))
    series = astroinertia.open(file)
    assert 0.5 < float(series["time"][-1]) < 29.0
    assert float(series["mass"][-1]) == pytest.approx(0.04, rel=1e-12)
    whole = series["mass"] + series["sink_mass"].sum("sink")
    np.testing.assert_allclose(whole, float(whole[0]), rtol=1e-12)
    turning = series["system_angular_momentum"].values
    assert np.abs(turning - turning[0]).max() <= 1e-13 * np.linalg.norm(turning[0])
    np.testing.assert_array_less(series["ledger_closure"], 1e-13)
    assert "Over before its end: all but 8 particles of the gas have been accreted." in plots.summary(series)
    written = file.read_bytes()
    assert main(["resume", str(tmp_path / "run")]) == 0
    assert main(["resume", str(tmp_path / "run"), "--set", "time.end=60.0"]) == 2
    assert "can go no further: all but 8 particles of the gas have been accreted." in capsys.readouterr().err
    assert file.read_bytes() == written


@pytest.mark.parametrize(
    ("settings", "number"), [([], 8), (["numerics.neighbours=200"], 22), (["numerics.kernel=quintic"], 9)]
)
def test_what_is_accreted_last_is_what_is_farthest(
    settings: list[str], number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 200 particles that all collapse at once, those farthest from the densest stay, for all to have a length."""
    body = prepared(CLOUD, "body.particles=200", "effects.sinks.radius=0.4", *settings)
    state = body.state
    densest = int(np.argmax(state.rates.fluid.density))
    order = np.concatenate([[densest], np.delete(np.arange(200), densest)])
    monkeypatch.setattr(accretion, "_new_sink", lambda *_: order)
    after, _ = accretion.step(body.problem, body.arrangement, state)
    away = np.linalg.norm(state.position - state.position[densest], axis=1)
    assert set(after.identity) == set(state.identity[np.argsort(away)[-number:]])
    assert body.over == ""
    body.state = after
    assert body.over == f"all but {number} particles of the gas have been accreted"
    assert after.points["sinks"].mass.sum() + after.mass.sum() == pytest.approx(state.mass.sum(), rel=1e-13)


def test_a_sink_accretes_what_is_bound_to_it_and_can_come_down() -> None:
    """Within the radius: at rest, too fast, too much angular momentum, and both but very near; and outside."""
    sink = replace(no_sinks(0.0, 10), mass=np.ones(1), position=np.zeros((1, 3)), velocity=np.zeros((1, 3)))
    place = np.array([[0.5, 0, 0], [0.5, 0, 0], [0.9, 0, 0], [0.05, 0, 0], [1.1, 0, 0]])
    speed = np.array([[0.0, 0, 0], [2.1, 0, 0], [0, 1.2, 0], [9.0, 0, 0], [0.0, 0, 0]])
    assert accretion.bound_to(sink, 1.0, place, speed).tolist() == [0, -1, -1, 0, -1]
    # Of two sinks, the one that it is bound to most.
    both = replace(
        sink, mass=np.array([1.0, 3.0]), position=np.array([[0.0, 0, 0], [1, 0, 0]]), velocity=np.zeros((2, 3))
    )
    assert accretion.bound_to(both, 1.0, place[:1], speed[:1]).tolist() == [1]


def test_bound_sinks_within_the_radius_become_the_older_one_the_closest_first() -> None:
    """Of two triples, one unites step by step; of the other, one is too fast to be bound and one too far away."""
    random = np.random.default_rng(4)
    near = 0.2 * random.normal(size=(3, 3))
    place = np.concatenate([near, [[9.0, 0, 0], [9.2, 0, 0], [10.1, 0, 0]]])
    speed = 0.3 * random.normal(size=(6, 3))
    speed[4] += [0.0, 9.0, 0.0]
    nothing = no_sinks(0.1, 10)
    mass, spin = random.uniform(0.5, 1.5, 6), random.normal(size=(6, 3))
    six = replace(nothing, mass=mass, position=place, velocity=speed, spin=spin, identity=np.arange(6), formed=6)
    left = accretion.united(six, 1.0)
    assert left.identity.tolist() == [0, 3, 4, 5]
    assert left.formed == 6
    for sinks in (six, left):
        assert sinks.mass.sum() == pytest.approx(mass.sum(), rel=1e-12)
        np.testing.assert_allclose(sinks.mass @ sinks.position, mass @ place, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(sinks.mass @ sinks.velocity, mass @ speed, rtol=1e-12, atol=1e-12)
        moment = (sinks.mass[:, None] * np.cross(sinks.position, sinks.velocity) + sinks.spin).sum(axis=0)
        np.testing.assert_allclose(moment, (mass[:, None] * np.cross(place, speed) + spin).sum(axis=0), rtol=1e-12)
    apart = accretion.united(six, 0.01)
    assert apart is six


def test_a_sink_forms_beside_denser_matter_that_does_not_collapse() -> None:
    """What is too hot to become a sink, and denser than what collapses elsewhere, does not keep that from doing so."""
    hot = BALL.replace("0.01", "1.0").replace("radius = 0.5", "radius = 0.2") + "position = [6.0, 0.0, 0.0]\n"
    text = NAME + BALL + "position = [-6.0, 0.0, 0.0]\n" + hot + PHYSICS
    text += "[effects.sinks]\ndensity = 4.0\nradius = 0.35\nsoftening = 0.02\n"
    body = prepared(text)
    while not len(body.state.points["sinks"].mass) and body.time < 0.5:
        beside, density = body.state.position[:, 0] > 0.0, body.state.rates.fluid.density
        body.advance(0.5)
    assert body.state.points["sinks"].position[:, 0] == pytest.approx([-6.0], abs=0.1)
    assert density[beside].max() > 3.0 * density[~beside].max()
    assert density[~beside].max() < 4.0 * 1.5


def test_peaks_are_the_densest_within_the_radius() -> None:
    random = np.random.default_rng(2)
    place, density = random.normal(size=(300, 3)), random.permutation(300) + 1.0
    near = np.linalg.norm(place[:, None] - place[None], axis=-1) <= 0.8
    expected = np.flatnonzero(np.where(near, density, 0.0).max(axis=1) == density)
    assert 5 < len(expected) < 100
    assert list(accretion.peaks(density, place, 0.8)) == sorted(expected, key=lambda k: -density[k])


def test_what_binds_many_particles_is_summed_in_little_memory() -> None:
    """Points on a line, one apart, have n - d pairs at each distance d; two in one place do not count."""
    count = 2000
    place = np.zeros((count, 3))
    place[:, 0] = np.arange(count)
    steps = np.arange(1, count)
    expected = ((count - steps) / steps).sum()
    tracemalloc.start()
    try:
        found = accretion.binding_energy(np.ones(count), place)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert found == pytest.approx(expected, rel=1e-13)
    assert peak < 0.5 * 8 * count**2
    twice = accretion.binding_energy(np.array([1.0, 2.0, 3.0]), np.array([[0.0, 0, 0], [0, 0, 0], [0, 0, 2.0]]))
    assert twice == pytest.approx(0.5 * (3.0 + 6.0))


def test_each_condition_of_collapse_counts() -> None:
    random = np.random.default_rng(1)
    place = np.concatenate([np.zeros((1, 3)), random.normal(size=(60, 3))])
    mass, falling, cold = np.full(61, 1.0 / 61), -0.05 * place, np.full(61, 1e-3)
    assert accretion.collapses(mass, place, falling, -place, cold)
    assert not accretion.collapses(mass, place, -falling, -place, cold)  # it spreads
    assert not accretion.collapses(mass, place, falling, place, cold)  # it is torn apart
    assert not accretion.collapses(mass, place, falling, -place, 1e3 * cold)  # it is hot
    turning = falling + 2.0 * np.cross([0.0, 0.0, 1.0], place)
    assert not accretion.collapses(mass, place, turning, -place, cold)  # it turns
    assert not accretion.collapses(mass, place, 20.0 * falling, -place, cold)  # it is not bound
