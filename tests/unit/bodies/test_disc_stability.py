"""Toomre's criterion against an integrated orbit, a potential summed ring by ring, and the definition of stability."""

import numpy as np
import pytest
from astropy import units as u
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from astroinertia.bodies.disc_stability import (
    epicyclic_frequency,
    fastest_wavenumber,
    squared_frequency,
    toomre_parameter,
)


@pytest.mark.parametrize("slope", [-1.5, -1.0, -0.4, 0.0])
def test_a_disturbed_orbit_oscillates_at_the_epicyclic_frequency(slope):
    """In the field -Omega^2 r of a rotation law Omega = 1.3 r^slope, by its own equation of motion."""
    rate = 1.3

    def motion(_, state):
        r, speed = state
        return [speed, rate**2 / r**3 - rate**2 * r ** (2 * slope + 1)]  # the angular momentum of the circle r = 1

    def outermost(_, state):
        return state[1]

    outermost.direction = -1
    orbit = solve_ivp(motion, (0, 40), [1 + 1e-5, 0.0], "DOP853", events=outermost, rtol=1e-12, atol=1e-16)
    turns = orbit.t_events[0][orbit.t_events[0] > 0.1]
    period = np.diff(turns).mean()
    assert 2 * np.pi / period == pytest.approx(epicyclic_frequency(rate, slope), rel=1e-6)


def test_rings_pull_as_the_dispersion_relation_says():
    """A short wave sigma_1 = cos(k x), of the displacement xi = -sin(k x)/(k sigma): its pull, summed over rings.

    Without pressure omega^2 - kappa^2 is -(pull)/xi.
    """
    k, sigma = 80.0, 0.7
    edges = np.linspace(0.3, 1.7, 140_001)
    rings, nearby = 0.5 * (edges[1:] + edges[:-1]), 4e-4

    def envelope(r):
        return np.exp(-(((r - 1.0) / 0.25) ** 2))

    mass = 2 * np.pi * rings * np.diff(edges) * np.cos(k * (rings - 1.0)) * envelope(rings)

    def potential(r):
        return -np.sum(2 / np.pi * mass * ellipk(4 * r * rings / (r + rings) ** 2) / (r + rings))

    at = edges[np.argmin(abs(edges - 1.0 - 0.5 * np.pi / k))]  # a quarter of a wave outwards, between two rings
    pull = -(potential(at + nearby) - potential(at - nearby)) / (2 * nearby) / envelope(at)
    displacement = -np.sin(k * (at - 1.0)) / (k * sigma)
    wanted = squared_frequency(k, 1e-9, 1.0, sigma, gravitational_constant=1.0) - 1.0
    assert -pull / displacement == pytest.approx(wanted, rel=2e-3)


@pytest.mark.parametrize("ratio", [0.5, 1.0, 1.7])
def test_the_least_frequency_is_zero_where_toomre_says(ratio):
    sigma, omega, slope = 3.1, 0.8, -1.2
    gravity = 0.6
    sound = ratio * np.pi * gravity * sigma / epicyclic_frequency(omega, slope)
    assert toomre_parameter(sound, omega, sigma, slope, gravity) == pytest.approx(ratio, rel=1e-14)
    fastest = fastest_wavenumber(sound, sigma, gravity)
    waves = fastest * np.linspace(0.0, 3.0, 301)
    squares = squared_frequency(waves, sound, omega, sigma, slope, gravity)
    assert waves[np.argmin(squares)] == pytest.approx(fastest, rel=1e-12)
    assert squares.min() == pytest.approx(epicyclic_frequency(omega, slope) ** 2 * (1 - ratio**-2), abs=1e-12)
    assert (squares.min() < -1e-12) == (ratio < 1)


def test_units():
    """Near the Sun, with kappa of a flat rotation curve; and kappa itself, as Omega with the slope -3/2."""
    omega = 27 * u.km / u.s / u.kpc
    disc = 8 * u.km / u.s, omega, 13 * u.Msun / u.pc**2
    kappa = np.sqrt(2) * omega
    G = 6.6743e-11 * u.m**3 / u.kg / u.s**2  # CODATA 2018
    exact = (8 * u.km / u.s * kappa / (np.pi * G * 13 * u.Msun / u.pc**2)).to_value("")
    assert toomre_parameter(*disc, slope=-1.0) == pytest.approx(exact, rel=1e-12)
    assert toomre_parameter(disc[0], kappa, disc[2]) == pytest.approx(exact, rel=1e-12)
    assert toomre_parameter(*disc, slope=np.array([-1.0, -1.5])) == pytest.approx([exact, exact / np.sqrt(2)])


def test_what_cannot_be_is_refused():
    with pytest.raises(ValueError, match=r"-2 or more, not -2\.1"):
        epicyclic_frequency(1.0, np.array([-1.0, -2.1]))
    with pytest.raises(ValueError, match="-2 or more, not nan"):
        epicyclic_frequency(1.0, np.nan)
    with pytest.raises(ValueError, match="surface_density must be positive"):
        toomre_parameter(1.0, 1.0, -1.0)
    with pytest.raises(ValueError, match="sound_speed must be positive"):
        squared_frequency(1.0, 0.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="surface_density"):
        toomre_parameter("1 km/s", "1e-11 rad/s", "3 kg/m3")
