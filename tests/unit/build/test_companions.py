"""Companions of a scene: from its tables, out of an archive, and acted on by the body."""

import jax
import numpy as np
import pytest
import rebound

from astroinertia.build import companions as start_companions, rigid as start_rigid, sph
from astroinertia.build.assemble import metadata
from astroinertia.build.companions import companions
from astroinertia.build.refusals import refuse_impossible
from astroinertia.errors import SceneError
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.scene import load
from astroinertia.scene.plan import code_units, plan
from tests.coupled import kept

SCENE = """
name = "pair"
model = "rigid"
units = "code"
[body]
kind = "rigid"
mass = 1.0
moments = [3.6e-4, 4.0e-4, 4.8e-4]
rotation = { rate = 2.5, axis = [0.1, 0.2, 1.0] }
[effects.gravity_gradient]
[numerics]
integrator = "splitting"
steps_per_rotation = 15
[time]
end = 2.0
"""
MOON = """
[[companions]]
name = "moon"
mass = 0.3
semi_major_axis = 1.0
eccentricity = 0.2
inclination = 0.3
"""


def evolution(text, origin=None):
    scene = load.loads(text, origin=origin)
    return start_rigid.evolution(scene, code_units(scene))


@pytest.mark.slow
def test_the_torque_of_a_scene_and_its_reaction():
    with jax.enable_x64(True):
        alone, coupled = evolution(SCENE + MOON), evolution(SCENE + MOON + "[orbits]\nback_reaction = true\n")
        momentum, _ = kept(coupled)
        records = []
        for body in (alone, coupled):
            body.advance(0.5)
            records.append(body.record(None))
        one, other = (record["angular_momentum"] for record in records)
        # The orbit's answer is of second order in the torque; the angular momentum of all is kept.
        assert 1e-12 < np.abs(one - other).max() < 1e-2 * np.abs(one).max()
        assert np.abs(kept(coupled)[0] - momentum).max() < 1e-15 * np.linalg.norm(momentum)


@pytest.mark.slow
def test_a_run_that_steps_may_end_has_its_first_orbits_and_finds_the_others_when_it_comes_there(monkeypatch):
    """In outputs and between them, as a branch, and as the bits of the same run that is resumed on either side."""
    monkeypatch.setattr(start_companions, "AT_FIRST", 0.9)
    limited = SCENE + "max_steps = 9\n" + MOON
    times = np.linspace(0.0, 1.5, 7)[1:]
    with jax.enable_x64(True):
        whole, brief, branch = evolution(SCENE + MOON), evolution(limited), evolution(limited)
        ends = [float(one.body.companions.end) for one in (whole, brief)]
        assert ends[0] > 2.0 and 0.25 < ends[1] < 0.9
        met, part, saved = whole.through(times, 0.0, np.inf), [], []
        while len(part) < len(times):
            part += brief.through(times[len(part) :], 0.0, np.inf)
            saved.append((len(part), float(brief.body.companions.end), brief.arrays()))
        assert [end for _, end, _ in saved] == [ends[1], ends[0], ends[0]] and len(met) == len(part)
        for one, other in zip(met, part, strict=True):
            np.testing.assert_array_equal(one["companion_position"], other["companion_position"])
            assert one["angular_momentum"] == pytest.approx(other["angular_momentum"], rel=1e-13)
        branch.begin(whole)
        assert branch.record(0.0)["companion_position"] == pytest.approx(met[-1]["companion_position"], rel=1e-14)
        for count, _, arrays in saved[:2]:
            resumed = evolution(limited)
            resumed.resume(arrays)
            assert np.isfinite(resumed.record(0.0)["companion_position"]).all()
            while count < len(times):
                count += len(resumed.through(times[count:], 0.0, np.inf))
            np.testing.assert_array_equal(brief.state.turning.total, resumed.state.turning.total)


@pytest.mark.slow
def test_whoever_comes_within_the_body_is_noticed_when_the_run_finds_the_orbits_to_there(monkeypatch):
    monkeypatch.setattr(start_companions, "AT_FIRST", 0.9)
    text = SCENE.replace("mass = 1.0\n", "mass = 1.0\nradius = 0.83\n")
    text += "max_steps = 9\n" + MOON + "mean_anomaly = 4.5\n"
    with jax.enable_x64(True):
        run = evolution(text)
        with pytest.raises(SceneError, match=r"moon comes within the body at 1\.\d"):
            run.advance(2.0)


@pytest.mark.full
def test_orbits_come_out_of_an_archive(tmp_path):
    moon = Companion("moon", 0.3, semi_major_axis=1.0, eccentricity=0.2, inclination=0.3)
    bodies = simulation(1.0, [moon])
    bodies.save_to_file(str(tmp_path / "orbits.bin"), interval=0.7)
    bodies.integrate(3.0)
    with jax.enable_x64(True):
        stated, found = evolution(SCENE + MOON), evolution(SCENE + '[orbits]\narchive = "orbits.bin"\n', str(tmp_path))
        for body in (stated, found):
            body.advance(2.0)
        assert np.asarray(found.state.quaternion) == pytest.approx(np.asarray(stated.state.quaternion), abs=1e-12)


