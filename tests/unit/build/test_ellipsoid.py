"""From a scene to an affine body: its quadrature, fluid and rotation, what it says of itself and what it refuses."""

import math
from types import SimpleNamespace

import jax
import numpy as np
import pytest

from astroinertia.build import ellipsoid as start_ellipsoid, placing
from astroinertia.build.spheres import sphere, stretch
from astroinertia.errors import SceneError
from astroinertia.matter.gases import ideal
from astroinertia.scene import load, plan
from astroinertia.sph import profiles

SCENE = """
name = "star"
model = "ellipsoid"
units = "code"
[body]
kind = "polytrope"
index = 1.5
mass = 2.0
radius = 3.0
axes = [1.2, 1.0, 0.8]
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = 1.0
"""
INCOMPRESSIBLE = ("equation_of_state={kind='incompressible'}",)


def body_of(*settings, text=SCENE):
    scene = load.loads(text, settings)
    with jax.enable_x64(True):
        return start_ellipsoid.evolution(scene, plan.code_units(scene))


def uniform(text=SCENE):
    return text.replace('kind = "polytrope"\nindex = 1.5', 'kind = "uniform"')


@pytest.mark.parametrize(
    "profile",
    [
        profiles.uniform(),
        profiles.power_law(1.0),
        profiles.power_law(2.0),
        profiles.polytrope(1.5),
        profiles.dyson(1.4),
    ],
    ids=lambda profile: profile.name,
)
def test_shells_integrate_over_the_mass(profile):
    share, s = start_ellipsoid.shells(profile)
    assert share @ s**2 / 3 == pytest.approx(profile.second_moment, rel=1e-11)
    # W = -integral of m dm / s
    assert -(share @ (profile.enclosed(s) / s)) == pytest.approx(profile.gravitational_energy, rel=1e-8)


def test_the_body_has_the_moments_energies_and_spin_of_its_sphere_stretched():
    body = body_of("body.rotation={t_over_w=0.05, axis=[1.0, 0.0, 2.0]}")
    record, profile = body.record(None), profiles.polytrope(1.5)
    moment = 2.0 * 3.0**2 * profile.second_moment
    np.testing.assert_allclose(record["second_moment"], moment * np.diag([1.44, 1.0, 0.64]), atol=1e-14 * moment)
    binding = profiles.ellipsoid_gravitational_energy(profile, 2.0, 3.0 * np.array([1.2, 1.0, 0.8]))
    assert record["gravitational_energy"] == pytest.approx(binding, rel=1e-13)
    assert record["kinetic_energy"] == pytest.approx(-0.05 * binding, rel=1e-12)
    # U = -W_sphere/(3 (gamma - 1)) at J = 1, and J^(1 - gamma) of it when stretched.
    sphere = profile.gravitational_energy * 4.0 / 3.0
    assert record["internal_energy"] == pytest.approx(-sphere / 2 * 0.96 ** (-2 / 3), rel=1e-12)
    spin = np.linalg.solve(record["inertia_tensor"], record["angular_momentum"])
    np.testing.assert_allclose(spin / np.linalg.norm(spin), np.array([1.0, 0.0, 2.0]) / 5**0.5, atol=1e-13)
    assert record["density_max"] == pytest.approx(profile.density(np.array(0.0)) * 2.0 / 27.0 / 0.96, rel=1e-12)
    assert "affine approximation" in body.approximation and "not uniform" in body.approximation


@pytest.mark.slow
def test_a_polytrope_in_equilibrium_has_no_net_force():
    for fluid in ("{kind='ideal', gamma=1.4}", "{kind='polytropic', gamma=1.6666666666666667}"):
        body = body_of("body.axes=[1.0, 1.0, 1.0]", f"equation_of_state={fluid}")
        virial = body.record(None)["virial_tensor"]
        assert np.abs(virial.sum(axis=0)).max() < 2e-6 * np.abs(virial[0]).max()


@pytest.mark.slow
def test_a_rotation_that_is_not_rigid_keeps_its_angular_momentum():
    body = body_of("body.rotation={law='j_constant', scale=1.0, angular_momentum=0.7}")
    record = body.record(None)
    np.testing.assert_allclose(record["angular_momentum"], [0.0, 0.0, 0.7], atol=1e-12)
    assert "j_constant" in body.approximation


