"""What cannot be beside sinks, or beside companions that move freely, is refused before anything is prepared."""

import re

import numpy as np
import pytest

from astroinertia.build import sph
from astroinertia.build.assemble import refuse_contradictions
from astroinertia.build.sinks import STORED, at_first
from astroinertia.errors import SceneError
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units, plan

CLOUD = """name = "cloud"
units = "code"
[body]
kind = "uniform"
particles = 100
mass = 1.0
radius = 1.0
placement = "random"
specific_internal_energy = 0.05
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = 1.0
"""
SINKS = "[effects.sinks]\ndensity = 10.0\nradius = 0.6\n"
MOON = '[[companions]]\nname = "moon"\nmass = 0.1\nsemi_major_axis = 8.0\n'
STARS = "[[sinks]]\nmass = 1.0\n[[sinks]]\nmass = 0.5\nposition = [2.0, 0.0, 0.0]\nvelocity = [0.0, 1.0, 0.0]\n"
LIVE = '[effects.companions]\nmotion = "live"\n' + MOON
FRAME = "[effects.rotating_frame]\nrate = 0.1\n"
TIDE = "[effects.tide]\nmass = 1.0\nposition = [9.0, 0.0, 0.0]\n"
WAVES = "[effects.radiation_reaction]\nspeed_of_light = 10.0\n"
FIELD = "[effects.external_field]\nuniform = [0.0, 0.0, 1.0]\n"


@pytest.mark.parametrize(
    ("further", "words"),
    [
        (SINKS + FRAME, "rotating_frame. acts on the fluid alone, so it cannot be listed with sinks"),
        (SINKS + TIDE, "tide. acts on the fluid alone, so it cannot be listed with sinks"),
        (SINKS + FIELD, "external_field. acts on the fluid alone, so it cannot be listed with sinks"),
        (SINKS + WAVES, "radiation_reaction. acts on the fluid alone, so it cannot be listed with sinks"),
        (SINKS + '[numerics]\nengine = "xla"\n', "needs the engine numba_cpu"),
        (SINKS + "[effects.companions]\n" + MOON, 'only if their motion is "live"'),
        (SINKS.replace("density = 10.0", ""), r"sinks. needs a density, above which sinks form, or \[\[sinks"),
        (STARS, r"\[\[sinks\]\] attract and accrete by \[effects.sinks\], which the scene does not list"),
        (SINKS + STARS + LIVE, "list all points as"),
        (SINKS + "number = 1\n" + STARS, "number must be at least that of .*, 2"),
        (SINKS.replace("0.6", "0.06"), "radius must be at least .* times as large"),
        (TIDE + LIVE, "tide. acts on the fluid alone, so it cannot be listed with live companions"),
        (FIELD + LIVE, "external_field. acts on the fluid alone, so it cannot be listed with live companions"),
        (WAVES + LIVE, "radiation_reaction. acts on the fluid alone, so it cannot be listed with live companions"),
        (MOON, "companions.. act on particles by"),
        ("[effects.companions]\n", r"effects.companions. needs .*companions"),
    ],
)
def test_what_a_run_would_refuse_is_refused_before_it_in_the_same_words(further: str, words: str) -> None:
    scene = loads(CLOUD + further)
    with pytest.raises(SceneError, match=words) as before:
        refuse_contradictions(scene)
    if "xla" not in further:  # that engine only computes in 64 bits, which this test is not in
        with pytest.raises(SceneError) as later:
            sph.evolution(scene, code_units(scene))
        assert str(before.value) == str(later.value)


@pytest.mark.parametrize(
    "further",
    [SINKS, LIVE, SINKS + LIVE, SINKS.replace("density = 10.0", "") + STARS, SINKS + "number = 2\n" + STARS],
)
def test_what_can_be_is_not(further: str) -> None:
    refuse_contradictions(loads(CLOUD + further))


def test_sinks_of_a_scene_are_there_from_the_start_in_its_units() -> None:
    """In code units of the body's mass and radius, with the identities that come first."""
    text = CLOUD.replace('units = "code"\n', "").replace("specific_internal_energy = 0.05", "")
    text = text.replace("mass = 1.0", 'mass = "2 Msun"').replace("radius = 1.0", 'radius = "4 au"')
    text = text.replace("end = 1.0", 'end = "1 yr"') + '[effects.sinks]\nradius = "1 au"\n'
    text += '[[sinks]]\nmass = "1 Msun"\n[[sinks]]\nmass = "3 Msun"\nposition = ["0 au", "2 au", "0 au"]\n'
    scene = loads(text + 'velocity = ["-1 km/s", "0 km/s", "0 km/s"]\n')
    units = code_units(scene)
    sinks = sph.evolution(scene, units).state.points["sinks"]
    assert sinks.mass == pytest.approx([0.5, 1.5])
    assert sinks.position.tolist() == [[0.0, 0.0, 0.0], [0.0, pytest.approx(0.5), 0.0]]
    assert sinks.velocity[1, 0] * units.to_si(1.0, "velocity") == pytest.approx(-1e3)
    assert sinks.identity.tolist() == [0, 1]
    assert sinks.formed == 2
    assert re.search(r"mass: 5.9652\d*e\+30 kg \(at \(0 m, 2.99\d+e\+11 m, 0 m\)\)", plan(scene).text())
    with pytest.raises(SceneError, match="are for the model sph, not for ellipsoid"):
        loads(CLOUD + STARS, ["model=ellipsoid"])


