"""Several bodies in one scene: where they stand, what each is by itself, and what is refused."""

import math

import numpy as np
import pytest

from astroinertia.build.assemble import metadata, prepare
from astroinertia.build.combine import kepler_state, places
from astroinertia.build.placing import particles
from astroinertia.build.sph import problem_of
from astroinertia.errors import SceneError
from astroinertia.scene.example import example_text
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units, plan

PAIR = """
name = "pair"
units = "code"
[[bodies]]
kind = "polytrope"
index = 1.5
particles = 40
mass = 1.0
radius = 1.0
relax = false
[[bodies]]
kind = "uniform"
particles = 30
mass = 0.5
radius = 0.8
relax = false
seed = 3
rotation = { rate = 0.3, axis = [1, 0, 0] }
[orbit]
pericentre = 1.0
eccentricity = 1.0
separation = 5.0
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = 1.0
"""
PLACED = PAIR.replace("[orbit]\npericentre = 1.0\neccentricity = 1.0\nseparation = 5.0\n", "").replace(
    "seed = 3", "seed = 3\nposition = [3.0, 0.5, -1.0]\nvelocity = [0.0, -0.25, 0.125]"
)


@pytest.mark.parametrize("eccentricity", [0.0, 0.4, 1.0, 3.0])
def test_two_points_are_on_the_orbit_that_was_asked_for(eccentricity: float) -> None:
    """Energy, angular momentum, direction of the pericentre, and inwards."""
    mass, pericentre = 1.7, 0.9
    separation = pericentre * (1.0 if eccentricity == 0 else 1.8)
    x, v = kepler_state(mass, pericentre, eccentricity, separation)
    energy = 0.5 * v @ v - mass / np.linalg.norm(x)
    spin = np.cross(x, v)
    vector = np.cross(v, spin) / mass - x / np.linalg.norm(x)
    assert np.linalg.norm(x) == pytest.approx(separation, rel=1e-15)
    assert energy == pytest.approx(mass * (eccentricity - 1) / (2 * pericentre), abs=1e-14)
    np.testing.assert_allclose(spin, [0, 0, math.sqrt(mass * pericentre * (1 + eccentricity))], atol=1e-14)
    np.testing.assert_allclose(vector, [eccentricity, 0, 0], atol=1e-14)
    assert x @ v <= 0.0


def test_the_apocentre_can_be_begun_at() -> None:
    x, v = kepler_state(1.0, 1.0, 0.5, 3.0)
    np.testing.assert_allclose([x[0], abs(x @ v)], [-3.0, 0.0], atol=1e-15)


def test_the_pericentre_can_be_begun_at_whatever_the_rounding() -> None:
    for eccentricity in np.concatenate([np.linspace(0.01, 0.99, 50), np.linspace(1.0, 5.0, 50)]):
        x, v = kepler_state(1.0, 0.7, float(eccentricity), 0.7)
        np.testing.assert_allclose([x[0], x @ v], [0.7, 0.0], atol=1e-7)


def test_bodies_begin_at_the_separation_or_else_at_the_pericentre() -> None:
    for text, apart in (
        (PAIR, 5.0),
        (PAIR.replace("separation = 5.0\n", "").replace("centre = 1.0", "centre = 2.0"), 2.0),
    ):
        scene = loads(text)
        (one, speed), (two, other) = places(scene, code_units(scene))
        assert np.linalg.norm(two - one) == pytest.approx(apart, rel=1e-14)
        np.testing.assert_allclose(one + 0.5 * two, 0.0, atol=1e-15)
        assert (two - one) @ (other - speed) <= 0.0


def test_each_body_is_what_it_is_alone_moved_to_its_place() -> None:
    scene = loads(PLACED)
    state = prepare(scene).evolution.state
    back = np.argsort(state.identity)
    whole = {name: np.asarray(getattr(state, name))[back] for name in ("mass", "position", "velocity", "entropy")}
    units, first = code_units(scene), 0
    moves = [(np.zeros(3), np.zeros(3)), (np.array([3.0, 0.5, -1.0]), np.array([0.0, -0.25, 0.125]))]
    for alone, (place, speed) in zip(scene.alone(), moves, strict=True):
        problem, ball = problem_of(alone, units)
        body = particles(alone, units, ball, problem)
        own = slice(first, first + len(body.mass))
        np.testing.assert_array_equal(whole["mass"][own], body.mass)
        np.testing.assert_array_equal(whole["entropy"][own], body.entropy)
        np.testing.assert_array_equal(whole["position"][own], body.position + place)
        np.testing.assert_array_equal(whole["velocity"][own], body.velocity + speed)
        first += len(body.mass)
    assert first == len(state.mass) == scene.particles == 70