@pytest.mark.slow
def test_every_fluid_can_be_asked_for():
    for fluid, pressure in (
        ("{kind='isothermal', sound_speed=0.3}", 2.0 * 0.09),
        ("{kind='polytropic', gamma=2.0, constant=0.5}", None),
        ("{kind='piecewise_polytropic', densities=[0.1], gammas=[1.3, 2.5], constant=0.4}", None),
        ("{kind='hybrid', nuclear_density=0.1, constant=0.4}", None),
    ):
        body = body_of(f"equation_of_state={fluid}")
        tensor = body.record(None)["virial_tensor"][1]
        assert np.isfinite(tensor).all() and tensor[0, 0] > 0.0
        if pressure is not None:
            np.testing.assert_allclose(tensor, pressure * np.eye(3), atol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "settings", "message"),
    [
        (uniform(), (), "exact"),
        (uniform(), INCOMPRESSIBLE, "exact"),
        (uniform(), ("body.specific_internal_energy=0.1",), "pressure force is not linear"),
        (uniform(), ("effects.tide={mass=1.0, position=[20.0, 0.0, 0.0]}",), "tide is taken to second order"),
        (SCENE, INCOMPRESSIBLE, "density is not uniform"),
    ],
)
def test_it_says_what_is_exact(text, settings, message):
    assert message in body_of(*settings, text=text).approximation


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (("body={kind='rotating_star', index=1.0, mass=1.0, radius=1.0, axis_ratio=0.8}",), "no stretched sphere"),
        ((*INCOMPRESSIBLE, "body.pressure_fraction=0.5"), "pressure_fraction is for a gas"),
        ((*INCOMPRESSIBLE, "body.velocity_gradient=[[1.0,0.0,0.0],[0.0,0.0,0.0],[0.0,0.0,0.0]]"), "has a trace"),
        ((*INCOMPRESSIBLE, "body.axes=[1.0, 1e-34, 1e-34]"), "axes are so unlike that the volume"),
        ((*INCOMPRESSIBLE, "effects={gravity={}}"), "needs [effects.pressure]"),
        ((*INCOMPRESSIBLE, "model='sph'", "body.particles=100"), "for the model ellipsoid, not for sph"),
        (("body={kind='power_law', exponent=2.6, mass=1.0, radius=1.0}",), "has no bound"),
        (("effects={pressure={}}",), "without gravity"),
        (("companions=[{name='moon', mass=0.1, semi_major_axis=10.0}]",), "[effects.tide]"),
        (("effects.radiation_reaction={}",), "speed_of_light is missing"),
        (("numerics.integrator='splitting'",), "splitting is for the model rigid"),
    ],
)
def test_what_an_ellipsoid_cannot_be_is_refused_in_one_sentence(settings, message):
    with pytest.raises(SceneError) as caught:
        body_of(*settings)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_modes_are_those_of_the_stretched_body():
    """|sum m exp(2 i phi)|/M of an ellipse is (a - b)/(a + b), and its square for k = 4."""
    record = body_of("body.axes=[1.5, 0.5, 1.0]").record(None)
    np.testing.assert_allclose(record["mode_amplitude"], [0.0, 0.5, 0.0, 0.25], atol=1e-14)
    phi = np.linspace(0, 2 * math.pi, 4000, endpoint=False)
    weight = 1 / ((np.cos(phi) / 1.5) ** 2 + (np.sin(phi) / 0.5) ** 2)
    for k, amplitude in enumerate(record["mode_amplitude"], start=1):
        assert abs((weight * np.exp(1j * k * phi)).sum()) / weight.sum() == pytest.approx(amplitude, abs=1e-12)


def test_axes_tilt_in_both_models_alike():
    """Particles and the affine body have the same stretch, along the same directions."""
    tilt = "body.axes_at_start=[[3.0, 4.0, 0.0], [-4.0, 3.0, 0.0], [0.0, 0.0, 2.0]]"
    scene = load.loads(SCENE, [tilt])
    turn = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    wanted = turn.T @ np.diag([1.2, 1.0, 0.8]) @ turn
    np.testing.assert_allclose(stretch(scene.body), wanted, atol=1e-15)
    np.testing.assert_allclose(np.array(body_of(tilt).state.deformation), wanted, atol=1e-15)
    particles = load.loads(SCENE, [tilt, "model='sph'", "body.particles=500", "body.relax=false"])
    units = plan.code_units(particles)
    ball = sphere(particles, units)
    placed = placing.particles(particles, units, ball, SimpleNamespace(equation_of_state=ideal(5 / 3)))
    second = (placed.mass[:, None] * placed.position).T @ placed.position
    expected = 2.0 * 9.0 * ball.profile.second_moment * wanted @ wanted
    np.testing.assert_allclose(second, expected, atol=1e-10 * np.abs(expected).max())


def test_crooked_axes_are_refused():
    with pytest.raises(SceneError, match="right angles"):
        load.loads(SCENE, ["body.axes_at_start=[[1.0,0.0,0.0],[1.0,1.0,0.0],[0.0,0.0,1.0]]"])
