"""Gravity fields as pyshtools has them: ellipsoids and layers from their shapes, conventions and rotations.

Source: Wieczorek & Meschede 2018, Geochemistry, Geophysics, Geosystems 19, 2574. It is in the extra interop-test.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from astroinertia.bodies.earth import prem_figure
from astroinertia.inertia.gravity_field import NORMALIZATIONS, ellipsoid_field, layered_field, particle_field

pyshtools = pytest.importorskip("pyshtools")
pytestmark = pytest.mark.filterwarnings("ignore")  # of the other program


def by_shape(axes, lmax, grid, powers):
    """4pi-normalised coefficients of a homogeneous ellipsoid, with the radius 1, from its surface on a grid."""
    n = 2 * grid + 2
    latitude = np.radians(90 - 180 / n * np.arange(n + 1))[:, None]
    longitude = np.radians(180 / n * np.arange(2 * n + 1))[None]
    across = np.cos(latitude)
    direction = (across * np.cos(longitude), across * np.sin(longitude), np.sin(latitude) + 0 * longitude)
    surface = sum((part / axis) ** 2 for part, axis in zip(direction, axes, strict=True)) ** -0.5
    gm = pyshtools.constants.G.value * 4 / 3 * np.pi * np.prod(axes)
    field = pyshtools.SHGravCoeffs.from_shape(
        pyshtools.SHGrid.from_array(surface), rho=1.0, gm=gm, nmax=powers, lmax=lmax, lmax_grid=grid, lmax_calc=lmax
    )
    coefficients = field.change_ref(r0=1.0).coeffs
    coefficients[0, 0, 0] = 1.0  # it has that of the relief
    return coefficients


def test_twenty_ellipsoids() -> None:
    rng = np.random.default_rng(3)
    for axes in rng.uniform(0.7, 1.0, (20, 3)):
        ours = ellipsoid_field(1.0, axes, degree=20, radius=1.0).coefficients
        np.testing.assert_allclose(ours, by_shape(axes, lmax=20, grid=120, powers=24), rtol=0, atol=1e-14)


def test_prem_as_layers_between_spheroids() -> None:
    """With the flattening that its level surfaces have."""
    figure = prem_figure()
    share, equator = 1 - figure.level_flattening, figure.radius / figure.equatorial_radius
    equator = equator * share ** (-1 / 3)
    tops = (np.diff(equator, append=np.inf) > 0) & (equator > 0)
    axes, densities = np.stack([equator, equator, equator * share], axis=-1)[tops], figure.density[tops]
    ours = layered_field(densities, axes, degree=6, radius=1.0)
    steps = -np.diff(densities, append=0.0) * axes.prod(1)
    total = sum(step * by_shape(each, 6, 30, 9) for step, each in zip(steps, axes, strict=True)) / steps.sum()
    np.testing.assert_allclose(ours.coefficients, total, rtol=0, atol=1e-15)
    assert ours.zonal_harmonic(2) == pytest.approx(figure.gravity_field().zonal_harmonic(2), rel=1e-3)


def test_conventions_and_rotations() -> None:
    rng = np.random.default_rng(5)
    field = particle_field(rng.uniform(1, 2, 30), rng.normal(size=(30, 3)), degree=50, radius=4.0)
    theirs = pyshtools.SHCoeffs.from_array(field.coefficients)
    for normalization in NORMALIZATIONS:
        for csphase in (1, -1):
            expected = theirs.convert(normalization=normalization, csphase=csphase).coeffs
            np.testing.assert_allclose(field.normalized(normalization, csphase), expected, rtol=1e-14)
    angles = (0.3, 1.1, -0.7)
    turned = theirs.rotate(*angles, degrees=False, convention="y", body=True).coeffs
    ours = field.rotated(Rotation.from_euler("ZYZ", angles).as_matrix()).coefficients
    np.testing.assert_allclose(ours, turned, rtol=0, atol=5e-14)


def test_its_field_pulls_as_ours() -> None:
    """Its radial gravity on a sphere, and the slope of our potential."""
    field = ellipsoid_field(5.0, (1.0, 0.9, 0.7), degree=20, radius=1.0)
    theirs = pyshtools.SHGravCoeffs.from_array(field.coefficients, gm=5.0, r0=1.0)
    grid = theirs.expand(a=2.0, f=0.0, lmax=20, lmax_calc=20, extend=True, normal_gravity=False)
    latitude, longitude = np.radians(grid.rad.lats()[3]), np.radians(grid.rad.lons()[5])
    across = np.cos(latitude)
    up = np.array([across * np.cos(longitude), across * np.sin(longitude), np.sin(latitude)])
    steps = 1e-3 * np.array([-2, -1, 1, 2])
    slope = field.potential(np.outer(2.0 + steps, up)) @ np.array([1, -8, 8, -1]) / 12e-3
    assert -slope == pytest.approx(float(grid.rad.data[3, 5]), rel=1e-10)
