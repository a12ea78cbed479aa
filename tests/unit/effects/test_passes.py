"""Time steps beside point masses that pass: none steps over a pass that matters, and a weak one costs nothing."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from astroinertia.effects import catalogue
from astroinertia.effects.passes import falling_time, time_beside
from astroinertia.gravity.point_masses import UNNOTICED, PointMasses
from astroinertia.models.sph import points as beside_the_fluid
from tests.evolve import prepared, reached

COURANT = 0.3


def beside(away: Any, velocity: Any, mass: float, sound_speed: float = 0.0, softening: float = 0.0) -> float:
    """The time of a particle at rest at the origin beside one point."""
    still = SimpleNamespace(
        position=np.zeros((1, 3)), velocity=np.zeros((1, 3)), sound_speed=np.array([float(sound_speed)])
    )
    points = np.array([mass]), np.array([away], dtype=float), np.array([velocity], dtype=float)
    return float(time_beside(np, still, *points, softening**2)[0])


def test_a_fast_pass_takes_the_distance_over_the_speed_and_a_slow_one_the_orbital_time() -> None:
    assert beside([3.0, 4.0, 0.0], [0.0, 0.0, 50.0], mass=2.0) == pytest.approx(0.1, rel=1e-14)
    assert beside([3.0, 0.0, 0.0], [0.0, 0.0, 50.0], mass=2.0, softening=4.0) == pytest.approx(0.1, rel=1e-14)
    orbital = np.sqrt(125.0 / 2.0)
    assert beside([3.0, 4.0, 0.0], [0.0, 0.1, 0.0], mass=2.0) == pytest.approx(orbital, rel=1e-14)
    assert beside([3.0, 4.0, 0.0], [0.0, 0.0, 0.0], mass=2.0) == pytest.approx(orbital, rel=1e-14)
    assert beside([3.0, 4.0, 0.0], [0.0, 0.0, 0.0], mass=0.0) > 1e20


@pytest.mark.parametrize(
    ("times", "low", "high"), [((time_beside,), 0.08, 0.2), ((time_beside, falling_time), 0, 0.03)]
)
def test_what_falls_onto_a_point_hardly_gains_energy(times: tuple, low: float, high: float) -> None:
    """From rest, to a fiftieth of the distance, where it is accreted: what is gained is gained for good."""
    away, speed, reached_at = 1.0, 0.0, 0.02
    while away > reached_at:
        particle = SimpleNamespace(
            position=np.array([[away, 0.0, 0.0]]), velocity=np.array([[speed, 0.0, 0.0]]), sound_speed=np.zeros(1)
        )
        points = np.ones(1), np.zeros((1, 3)), np.zeros((1, 3)), 0.0
        dt = COURANT * min(float(time(np, particle, *points)[0]) for time in times)
        speed -= 0.5 * dt / away**2
        away += dt * speed
        speed -= 0.5 * dt / away**2
    gained = (0.5 * speed**2 - 1.0 / away + 1.0) * away
    assert low <= gained <= high


def test_what_flies_past_a_point_is_not_falling() -> None:
    """Within twice the energy of escape it falls, towards the point and not away from it."""

    def of(speed: float) -> float:
        particle = SimpleNamespace(position=np.array([[2.0, 0.0, 0.0]]), velocity=np.array([[speed, 0.0, 0.0]]))
        return float(falling_time(np, particle, np.ones(1), np.zeros((1, 3)), np.zeros((1, 3)), 0.0)[0])

    assert of(-1.4) == pytest.approx(0.5 * 2.0 / 1.4)
    assert of(-1.42) > 1e20 and of(0.5) > 1e20


@pytest.mark.parametrize("mass", [1e-2, 1.0, 1e2])
@pytest.mark.parametrize("start", [-31.0, -3.7, -0.2])
def test_steps_past_a_point_give_the_impulse_of_the_impulse_approximation(mass: float, start: float) -> None:
    """2M/(b w), Binney & Tremaine 2008, eq. 1.30, and its part along the path, or to UNNOTICED of the sound speed."""
    speed, impact = 1e3, 0.1
    for sound_speed in (0.0, 1.0):
        at, gained = start, np.zeros(3)
        while at < 40.0:
            span = COURANT * beside([at, impact, 0.0], [speed, 0.0, 0.0], mass, sound_speed)
            span = min(span, 0.5)  # what all else allows: 500 in length
            for there in (at, at + speed * span):
                away = np.array([there, impact, 0.0])
                gained += 0.5 * span * mass * away / np.linalg.norm(away) ** 3
            at += speed * span
        ends = [np.array([x, impact, 0.0]) for x in (start, at)]
        across = np.diff([x[0] / np.linalg.norm(x) for x in ends])[0] * mass / (impact * speed)
        forward = -np.diff([1.0 / np.linalg.norm(x) for x in ends])[0] * mass / speed
        error = np.abs(gained - np.array([forward, across, 0.0])).max()
        assert error <= max(0.02 * 2.0 * mass / (impact * speed), 2.0 * UNNOTICED * sound_speed)


def test_a_pass_that_nothing_notices_costs_no_steps() -> None:
    """A point of 1e-6 that flies through gas whose sound speed is 1: its kicks are far below that."""
    assert beside([0.0, 0.5, 0.0], [100.0, 0.0, 0.0], mass=1e-6, sound_speed=1.0) > 1.0


STAR = """
name = "passed"
units = "code"
[body]
kind = "polytrope"
index = 1.5
particles = 60
mass = 1.0
radius = 1.0
relax = false
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[effects.gravity]
[effects.pressure]
[time]
end = 0.4
"""


@pytest.mark.parametrize("scheme", ["global", "individual"])
def test_a_star_that_a_perturber_passes_at_ten_times_the_speed_of_an_orbit_gets_its_impulse(scheme: str) -> None:
    """The perturber's own orbit turns by as much: the attraction of the origin is minus its acceleration."""
    options = {"mass": 3e4, "position": (0.0, 10.0, 0.0), "eccentricity": 100.0, "pericentre_time": 0.2}
    listed = 'frame = "direct"\n' + "\n".join(
        f"{name} = {list(value) if isinstance(value, tuple) else value}" for name, value in options.items()
    )
    body = prepared(STAR + f"[effects.tide]\n{listed}\n", f"numerics.timesteps={scheme}")
    first, last = reached(body, 0.4)
    tide, dt = catalogue.build("tide", options), 1e-6
    speeds = [
        (tide.place(np, SimpleNamespace(time=t + dt)) - tide.place(np, SimpleNamespace(time=t - dt))) / (2.0 * dt)
        for t in (0.0, 0.4)
    ]
    expected = speeds[0] - speeds[1]
    assert np.linalg.norm(expected) > 5.0  # five times the speed of its sound
    error = np.linalg.norm(last["momentum"] - first["momentum"] - expected)
    assert error <= 0.03 * np.linalg.norm(expected)


