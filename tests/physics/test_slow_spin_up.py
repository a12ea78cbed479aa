"""A star spun up slowly passes through the figures of equilibrium of the self-consistent field."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import brentq

from astroinertia.bodies.rotating_sequence import rotating_sequence
from astroinertia.errors import SceneError
from astroinertia.studies.slow_spin_up import along_sequence
from astroinertia.studies.spinup import spin_up

SIMS = Path(__file__).parents[2] / "sims"
SCENE = SIMS / "slow_spin_up.toml"
# What shedding begins at is 0.53 for n = 1.5, 0.565 for n = 0.5 and 0.572 for n = 0.25, in units of the star at rest.


def followed(index: float, particles: int, *settings: str) -> xr.Dataset:
    chosen = [f"body.index={index}", f"equation_of_state.gamma={1 + 1 / index}", f"body.particles={particles}"]
    return along_sequence(spin_up(SCENE, settings=[*chosen, *settings]), index)


def errors(found: xr.Dataset) -> np.ndarray:
    """Largest errors along the sequence of the axis ratio, of T/|W|, and of the axis ratio against Maclaurin's."""
    names = ("axis_ratio_error", "rotational_to_gravitational_error", "maclaurin_error")
    return np.array([float(np.abs(found[name]).max()) for name in names])


@pytest.mark.full
def test_a_star_spun_up_follows_its_sequence() -> None:
    """500 particles, twice as fast as the scene: axis ratio within 2 %, T/|W| within 7 % (N^-0.8 from there)."""
    found = followed(
        1.5,
        500,
        "numerics.precision=float64",
        "effects.damping.rate_change=0.017",
        "time.end=31",
        "effects.damping.time_scale=1.5",
    )
    axis_ratio, share, _ = errors(found)
    assert axis_ratio < 0.02
    assert share < 0.07
    # The errors are those of the star at rest, which is too small: T/|W| at one L goes as 1/(I |W|).
    assert np.ptp(found["rotational_to_gravitational_error"].values) < 0.02
    assert (np.diff(found["axis_ratio"]) < 0).all()
    assert float(found["disordered_energy"].max()) < 2e-4
    assert (found["angular_velocity"] >= found["rate"] * 0.528).all()


def test_a_star_that_was_never_so_fast_is_said_to_be() -> None:
    series = xr.Dataset(
        {
            "mass": ("time", [1.0]),
            "angular_momentum": (("time", "i"), [[0.0, 0.0, 0.02]]),
            "second_moment": (("time", "i", "j"), 0.1 * np.eye(3)[None]),
        },
        {"i": list("xyz"), "j": list("xyz")},
        {"reference_radius": 1.0, "gravitational_constant": 1.0},
    )
    with pytest.raises(SceneError, match=r"never turned at 0\.2 of the rate"):
        along_sequence(series, 1.5)


def test_times_are_in_units_of_the_star_at_rest() -> None:
    """G M = 4 at a radius of 1 makes a time of 8.2 twice as many units."""
    series = xr.Dataset(
        {
            "mass": ("time", [4.0]),
            "angular_momentum": (("time", "i"), [[0.0, 0.0, 0.24]]),
            "second_moment": (("time", "i", "j"), 0.4 * np.eye(3)[None]),
            "kinetic_energy": ("time", [1.0]),
            "gravitational_energy": ("time", [-10.0]),
        },
        {"i": list("xyz"), "j": list("xyz"), "time": [8.2]},
        {"reference_radius": 1.0, "gravitational_constant": 1.0},
    )
    assert float(along_sequence(series, 1.5, rates=(0.2,)).time[0]) == pytest.approx(16.4)


@pytest.mark.full
def test_a_star_settles_in_a_frame_that_turns() -> None:
    """500 particles at four fifths of the shedding rate: the exact star's axis ratio within 1.5 %, and still.

    Measured 0.86, 0.47 and 0.19 % with 500, 1000 and 3000; I is smaller by 3.9, 2.4 and 1.1 %, as at rest.
    """
    data = spin_up(
        SIMS / "settle_in_rotating_frame.toml", settings=["body.particles=500", "numerics.precision=float64"]
    )
    rate, star = 0.42, rotating_sequence(1.5)
    fastest = star.angular_momentum[star.figures[:, 0].argmax()]
    exact = star.at(brentq(lambda momentum: star.at(momentum)["angular_velocity"] - rate, 1e-3, fastest))
    second, energy = data["second_moment"].values[-1], data["kinetic_energy"].values[-1]
    across = (second[0, 0] + second[1, 1]) / 2
    assert np.sqrt(second[2, 2] / across) == pytest.approx(exact["axis_ratio"], rel=0.015)
    assert 2 * across == pytest.approx(exact["polar_moment"], rel=0.06)
    assert energy < 1e-5 * -data["gravitational_energy"].values[-1]
    assert np.linalg.norm(data["angular_momentum"].values[-1]) < 1e-3  # in the frame; its own is 0.1


@pytest.mark.full(inputs=["sims/slow_spin_up.toml"])
@pytest.mark.parametrize("particles", [1000, 3000, 10_000, 30_000, 100_000])
def test_it_follows_its_sequence_the_better_the_more_particles(particles: int, result: Any) -> None:
    """Eight rates up to 90 % of mass shedding: axis ratio and T/|W| within 1 % at 1e5 particles."""
    found = followed(1.5, particles)
    for name in ("angular_velocity", "axis_ratio", "rotational_to_gravitational"):
        result(**{name: found[name].values.tolist(), f"{name}_exact": found[f"{name}_exact"].values.tolist()})
    axis_ratio, share, _ = errors(found)
    result(axis_ratio_error=axis_ratio, rotational_to_gravitational_error=share)
    result(disordered_energy=float(found["disordered_energy"].max()))
    # Measured 0.93 % and 3.4 % at 1000, falling as N^-0.8; the bars leave as much again.
    assert axis_ratio <= max(0.01, 0.02 * (1000 / particles) ** 0.7)
    assert share <= max(0.01, 0.05 * (1000 / particles) ** 0.7)


@pytest.mark.full(inputs=["sims/slow_spin_up.toml"])
@pytest.mark.parametrize("index", [0.5, 0.25])
def test_a_stiff_star_follows_maclaurins_spheroids(index: float, result: Any) -> None:
    """20,000 particles: its own sequence, and the axis ratio of the Maclaurin spheroid of its T/|W|, within 1 %.

    T/|W| at an axis ratio would tell nothing near a sphere, where it goes as one less the ratio. From its own sequence
    T/|W| is 2.1 % with 3000 particles and 1.1 % with 10,000; from Maclaurin's the axis ratio is 0.3 and 0.5 %.
    """
    found = followed(index, 20_000, "effects.damping.rate_change=0.009", "time.end=66")
    axis_ratio, share, liquid = errors(found)
    result(axis_ratio_error=axis_ratio, rotational_to_gravitational_error=share, maclaurin_error=liquid)
    result(rotational_to_gravitational=found["rotational_to_gravitational"].values.tolist())
    assert max(axis_ratio, share, liquid) <= 0.01