def test_kernels_of_a_fixed_softening_reach_as_far_as_it_says_at_any_density() -> None:
    """At 0.2 no sink ever formed, and at 0.1 the radius was refused for kernels that follow the density."""
    cold = CLOUD.replace("[effects.pressure]\n", "") + SINKS
    with pytest.raises(SceneError, match=r"at least 1\.33 times as large: .* with that softening of gravity"):
        refuse_contradictions(loads(cold, ["effects.gravity.softening=0.4"]))
    loose = ["effects.gravity.softening=0.2", "effects.sinks.density=0.5"]
    refuse_contradictions(loads(cold, loose))
    with pytest.raises(SceneError, match="at its density"):
        refuse_contradictions(loads(cold, loose[1:]))


def test_particles_of_a_table_that_do_not_fit_into_a_sink_are_refused_before_a_run(tmp_path) -> None:
    """The heaviest of them say how far kernels reach at the density of a sink."""
    rows = "".join(f"{1.0 + 7.0 * (k == 5)},{k % 2},{k % 3},{k % 5},0.1\n" for k in range(30))
    (tmp_path / "cloud.csv").write_text("mass,x,y,z,u\n" + rows)
    body = CLOUD[CLOUD.index("kind") : CLOUD.index("[equation")]
    table = CLOUD.replace(body, 'kind = "table"\nfile = "cloud.csv"\n') + SINKS
    reach = 2.0 * 1.3 * (8.0 / 10.0) ** (1 / 3)
    refuse_contradictions(loads(table, [f"effects.sinks.radius={1.001 * reach}"], str(tmp_path)))
    with pytest.raises(SceneError, match="radius must be at least 1 times as large"):
        refuse_contradictions(loads(table, [f"effects.sinks.radius={0.999 * reach}"], str(tmp_path)))


def test_the_heaviest_particles_of_several_bodies_say_how_far_kernels_reach() -> None:
    """Wherever these stand among the bodies; a run refuses what its plan does, in the same words."""
    body = CLOUD[CLOUD.index("kind") : CLOUD.index("[equation")]
    heavy = body.replace("mass = 1.0", "mass = 8.0\nposition = [9.0, 0.0, 0.0]")
    reach = 2.0 * 1.3 * (8.0 / 100 / 10.0) ** (1 / 3)
    for bodies in (f"[[bodies]]\n{body}[[bodies]]\n{heavy}", f"[[bodies]]\n{heavy}[[bodies]]\n{body}"):
        text = CLOUD.replace(f"[body]\n{body}", bodies) + SINKS
        refuse_contradictions(loads(text, [f"effects.sinks.radius={1.001 * reach}"]))
        scene = loads(text, [f"effects.sinks.radius={0.999 * reach}"])
        with pytest.raises(SceneError, match="radius must be at least 1 times as large") as before:
            refuse_contradictions(scene)
        with pytest.raises(SceneError) as later:
            sph.evolution(scene, code_units(scene))
        assert str(before.value) == str(later.value)


def test_a_checkpoint_cannot_have_begun_with_fewer_particles_than_it_has() -> None:
    stored = STORED.format("particles")
    assert at_first({}, 90) == 90  # without sinks it is those that are there
    assert at_first({stored: np.array(100)}, 90) == 100
    for wrong in (np.array(89), np.array([100]), np.array(100.0)):
        with pytest.raises(ValueError, match="how many particles there were before the sinks"):
            at_first({stored: wrong}, 90)


def test_candidates_that_contradict_are_refused_as_the_scene_lists_them() -> None:
    """And what "auto" has chosen by itself, which no table lists, by its name."""
    automatic = CLOUD.replace("[effects.gravity]\n[effects.pressure]\n", "")
    automatic = automatic.replace("[body]", 'effects = "auto"\naccuracy = 1e-9\nsettings = "given"\n[body]', 1)
    both = (SINKS + TIDE + "softening = 0.1\n").replace("[effects.", "[candidates.").replace("10.0", "1e-3")
    with pytest.raises(SceneError, match=r"^\[candidates\.tide\] acts on the fluid alone"):
        refuse_contradictions(loads(automatic + both.replace("0.6", "2.0")))
    scene = loads(automatic)
    assert [scene.where_listed(kind) for kind in ("gravity", "sinks")] == ["the effect gravity", "[effects.sinks]"]
    assert loads(CLOUD).where_listed("gravity") == "[effects.gravity]"
