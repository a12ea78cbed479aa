"""Modes of homogeneous ellipsoids without friction, against closed forms and published points of onset."""

import math

import numpy as np
import pytest
from scipy.special import elliprd

from astroinertia.bodies import darwin, ellipsoid_stability, jacobi, maclaurin, riemann, roche
from astroinertia.bodies.ellipsoid_stability import onset, spectrum
from astroinertia.bodies.homogeneous_ellipsoid import HomogeneousEllipsoid

SCALE = {"mass": 2.0, "mean_radius": 3.0, "gravitational_constant": 0.5}


def test_dynamical_instability_of_maclaurin_spheroids_is_found_from_growth():
    assert onset(maclaurin.from_eccentricity, 0.9, 0.99) == pytest.approx(0.952886702034254, abs=2e-15)
    beyond = [spectrum(maclaurin.from_eccentricity(0.952886702034254 + step)).growth_rate for step in (1e-8, 4e-8)]
    assert beyond[1] / beyond[0] == pytest.approx(2.0, rel=1e-5)  # a root of the distance
    assert spectrum(maclaurin.from_eccentricity(0.952886702034254 - 1e-8)).growth_rate == 0


@pytest.mark.parametrize("e", [0.2, 0.7, 0.9, 0.94, 0.96, 0.99, 0.9999])
def test_modes_of_maclaurin_spheroids(e):
    """Bars in closed form (Chandrasekhar 1969, section 33), and the axisymmetric mode from the energy of spheroids."""
    body = maclaurin.from_eccentricity(e, **SCALE)
    found = spectrum(body)
    for frequency in body.bar_mode_frequencies:
        assert min(abs(found.even + frequency**2)) < 1e-14
    assert found.growth_rate == pytest.approx(max(abs(each.imag) for each in body.bar_mode_frequencies), abs=1e-14)
    assert found.is_stable == body.is_dynamically_stable
    square = _axisymmetric(body)
    assert min(abs(found.even + square)) < 2e-9 * square


def _axisymmetric(body):
    """sigma^2 of spheroids of equal volume and angular momentum: the curvature of L^2/(2 C) + W over their inertia."""
    a, _, c = body.axes

    def slope(s):  # by s, of semi-axes a e^s, a e^s, c e^(-2 s); R_D/6 are the derivatives of -R_F
        x, z = (a * math.exp(s)) ** 2, (c * math.exp(-2 * s)) ** 2
        pull = (
            0.6 * body.gravitational_constant * body.mass**2 * (4 * x * elliprd(x, z, x) - 4 * z * elliprd(x, x, z)) / 6
        )
        return pull - 2.5 * body.angular_momentum**2 / body.mass / x

    step = 1e-4
    curvature = (8 * (slope(step) - slope(-step)) - slope(2 * step) + slope(-2 * step)) / (12 * step)
    return curvature / (body.mass / 5 * (2 * a * a + 4 * c * c))


def test_modes_of_a_sphere():
    """Kelvin: sigma^2 = 8 l (l - 1)/(3 (2 l + 1)) pi G rho = (16/15) pi G rho for l = 2, five times."""
    for body in (maclaurin.from_eccentricity(0.0, **SCALE), maclaurin.from_eccentricity(1e-9, **SCALE)):
        unit = math.pi * body.gravitational_constant * body.density
        found = spectrum(body)
        np.testing.assert_allclose(np.append(found.even, found.odd), -16 / 15 * unit, rtol=1e-7)
        assert found.is_stable


def test_jeans_spheroids_lose_stability_where_the_tide_is_strongest():
    """e = 0.883026 (Chandrasekhar 1969, section 56): without rotation the dynamical point and the limit are one."""
    share = onset(lambda c: roche.from_axis_ratio(-1.0, c), 0.3, 0.7)
    assert share == pytest.approx(roche.limit(-1.0).c_over_a, abs=2e-15)
    assert math.sqrt(1 - share**2) == pytest.approx(0.883026, abs=6e-7)


@pytest.mark.slow
def test_roche_ellipsoids_stay_stable_a_little_beyond_the_limit():
    """Chandrasekhar 1969, section 57: with circulation kept, dynamical instability comes after the Roche limit."""
    for ratio in (0.0, 1.0, 100.0):
        limit = roche.limit(ratio)
        share = onset(lambda c, ratio=ratio: roche.from_axis_ratio(ratio, c), 0.3, limit.c_over_a)
        assert 0.002 < limit.c_over_a - share < 0.02
        assert spectrum(limit).is_stable


def test_jacobi_and_adjoint_figures():
    """Jacobi ellipsoids are stable to second harmonics, and adjoint figures have the same modes."""
    for ratio in (0.97, 0.5, 0.1, 0.01):
        assert spectrum(jacobi.from_axis_ratio(ratio)).is_stable
    for ratio, x in ((0.9, 0.5), (0.3, -0.4), (0.2, -0.9), (0.05, 1e-9)):
        body = riemann.from_rate_ratio(ratio, x, **SCALE)
        one, other = spectrum(body), spectrum(body.adjoint)
        np.testing.assert_allclose(one.even, other.even, rtol=1e-12)
        np.testing.assert_allclose(one.odd, other.odd, rtol=1e-12)
        assert one.growth_rate == pytest.approx(other.growth_rate, rel=1e-12)


def test_slender_figures_that_turn_against_their_flow_become_unstable_by_tilting():
    """From Omega = -Lambda, b/a = 0.29633 on odd displacements grow; irrotational figures are stable."""
    ratio = onset(lambda b: riemann.from_rate_ratio(b, -1.0), 0.1, 0.6)
    assert ratio == pytest.approx(0.2963311636, abs=1e-10)
    assert spectrum(riemann.from_rate_ratio(ratio + 1e-6, -1.0)).growth_rate == 0
    grown = spectrum(riemann.from_rate_ratio(ratio - 1e-6, -1.0))
    assert grown.growth_rate > 0 and grown.odd.real.max() > 0 > grown.even.real.max()
    assert all(spectrum(riemann.irrotational(b)).is_stable for b in (0.9, 0.5, 0.1, 0.01))


def test_known_zero_modes_are_there_before_they_are_divided_out():
    """Turning the figure or the labels costs nothing: rates 0, Omega and Lambda come out of the matrices themselves."""
    body = riemann.from_rate_ratio(0.4, 0.6)
    frame = ellipsoid_stability.steady_frame(body)
    even = ellipsoid_stability._squared_polynomial(frame, ellipsoid_stability.EVEN)
    odd = ellipsoid_stability._squared_polynomial(frame, ellipsoid_stability.ODD)
    np.testing.assert_allclose(even[3:], 0, atol=3e-15)
    for rate in (frame.turning, frame.internal):
        assert np.polyval(odd, -(rate**2)) == pytest.approx(0, abs=3e-15)


def test_figures_out_of_balance_are_refused():
    with pytest.raises(ValueError, match="in balance"):
        spectrum(HomogeneousEllipsoid(0.9, 0.8, 0.3))
    with pytest.raises(ValueError, match="in the tide of a point mass"):
        spectrum(darwin.from_gap(1.2))
