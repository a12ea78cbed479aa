"""Laws of cooling and heating against their solutions, on matter that otherwise is left alone."""

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from astroinertia.effects import catalogue
from astroinertia.errors import SceneError
from astroinertia.gravity.point_masses import PointMasses
from astroinertia.models.sph.sinks import no_sinks
from astroinertia.models.sph.step import step
from tests.ball import ball, state_of
from tests.evolve import prepared

POSITION = ball(60)
GAMMA = 5 / 3
DENSITIES = {"reference_density": 0.2, "reference_energy": 0.4}


def energy_of(state: Any) -> np.ndarray:
    return state.entropy * state.rates.fluid.density ** (GAMMA - 1) / (GAMMA - 1)


def cooled(options: dict[str, Any], end: float, steps: int, velocity: Any = None, start: Any = 0.5) -> tuple[Any, Any]:
    """The state at first and at the end, after equal steps; matter moves with the given velocities."""
    velocity = np.zeros_like(POSITION) if velocity is None else velocity
    problem, first, arrangement = state_of(
        catalogue.build("cooling", options), position=POSITION, velocity=velocity, entropy=start
    )
    state = first
    for _ in range(steps):
        state = step(problem, arrangement, state, np.float64(end / steps))
    return first, state


def test_a_time_scale_is_exact_in_steps_of_any_length() -> None:
    for steps in (1, 7):
        first, last = cooled({"time_scale": 0.2}, 4.0, steps)
        assert np.allclose(last.entropy, math.exp(-20.0) * first.entropy, rtol=1e-13)
        taken = first.mass @ (energy_of(first) - energy_of(last))
        assert float(last.ledger.heating.total[0]) == pytest.approx(-taken, rel=1e-14)


def test_a_time_scale_that_falls_with_the_free_fall_time() -> None:
    """A = A_0 (1 - 3 t/(2 tau))^(2/3), second order in the step."""
    exact = (1.0 - 1.5 * 0.5) ** (2 / 3)
    errors = []
    for steps in (10, 20, 40):
        first, last = cooled({"time_scale": 1.0, "time_scale_change": -1.5}, 0.5, steps)
        errors.append(abs(float(last.entropy[0] / first.entropy[0]) / exact - 1.0))
    assert all(3.7 < a / b < 4.3 for a, b in itertools.pairwise(errors)), errors


def test_no_step_follows_a_time_scale_that_has_fallen_to_zero() -> None:
    effect = catalogue.build("cooling", {"time_scale": 1.0, "time_scale_change": -2.0})
    cold = SimpleNamespace(
        density=np.ones(3), thermal_energy=np.full(3, 1e-9), smoothing_length=np.full(3, 0.1), time=0.25
    )
    assert effect.timestep(np, cold) == pytest.approx(0.5)
    cold.time = 0.5
    assert np.isinf(effect.timestep(np, cold)).all()
    first, last = cooled({"time_scale": 1.0, "time_scale_change": -2.0}, 1.0, 10)
    assert float(last.entropy.max()) < 1e-8 * float(first.entropy.min())


@pytest.mark.parametrize(
    ("a", "b"),
    [(1.0, 0.5), pytest.param(-0.5, 3.0, marks=pytest.mark.full), pytest.param(2.0, 1.0, marks=pytest.mark.full)],
)
def test_power_laws_converge_to_their_solution(a: float, b: float) -> None:
    """(u/u_0)^(1-b) = 1 - (1 - b) (t/tau) (rho/rho_0)^a (u_0/u_r)^(b-1); an exponential for b = 1."""
    options = {"law": "power_law", "time_scale": 2.0, "density_exponent": a, "energy_exponent": b, **DENSITIES}
    errors = []
    for steps in (8, 16, 32):
        first, last = cooled(options, 1.0, steps)
        start, density = energy_of(first), first.rates.fluid.density
        rate = 0.5 * (density / 0.2) ** a * (start / 0.4) ** (b - 1.0)
        exact = np.exp(-rate) if b == 1.0 else (1.0 - (1.0 - b) * rate) ** (1.0 / (1.0 - b))
        assert exact.max() < 0.95
        errors.append(np.abs(energy_of(last) / start / exact - 1.0).max())
    assert errors[0] < 1e-13 if b == 1.0 else all(3.6 < x / y < 4.4 for x, y in itertools.pairwise(errors)), errors


def test_beta_cooling_goes_with_the_local_rotation() -> None:
    """u falls by exp(-integral of Omega/beta dt), Omega = |x cross v|/x^2 about the moving centre of mass."""
    about = POSITION - POSITION.mean(axis=0)
    rotation = np.array([0.2, 0.1, 0.5]) * np.linalg.norm(about, axis=1)[:, None]
    velocity = np.cross(rotation, about) + [3.0, 0.0, 0.0]
    _, first, _ = state_of(
        catalogue.build("cooling", {"law": "beta", "beta": 4.0}), position=POSITION, velocity=velocity
    )
    gain, decay = catalogue.build("cooling", {"law": "beta", "beta": 4.0}).exchange(np, first.rates.fluid)
    relative = velocity - velocity.mean(axis=0)
    turned = np.linalg.norm(np.cross(about, relative), axis=1) / (about**2).sum(axis=1)
    assert np.allclose(decay, turned[first.identity] / 4.0, rtol=1e-13)
    assert not gain.any()


