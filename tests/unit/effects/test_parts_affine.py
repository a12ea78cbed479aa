"""What effects do to an affine body: forces from potentials, virial tensors by two routes, parallel axes."""

from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.effects import catalogue

MASS, MOMENT, ENERGY = 1.3, 0.23, -0.7
DEFORMATION = np.array([[1.1, 0.2, -0.3], [0.1, 0.8, 0.25], [-0.2, 0.15, 0.9]])
RATE = np.array([[0.1, -0.4, 0.2], [0.5, 0.2, -0.1], [0.05, 0.3, -0.3]])
CENTRE, VELOCITY = np.array([0.3, -0.2, 0.1]), np.array([-0.1, 0.4, 0.2])
POTENTIALS = {
    "gravity": {},
    "tide": {"mass": 3.0, "position": (4.0, 1.0, -2.0), "softening": 0.5},
    "tide direct": {"mass": 3.0, "position": (4.0, 1.0, -2.0), "softening": 0.5, "frame": "direct"},
    "external_field": {
        "uniform": (0.1, 0.2, -0.3),
        "quadratic": ((0.5, 0.1, 0.0), (0.1, 0.3, 0.2), (0.0, 0.2, 0.7)),
        "circular_speed": 0.8,
        "core": 0.6,
        "point_mass": 2.0,
        "softening": 1.5,
        "origin": (1.0, 2.0, -1.0),
    },
}


def seen(**changes):
    values = {
        "time": 0.7,
        "mass": MASS,
        "second_moment": MOMENT,
        "sphere_energy": ENERGY,
        "deformation": jnp.asarray(DEFORMATION),
        "rate": jnp.asarray(RATE),
        "centre": jnp.asarray(CENTRE),
        "velocity": jnp.asarray(VELOCITY),
        "pressure_slope": -0.4,
    }
    return SimpleNamespace(**values | changes)


@pytest.mark.slow
@pytest.mark.parametrize("name", POTENTIALS)
def test_force_and_push_are_minus_the_slopes_of_the_potential(name):
    effect = catalogue.build(name.split()[0], POTENTIALS[name])
    with jax.enable_x64(True):

        @jax.jit
        def found():
            slope, along = jax.grad(
                lambda at, centre: effect.affine_potential(seen(deformation=at, centre=centre)), argnums=(0, 1)
            )(jnp.asarray(DEFORMATION), jnp.asarray(CENTRE))
            push = effect.affine_push(seen())
            return slope, along, effect.affine_force(seen()), jnp.zeros(3) if push is None else push

        slope, along, force, push = map(np.array, found())
    np.testing.assert_allclose(force, -slope, atol=1e-14)
    np.testing.assert_allclose(push, -along, atol=1e-14)


@pytest.mark.full
@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("gravity", {}),
        ("pressure", {}),
        ("shear_viscosity", {"kinematic_viscosity": 0.3}),
        ("tide", POTENTIALS["tide"]),
        ("external_field", POTENTIALS["external_field"]),
        ("rotating_frame", {"rate": 0.3, "rate_change": 0.1, "axis": (1.0, 2.0, 2.0)}),
        ("damping", {"time_scale": 3.0, "rate": 0.4, "axis": (0.0, 1.0, 1.0)}),
    ],
)
def test_virial_tensor_by_its_own_route(kind, options):
    effect = catalogue.build(kind, options)
    with jax.enable_x64(True):
        force, virial = map(np.array, jax.jit(lambda: (effect.affine_force(seen()), effect.affine_virial(seen())))())
    np.testing.assert_allclose(virial, DEFORMATION @ force.T, atol=1e-14)


@pytest.mark.parametrize("kind", ["rotating_frame", "damping"])
def test_linear_accelerations_agree_with_those_of_points(kind):
    """Eight points with the moments of the body: the accelerations of the particle part, summed."""
    options = {"rotating_frame": {"rate": 0.3, "rate_change": 0.1, "axis": (1.0, 2.0, 2.0)}}
    options["damping"] = {"time_scale": 3.0, "rate": 0.4, "frame": "inertial"}
    effect = catalogue.build(kind, options[kind])
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * np.sqrt(MOMENT / MASS)
    position, velocity = CENTRE + signs @ DEFORMATION.T, VELOCITY + signs @ RATE.T
    fluid = SimpleNamespace(
        time=0.7,
        mass=np.full(8, MASS / 8),
        position=position,
        velocity=velocity,
        centre=CENTRE,
        centre_velocity=VELOCITY,
    )
    acceleration = effect.acceleration(np, fluid) + velocity @ np.asarray(effect.drag(fluid)).T
    with jax.enable_x64(True):
        force, push = np.array(effect.affine_force(seen())), np.array(effect.affine_push(seen()))
    np.testing.assert_allclose(force, MASS / 8 * acceleration.T @ signs, atol=1e-14)
    np.testing.assert_allclose(push, MASS / 8 * acceleration.sum(axis=0), atol=1e-14)


@pytest.mark.slow
def test_a_tide_agrees_with_that_of_points_far_away():
    """The same eight points in the field of a distant mass: the second order is what is left."""
    effect = catalogue.build("tide", {"mass": 1e12, "position": (6e3, -8e3, 1e3)})
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * np.sqrt(MOMENT / MASS)
    fluid = SimpleNamespace(
        time=0.0,
        mass=np.full(8, MASS / 8),
        position=signs @ DEFORMATION.T,
        centre=np.zeros(3),
        centre_velocity=np.zeros(3),
    )
    wanted = MASS / 8 * effect.acceleration(np, fluid).T @ signs
    with jax.enable_x64(True):
        force = np.array(effect.affine_force(seen(centre=jnp.zeros(3))))
    np.testing.assert_allclose(force, wanted, atol=1e-6 * np.abs(wanted).max())
