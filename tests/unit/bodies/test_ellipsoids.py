"""Homogeneous ellipsoids: gravity, Maclaurin and Jacobi figures, against independent values and their own theorems."""

import json
import math
from pathlib import Path

import astropy.units as u
import mpmath
import numpy as np
import pytest
import xarray as xr

from astroinertia.bodies import ellipsoid_gravity, jacobi, maclaurin, riemann

ENTRIES = json.loads((Path(__file__).parents[2] / "reference" / "ellipsoids.json").read_text())
SPECIAL = {
    "maclaurin.jacobi_bifurcation(secular)": maclaurin.bifurcation,
    "maclaurin.dynamical_bar_instability": maclaurin.dynamical_limit,
    "maclaurin.max_Omega2": maclaurin.fastest,
}
MACLAURIN = [entry for entry in ENTRIES if entry["name"].startswith("maclaurin")]
JACOBI = [entry for entry in ENTRIES if entry["name"] == "jacobi"]
SCALE = {"mass": 2.0, "mean_radius": 3.0, "gravitational_constant": 0.5}


@pytest.mark.parametrize("entry", MACLAURIN, ids=lambda entry: f"{entry['name']}-{entry['inputs']}")
def test_maclaurin_reference_values(entry):
    special = SPECIAL.get(entry["name"])
    body = special() if special else maclaurin.from_eccentricity(entry["inputs"]["e"])
    ours = {
        "e": body.eccentricity,
        "Omega2_piGrho": body.omega2,
        "T_W": body.rotational_to_gravitational,
        "f": body.flattening,
        "Izz_MRm2": body.polar_moment,
        "Ixx_MRm2": body.equatorial_moment,
        "L_GM3Rm": body.angular_momentum,
        "W_GM2Rm": body.gravitational_energy,
        "J2": body.second_zonal_harmonic,
    }
    for name, value in entry["value"].items():
        assert ours[name] == pytest.approx(float(value), rel=1e-14), name


@pytest.mark.parametrize("entry", JACOBI, ids=lambda entry: f"b/a={entry['inputs']['b_over_a']}")
def test_jacobi_reference_values(entry):
    body = jacobi.from_axis_ratio(entry["inputs"]["b_over_a"])
    ours = {
        "b_over_a": body.b_over_a,
        "c_over_a": body.c_over_a,
        "Omega2_piGrho": body.omega2,
        "L_GM3Rm": body.angular_momentum,
        "T_W": body.rotational_to_gravitational,
        "W_GM2Rm": body.gravitational_energy,
        "Ixx": body.principal_moments[0],
        "Iyy": body.principal_moments[1],
        "Izz": body.polar_moment,
    }
    for name, value in entry["value"].items():
        assert ours[name] == pytest.approx(float(value), rel=1e-14), name


@pytest.mark.parametrize("axes", [(1, 1, 1), (1, 0.5, 0.3), (1, 1, 1e-6), (1, 1e-4, 1e-4), (1, 0.9999999, 0.5)])
def test_index_symbols_in_thirty_digits(axes):
    with mpmath.workdps(30):
        squares = [mpmath.mpf(axis) ** 2 for axis in axes]
        volume = mpmath.sqrt(squares[0] * squares[1] * squares[2])
        singles = [volume * mpmath.mpf(2) / 3 * mpmath.elliprd(*_without(squares, i), squares[i]) for i in range(3)]
        np.testing.assert_allclose(ellipsoid_gravity.index_symbols(axes), [float(each) for each in singles], rtol=1e-15)
        for i, j in ((0, 1), (0, 2), (1, 2)):
            first = ellipsoid_gravity.index_integral([axis**2 for axis in axes], (i, j), 0)
            second = ellipsoid_gravity.index_integral([axis**2 for axis in axes], (i, j), 1)
            # A_i = B_ij + a_j^2 A_ij and, for axes that differ, A_ij = -(A_i - A_j)/(a_i^2 - a_j^2)
            assert second + float(squares[j]) * first == pytest.approx(float(singles[i]), rel=2e-15)
            if squares[i] != squares[j]:
                exact = -(singles[i] - singles[j]) / (squares[i] - squares[j])
                assert first == pytest.approx(float(exact), rel=2e-15)


