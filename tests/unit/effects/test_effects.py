"""The physics of each effect, against closed forms, on a few hundred particles."""

import dataclasses
import itertools
import math
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.effects import catalogue
from astroinertia.effects.catalogue import CATALOGUE, DIMENSIONS, Default
from astroinertia.inertia.tensor import axial_vector
from astroinertia.models.sph.step import step
from tests.ball import ball, state_of


def at(position: Any, velocity: Any = None, time: float = 0.0, mass: Any = None) -> SimpleNamespace:
    """As much of a fluid as a per-particle effect sees."""
    position = np.asarray(position, dtype=float)
    velocity = np.zeros_like(position) if velocity is None else np.asarray(velocity, dtype=float)
    mass = np.full(len(position), 1.0 / len(position)) if mass is None else mass
    return SimpleNamespace(
        time=time,
        mass=mass,
        position=position,
        velocity=velocity,
        centre=(mass @ position) / mass.sum(),
        centre_velocity=(mass @ velocity) / mass.sum(),
    )


# The catalogue


@pytest.mark.parametrize("kind", CATALOGUE)
def test_the_catalogue_describes_the_options_that_the_effect_has(kind: str) -> None:
    entry = CATALOGUE[kind]
    made = catalogue.load(kind)
    assert made.__name__ == entry.class_name
    assert made.kind == kind
    fields = {field.name: field for field in dataclasses.fields(made)}
    assert set(entry.options) == set(fields)
    for name, option in entry.options.items():
        assert option.dimension in {*DIMENSIONS, "choice", "boolean"}
        assert (option.dimension == "choice") == bool(option.choices)
        assert (fields[name].metadata.get("static", False)) == bool(option.choices)
        if isinstance(option.default, Default):
            continue
        assert fields[name].default == option.default
        if option.choices:
            assert option.default in option.choices
        elif option.default is not None:
            assert np.shape(option.default) == option.shape


def test_a_missing_and_an_unknown_option_are_named() -> None:
    with pytest.raises(ValueError, match="time_scale is missing"):
        catalogue.build("damping")
    with pytest.raises(ValueError, match="alfa is not an option of viscosity"):
        catalogue.build("viscosity", {"alfa": 1.0})


