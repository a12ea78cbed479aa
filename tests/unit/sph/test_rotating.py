"""Rotating stars as particles: the map of the glass, and what scenes say of them."""

import numpy as np
import pytest

from astroinertia.bodies.rotating_star import rotating_star
from astroinertia.bodies.rotation_laws import RotationLaw
from astroinertia.build.assemble import metadata, prepare
from astroinertia.build.fluids import equation_of_state
from astroinertia.build.spheres import sphere
from astroinertia.errors import SceneError
from astroinertia.matter.barotropes import polytropic_matter
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units, plan
from astroinertia.sph import profiles
from astroinertia.sph.placement import place
from astroinertia.sph.rotating import mapped
from astroinertia.sph.rotation import rotation_velocity

SCENE = """\
name = "star"
units = "code"
[body]
kind = "rotating_star"
particles = 500
mass = 2.0
radius = 3.0
index = 1.5
axis_ratio = 0.7
relax = false
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = 1.0
"""


@pytest.mark.full
@pytest.mark.parametrize("law", [RotationLaw(), RotationLaw("j_constant", 0.3)], ids=lambda law: law.kind)
def test_the_map_keeps_mass_and_moments_and_adds_no_noise(law):
    star = rotating_star(polytropic_matter(1.5), 0.65, law, mass=2.0, equatorial_radius=3.0)
    profile, count = profiles.polytrope(1.5), 20_000
    ball = place(profile, count, "lattice", seed=3)
    x = mapped(star, profile.enclosed(np.linalg.norm(ball, axis=1)), ball)
    w, z = np.hypot(x[:, 0], x[:, 1]), np.abs(x[:, 2])
    assert np.abs(x.mean(axis=0)).max() < 1e-14
    assert 2.0 * np.mean(w**2) == pytest.approx(star.polar_moment, rel=1e-12)
    assert 2.0 * np.mean(z**2 + w**2 / 2) == pytest.approx(star.equatorial_moment, rel=1e-12)
    assert (star.level(w, z) > 0).all()
    # mass in cylinders and slabs by quadrature; random points would be off by 0.005 at best
    nodes, weights = np.polynomial.legendre.leggauss(80)
    share, weights = (nodes + 1) / 2, weights / 2
    for radius, height in ((0.9, 3.0), (1.5, 0.6), (3.0, 0.5), (3.0, 1.0)):
        rows, columns = radius * share, height * share
        rho = star.density(rows[:, None], columns[None, :])
        mass = 4 * np.pi * radius * height * (weights * rows) @ rho @ weights
        assert np.mean((w < radius) & (z < height)) == pytest.approx(mass / 2.0, abs=0.002)


def test_a_ring_is_not_placed():
    with pytest.raises(ValueError, match="ring"):
        mapped(rotating_star(polytropic_matter(1.5), -0.5), np.array([0.5]), np.array([[0.0, 0.0, 1.0]]))


@pytest.mark.slow
def test_a_scene_turns_as_its_star_does():
    scene = loads(SCENE, ('body.law="v_constant"', "body.scale=1.5"))
    units = code_units(scene)
    star = sphere(scene, units)
    ready = prepare(scene).evolution
    x, v = (np.asarray(value) for value in (ready.state.position, ready.state.velocity))
    momentum = np.asarray(ready.state.mass) @ np.cross(x, v)
    assert momentum[2] == pytest.approx(star.star.angular_momentum, rel=1e-12)
    assert np.abs(momentum[:2]).max() < 1e-3 * momentum[2]  # what 500 points and a law that is not rigid leave
    rate = v[:, 1] * x[:, 0] - v[:, 0] * x[:, 1]
    w = np.hypot(x[:, 0], x[:, 1])
    np.testing.assert_allclose(rate / w**2, star.star.rotation_rate(w), rtol=0.005)  # one factor makes L exact
    # the entropy is the star's own, one for all
    np.testing.assert_allclose(
        ready.state.entropy, star.star.max_pressure / star.star.max_density ** (5 / 3), rtol=1e-9
    )
    attributes = metadata(scene)
    assert attributes["reference_radius"] == 3.0
    assert "equatorial" in attributes["reference_radius_convention"]
    text = plan(scene).text()
    assert "rotating star of index 1.5" in text
    assert "v_constant, axis_ratio 0.7 (in equilibrium, about z)" in text


@pytest.mark.slow
@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("t_over_w", 0.03),
        ("rate", 0.12),
        pytest.param("angular_momentum", 0.5, marks=pytest.mark.full),
        pytest.param("breakup_fraction", 0.4, marks=pytest.mark.full),
        pytest.param("period", 52.0, marks=pytest.mark.full),
    ],
    ids=lambda part: str(part),
)
def test_a_scene_gives_one_measure_of_its_own(setting, value):
    scene = loads(SCENE.replace("axis_ratio = 0.7", f"{setting} = {value}"))
    star = sphere(scene, code_units(scene)).star
    names = {"t_over_w": "rotational_to_gravitational", "rate": "angular_velocity", "period": "angular_velocity"}
    names["breakup_fraction"] = "keplerian_fraction"
    wanted = 2 * np.pi / value if setting == "period" else value
    assert getattr(star, names.get(setting, setting)) == pytest.approx(wanted, rel=1e-9)


def test_a_pressure_deficit_and_the_hybrid_equation_start_from_the_star():
    """The initial star of a collapse: equilibrium of index 3, and a cold pressure that falls short of it by a tenth."""
    scene = loads(
        SCENE.replace('kind = "ideal"', 'kind = "hybrid"\nnuclear_density = 1e4\ngamma_1 = 1.3'),
        ("body.index=3.0", "body.pressure_fraction=0.9", "body.axis_ratio=0.75"),
    )
    units = code_units(scene)
    star = sphere(scene, units)
    fluid = equation_of_state(scene, units, star)
    densest = np.array([star.star.max_density])
    assert fluid.pressure(np, densest, 0 * densest)[0] == pytest.approx(0.9 * star.star.max_pressure, rel=1e-12)


def test_scenes_that_contradict_themselves_are_reported():
    for setting, message in (
        (
            "body.t_over_w=0.02",
            "exactly one of axis_ratio, breakup_fraction, t_over_w, rate, period and angular_momentum",
        ),
        ("body.rotation.t_over_w=0.02", "turns as its own law"),
        ('body.law="j_constant"', "needs a scale"),
        ("body.scale=1.0", "only the laws j_constant and v_constant"),
        ("body.index=0.0", "greater than 0"),
    ):
        with pytest.raises(SceneError) as caught:
            loads(SCENE, (setting,))
        assert message in str(caught.value), setting
    scene = loads(SCENE, ("body.axis_ratio=0.5",))
    with pytest.raises(SceneError, match=r"^\[body\] axis_ratio of 0\.5: no polytrope of index 1\.5 .*mass shedding"):
        sphere(scene, code_units(scene))


def test_beyond_an_edge_particles_keep_the_angular_momentum_of_the_edge():
    x = np.array([[0.5, 0, 0], [1, 0, 0], [0, 4, 0]], dtype=float)
    v = rotation_velocity(np.ones(3), x, edge=1.0, rate=2.0)
    np.testing.assert_allclose(np.linalg.norm(v, axis=1), [1.0, 2.0, 0.5])
