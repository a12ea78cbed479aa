"""Gravitational radiation reaction on particles: what it takes, against the quadrupole formula and the decay by it."""

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from astroinertia.effects import catalogue
from astroinertia.effects.kinds.radiation_reaction import Waves
from astroinertia.inertia.tensor import axial_vector
from astroinertia.models.sph.step import step
from astroinertia.sph.placement import isotropised
from tests.ball import ball, state_of
from tests.evolve import prepared

PACE = 1.3  # of all motion in the spring-like field, rad per time


SWINGING = """name = "swinging"
units = "code"
[body]
kind = "power_law"
exponent = 1.5
particles = 200
mass = 1.0
radius = 1.0
placement = "random"
relax = false
specific_internal_energy = 0.4
velocity_gradient = [[-0.6, 0.2, 0.0], [0.1, 0.5, 0.0], [0.0, 0.0, 0.1]]
rotation = { rate = 0.6 }
[equation_of_state]
kind = "ideal"
[numerics]
timesteps = "individual"
[effects.gravity]
[effects.pressure]
[effects.viscosity]
[effects.radiation_reaction]
speed_of_light = 3.0
[time]
end = 10.0
"""


def field_and_waves(light: float, along_z: float = 0.0) -> tuple[Any, Any]:
    field = np.diag([PACE**2, PACE**2, along_z * PACE**2])
    return (
        catalogue.build("external_field", {"quadratic": tuple(map(tuple, field))}),
        catalogue.build("radiation_reaction", {"speed_of_light": light}),
    )


def moving(
    position: np.ndarray, velocity: np.ndarray, light: float, turns: float, steps: int, along_z: float = 0.0
) -> tuple[Any, Any]:
    """The first and last state of free particles in a field in which all motion has one period.

    along_z: how strong it is there, with 0 particles keep their height.
    """
    effects = field_and_waves(light, along_z)
    problem, first, arrangement = state_of(*effects, position=position, velocity=velocity)
    state = first
    for _ in range(steps):
        state = step(problem, arrangement, state, np.float64(turns * 2.0 * np.pi / PACE / steps))
    return first, state


def stretched() -> np.ndarray:
    """An ellipsoid along the axes: nothing of it is seen but its figure."""
    return isotropised(ball(60), 1.0) * [1.0, 0.5, 0.7]


def two_bodies(separation: np.ndarray) -> np.ndarray:
    """Each of 16 points at one place."""
    position = np.repeat([separation / 2, -separation / 2], 16, axis=0)
    position = position + 1e-6 * np.random.default_rng(1).normal(size=position.shape)
    return position - position.mean(axis=0)


def second_moment(state: Any) -> np.ndarray:
    return np.einsum("n,ni,nj->ij", state.mass, state.position, state.position)


def turning_loss(state: Any, light: float) -> float:
    """(32/5) (G/c^5) Omega^6 (difference of the moments in the plane)^2 (MTW 1973, eqs. 36.1 and 36.9)."""
    inner = np.linalg.eigvalsh(second_moment(state)[:2, :2])
    return 32.0 / 5.0 * light**-5 * PACE**6 * (inner[1] - inner[0]) ** 2


@pytest.mark.full
def test_a_turning_figure_loses_energy_and_angular_momentum_by_the_quadrupole_formula() -> None:
    """dE/dt = Omega dL/dt: the error falls with the step, of which the first three see no wave yet."""
    errors = []
    for steps in (50, 100, 200):
        position = stretched()
        first, last = moving(position, np.cross([0.0, 0.0, PACE], position), 20.0, 1.0, steps)
        time = 2.0 * np.pi / PACE * (1.0 - 3.0 / steps)
        energy = float(last.ledger.work.total[1]) / (-turning_loss(first, 20.0) * time)
        turned = axial_vector(last.ledger.mixed_impulse.total[1])
        spin = turned[2] * PACE / (-turning_loss(first, 20.0) * time)
        assert spin == pytest.approx(energy, rel=0.15 / steps)
        assert np.abs(turned[:2]).max() < 1e-6 * abs(turned[2])
        assert np.abs(last.ledger.impulse.total[1]).max() < 1e-15
        errors.append(abs(energy - 1.0))
    assert errors[-1] < 0.02, errors
    assert all(a > 1.8 * b for a, b in itertools.pairwise(errors)), errors


def test_two_bodies_on_a_circle_lose_what_peters_found_and_spiral_in() -> None:
    """Of two points on a spring E ~ a^2 and dE/dt ~ -a^4: 1/a^2 grows linearly with (32/5) G mu^2 a^4 Omega^6/c^5."""
    light = 3.0
    separation = np.array([0.8, 0.0, 0.0])
    position = two_bodies(separation)
    velocity = np.cross([0.0, 0.0, PACE], position)
    first, last = moving(position, velocity, light, 4.0, 400)
    reduced, a = 0.25, 0.8
    power = 32.0 / 5.0 * reduced**2 * a**4 * PACE**6 / light**5  # Peters 1964, Phys. Rev. 136, B1224, eq. 15
    energy = reduced * a**2 * PACE**2
    assert turning_loss(first, light) == pytest.approx(power, rel=1e-4)
    time = 4.0 * 2.0 * np.pi / PACE * (1.0 - 3.0 / 400)
    expected = 1.0 / (1.0 + power * time / energy)
    assert expected < 0.9
    left = last.mass @ (last.velocity**2 + PACE**2 * last.position**2).sum(axis=1) / 2.0 / energy
    assert left == pytest.approx(expected, rel=2e-3)
    lost = float(last.ledger.work.total[1]) / energy
    assert lost == pytest.approx(left - 1.0, rel=1e-3)