def test_beta_cooling_beside_a_star_goes_with_the_rotation_about_it_and_the_fluid() -> None:
    """Omega is about the centre of mass of fluid and sinks; companions are other bodies, and change nothing."""
    effect = catalogue.build("cooling", {"law": "beta", "beta": 4.0})
    _, first, _ = state_of(effect, position=POSITION, velocity=np.cross([0.0, 0.0, 1.0], POSITION))
    fluid = first.rates.fluid
    place, speed, mass = np.array([[0.3, -0.2, 0.1]]), np.array([[0.0, 0.5, 0.2]]), np.array([2.0])
    star = replace(no_sinks(0.0, 60), mass=mass, position=place, velocity=speed)
    other = PointMasses(np.array([50.0]), place + 9.0, speed, 0.0)
    _, decay = effect.exchange(np, replace(fluid, points={"sinks": star, "companions": other}))
    total = fluid.mass.sum() + 2.0
    x = fluid.position - (fluid.mass @ fluid.position + 2.0 * place[0]) / total
    v = fluid.velocity - (fluid.mass @ fluid.velocity + 2.0 * speed[0]) / total
    assert np.allclose(decay, np.linalg.norm(np.cross(x, v), axis=1) / (x**2).sum(axis=1) / 4.0, rtol=1e-13)
    _, before = effect.exchange(np, replace(fluid, points={"companions": other}))
    assert np.array_equal(before, effect.exchange(np, fluid)[1])
    assert np.abs(decay - before).max() > 0.1 * before.max()


def test_heating_and_cooling_come_to_their_equilibrium_in_one_step() -> None:
    """u = floor + tau heating_rate, in a step of a thousand time scales: all that is given is radiated, or kept."""
    options = {"time_scale": 1e-3, "floor": 0.1, "heating_rate": 50.0}
    first, last = cooled(options, 1.0, 1)
    assert np.allclose(energy_of(last), 0.15, rtol=1e-12)
    gained = last.mass @ (energy_of(last) - energy_of(first))
    assert float(last.ledger.heating.total[0]) == pytest.approx(gained, abs=1e-13 * 50.0)


def test_below_the_floor_nothing_is_radiated_or_given() -> None:
    start = np.linspace(0.05, 0.5, len(POSITION))
    first, last = cooled({"time_scale": 0.01, "floor": 0.2}, 1.0, 3, start=start)
    before, after = energy_of(first), energy_of(last)
    assert np.array_equal(after[before < 0.2], before[before < 0.2])
    assert np.allclose(after[before > 0.2], 0.2, rtol=1e-12)
    assert (before < 0.2).any()
    assert (before > 0.2).any()


def test_steps_resolve_the_cooling_time_unless_switched_off() -> None:
    fluid = SimpleNamespace(
        time=0.0, density=np.ones(3), smoothing_length=np.full(3, 0.1), thermal_energy=np.array([1.0, 0.1, 0.0])
    )
    options = {"time_scale": 0.2, "floor": 0.1, "heating_rate": 0.5}
    limit = catalogue.build("cooling", options).timestep(np, fluid)
    moved = (0.1**2 / 0.5) ** (1 / 3)
    assert np.allclose(limit, [1.0 / 4.0, 0.1 / 0.5 + moved, moved])
    # Without heat there is nothing to lose, and below the floor nothing is lost.
    limit = catalogue.build("cooling", {"time_scale": 0.2}).timestep(np, fluid)
    assert np.allclose(limit[:2], 0.2)
    assert limit[2] > 1e50
    limit = catalogue.build("cooling", {"time_scale": 0.2, "floor": 0.5}).timestep(np, fluid)
    assert (limit[1:] > 1e50).all()
    assert catalogue.build("cooling", {**options, "limit": "none"}).timestep(np, fluid) is None


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({}, "needs time_scale"),
        ({"law": "beta"}, "needs beta"),
        ({"law": "power_law", "time_scale": 1.0}, "needs reference_density and reference_energy"),
        ({"time_scale": 1.0, "beta": 3.0}, "has no beta"),
        ({"law": "beta", "beta": 3.0, "time_scale_change": -1.0}, "has no time_scale_change"),
    ],
)
def test_options_that_a_law_lacks_or_does_not_have_are_refused(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        catalogue.build("cooling", options)


def test_matter_without_a_thermal_part_is_refused() -> None:
    scene = """
        name = "cold"
        units = "code"
        [body]
        kind = "uniform"
        particles = 64
        mass = 1.0
        radius = 1.0
        relax = false
        [equation_of_state]
        kind = "isothermal"
        sound_speed = 1.0
        [effects.pressure]
        [effects.cooling]
        time_scale = 1.0
        [time]
        end = 1.0
    """
    with pytest.raises(SceneError, match=r"\[effects.cooling\] needs matter that can be warm"):
        prepared(scene)
