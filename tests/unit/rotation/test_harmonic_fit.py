"""A record is taken apart into what it was put together from, and one too short is refused."""

import numpy as np
import pytest

from astroinertia.errors import NumericalError
from astroinertia.rotation.harmonic_fit import harmonic_fit

FREQUENCIES, PHASES = np.array([0.7, 2.3]), np.array([0.4, -1.0])


def record(times, noise=0.0):
    slow = 3.0 + 0.2 * times + 0.5 * 1e-3 * times**2
    waves = 0.5 * np.sin(0.7 * times + 0.4) - 0.2 * np.cos(2.3 * times - 1.0)
    return slow + waves + noise * np.random.default_rng(0).normal(size=len(times))


def test_it_finds_what_is_there():
    times = np.linspace(-50.0, 70.0, 400)
    found = harmonic_fit(times, record(times), FREQUENCIES, PHASES)
    assert (found.offset, found.rate, found.acceleration) == pytest.approx((3.0, 0.2, 1e-3), rel=1e-12)
    np.testing.assert_allclose(found.sine, [0.5, 0.0], atol=1e-13)
    np.testing.assert_allclose(found.cosine, [0.0, -0.2], atol=1e-13)
    assert found.residual < 1e-13
    np.testing.assert_allclose(found.steady(times), 3.0 + 0.2 * times + 0.5e-3 * times**2, rtol=1e-11)
    assert harmonic_fit(times, record(times, 0.01), FREQUENCIES, PHASES).residual == pytest.approx(0.01, rel=0.1)
    without = harmonic_fit(times, record(times))
    assert without.residual == pytest.approx(np.sqrt(0.5**2 / 2 + 0.2**2 / 2), rel=0.05)


def test_records_of_the_wrong_shape_or_length_are_refused():
    times = np.linspace(0.0, 1.0, 50)
    with pytest.raises(NumericalError, match="too short"):
        harmonic_fit(times, times, [1e-3, 1.1e-3])
    for arguments in ((times, times[1:]), (times[:4], times[:4], [1.0]), (times, times, [1.0], [1.0, 2.0])):
        with pytest.raises(ValueError, match="a fit needs"):
            harmonic_fit(*arguments)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_values_that_are_not_finite_are_refused(wrong):
    times = np.linspace(0.0, 10.0, 50)
    with pytest.raises(ValueError, match="values, frequencies and phases of a fit must be finite"):
        harmonic_fit(times, np.where(times > 9.9, wrong, np.sin(times)), [1.0])