def _without(values, index):
    return [value for i, value in enumerate(values) if i != index]


def test_gravity_inside_and_outside():
    axes, density, constant = np.array([1.5, 1.1, 0.6]), 0.7, 2.0
    rng = np.random.default_rng(1)
    points = rng.normal(size=(200, 3)) * 1.5
    step = 1e-5
    found = ellipsoid_gravity.acceleration(axes, points, density, constant)
    for i in range(3):
        shift = step * np.eye(3)[i]
        ahead, behind = (ellipsoid_gravity.potential(axes, points + s * shift, density, constant) for s in (1, -1))
        np.testing.assert_allclose(-(ahead - behind) / (2 * step), found[:, i], atol=2e-8)
    far = np.array([[2e4, 1e4, -3e4]])
    mass = 4 / 3 * math.pi * axes.prod() * density
    expected = -constant * mass / np.linalg.norm(far)
    assert ellipsoid_gravity.potential(axes, far, density, constant)[0] == pytest.approx(expected, rel=1e-8)


def test_potential_is_continuous_on_the_surface_and_that_of_a_sphere():
    direction = np.array([[0.3, -0.5, 0.2]])
    axes = np.array([1.5, 1.1, 0.6])
    on = direction / np.sqrt((direction**2 / axes**2).sum())
    inside, outside = (ellipsoid_gravity.potential(axes, on * f)[0] for f in (1 - 1e-12, 1 + 1e-12))
    assert inside == pytest.approx(outside, rel=1e-11)
    ball = ellipsoid_gravity.potential([1.0, 1.0, 1.0], [[0.0, 0.0, 0.5], [0.0, 3.0, 4.0]])
    np.testing.assert_allclose(ball, [-2 / 3 * math.pi * (3 - 0.25), -4 / 15 * math.pi], rtol=1e-15)


@pytest.mark.parametrize("size", [1e-160, 1e120])  # whose squares or cubes are no numbers
def test_energy_of_axes_in_any_unit(size):
    axes = np.array([3.0, 2.0, 1.0])
    np.testing.assert_allclose(
        ellipsoid_gravity.potential_energy_tensor(size * axes),
        ellipsoid_gravity.potential_energy_tensor(axes) / size,
        rtol=1e-15,
    )
    assert ellipsoid_gravity.gravitational_energy(size * axes) == pytest.approx(
        ellipsoid_gravity.gravitational_energy(axes) / size, rel=1e-15
    )
    np.testing.assert_allclose(
        ellipsoid_gravity.index_symbols(size * axes), ellipsoid_gravity.index_symbols(axes), rtol=1e-15
    )


def test_energy_is_the_trace_of_its_tensor_and_that_of_a_sphere():
    axes = [1.5, 1.1, 0.6]
    tensor = ellipsoid_gravity.potential_energy_tensor(axes, mass=2.0, gravitational_constant=0.5)
    assert tensor.sum() == pytest.approx(ellipsoid_gravity.gravitational_energy(axes, 2.0, 0.5), rel=1e-15)
    assert ellipsoid_gravity.gravitational_energy([2.0, 2.0, 2.0], 3.0) == pytest.approx(-0.6 * 9 / 2, rel=1e-15)


