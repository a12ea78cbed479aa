"""Harmonic functions and Helmholtz solutions of flattened bodies against closed forms and their own equations."""

import math

import numpy as np
import pytest
from scipy.special import spherical_jn

from astroinertia.bodies.spheroidal_basis import SpheroidalBasis, legendre_polynomials

R, MU = np.array([0.3, 1.0, 3.0, 5.0]), np.array([0.2, 0.5, 0.9, 0.0])


def test_without_focal_radius_they_are_spherical_bessel_functions():
    basis = SpheroidalBasis(20, 0.0, 1.3)
    values, radial, angular = basis.helmholtz_solutions(R, MU)
    legendre, slope = legendre_polynomials(20, MU)
    for i, degree in enumerate(basis.degrees):
        scale = math.prod(range(1, 2 * degree + 2, 2)) / 1.3 ** int(degree)
        bessel, bessel_slope = spherical_jn(degree, R), spherical_jn(degree, R, derivative=True)
        np.testing.assert_allclose(values[i], scale * bessel * legendre[i], rtol=1e-13)
        np.testing.assert_allclose(radial[i], scale * R * bessel_slope * legendre[i], rtol=1e-13)
        np.testing.assert_allclose(angular[i], scale * bessel * slope[i], rtol=1e-13)


def test_legendre_polynomials_on_the_axis():
    values, slopes = legendre_polynomials(40, np.array([1.0]))
    degrees = np.arange(0, 41, 2)
    np.testing.assert_allclose(values[:, 0], 1.0, rtol=1e-14)
    np.testing.assert_allclose(slopes[:, 0], degrees * (degrees + 1) / 2, rtol=1e-13)


@pytest.mark.parametrize(
    ("kind", "constant"), [("regular_harmonics", 0.0), ("decaying_harmonics", 0.0), ("helmholtz_solutions", 1.0)]
)
def test_they_solve_their_equations_with_the_slopes_they_tell(kind, constant):
    basis = SpheroidalBasis(12, 0.8, 0.7)
    function = getattr(basis, kind)
    r, mu, step = np.array([0.9, 1.1, 1.4]), np.array([0.85, 0.4, 0.1]), 1e-5
    value, radial, angular = function(r, mu)
    outer, inner = function(r * (1 + step), mu), function(r * (1 - step), mu)
    north, south = function(r, mu + step), function(r, mu - step)
    tallest = np.max(np.abs(radial), axis=1, keepdims=True) + np.max(np.abs(angular), axis=1, keepdims=True) + 1e-300
    assert np.max(np.abs((outer[0] - inner[0]) / (2 * step) - radial) / tallest) < 1e-8
    assert np.max(np.abs((north[0] - south[0]) / (2 * step) - angular) / tallest) < 1e-8
    # r^2 laplacian = r d/dr (r d/dr) + r d/dr + d/dmu (1 - mu^2) d/dmu
    second = (outer[1] - inner[1]) / (2 * step)
    across = (north[2] * (1 - (mu + step) ** 2) - south[2] * (1 - (mu - step) ** 2)) / (2 * step)
    left, size = second + radial + across, np.max(np.abs(second) + np.abs(across) + np.abs(value), axis=1)
    assert np.max(np.max(np.abs(left + constant * r**2 * value), axis=1) / size) < 1e-8


def test_decaying_harmonics_decay_as_their_degree():
    basis = SpheroidalBasis(6, 0.8, 0.7)
    far, farther = (basis.decaying_harmonics(r, np.array([0.3]))[0][:, 0] for r in (np.array([1e4]), np.array([2e4])))
    np.testing.assert_allclose(np.log2(far / farther), basis.degrees + 1, rtol=1e-6)


def test_solutions_stay_of_order_one_on_a_body_of_their_own_flattening():
    """r^40 falls by 1e10 from the equator to the pole of this spheroid; the fitted functions do not."""
    equator, pole = 1.0, 0.56
    mu = np.linspace(0, 1, 41)
    r = 1 / np.sqrt((1 - mu**2) / equator**2 + mu**2 / pole**2)
    basis = SpheroidalBasis(40, math.sqrt(equator**2 - pole**2), pole)
    for kind in (basis.regular_harmonics, basis.decaying_harmonics):
        largest = np.max(np.abs(kind(r, mu)[0]), axis=1)
        np.testing.assert_allclose(largest, 1.0, rtol=1e-9)
