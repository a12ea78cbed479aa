"""Parabolas and hyperbolas of a perturber: Kepler's equation, and the equation of motion itself."""

import math
from itertools import product

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

from astroinertia.effects import catalogue
from astroinertia.orbits.kepler import eccentric_anomaly, place_on_open_orbit, time_from_pericentre
from tests.unit.points import at

TIMES = np.concatenate([-np.logspace(-8, 6, 57), [0.0], np.logspace(-8, 6, 57)])


def test_keplers_equation_is_solved_for_every_eccentricity() -> None:
    mean = np.linspace(-20.0, 20.0, 4001)
    near = 10.0 ** np.arange(-12.0, 0.0)
    mean = np.concatenate([mean, near, -near])
    for e in (0.0, 0.1, 0.5, 0.9, 0.99, 0.9999, 1.0 - 1e-9):
        anomaly = eccentric_anomaly(np, mean, e)
        wanted = np.remainder(mean + math.pi, 2 * math.pi) - math.pi
        error = np.remainder(anomaly - e * np.sin(anomaly) - wanted + math.pi, 2 * math.pi) - math.pi
        assert np.abs(error).max() < 2e-14, e


def test_keplers_equation_keeps_its_digits_near_the_pericentre_of_long_ellipses() -> None:
    # By bisection in mpmath: 1e-9 of E was lost at e = 1 - 1e-10 and M = 1e-12, all of it where M is smaller still.
    for gap, mean in product((0.1, 1e-6, 1e-10, 1e-14), (1e-30, 1e-12, -1e-8, 1e-3, 2.0)):
        with mpmath.workdps(60):
            low, high = mpmath.mpf(0), mpmath.pi
            e, size = mpmath.mpf(1.0 - gap), mpmath.mpf(abs(mean))
            for _ in range(220):
                middle = (low + high) / 2
                low, high = (low, middle) if middle - e * mpmath.sin(middle) > size else (middle, high)
        exact = math.copysign(float(low), mean)
        assert eccentric_anomaly(np, np.float64(mean), 1.0 - gap) == pytest.approx(exact, rel=2e-15, abs=0.0)


@pytest.mark.parametrize(("gap", "time"), [(2.0**-52, 1e30), (1e-10, 1e30), (1e-5, 1e12), (1e-5, 1e30), (0.5, 1e30)])
def test_hyperbolas_that_are_almost_parabolas_are_followed_for_all_times(gap: float, time: float) -> None:
    # By mpmath from e sinh H - H = b^1.5 t: by 5e-4 off at b = 1e-5, by 1e15 at b = 2e-16, as Newton's steps ran out.
    x, y = place_on_open_orbit(np, np.float64(time), np.float64(1.0 + gap))
    with mpmath.workdps(60):
        e = mpmath.mpf(1.0 + gap)
        b, mean = e - 1, (e - 1) ** mpmath.mpf("1.5") * time
        low, high = mpmath.mpf(0), mpmath.mpf(200)
        for _ in range(220):
            middle = (low + high) / 2
            low, high = (low, middle) if e * mpmath.sinh(middle) - middle > mean else (middle, high)
        exact = float((e - mpmath.cosh(low)) / b), float(mpmath.sqrt(e * e - 1) * mpmath.sinh(low) / b)
    assert (x, y) == pytest.approx(exact, rel=1e-13)


@pytest.mark.parametrize("eccentricity", [1.0, 1.0 + 1e-9, 1.001, 1.3, 5.0, 100.0])
def test_places_are_on_the_conic_and_have_swept_the_area_of_their_time(eccentricity: float) -> None:
    """r = p/(1 + e cos f), and Kepler's second law: the area between orbit and focus is time times h/2."""
    e = eccentricity
    x, y = place_on_open_orbit(np, TIMES, np.float64(e))
    radius = np.hypot(x, y)
    np.testing.assert_allclose(
        radius + e * x, (1 + e) * np.ones_like(x), rtol=1e-13 * (1 + e), atol=3e-16 * e * radius.max()
    )
    np.testing.assert_array_equal(np.sign(y), np.sign(TIMES))
    # From the true anomaly, by Barker's equation or the hyperbola's own, where these do not cancel.
    half = y / (radius + x)  # tan(f/2)
    if e == 1.0:
        time = math.sqrt(2.0) * (half + half**3 / 3.0)
        np.testing.assert_allclose(time, TIMES, rtol=2e-13)
    elif e > 1.0001:
        anomaly = np.arcsinh(y * math.sqrt(e - 1.0) / math.sqrt(e + 1.0))
        time = (e * np.sinh(anomaly) - anomaly) / (e - 1.0) ** 1.5
        late = np.abs(anomaly) > 0.5
        np.testing.assert_allclose(time[late], TIMES[late], rtol=1e-12)