def test_the_body_of_an_archive_may_be_any_of_its_particles_and_is_not_another(tmp_path):
    bodies = simulation(3e5, [Companion("planet", 1.0, semi_major_axis=50.0)])  # as most archives are: the star first
    bodies.save_to_file(str(tmp_path / "orbits.bin"), interval=0.7)
    bodies.integrate(3.0)
    orbits = '[orbits]\narchive = "orbits.bin"\n'
    unnamed = rebound.Simulation()
    unnamed.add(m=3e5)
    unnamed.add(m=1.0, a=50.0)
    unnamed.save_to_file(str(tmp_path / "unnamed.bin"), interval=0.7)
    unnamed.integrate(3.0)
    for file, which in (("orbits", "planet"), ("unnamed", "particle 1")):
        stated = f'[orbits]\narchive = "{file}.bin"\nbody = "{which}"\n'
        scene = load.loads(SCENE + stated, origin=str(tmp_path))
        refuse_impossible(scene)
        found = companions(scene, code_units(scene), 1.0)
        assert np.asarray(found.mass) == pytest.approx([3e5], rel=1e-12)
    for which, sentence in (
        ("", r"'body' has 3e\+05 of the body's mass, .* by orbits.body, of these: body, planet"),
        ('body = "moon"\n', "the archive has no particle moon"),
    ):
        text = f"{SCENE}{orbits}{which}"
        with pytest.raises(SceneError, match=sentence):
            refuse_impossible(load.loads(text, origin=str(tmp_path)))
        with pytest.raises(SceneError, match=sentence):
            evolution(text, str(tmp_path))


def test_companions_of_an_archive_keep_their_names(tmp_path):
    bodies = simulation(1.0, [Companion("moon", 0.3, semi_major_axis=1.0), Companion("sun", 9.0, semi_major_axis=30.0)])
    bodies.save_to_file(str(tmp_path / "orbits.bin"), interval=0.7)
    bodies.integrate(3.0)
    scene = load.loads(SCENE + '[orbits]\narchive = "orbits.bin"\n', origin=str(tmp_path))
    assert metadata(scene)["companions"] == ["moon", "sun"]
    said = [(line.name, line.value) for line in plan(scene).sections["companions"]]
    assert said == [("moon", "0.3"), ("sun", "9"), ("orbits", "from the archive orbits.bin")]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SCENE + '[orbits]\nbody = "sun"\n', "has body, which only archive uses"),
        (SCENE + "[orbits]\nback_reaction = true\n", "back_reaction needs companions"),
        (
            SCENE + MOON + '[orbits]\nback_reaction = true\nintegrator = "whfast"\n',
            "integrator and timestep are for orbits that the body does not act on",
        ),
        (
            SCENE.replace("[effects.gravity_gradient]", "[effects]") + MOON + "[orbits]\nback_reaction = true\n",
            "back_reaction needs the effect gravity_gradient",
        ),
        (SCENE + '[orbits]\narchive = "none.bin"\n', "archive: there is no archive none.bin"),
        (SCENE + MOON + '[orbits]\narchive = "none.bin"\n', "must not be given with it"),
    ],
)
def test_what_contradicts_is_refused_in_a_sentence(text, message):
    with pytest.raises(SceneError, match=message):
        evolution(text)


FLUID = """
name = "beside"
units = "code"
[body]
kind = "table"
file = "cloud.csv"
[equation_of_state]
kind = "ideal"
[effects.pressure]
[effects.companions]
motion = "MOTION"
softening = 0.1
[time]
end = 1.0
"""


@pytest.mark.parametrize("motion", ["live", "orbit"])
def test_a_body_of_particles_is_where_the_orbits_have_it_wherever_its_table_put_it(motion, tmp_path) -> None:
    """The centre of mass of all rests at 0, and the moon's orbit about the body has the elements of the scene."""
    rng = np.random.default_rng(4)
    mass, position, velocity = (
        rng.uniform(0.01, 0.02, 40),
        rng.normal(3.0, 0.2, (40, 3)),
        rng.normal(-2.0, 0.1, (40, 3)),
    )
    rows = np.column_stack([mass, position, velocity, np.full(40, 0.1)])
    np.savetxt(tmp_path / "cloud.csv", rows, "%.17g", ",", header="mass,x,y,z,vx,vy,vz,u", comments="")
    scene = load.loads(FLUID.replace("MOTION", motion) + MOON, origin=str(tmp_path))
    units = code_units(scene)
    state = sph.evolution(scene, units).state
    shares = state.mass / state.mass.sum()
    total, moon = units.to_code(mass.sum(), "mass"), units.to_code(0.3, "mass")
    body, drift = shares @ state.position, shares @ state.velocity
    there, speed = (
        np.asarray(each)[0] for each in (state.points["companions"].position, state.points["companions"].velocity)
    )
    np.testing.assert_allclose(total * body + moon * there, 0.0, atol=1e-14)
    np.testing.assert_allclose(total * drift + moon * speed, 0.0, atol=1e-14)
    apart, away = there - body, speed - drift
    assert away @ away / 2 - (total + moon) / np.linalg.norm(apart) == pytest.approx(-(total + moon) / 2, rel=1e-12)
    momentum = np.cross(apart, away)
    assert momentum @ momentum == pytest.approx((total + moon) * (1 - 0.2**2), rel=1e-12)
    assert momentum[2] / np.linalg.norm(momentum) == pytest.approx(np.cos(0.3), rel=1e-12)