@pytest.mark.parametrize("share", [1e-2, 1e-4, 1e-8])
def test_a_short_step_as_between_outputs_at_nearly_the_same_time_changes_nothing_of_the_loss(share: float) -> None:
    """With a hundredth of a step after each tenth five times as much was lost; with less the run ended."""
    position, light, steps = two_bodies(np.array([0.8, 0.0, 0.0])), 3.0, 200
    velocity = np.cross([0.0, 0.0, PACE], position)
    _, even = moving(position, velocity, light, 2.0, steps)
    problem, state, arrangement = state_of(*field_and_waves(light), position=position, velocity=velocity)
    dt = 4.0 * np.pi / PACE / steps
    for number in range(steps):
        parts = [dt] if number % 10 != 5 else [dt * (1.0 - share), dt * share]
        for part in parts:
            state = step(problem, arrangement, state, np.float64(part))
    assert float(state.ledger.work.total[1]) == pytest.approx(float(even.ledger.work.total[1]), rel=2e-3)


@pytest.mark.usefixtures("steps_differ")
def test_nor_does_it_with_individual_steps() -> None:
    """The same of gas in a base step each: the loss was wrong by a factor, or the steps fell to nothing."""
    lost = []
    for share in (0.0, 1e-4):
        body = prepared(SWINGING)
        rungs = set()
        for time in np.linspace(0.1, 0.6, 6):
            for until in (time, time + 0.02 * share):
                while body.time < until * (1.0 - 1e-13):
                    body.advance(until)
                    rungs.add(body.note)
        assert any(note.count(" ") > 4 for note in rungs)  # several of them
        lost.append(body.record(None)["work"][body.effects.index("radiation_reaction")])
    assert lost[1] == pytest.approx(lost[0], rel=0.05)
    assert lost[0] < 0.0


def test_an_inspiral_loses_what_its_frequency_asks_for_now() -> None:
    """Two points draw together by 4.4 % in three turns: a mean of the last turn's frequencies lost 6.4 % too little."""
    light, distance, turns, steps = 4.8, 0.8, 3.0, 300
    position = two_bodies(np.array([distance, 0.0, 0.0]))
    problem, state, arrangement = state_of(
        catalogue.build("gravity", {"softening": 0.1}),
        catalogue.build("radiation_reaction", {"speed_of_light": light}),
        position=position,
        velocity=np.cross([0.0, 0.0, distance**-1.5], position),
    )
    dt = turns * 2.0 * np.pi * distance**1.5 / steps
    for _ in range(steps):
        state = step(problem, arrangement, state, np.float64(dt))
    # Peters 1964, eq. 5.9, of a reduced mass of 1/4; the first three steps see no wave yet.
    last = (distance**4 - 256.0 / 5.0 * 0.25 / light**5 * (steps - 3) * dt) ** 0.25
    lost = float(state.ledger.work.total[1])
    assert last < 0.957 * distance
    assert lost == pytest.approx(0.125 / distance - 0.125 / last, rel=0.035)


def test_what_changes_faster_than_any_wave_is_not_taken_for_one_that_goes_on() -> None:
    """In a collapse with a bounce the ratio of the means grew a thousandfold, and steps fell to nothing."""
    none, now = np.zeros((3, 3)), np.zeros(())
    waves = Waves(now, now, none, none, np.ones(2), np.array([1e3, 1.0]), now)
    assert waves.frequency_to_the_fourth(np) == 2e3
    assert replace(waves, third_square=np.array([3.0, 4.0])).frequency_to_the_fourth(np) == 2.25


@pytest.mark.full
def test_a_body_that_swings_along_one_axis_loses_the_energy_of_its_waves() -> None:
    """x = a cos(Omega t): the mean of (1/5) (G/c^5) |d3Q/dt3|^2 over whole periods, with no angular momentum at all."""
    light = 12.0
    position = stretched()
    first, last = moving(position, np.zeros_like(position), light, 4.0, 400, along_z=1.0)
    # Q = Q_0 (1 + cos(2 Omega t))/2 of the traceless Q_0.
    moment = second_moment(first)
    moment -= np.trace(moment) / 3.0 * np.eye(3)
    power = 0.2 * light**-5 * (moment**2).sum() * (0.5 * (2.0 * PACE) ** 3) ** 2 * 0.5
    time = 4.0 * 2.0 * np.pi / PACE
    assert float(last.ledger.work.total[1]) == pytest.approx(-power * time, rel=0.01)
    assert np.abs(axial_vector(last.ledger.mixed_impulse.total[1])).max() < 1e-9 * power * time