def test_times_from_the_pericentre_are_those_of_the_places() -> None:
    for e in (1.0, 1.0 + 1e-9, 1.001, 1.3, 5.0, 100.0, 1e6):
        times = np.logspace(-1, 6, 29)
        distance = np.hypot(*place_on_open_orbit(np, times, np.float64(e)))
        far = distance > 1.01  # nearer the pericentre, the distance hardly says where
        np.testing.assert_allclose(time_from_pericentre(np, distance, e)[far], times[far], rtol=1e-13)
    for e in (1e-3, 0.5, 0.9, 0.999, 1.0 - 1e-9):
        anomaly = np.linspace(0.5, 3.0, 9)
        distance, times = (1.0 - e * np.cos(anomaly)) / (1.0 - e), (anomaly - e * np.sin(anomaly)) / (1.0 - e) ** 1.5
        np.testing.assert_allclose(time_from_pericentre(np, distance, e), times, rtol=1e-11)
        half = math.pi / (1.0 - e) ** 1.5
        assert time_from_pericentre(np, 9.0 * distance[-1], e) == pytest.approx(half, rel=1e-12)
        assert time_from_pericentre(np, np.float64(0.5), e) == 0.0


def test_times_on_ellipses_that_are_almost_parabolas_are_right_to_round_off() -> None:
    # Kepler's equation by itself loses the digits of 1 - e there: 1e-8 of the time at e = 1 - 1e-8.
    for gap, distance in product((1e-4, 1e-8, 1e-12, 2.0**-53), (1.01, 2.0, 100.0)):
        with mpmath.workdps(40):
            e, b = 1 - mpmath.mpf(gap), mpmath.mpf(gap)
            anomaly = mpmath.acos((1 - distance * b) / e)
            exact = float((anomaly - e * mpmath.sin(anomaly)) / b ** mpmath.mpf("1.5"))
        assert time_from_pericentre(np, np.float64(distance), 1.0 - gap) == pytest.approx(exact, rel=1e-14)


@pytest.mark.full
def test_the_motion_is_that_of_the_attraction() -> None:
    """The second derivative of the place by time is -x/r^3, by exact differentiation."""
    with jax.enable_x64(True):
        pairs = product([1.0, 1.0 + 1e-9, 1.3, 20.0], [-4.0, 0.0, 0.3, 1.1, 30.0])
        eccentricity, time = jnp.asarray(list(pairs)).T
        one = jnp.ones_like(time)  # each place by its own time

        def place(t: jax.Array) -> jax.Array:
            return jnp.stack(place_on_open_orbit(jnp, t, eccentricity))

        def velocity(t: jax.Array) -> jax.Array:
            return jax.jvp(place, (t,), (one,))[1]

        x, acceleration = np.asarray(place(time)), np.asarray(jax.jvp(velocity, (time,), (one,))[1])
    np.testing.assert_allclose(acceleration, -x / np.linalg.norm(x, axis=0) ** 3, rtol=1e-11, atol=1e-13)


def test_a_passage_of_the_tide_is_on_its_orbit_in_any_units() -> None:
    """Pericentre at the right time and place, and the energy of the orbit from places a little apart in time."""
    options = {"mass": 8.0, "position": (0.0, 2.0, 0.0), "normal": (0.0, 0.0, 3.0)}
    effect = catalogue.build("tide", {**options, "eccentricity": 1.5, "pericentre_time": 4.0})
    np.testing.assert_allclose(effect.place(np, at(np.zeros((1, 3)), time=4.0)), [0.0, 2.0, 0.0], atol=1e-15)
    step = 1e-4
    before, now, after = (effect.place(np, at(np.zeros((1, 3)), time=5.0 + k * step)) for k in (-1, 0, 1))
    speed = (after - before) / (2 * step)
    energy = 0.5 * speed @ speed - 8.0 / np.linalg.norm(now)
    assert energy == pytest.approx(8.0 * 0.5 / (2 * 2.0), rel=1e-7)
    assert np.cross(now, speed)[2] == pytest.approx(math.sqrt(8.0 * 2.0 * 2.5), rel=1e-7)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"eccentricity": 0.9, "pericentre_time": 1.0}, "at least 1"),
        ({"eccentricity": 1.0, "period": 1.0}, "at most 0.99"),
        ({"eccentricity": 1.0, "period": 1.0, "pericentre_time": 1.0}, "not both"),
        ({"eccentricity": 1.0, "pericentre_time": 1.0, "normal": (1.0, 0.0, 0.0)}, "perpendicular"),
    ],
)
def test_orbits_that_contradict_themselves_are_refused(options: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        catalogue.build("tide", {"mass": 1.0, "position": (1.0, 0.0, 0.0), **options})