@pytest.mark.parametrize("kind", ["companions", "sinks"])
def test_the_steps_beside_points_that_move_with_the_fluid_are_by_their_speed_relative_to_it(kind: str) -> None:
    points = PointMasses(np.array([2.0]), np.array([[3.0, 4.0, 0.0]]), np.array([[7.0, 0.0, 50.0]]), np.zeros(()))
    options = {"companions": {"motion": "live", "frame": "direct"}, "sinks": {"density": 1.0, "radius": 100.0}}
    fluid = SimpleNamespace(
        position=np.zeros((1, 3)), velocity=np.array([[7.0, 0.0, 0.0]]), sound_speed=np.zeros(1),
        points={kind: points}, point_masses=[points],
    )  # fmt: skip
    assert catalogue.build(kind, options[kind]).timestep(np, fluid) == pytest.approx([0.1], rel=1e-14)


@pytest.mark.parametrize("apart", [False, True])
@pytest.mark.parametrize(
    ("masses", "sound_speed", "steps"), [((1.0, 0.3), 0.0, 45), ((40.0, 10.0), 10.0, 45), ((1e-4, 1e-3), 1.0, 1)]
)
def test_two_points_that_pass_each_other_far_above_the_speed_of_their_orbit_turn_as_they_should(
    masses: tuple[float, float], sound_speed: float, steps: int, apart: bool
) -> None:
    """2 (m + M)/(b w), Binney & Tremaine 2008, eq. 1.30, to 2 %, or to UNNOTICED of the sound speed.

    By the orbital time alone the first step goes past all of it.
    """
    speed, impact, length = 300.0, 0.1, 10.0
    place, velocity = np.array([[0.0] * 3, [-length, impact, 0.0]]), np.array([[0.0] * 3, [speed, 0.0, 0.0]])
    rows = [slice(0, 1), slice(1, 2)] if apart else [slice(0, 2)]
    groups = {
        kind: PointMasses(np.array(masses)[row], place[row], velocity[row], np.zeros(()))
        for kind, row in zip(("sinks", "companions"), rows, strict=False)
    }
    time, end, taken = 0.0, 2.0 * length / speed, 0
    while time < end:
        among = beside_the_fluid.moving(groups)
        limit = min(float(group.meeting_time(np, among, sound_speed)) for group in among)
        span = min(COURANT * limit, end - time)
        groups, time, taken = beside_the_fluid.drifted(np, groups, span, time + span), time + span, taken + 1
    found = np.diff(np.concatenate([group.velocity for group in groups.values()]), axis=0)[0] - velocity[1]
    across = -2.0 * sum(masses) / (impact * speed) * length / np.hypot(length, impact)
    assert np.abs(found[1:] - [across, 0.0]).max() <= max(0.02 * abs(across), UNNOTICED * sound_speed)
    assert taken <= steps
