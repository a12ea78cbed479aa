"""The ledger follows particles to round-off, and says which effect did what."""

import json
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

from astroinertia.inertia.tensor import inertia_from_second_moment
from astroinertia.ledger import moments as ledger_moments
from astroinertia.models.sph.kick_drift import velocity_change

REFERENCE = Path(__file__).parents[2] / "reference"


def body(seed: int = 3, count: int = 40) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    mass = random.uniform(0.5, 1.5, count) / count
    return mass, random.normal(size=(count, 3)) + [3.0, 0.0, 1.0], random.normal(size=(count, 3)) + [0.3, -0.2, 0.1]


def test_a_thousand_kicks_and_drifts_close_to_round_off() -> None:
    """Variable steps, a moving centre of mass, three effects of which one pushes the whole body."""
    mass, position, velocity = body()
    random = np.random.default_rng(7)
    entry = ledger_moments.open_ledger(np, mass, position, velocity, 3)
    kinetic_at_start = 0.5 * (mass[:, None] * velocity**2).sum()
    mixed_at_start = ledger_moments.moments(mass, position, velocity)[1]
    elapsed = 0.0
    for _ in range(1000):
        dt = random.uniform(0.0005, 0.002)
        pull = -(position - ledger_moments.centre_of_mass(mass, position))
        increments = [dt * pull, dt * 0.3 * random.normal(size=position.shape), dt * np.ones_like(position)]
        after = velocity + sum(increments)
        entry = ledger_moments.after_kick(np, entry, mass, position, velocity, after, increments)
        velocity = after
        position = position + dt * velocity
        entry = ledger_moments.after_drift(np, entry, dt)
        elapsed += dt
    second, mixed, kinetic = ledger_moments.moments(mass, position, velocity)
    largest = float(entry.largest_inertia)
    direct = inertia_from_second_moment(second)
    assert np.abs(entry.inertia_tensor() - direct).max() < 5e-14 * largest
    assert np.abs(entry.mixed_moment.total - mixed).max() < 5e-14 * np.abs(mixed).max()
    assert np.abs(entry.kinetic_tensor.total - kinetic).max() < 5e-14 * np.abs(kinetic).max()
    gain = 0.5 * (mass[:, None] * velocity**2).sum() - kinetic_at_start
    assert entry.work.total.sum() == pytest.approx(gain, rel=1e-12)
    # Effects change the antisymmetric part of P, the angular momentum; free motion does not.
    turned = entry.mixed_impulse.total.sum(axis=0)
    spin = mixed - mixed_at_start
    assert np.allclose(turned - turned.T, spin - spin.T, atol=1e-13)
    assert np.allclose(entry.impulse.total[2], mass.sum() * elapsed, rtol=1e-13)


@pytest.mark.slow
def test_rounding_of_velocities_and_places_does_not_pile_up() -> None:
    """A turning body in a harmonic field: not in the ledger, rounding is 4e-13 of Q after 2000 steps, and grows."""
    mass, position, velocity = body()
    position = position - ledger_moments.centre_of_mass(mass, position)
    velocity = np.cross([0.0, 0.0, 1.0], position)
    entry, dt = ledger_moments.open_ledger(np, mass, position, velocity, 1), 0.01
    for _ in range(2000):
        after = velocity - dt * position
        entry = ledger_moments.after_kick(np, entry, mass, position, velocity, after, [position], -dt)
        moved = position + dt * after
        entry = ledger_moments.after_rounding(
            np, ledger_moments.after_drift(np, entry, dt), mass, position, moved, after, dt
        )
        position, velocity = moved, after
    second, mixed, kinetic = ledger_moments.moments(mass, position, velocity)
    assert np.abs(entry.inertia_tensor() - inertia_from_second_moment(second)).max() < 2e-14
    for found, direct in ((entry.mixed_moment, mixed), (entry.kinetic_tensor, kinetic)):
        assert np.abs(found.total - direct).max() < 1e-15


def test_each_effect_is_entered_in_its_own_row() -> None:
    mass, position, velocity = body()
    entry = ledger_moments.open_ledger(np, mass, position, velocity, 2)
    increments = [np.zeros_like(position), 0.1 * position]
    entry = ledger_moments.after_kick(np, entry, mass, position, velocity, velocity + increments[1], increments)
    assert not entry.mixed_impulse.total[0].any() and entry.work.total[0] == 0.0
    relative = position - ledger_moments.centre_of_mass(mass, position)
    assert np.allclose(entry.mixed_impulse.total[1], 0.1 * ledger_moments.weighted_outer(mass, relative, relative))


