"""Free tops where formulae lose their digits: needles, discs, ratios of 1e12, the separatrix, a million periods."""

from fractions import Fraction

import numpy as np
import pytest

from astroinertia.rotation import free_attitude, free_top
from astroinertia.rotation.attitude import angle_between
from tests import exact_top

BODIES = {
    "needle": [1e-12, 1.0, 1.0000001],
    "thick needle": [1e-6, 1.0, 1.0 + 1e-6],
    "disc": [1.0, 1.0 + 1e-9, 2.0 + 1e-9],
    "ratios of 1e12": [1e-12, 3e-4, 1.0],
    "two small": [1e-12, 3e-12, 1.0],
    "nearly a sphere": [1.0, 1.0 + 2e-15, 1.0 + 9e-15],
    "nearly oblate": [1.0, 1.0 + 3e-16, 1.5],
    "nearly prolate": [0.5, 1.0, 1.0 + 3e-16],
    "plain": [1.0, 2.0, 3.0],
}
SPINS = {"even": [0.7, -0.4, 0.5], "tiny": [3e-200, 1e-200, -2e-200], "almost steady": [1e-13, 3e-14, 1.0]}


def assert_as_exact(moments, spin, times, digits=120, rtol=4e-15):
    top = free_top.free_top(moments, spin)
    with np.errstate(all="raise", under="ignore"):
        rates, attitudes = free_top.angular_velocity(top, times), free_attitude.attitude(top, times)
    for time, rate, attitude in zip(times, rates, attitudes, strict=True):
        expected = exact_top.floats(exact_top.motion(moments, spin, float(time), digits))
        np.testing.assert_allclose(rate, expected[0], rtol=rtol)
        np.testing.assert_allclose(attitude, expected[1], rtol=0, atol=2e-15)


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize(
    "spin", [pytest.param(spin, marks=() if spin == "even" else pytest.mark.full) for spin in SPINS]
)
def test_extreme_bodies_and_spins_to_a_million_periods(body, spin):
    moments, rates = BODIES[body], SPINS[spin]
    period = min(free_top.period(free_top.free_top(moments, rates)), 1.0 / np.abs(rates).max())
    assert_as_exact(moments, rates, period * np.array([-3.3, 0.7, 4321.0, 1e6 + 0.3]))


@pytest.mark.full
@pytest.mark.parametrize(
    "offset", [1e-2, 1e-8, 1e-15, -1e-15, -1e-8], ids=["1e-2", "1e-8", "1e-15", "less 1e-15", "less 1e-8"]
)
@pytest.mark.parametrize("body", [[1.0, 1.5, 3.0], [1.0, 1.5, 1e6], [1e-6, 1.0, 1.0 + 1e-6]])
def test_next_to_the_separatrix(body, offset):
    least, middle, most = body
    fast = np.sqrt(least * (middle - least) / (most * (most - middle)))
    spin = [1.0 + offset, 0.3 * fast, fast]
    period = free_top.period(free_top.free_top(body, spin))
    assert_as_exact(body, spin, period * np.array([-0.3, 0.26, 2.1, 1000.4]))


@pytest.mark.full
@pytest.mark.parametrize("size", [1e-8, 1e-30, 1e-100, 1e-150])
def test_flips_from_next_to_the_intermediate_axis(size):
    moments, spin = [1.0, 2.0, 3.0], [size, 1.0, size]
    top = free_top.free_top(moments, spin)
    times = free_top.period(top) * np.array([0.05, 0.3, 0.9, 10.4])
    assert_as_exact(moments, spin, times, digits=400 if size < 1e-50 else 160, rtol=2e-13 if size < 1e-50 else 5e-15)
    # The time between flips grows as the logarithm of the offset: K = ln(4/k') with k'^2 = 2 size^2.
    expected = 4 * np.sqrt(3) * (np.log(4 / np.sqrt(2)) - np.log(size))
    assert free_top.period(top) == pytest.approx(expected, rel=2e-15)


