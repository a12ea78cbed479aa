"""Tides in the particle fluid: Love numbers, Roche's limit, the torque on a body that turns, and a disruption."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from astroinertia.bodies.roche_polytrope import roche_limit
from astroinertia.build.assemble import prepare
from astroinertia.models.sph.evolution import Particles
from astroinertia.scene import load
from astroinertia.studies.love_number_of_fluid import love_number_of_fluid

SIMS = Path(__file__).parent.parent.parent / "sims"


def scene(name: str, *settings: str) -> Particles:
    """A scene of sims, prepared."""
    return prepare(load.load_file(SIMS / f"{name}.toml", settings)).evolution


def ratio_to_theory(index: float, particles: int) -> float:
    found = love_number_of_fluid(index, particles).love_number
    return float(found) / found.attrs["exact"]


@pytest.mark.full
def test_few_particles_are_drawn_out_by_a_tide_as_the_fluid_is() -> None:
    """n = 1.5; measured with 1000 and 3000 particles: 0.996 of k2 and nearer; 400: 1.026, for the body is smaller."""
    assert ratio_to_theory(1.5, 400) == pytest.approx(1.0, abs=0.06)


@pytest.mark.full
@pytest.mark.parametrize("index", [0.5, 1.0, 1.5])
def test_love_numbers_within_three_percent(index: float, result: Any) -> None:
    """1000 and 3000 particles: within 5 % and 3 % of the exact k2, and nearer with more."""
    ratios = {count: ratio_to_theory(index, count) for count in (1000, 3000)}
    result(**{f"ratio_{count}": ratio for count, ratio in ratios.items()})
    assert abs(ratios[1000] - 1.0) <= 0.05
    assert abs(ratios[3000] - 1.0) <= 0.03


def in_synchronous_orbit(tide: float, particles: int, orbits: float) -> tuple[float, float]:
    """Longest extent along the companion over R, largest until the end, and how many orbits it lasted undamped."""
    matrix = [[-2 * tide, 0.0, 0.0], [0.0, tide, 0.0], [0.0, 0.0, tide]]
    body = scene(
        "roche_limit",
        f"body.particles={particles}",
        f"effects.external_field.quadratic={matrix}",
        f"effects.rotating_frame.rate={math.sqrt(tide)}",
    )
    period, released = 2 * math.pi / math.sqrt(tide), 25.0
    end, extent = released + orbits * period, 0.0
    while body.time < end and extent < TORN:
        body.advance(end)
        extent = max(extent, float(np.ptp(np.asarray(body.state.position)[:, 0])) / 2)
    return extent, (body.time - released) / period


TORN = 4.0  # half the extent, over R: the longest figure in equilibrium has 1.66
INSIDE = 1.03  # distances over the limit of the compressible fluid


@pytest.mark.full(inputs=["sims/roche_limit.toml"])
@pytest.mark.parametrize("particles", [1000, 3000])
def test_roches_limit_is_bracketed(particles: int, result: Any) -> None:
    """At 1.03 times the limiting distance of n = 0.5 it lasts five orbits, at 1/1.03 it is torn within them."""
    limit = roche_limit(0.5).scaled_distance
    outside = in_synchronous_orbit((limit * INSIDE) ** -3, particles, 5.0)
    inside = in_synchronous_orbit((limit / INSIDE) ** -3, particles, 5.0)
    result(limit=limit, extent_outside=outside[0], orbits_outside=outside[1], orbits_inside=inside[1])
    assert outside[0] < 2.5 and outside[1] >= 5.0
    assert inside[0] >= TORN and inside[1] < 5.0


def test_a_tide_turns_a_star_by_the_torque_in_its_ledger() -> None:
    """What changes the spin is the tide alone, by its impulse in the ledger, which is the integral of its torque."""
    body = scene("tidal_spin_down", "body.particles=200", "body.relax=false")
    records = [body.record(None)]
    for _ in range(150):
        body.advance(body.end)
        records.append(body.record(records[0]["potential_energy"]))
    first, last = records[0], records[-1]
    row, scale = body.effects.index("external_field"), float(first["angular_momentum"][2])
    change = last["angular_momentum"][2] - first["angular_momentum"][2]
    given = np.array([moment[0, 1] - moment[1, 0] for moment in last["mixed_impulse"]])
    assert abs(change) > 1e-3 * scale
    assert change == pytest.approx(given[row], abs=1e-13 * scale)
    assert np.abs(np.delete(given, row)).max() <= 1e-13 * scale
    # The integral of the torque over time, by the trapezoidal rule, which is what kicks at both ends of a step do.
    times, torques = (np.array([each[name] for each in records]) for name in ("time", "torque"))
    assert change == pytest.approx(np.trapezoid(torques[:, row, 2], times), abs=1e-12 * scale)