@pytest.mark.parametrize("body", [maclaurin.from_eccentricity(0.9, **SCALE), jacobi.from_axis_ratio(0.4, **SCALE)])
def test_surface_is_level_and_virial_tensor_balances(body):
    """Potential plus centrifugal potential is one constant on the surface: equilibrium, in the caller's units."""
    rng = np.random.default_rng(2)
    direction = rng.normal(size=(50, 3))
    points = direction / np.sqrt((direction**2 / body.axes**2).sum(-1))[:, None]
    level = ellipsoid_gravity.potential(body.axes, points, body.density, body.gravitational_constant)
    level = level - 0.5 * body.angular_velocity**2 * (points[:, 0] ** 2 + points[:, 1] ** 2)
    np.testing.assert_allclose(level, level[0], rtol=1e-13)
    tensor = ellipsoid_gravity.potential_energy_tensor(body.axes, body.mass, body.gravitational_constant)
    rotation = body.angular_velocity**2 * body.mass / 5 * body.axes**2 * [1, 1, 0]
    np.testing.assert_allclose((tensor + rotation) / tensor[2], 1.0, rtol=1e-13)
    assert body.kinetic_energy == pytest.approx(body.angular_momentum**2 / (2 * body.polar_moment), rel=1e-14)
    assert body.small_m == pytest.approx(body.angular_velocity**2 * 27 / (0.5 * 2.0), rel=1e-14)
    q = body.angular_velocity**2 * body.equatorial_radius**3 / (0.5 * 2.0)
    assert body.rotation_parameter == pytest.approx(q, rel=1e-14)
    assert body.mean_moment == pytest.approx(body.moment_ratio * 2.0 * 9.0, rel=1e-15)


@pytest.mark.parametrize("eccentricity", [1e-6, 0.3, 0.9, 0.94, 0.999999])
def test_maclaurin_from_every_quantity(eccentricity):
    body = maclaurin.from_eccentricity(eccentricity, **SCALE)
    branch = "slow" if body.second_eccentricity < maclaurin.fastest().second_eccentricity else "fast"
    again = [
        maclaurin.from_angular_momentum(body.angular_momentum, **SCALE),
        maclaurin.from_energy_ratio(body.rotational_to_gravitational, **SCALE),
        maclaurin.from_second_eccentricity(body.second_eccentricity, **SCALE),
    ]
    for other in again:
        assert other.second_eccentricity == pytest.approx(body.second_eccentricity, rel=2e-13)
        assert other.angular_velocity == pytest.approx(body.angular_velocity, rel=1e-13)
    other = maclaurin.from_angular_velocity(body.angular_velocity, branch, **SCALE)
    # the flat maximum at e = 0.92996 leaves fewer digits of the eccentricity
    assert other.second_eccentricity == pytest.approx(
        body.second_eccentricity, rel=2e-13 if eccentricity != 0.94 else 1e-11
    )


@pytest.mark.parametrize("b_over_a", [0.999, 0.5, 1e-3])
def test_jacobi_from_every_quantity(b_over_a):
    body = jacobi.from_axis_ratio(b_over_a, **SCALE)
    for other in (
        jacobi.from_angular_velocity(body.angular_velocity, **SCALE),
        jacobi.from_angular_momentum(body.angular_momentum, **SCALE),
        jacobi.from_energy_ratio(body.rotational_to_gravitational, **SCALE),
    ):
        # next to the bifurcation everything depends on the square of 1 - b/a
        assert other.b_over_a == pytest.approx(b_over_a, rel=1e-8 if b_over_a > 0.9 else 1e-13)


def test_harmonics_of_a_spheroid():
    """J_2n of the exterior field on the axis: V = -(GM/r)(1 - sum J_2n (a/r)^2n)."""
    body = maclaurin.from_eccentricity(0.5)
    height = 6 * body.equatorial_radius
    series = 1 - (body.zonal_harmonics * 6.0 ** (-2 * np.arange(1, 11))).sum()
    field = ellipsoid_gravity.potential(body.axes, [0, 0, height], body.density)
    assert -field * height == pytest.approx(series, rel=1e-15)
    assert body.second_zonal_harmonic == body.zonal_harmonics[0]
    moments = (body.polar_moment - body.equatorial_moment) / body.equatorial_radius**2
    assert body.second_zonal_harmonic == pytest.approx(moments, rel=1e-14)
    with pytest.raises(ValueError, match="three axes"):
        _ = jacobi.from_axis_ratio(0.5).zonal_harmonics
    long = jacobi.from_axis_ratio(0.5)
    a, b, c = long.principal_moments / (long.mass * long.equatorial_radius**2)
    assert long.second_zonal_harmonic == pytest.approx(c - (a + b) / 2, rel=1e-14)
    assert long.sectorial_harmonic == pytest.approx((b - a) / 4, rel=1e-14)