def test_bodies_on_an_orbit_have_a_centre_of_mass_at_rest_and_its_angular_momentum() -> None:
    record = prepare(loads(PAIR, ["bodies.1.rotation.rate=0.0"])).evolution.record(None)
    np.testing.assert_allclose(record["momentum"], 0.0, atol=1e-15)
    np.testing.assert_allclose(record["centre_of_mass"], 0.0, atol=1e-15)
    expected = 1.0 * 0.5 / 1.5 * math.sqrt(1.5 * 2.0)
    np.testing.assert_allclose(record["angular_momentum"], [0, 0, expected], atol=1e-14)


def test_units_are_the_mass_of_all_and_the_radius_of_the_first() -> None:
    text = PAIR.replace('units = "code"\n', "")
    for plain, quantity in (
        ("mass = 1.0", 'mass = "1 kg"'),
        ("mass = 0.5", 'mass = "0.5 kg"'),
        ("radius = 1.0", 'radius = "2 m"'),
        ("radius = 0.8", 'radius = "0.8 m"'),
        ("rate = 0.3", 'rate = "0.3 rad/s"'),
        ("pericentre = 1.0", 'pericentre = "1 m"'),
        ("separation = 5.0", 'separation = "5 m"'),
        ("end = 1.0", 'end = "1 s"'),
    ):
        text = text.replace(plain, quantity)
    units = code_units(loads(text))
    assert (units.mass, units.length) == (1.5, 2.0)


def test_overrides_reach_one_of_the_bodies_and_are_kept() -> None:
    scene = loads(PAIR, ["bodies.1.particles=50", "bodies.0.rotation.rate=0.1"])
    assert [body.particles for body in scene.bodies] == [40, 50]
    again = loads(scene.to_toml())
    assert again.bodies == scene.bodies and again.body == scene.bodies[0]
    assert again.body.rotation is not None and again.body.rotation.rate == 0.1


def test_the_plan_and_the_file_tell_of_all_bodies() -> None:
    text = plan(loads(PAIR)).text()
    assert "bodies.0:" in text and "bodies.1:" in text and "separation: 5 (at time 0, on the way in)" in text
    assert metadata(loads(PAIR))["body_particles"] == [40, 30]
    assert "[[bodies]]" in example_text()


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("bodies.0.masss=1.0", r"\[bodies.0\] masss is not a known key; did you mean 'mass'"),
        ("bodies.1.rotation.rat=1.0", r"\[bodies.1.rotation\] rat is not a known key"),
        ("bodies.0.exponent=1.0", r"\[bodies.0\] exponent is not a known key; it belongs to the kind power_law"),
        ("bodies.0.mass=-1.0", r"\[bodies.0\] mass: must be positive"),
        ("bodies.5.mass=1.0", "bodies is not a table, so it has no key 5"),
        ("bodies=[]", "bodies: must be a list with at least 2 entries"),
        ('body={kind="uniform"}', r"\[bodies\] is given besides \[body\]"),
        ('model="ellipsoid"', r"\[\[bodies\]\] are for the model sph"),
        ("orbit.separation=0.5", r"\[orbit\] has a separation that is less than the pericentre"),
        ("orbit.eccentricity=0.5", r"\[orbit\] has a separation that is beyond the apocentre"),
        ("bodies.0.position=[1.0, 0.0, 0.0]", r"\[orbit\] says where the bodies are"),
        ('bodies.1.kind="polytrope"', r"\[bodies.1\] index is missing"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(override: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        loads(PAIR, [override])


def test_bodies_that_would_need_two_fluids_are_refused() -> None:
    text = PAIR.replace('kind = "ideal"', 'kind = "polytropic"\ngamma = 1.6666666666666667')
    with pytest.raises(SceneError, match="not the same for all bodies"):
        prepare(loads(text))


def test_energies_of_some_bodies_only_are_refused() -> None:
    with pytest.raises(SceneError, match="either all have a specific_internal_energy"):
        prepare(loads(PAIR, ["bodies.1.specific_internal_energy=0.1"]))