def test_the_side_of_the_separatrix_is_never_mistaken():
    for bits in range(1, 60, 7):
        above = Fraction(3) + Fraction(1, 2**bits)
        assert free_top.free_top([1.0, 1.5, 3.0], [above, 0.6, 1]).sense == -1
        assert free_top.free_top([1.0, 1.5, 3.0], [6 - above, 0.6, 1]).sense == 1
    ulp = np.nextafter(3.0, 4.0)
    assert free_top.free_top([1.0, 1.5, 3.0], [ulp, 0.6, 1.0]).motion == "periodic"
    assert free_top.free_top([1.0, 1.5, 3.0], [3.0, 0.6, 1.0]).motion == "separatrix"


def test_a_start_in_decimals_is_followed_for_a_million_periods():
    moments, spin = ["0.7", "1.1", "1.3"], ["0.1", "0.9", "0.3"]
    top = free_top.free_top(moments, spin)
    time = float(np.round(1e6 * free_top.period(top)))
    assert_as_exact(moments, spin, [time])
    # What the floats of these decimals lack has grown with the angle turned through.
    other = free_attitude.attitude(free_top.free_top([0.7, 1.1, 1.3], [0.1, 0.9, 0.3]), time)
    known = free_attitude.uncertainty(top, time)[1]
    assert 1e-17 < known / (free_attitude.precession_rate(top) * time) < 1e-15
    assert 0.05 * known < angle_between(other, free_attitude.attitude(top, time)) < known


def test_next_to_the_separatrix_motion_is_known_worse():
    known = []
    for offset in (1e-1, 1e-4, 1e-7):
        top = free_top.free_top([1.0, 1.5, 3.0], [3.0 + offset, 0.6, 1.0])
        times = np.linspace(100, 100.5, 3001) * free_top.period(top)
        known.append(free_attitude.uncertainty(top, times)[0].max())
    assert known[0] < 2e-12
    np.testing.assert_allclose(np.array(known[1:]) / known[:-1], 1e3, rtol=0.05)
    # Next to the intermediate axis what is small is known by itself, and nothing is lost.
    top = free_top.free_top([1.0, 2.0, 3.0], [1e-8, 1.0, 1e-8])
    assert free_attitude.uncertainty(top, 100.2 * free_top.period(top))[0] < 1e-12
    for moments in ([0.0, 1.0, 1.0], [2.0, 2.0, 2.0]):
        top = free_top.free_top(moments, [0.3, 0.4, 0.5])
        assert max(free_attitude.uncertainty(top, 100.0)) < 1e-13
    assert free_attitude.uncertainty(free_top.free_top([1.0, 2.0, 3.0], [0.0, 0.0, 0.0]), [1.0, 2.0])[1].max() == 0.0


def random_tops(count):
    """Bodies of every shape with spins of every size, half of them within 1e-1 to 1e-15 of the separatrix."""
    generator = np.random.default_rng(11)
    while count:
        small = 10 ** generator.uniform(-15, -1)
        moments = generator.permutation(
            [
                generator.uniform(0.5, 3.0, 3),
                10 ** generator.uniform(-12, 0, 3),
                1.0 + small * generator.uniform(0, 1, 3),
                [10 ** generator.uniform(-12, -1), 1.0, 1.0 + small],
                [1.0, 1.0 + small, 2.0 + small],
            ][generator.integers(5)]
        )
        least, middle, most = np.sort(moments)
        if least < middle < most:
            spin = generator.normal(size=3) * 10 ** generator.uniform(-9, 0, 3)
            if generator.random() < 0.5:
                slow, fast = np.argmin(moments), np.argmax(moments)
                ratio = np.sqrt(most * (most - middle) / least / (middle - least))
                spin[slow] = spin[fast] * ratio * (1 + generator.choice([-1, 1]) * 10 ** generator.uniform(-15, -1))
            yield moments, spin, generator.uniform(-1, 1) * 10 ** generator.uniform(-1, 6.5)
            count -= 1


@pytest.mark.full
def test_any_top_at_any_time():
    for moments, spin, periods in random_tops(80):
        once = min(free_top.period(free_top.free_top(moments, spin)), 1.0 / abs(spin).max())
        assert_as_exact(moments, spin, [periods * once], digits=160)