def test_bar_modes():
    """Kelvin's frequency without rotation; at rest in space at the bifurcation; complex beyond the dynamical limit."""
    kelvin = math.sqrt(16 / 15 * math.pi * 3 / (4 * math.pi))
    still = maclaurin.from_eccentricity(0.0).bar_mode_frequencies
    np.testing.assert_allclose(still, [kelvin, -kelvin], rtol=1e-14)
    fork = maclaurin.bifurcation()
    assert abs(fork.bar_mode_frequencies[1]) < 1e-14
    assert fork.bar_mode_frequencies[0] == pytest.approx(2 * fork.angular_velocity, rel=1e-14)
    limit = maclaurin.dynamical_limit().second_eccentricity
    below, above = (maclaurin.from_second_eccentricity(limit * factor) for factor in (1 - 1e-9, 1 + 1e-9))
    assert below.bar_mode_frequencies[0].imag == 0 and below.is_dynamically_stable
    assert above.bar_mode_frequencies[0].imag > 0 > above.bar_mode_frequencies[1].imag
    assert not above.is_dynamically_stable and not below.is_secularly_stable


@pytest.mark.parametrize(
    "call",
    [
        lambda: maclaurin.from_eccentricity(1.0),
        lambda: maclaurin.from_eccentricity(math.nan),
        lambda: maclaurin.from_axis_ratio(0.0),
        lambda: maclaurin.from_angular_velocity(10.0),
        lambda: maclaurin.from_angular_velocity(-1e-3),
        lambda: maclaurin.from_angular_velocity(0.0, "fast"),
        lambda: maclaurin.from_angular_velocity(0.1, "flat"),
        lambda: maclaurin.from_angular_momentum(-1.0),
        lambda: maclaurin.from_energy_ratio(0.5),
        lambda: maclaurin.from_eccentricity(0.5, mass=-1.0),
        lambda: jacobi.from_axis_ratio(1.1),
        lambda: jacobi.from_axis_ratio(0.0),
        lambda: jacobi.from_angular_momentum(0.3),
        lambda: jacobi.from_energy_ratio(0.13),
        lambda: jacobi.from_angular_velocity(1.0),
        lambda: ellipsoid_gravity.index_symbols([1.0, 0.0, 1.0]),
        lambda: ellipsoid_gravity.potential([1.0, 1.0], [[0, 0, 0]]),
    ],
)
def test_what_does_not_exist_is_refused(call):
    with pytest.raises(ValueError, match=r".{30,}"):
        call()


@pytest.mark.parametrize("rate", [-1e-3, -maclaurin.fastest().angular_velocity, math.nan])
def test_a_spheroid_that_turns_backwards_is_refused_for_that(rate):
    with pytest.raises(ValueError, match=f"is a number of 0 or more, not {rate}"):
        maclaurin.from_angular_velocity(rate)


def test_one_value_of_a_dataset_scales_a_figure() -> None:
    ds = xr.Dataset(
        {"mass": ("time", [2.0, 3.0], {"units": "kg"}), "mean_radius": ("time", [4.0, 5.0], {"units": "m"})}
    )
    one = ds.isel(time=1)
    for figure in (jacobi.from_axis_ratio, riemann.dedekind, maclaurin.from_axis_ratio):
        found = figure(0.7, mass=one["mass"], mean_radius=one["mean_radius"])
        np.testing.assert_allclose(found.axes, 5.0 * figure(0.7).axes, rtol=1e-14)
        assert found.mass == pytest.approx(3.0, rel=1e-15) and found.gravitational_constant < 1e-10


def test_index_symbols_take_units_as_their_neighbours_do():
    axes = np.array([3.0, 2.0, 1.0])
    assert ellipsoid_gravity.index_symbols(axes * u.km).tolist() == ellipsoid_gravity.index_symbols(1e3 * axes).tolist()
    pair = ellipsoid_gravity.index_integral(axes**2 * u.km**2, (0, 1), 1)
    assert pair == pytest.approx(ellipsoid_gravity.index_integral(axes**2, (0, 1), 1), rel=1e-14)
    with pytest.raises(ValueError, match="axes"):
        ellipsoid_gravity.index_symbols(axes * u.kg)