def test_a_compensated_sum_keeps_what_a_plain_one_loses() -> None:
    total = ledger_moments.Compensated(np.float64(1.0), np.float64(0.0))
    for _ in range(10000):
        total = total.add(np.float64(1e-17))
    assert total.value == 1.0
    assert total.total - 1.0 == pytest.approx(1e-13, rel=1e-2)


@pytest.mark.slow
def test_the_size_of_an_inertia_tensor_follows_from_the_second_moment() -> None:
    second, _, _ = ledger_moments.moments(*body())
    norm = np.linalg.norm(inertia_from_second_moment(second))
    assert ledger_moments.inertia_size(np, second) == pytest.approx(norm, rel=1e-14)


def test_rate_of_inertia_is_its_derivative_along_the_motion() -> None:
    """dI/dt = tr(P + P^T) 1 - (P + P^T) equals the JVP of I along v, and the independent value for five particles."""
    case = json.loads((REFERENCE / "inertia_rate.json").read_text())
    position, velocity = np.array(case["inputs"]["X"]), np.array(case["inputs"]["V"])
    mass = np.array(case["inputs"].get("M", case["inputs"].get("m")), dtype=float)
    with jax.enable_x64(True):

        def inertia(x: jax.Array) -> jax.Array:
            second = (mass[:, None] * x).T @ x
            return inertia_from_second_moment(second)

        value, rate = jax.jvp(inertia, (position,), (velocity,))
    mixed = ledger_moments.weighted_outer(mass, position, velocity)
    ours = inertia_from_second_moment(mixed + mixed.T)
    assert np.allclose(ours, rate, rtol=0, atol=1e-14)
    assert np.allclose(value, case["value"]["Theta"], rtol=1e-12)


def test_a_coriolis_matrix_does_no_work_and_damping_is_midpoint() -> None:
    mass, _, velocity = body()
    turn = np.array([[0.0, 2.0, -0.4], [-2.0, 0.0, 1.0], [0.4, -1.0, 0.0]])
    push = np.random.default_rng(2).normal(size=velocity.shape)
    dt = 0.7
    spans: list[Any] = [dt, np.full(len(mass), dt)]  # with a span for each particle, as with individual steps
    both, again = (velocity_change(np, [push, None], [None, turn], velocity, span, dt).increments for span in spans)
    assert all(np.array_equal(one, other) for one, other in zip(both, again, strict=True))
    after = velocity + both[0] + both[1]
    assert np.abs(both[1] - dt * 0.5 * (velocity + after) @ turn.T).max() < 1e-14
    assert abs((mass[:, None] * both[1] * (velocity + after)).sum()) < 1e-15 * np.abs(both[1]).sum()
    slowed = velocity_change(np, [None], [-np.eye(3) / 2.0], velocity, dt).after
    assert np.allclose(slowed, velocity * (1 - dt / 4) / (1 + dt / 4), rtol=1e-14)


def test_taking_matter_away_leaves_the_moments_of_the_rest() -> None:
    """A subset taken from a body off the origin: Q, P and K of what is left by direct sums, and a row that lost it."""
    mass, position, velocity = body()
    taken = np.arange(len(mass)) % 3 == 0
    entry = ledger_moments.open_ledger(np, mass, position, velocity, 2)
    whole = ledger_moments.whole(np, mass, position, velocity)
    lost = ledger_moments.removed(whole, mass[taken], position[taken], velocity[taken])
    entry = ledger_moments.after_removal(entry, lost, 1, -0.3, -0.2)
    left = ledger_moments.moments(mass[~taken], position[~taken], velocity[~taken])
    for found, wanted in zip((entry.second_moment, entry.mixed_moment, entry.kinetic_tensor), left, strict=True):
        np.testing.assert_allclose(found.total, wanted, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(entry.impulse.total, [np.zeros(3), -(mass[taken] @ velocity[taken])], rtol=1e-14)
    assert entry.work.total.tolist() == [0.0, -0.3]
    assert entry.heating.total.tolist() == [0.0, -0.2]
    twice = lost + lost
    np.testing.assert_allclose(twice.mass, 2 * mass[taken].sum(), rtol=1e-15)
    np.testing.assert_allclose(entry.mixed_impulse.total[1], -0.5 * twice.mixed_moment, rtol=1e-14)
