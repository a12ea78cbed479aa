"""Gravity with a softening that is given: smoothing lengths stay, so that any masses are allowed."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import astroinertia
from astroinertia.dataset import open_snapshots
from astroinertia.effects import catalogue
from astroinertia.errors import NumericalError, SceneError
from astroinertia.models.sph.evaluate import effect_accelerations, evaluated, potential_energies
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.step import step as sph_step
from astroinertia.scene.load import loads
from astroinertia.scene.plan import plan
from tests.ball import ball, state_of

pytestmark = pytest.mark.usefixtures("steps_differ")

RATIO = 1e-6  # of the masses of planets to that of their star
SOFTENING = 0.05
SCENE = """
name = "planets"
units = "code"
[body]
kind = "table"
file = "planets.csv"
entropy = 1.0
[equation_of_state]
kind = "ideal"
[effects]
gravity = { method = "direct", softening = 0.05 }
[time]
end = 0.3
"""


def planets(count: int = 12) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A star and planets on circular orbits from 1 on: masses, places, velocities, and the planets' angular speeds."""
    random = np.random.default_rng(0)
    radius, angle = np.linspace(1.0, 2.0, count), random.uniform(0.0, 2.0 * np.pi, count)
    away = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    along = np.stack([-np.sin(angle), np.cos(angle), 0.0 * angle], axis=1)
    mass = np.concatenate([[1.0], np.full(count, RATIO)])
    position = np.concatenate([np.zeros((1, 3)), radius[:, None] * away])
    velocity = np.concatenate([np.zeros((1, 3)), radius[:, None] ** -0.5 * along])
    return mass, position, velocity, radius**-1.5


def turned(position: np.ndarray, velocity: np.ndarray, speed: np.ndarray, time: float) -> np.ndarray:
    """Where the planets are on their circles."""
    angle = (speed * time)[:, None]
    return position[1:] * np.cos(angle) + velocity[1:] / speed[:, None] * np.sin(angle)


def start(**options: object):
    mass, position, velocity, _ = planets()
    problem, _, _ = state_of(position=ball(60), velocity=ball(60))
    problem = replace(problem, effects=(catalogue.build("gravity", options),))
    return problem, *initial_state(problem, mass, position, velocity, np.ones(len(mass)))


@pytest.mark.parametrize("method", ["direct", "points"])
def test_planets_go_round_a_star_of_a_million_times_their_mass(method: str) -> None:
    """Apart by 20 times the softening and more, orbits are Kepler's, and energy is kept to the order of the steps."""
    _, first, velocity, speed = planets()
    problem, state, arrangement = start(method=method, softening=SOFTENING)
    energies = []
    for _ in range(60):
        state = sph_step(problem, arrangement, state, np.float64(0.02))
        kinetic = 0.5 * state.mass @ (state.velocity**2).sum(axis=1)
        energies.append(kinetic + potential_energies(problem, state)["gravity"])
    apart = state.position[1:] - state.position[0]
    assert np.abs(apart - turned(first, velocity, speed, float(state.time))).max() < 1e-4
    assert np.ptp(energies) < 1e-7 * RATIO  # round-off of the star against its own softened potential
    assert np.array_equal(state.smoothing_length, np.full(len(state.mass), SOFTENING))


def test_softened_forces_are_those_of_the_kernel_and_derive_from_the_energy() -> None:
    problem, state, arrangement = start(method="direct", softening=1.5)

    def energy(position: np.ndarray) -> float:
        moved = evaluated(problem, arrangement, replace(state, position=position), np.float64(0.0))
        return float(potential_energies(problem, moved)["gravity"])

    for particle, axis in ((0, 0), (3, 1)):
        step = np.zeros_like(state.position)
        step[particle, axis] = 1e-5
        slope = (energy(state.position + step) - energy(state.position - step)) / 2e-5
        force = state.mass[particle] * effect_accelerations(np, state.rates)[0][particle, axis]
        assert abs(force + slope) < 1e-4 * abs(force)


def test_without_it_such_masses_are_refused_with_what_would_do() -> None:
    with pytest.raises(NumericalError, match=r"needs .* its own mass around it .* gravity alone can have a softening"):
        start(method="direct")


def test_effects_between_neighbours_are_refused_beside_it() -> None:
    with pytest.raises(
        SceneError, match=r"\[effects.gravity\] softening keeps smoothing lengths .* but pressure needs"
    ):
        loads(SCENE + "[effects.pressure]\n")


@pytest.mark.full
@pytest.mark.parametrize("timesteps", ["global", "individual"])
def test_a_scene_of_planets_runs(timesteps: str, tmp_path: Path) -> None:
    mass, position, velocity, speed = planets()
    rows = np.column_stack([position, velocity, mass])
    np.savetxt(tmp_path / "planets.csv", rows, delimiter=",", header="x,y,z,vx,vy,vz,mass", comments="")
    scene = loads(SCENE, (f'numerics.timesteps="{timesteps}"',), origin=str(tmp_path))
    assert re.search(r"smoothing lengths: 0.05 \(of every particle", plan(scene).text())
    found = astroinertia.run_scene(scene, tmp_path / "run")
    with astroinertia.open(found) as ds:
        assert "resolution_warnings" not in ds.attrs
    snapshots = open_snapshots(found)
    assert snapshots is not None
    with snapshots:
        place = snapshots["position"].isel(snapshot_time=-1).values
    assert np.abs(place[1:] - place[0] - turned(position, velocity, speed, 0.3)).max() < 1e-4