@pytest.mark.parametrize(
    ("kind", "options", "sentence"),
    [
        ("viscosity", {"alpha_max": 0.5, "alpha_min": 0.6}, "alpha_min must not be above"),
        ("damping", {"time_scale": 1.0, "rate_change": 0.1}, "needs the rate at time 0"),
        ("rotating_frame", {"rate": 1.0, "axis": (0.0, 0.0, 0.0)}, "axis must not be zero"),
        ("tide", {"mass": 1.0, "position": (0.0, 0.0, 0.0)}, "must not be the origin"),
        ("tide", {"mass": 1.0, "position": (1.0, 0.0, 1.0), "period": 1.0}, "perpendicular"),
        ("external_field", {}, "needs one of"),
        ("external_field", {"circular_speed": 1.0}, "needs both circular_speed and core"),
        ("external_field", {"quadratic": ((0.0, 1.0, 0.0), (0.0,) * 3, (0.0,) * 3)}, "must be symmetric"),
    ],
)
def test_options_that_contradict_are_refused(kind: str, options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        catalogue.build(kind, options)


def test_effects_are_pytrees_whose_numbers_are_leaves() -> None:
    effect = catalogue.build("viscosity", {"beta": 1.5})
    leaves, tree = jax.tree.flatten(effect)
    assert sorted(leaves) == [0.0, 1.0, 1.5, 10.0]
    assert jax.tree.unflatten(tree, leaves) == effect or jax.tree.unflatten(tree, leaves).beta == 1.5


# Rotating frame


def test_the_coriolis_force_does_no_work_in_a_step() -> None:
    """In a frame whose centrifugal force is taken away, |v| of every particle stays to round-off."""
    position, random = ball(60), np.random.default_rng(0)
    frame = catalogue.build("rotating_frame", {"rate": 0.7, "axis": (1.0, -2.0, 0.5)})
    rotation = frame.rotation(at(position))
    remove = catalogue.build("external_field", {"quadratic": tuple(map(tuple, -rotation @ rotation))})
    problem, state, arrangement = state_of(
        frame, remove, position=position, velocity=random.normal(size=position.shape)
    )
    before = np.linalg.norm(state.velocity, axis=1)
    for _ in range(50):
        state = step(problem, arrangement, state, np.float64(0.1))
    assert np.abs(np.linalg.norm(state.velocity, axis=1) / before - 1).max() < 1e-14
    work = np.asarray(state.ledger.work.total)
    assert abs(work.sum()) < 1e-15
    assert np.abs(state.velocity).max() > 0.1


@pytest.mark.parametrize("rate_change", [None, -0.15])
def test_a_free_particle_in_a_rotating_frame_runs_straight_in_the_inertial_one(rate_change: float | None) -> None:
    """Second order in the step towards x0 + t u seen from the turning frame, with and without spin-up."""
    axis, rate = np.array([2.0, 1.0, -2.0]) / 3.0, 0.6
    frame = catalogue.build("rotating_frame", {"rate": rate, "rate_change": rate_change, "axis": tuple(axis)})
    start, speed = ball(60), np.random.default_rng(1).normal(size=(len(ball(60)), 3))
    velocity = speed - np.cross(rate * axis, start)

    def error(steps: int) -> float:
        problem, state, arrangement = state_of(frame, position=start, velocity=velocity)
        for _ in range(steps):
            state = step(problem, arrangement, state, np.float64(2.0 / steps))
        angle = rate * 2.0 + 0.5 * (rate_change or 0.0) * 4.0
        straight = start + 2.0 * speed
        turned = (
            straight * math.cos(angle)
            - np.cross(axis, straight) * math.sin(angle)
            + np.outer(straight @ axis, axis) * (1 - math.cos(angle))
        )
        return float(np.abs(state.position - turned).max())

    errors = [error(steps) for steps in (16, 32, 64)]
    assert errors[-1] < 1e-3
    assert all(3.8 < a / b < 4.2 for a, b in itertools.pairwise(errors)), errors


def test_a_body_at_rest_in_the_inertial_frame_turns_backwards_on_a_circle() -> None:
    """Centrifugal and Coriolis together give the centripetal acceleration of the turning -Omega that is seen."""
    frame = catalogue.build("rotating_frame", {"rate": 1.3})
    position = ball(60)
    fluid = at(position, -np.cross([0.0, 0.0, 1.3], position))
    total = frame.acceleration(np, fluid) + fluid.velocity @ frame.drag(fluid).T
    assert np.allclose(total, -(1.3**2) * position * (1.0, 1.0, 0.0), atol=1e-15)


# Tide


def test_the_perturber_follows_keplers_laws() -> None:
    """Pericentre and apocentre, equal areas, and the force that an ellipse with that period and size belongs to."""
    e, period, pericentre = 0.6, 7.0, 2.0
    tide = catalogue.build(
        "tide",
        {
            "mass": 1.0,
            "position": (0.0, pericentre, 0.0),
            "period": period,
            "eccentricity": e,
            "normal": (3.0, 0.0, 0.0),
            "mean_anomaly": 0.4,
        },
    )

    def place(time: float) -> np.ndarray:
        return tide.place(np, SimpleNamespace(time=time))

    epoch, dt = -0.4 * period / (2 * math.pi), 0.01
    assert np.allclose(place(epoch), (0.0, pericentre, 0.0), atol=1e-14)
    axis = pericentre / (1 - e)
    assert np.allclose(place(epoch + period / 2), (0.0, -axis * (1 + e), 0.0), atol=1e-13)
    assert place(epoch + 0.1)[2] > 0  # pericentre, velocity and normal are right-handed: y, z, x
    gm = (2 * math.pi / period) ** 2 * axis**3
    for time in np.linspace(0.0, period, 9):
        far_back, back, here, on, far_on = (place(time + k * dt) for k in (-2, -1, 0, 1, 2))
        speed = (8.0 * (on - back) - (far_on - far_back)) / (12.0 * dt)
        change = (16.0 * (on + back) - (far_on + far_back) - 30.0 * here) / (12.0 * dt**2)
        assert np.allclose(np.cross(here, speed), [math.sqrt(gm * axis * (1 - e * e)), 0.0, 0.0], atol=1e-6)
        assert np.allclose(change, -gm * here / np.linalg.norm(here) ** 3, atol=1e-6)


def test_the_tide_far_away_is_the_textbook_one() -> None:
    """GM/D^3 (2 x, -y, -z) to first order, free of cancellation at any distance; the rest falls as 1/D."""
    position = ball(60)
    for distance in (1e2, 1e5, 1e8):
        tide = catalogue.build("tide", {"mass": distance**3, "position": (distance, 0.0, 0.0)})
        found = tide.acceleration(np, at(position))
        error = np.abs(found - position * (2.0, -1.0, -1.0)).max()
        assert error < 5.0 / distance
        energy = tide.potential_energy(np, at(position))
        textbook = -0.5 * np.mean((position**2) @ np.array([2.0, -1.0, -1.0]))
        assert abs(energy - textbook) < 5.0 / distance + 1e-15 * distance


def test_the_tidal_force_is_the_direct_one_less_that_on_the_origin() -> None:
    options = {"mass": 2.0, "position": (1.5, 0.3, -0.2), "softening": 0.2}
    position = ball(60)
    tidal = catalogue.build("tide", options).acceleration(np, at(position))
    direct = catalogue.build("tide", {**options, "frame": "direct"})
    separation = position - np.array(options["position"])
    wanted = -2.0 * separation / ((separation**2).sum(axis=1) + 0.04)[:, None] ** 1.5
    assert np.allclose(direct.acceleration(np, at(position)), wanted, rtol=1e-14)
    assert np.allclose(tidal, wanted - direct.acceleration(np, at(np.zeros((1, 3)))), rtol=1e-13, atol=1e-14)


# External field and damping


@pytest.mark.parametrize(
    "options",
    [
        {"uniform": (0.3, -0.2, 0.1)},
        {"quadratic": ((1.0, 0.2, 0.1), (0.2, 0.5, -0.3), (0.1, -0.3, -0.4)), "origin": (0.1, 0.2, 0.3)},
        {"circular_speed": 1.4, "core": 0.3, "origin": (0.5, 0.0, -0.5)},
        {"point_mass": 2.0, "softening": 0.1, "origin": (1.5, 0.0, 0.0)},
    ],
    ids=lambda options: next(iter(options)),
)
def test_each_given_field_is_the_gradient_of_its_potential(options: dict[str, Any]) -> None:
    effect, position = catalogue.build("external_field", options), ball(60)
    with jax.enable_x64(True):
        mass = jnp.full(len(position), 1.0 / len(position))

        def energy(x: Any) -> Any:
            return effect.potential_energy(jnp, SimpleNamespace(position=x, mass=mass))

        force = jax.grad(energy)(jnp.asarray(position))
    assert np.allclose(effect.acceleration(np, at(position)) / len(position), -force, rtol=1e-12, atol=1e-16)


def test_circular_orbits_have_the_given_speed() -> None:
    """Far outside its core the logarithmic field holds a particle at the given speed at any radius."""
    effect = catalogue.build("external_field", {"circular_speed": 1.4, "core": 1e-6})
    for radius in (1.0, 10.0, 100.0):
        pull = effect.acceleration(np, at([[radius, 0.0, 0.0]]))[0, 0]
        assert math.isclose(math.sqrt(-pull * radius), 1.4, rel_tol=1e-11)


def test_damping_takes_the_motion_within_the_body_and_leaves_that_of_its_centre() -> None:
    position, random = ball(60), np.random.default_rng(2)
    velocity = random.normal(loc=(3.0, 0.0, 0.0), size=position.shape)
    damping = catalogue.build("damping", {"time_scale": 0.5, "until": 1.0})
    problem, state, arrangement = state_of(damping, position=position, velocity=velocity)
    mean = state.velocity.mean(axis=0)
    inner = np.abs(state.velocity - mean).max()
    for _ in range(100):
        state = step(problem, arrangement, state, np.float64(0.01))
    assert np.allclose(state.velocity.mean(axis=0), mean, rtol=1e-13)
    assert math.isclose(np.abs(state.velocity - mean).max() / inner, math.exp(-2.0), rel_tol=1e-2)
    velocity = state.velocity
    for _ in range(10):
        state = step(problem, arrangement, state, np.float64(0.01))
    assert np.allclose(state.velocity, velocity, rtol=0.02)
    for _ in range(10):
        earlier, state = state.velocity, step(problem, arrangement, state, np.float64(0.01))
    assert np.array_equal(state.velocity, earlier)


def test_damping_towards_rotation_ends_in_rigid_rotation() -> None:
    position = ball(60)
    damping = catalogue.build("damping", {"time_scale": 0.01, "rate": 0.05, "axis": (0.0, 3.0, 0.0)})
    problem, state, arrangement = state_of(damping, position=position, velocity=np.zeros_like(position))
    for _ in range(40):
        state = step(problem, arrangement, state, np.float64(0.01))
    relative = state.position - state.position.mean(axis=0)
    assert np.allclose(state.velocity, np.cross([0.0, 0.05, 0.0], relative), atol=1e-4)
    assert np.abs(state.velocity).max() > 0.04


def test_damping_towards_a_rate_that_changes_turns_each_particle_as_its_equation_says() -> None:
    """Second order in the step towards x'' = (Omega(t) x x - x')/tau, and the torque in the ledger is what L gains."""
    position, rate, change, tau, end = ball(60), 0.3, 0.8, 0.4, 1.0
    position -= position.mean(axis=0)
    options = {"time_scale": tau, "rate": rate, "rate_change": change}
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])

    def rates(time: float, packed: np.ndarray) -> np.ndarray:
        x, v = packed.reshape(2, -1, 3)
        return np.concatenate([v, ((rate + change * time) * x @ turn.T - v) / tau]).ravel()

    start = np.concatenate([position, 0.0 * position]).ravel()
    exact = solve_ivp(rates, (0.0, end), start, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1].reshape(2, -1, 3)

    def final(steps: int) -> Any:
        problem, state, arrangement = state_of(
            catalogue.build("damping", options), position=position, velocity=np.zeros_like(position)
        )
        for _ in range(steps):
            state = step(problem, arrangement, state, np.float64(end / steps))
        return state

    states = [final(steps) for steps in (20, 40, 80)]
    errors = [float(np.abs(state.velocity - exact[1][state.identity]).max()) for state in states]
    assert all(3.8 < a / b < 4.2 for a, b in itertools.pairwise(errors)), errors
    gained = np.cross(states[-1].position, states[-1].velocity).mean(axis=0)
    assert gained[2] > 0.1
    assert np.allclose(axial_vector(states[-1].ledger.mixed_impulse.total[0]), gained, rtol=1e-12, atol=1e-15)
