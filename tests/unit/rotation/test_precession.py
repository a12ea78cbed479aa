"""Rates of precession by formula, against independent values, published ones and averages of the torque itself."""

import json
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies.planets import body
from astroinertia.rotation import precession
from astroinertia.rotation.precession import ARCSECOND, ARCSECOND_PER_YEAR, JULIAN_YEAR
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS

KNOWN = {
    entry["name"]: entry
    for entry in json.loads((Path(__file__).parents[2] / "reference" / "precession.json").read_text())
}
MARS_ORBIT = (body("Sun").gravitational_parameter, 1.523679342 * 149597870700.0, 0.0934006)


def value(name):
    return KNOWN[name]["value"]


def test_the_earth_by_formula():
    found, known = precession.luni_solar_precession(), value("luni_solar_precession")
    assert found.solar / ARCSECOND_PER_YEAR == pytest.approx(known["solar"], rel=2e-7)
    assert found.lunar / ARCSECOND_PER_YEAR == pytest.approx(known["lunar"], rel=2e-7)
    assert found.total / ARCSECOND_PER_YEAR == pytest.approx(known["total"], rel=2e-7)
    assert found.period / JULIAN_YEAR == pytest.approx(known["period_yr"], rel=2e-7)
    # Of a rigid Earth: larger by 0.3 to 0.5 % than that of the Earth as it is.
    nutation = value("nutation_of_the_node")
    assert 1.003 < found.nutation_longitude / ARCSECOND / nutation["longitude"] < 1.006
    assert 1.002 < found.nutation_obliquity / ARCSECOND / nutation["obliquity"] < 1.004


def averaged_torque(normal, axis, eccentricity, points=20001):
    """The mean over an orbit of 3 (GM/r^3) (s.r)(r x s), GM = a = 1, by a sum over equal steps of eccentric anomaly."""
    u = 2 * np.pi * np.arange(points) / points
    first = np.cross(normal, [1.0, 0.3, 0.2])
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    x, y = np.cos(u) - eccentricity, np.sqrt(1 - eccentricity**2) * np.sin(u)
    place = x[:, None] * first + y[:, None] * second
    distance = 1 - eccentricity * np.cos(u)
    torque = 3 * (place @ axis)[:, None] * np.cross(place, axis) / distance[:, None] ** 5
    return (torque * distance[:, None]).mean(0)


@pytest.mark.parametrize("eccentricity", [0.0, 0.3, 0.8])
def test_the_constant_is_the_average_of_the_torque(eccentricity):
    normal, axis = np.array([0.0, 0.6, 0.8]), np.array([0.48, 0.36, 0.8])
    alpha = precession.precession_constant(1.0, 1.0, 1.0, 1.0, eccentricity)
    expected = -alpha * (axis @ normal) * np.cross(normal, axis)
    np.testing.assert_allclose(averaged_torque(normal, axis, eccentricity), expected, rtol=1e-10, atol=1e-12)


def test_an_inclined_orbit_with_a_fast_node():
    """Mean rate and both amplitudes of the nutation, from the torque averaged over the node as well."""
    tilt, lean, alpha, count = 0.4, 0.09, 1.0, 720
    node = 2 * np.pi * np.arange(count) / count
    axis = np.array([0.0, np.sin(tilt), np.cos(tilt)])
    normals = np.stack([np.sin(lean) * np.sin(node), -np.sin(lean) * np.cos(node), np.full(count, np.cos(lean))], 1)
    rates = np.array([-alpha * (axis @ n) * np.cross(n, axis) for n in normals])
    # A regression moves the axis towards +x; a growing obliquity towards +y of the pole's projection.
    longitude, obliquity = rates[:, 0] / np.sin(tilt), rates[:, 1] / np.cos(tilt)
    assert longitude.mean() == pytest.approx(
        float(precession.precession_rate(1, 1.5 / alpha, tilt, 1, 1, 0, lean)), rel=1e-12
    )
    amplitudes = precession.node_nutation(1, 1.5 / alpha, tilt, 1, 1, 0, lean, -1.0)
    # d/dt of -longitude sin(node) and of obliquity cos(node), with node = -t.
    assert 2 * np.mean(longitude * np.cos(node)) == pytest.approx(amplitudes[0], rel=1e-12)
    assert 2 * np.mean(obliquity * np.sin(node)) == pytest.approx(amplitudes[1], rel=1e-12)


def test_relativity():
    earth = precession.geodesic_precession(
        body("Sun").gravitational_parameter, precession.SUN_SEMI_MAJOR_AXIS, precession.SUN_ECCENTRICITY
    )
    assert earth / ARCSECOND_PER_YEAR == pytest.approx(value("geodesic_precession"), rel=2e-5)
    mars = precession.geodesic_precession(*MARS_ORBIT)
    assert mars / ARCSECOND_PER_YEAR == pytest.approx(value("mars_rigid")["geodesic_mas"] / 1e3, rel=1e-3)
    for name, rel in (("J0737-3039B", 2e-4), ("B1913+16", 4e-3)):
        pulsar = value("geodetic_precession_of_pulsars")[name]
        own, other = (GRAVITATIONAL_CONSTANT * SOLAR_MASS * pulsar[key] for key in ("own_msun", "other_msun"))
        rate = precession.geodetic_precession_of_binary(pulsar["period_d"] * 86400, own, other, pulsar["eccentricity"])
        assert np.degrees(rate) * JULIAN_YEAR == pytest.approx(pulsar["deg_per_yr"], rel=rel)
    a, mu, e = 7e8, 1.3e20, 0.4
    light = precession.geodetic_precession_of_binary(2 * np.pi * np.sqrt(a**3 / mu), 0.0, mu, e)
    assert light == pytest.approx(precession.geodesic_precession(mu, a, e), rel=1e-14)


def test_the_ecliptic_moves_too():
    known = value("IAU2006_precession")
    tilt = body("Earth").value("obliquity")
    pole = known["chi_A"] * np.sin(tilt)
    assert precession.general_precession(known["psi_A"], tilt, pole) == pytest.approx(known["p_A"], abs=5e-4)


def test_mars_by_formula():
    known, spin = value("mars_precession"), body("Mars").angular_velocity
    tilt = np.radians(KNOWN["mars_precession"]["inputs"]["obliquity_deg"])
    found = precession.moment_ratio_from_rate(7.608 * ARCSECOND_PER_YEAR, 1.9566e-3, spin, tilt, *MARS_ORBIT)
    assert found == pytest.approx(known["moment_ratio_at_7608_mas"], rel=5e-8)
    rate = precession.rate_from_moment_ratio(0.3644, 1.9566e-3, spin, tilt, *MARS_ORBIT)
    assert 1e3 * rate / ARCSECOND_PER_YEAR == pytest.approx(known["rate_at_0.3644_mas"], rel=1e-7)
    # Relativity out of the measured rates: C/(M a^2) as published, within its error.
    geodesic = precession.geodesic_precession(*MARS_ORBIT)
    for name in ("mars_rigid", "mars_pathfinder_precession"):
        measured = value(name)
        torque = -measured["rate_mas"] / 1e3 * ARCSECOND_PER_YEAR + geodesic
        ratio = precession.moment_ratio_from_rate(torque, 1.9566e-3, spin, tilt, *MARS_ORBIT)
        assert abs(ratio - measured["moment_ratio"]) < measured["moment_ratio_error"]
    with pytest.raises(ValueError, match="does not precess"):
        precession.moment_ratio_from_rate(0.0, 1e-3, spin, tilt, *MARS_ORBIT)


def test_orbits_about_a_flattened_body():
    """The perturbing potential averaged over an orbit, differentiated as Lagrange's equations say."""
    j2, radius, mu, a, e, i = 1e-3, 1.0, 1.0, 4.0, 0.3, 0.7

    def averaged(eccentricity, inclination):
        u = 2 * np.pi * np.arange(4096) / 4096
        distance = a * (1 - eccentricity * np.cos(u))
        sine = np.sqrt(1 - eccentricity**2) * np.sin(u) * a / distance
        potential = -mu * j2 * radius**2 / distance**3 * (1.5 * (np.sin(inclination) * sine) ** 2 - 0.5)
        return (potential * distance / a).mean()

    step, n = 1e-5, np.sqrt(mu / a**3)
    by_e = (averaged(e + step, i) - averaged(e - step, i)) / (2 * step)
    by_i = (averaged(e, i + step) - averaged(e, i - step)) / (2 * step)
    root = np.sqrt(1 - e**2)
    node = by_i / (n * a**2 * root * np.sin(i))
    assert precession.nodal_precession(j2, radius, mu, a, e, i) == pytest.approx(node, rel=1e-8)
    pericentre = root / (n * a**2 * e) * by_e - np.cos(i) * node
    assert precession.apsidal_precession(j2, radius, mu, a, e, i) == pytest.approx(pericentre, rel=1e-8)
    assert abs(precession.apsidal_precession(j2, radius, mu, a, e, np.arccos(5**-0.5))) < 1e-18
    both = precession.apsidal_precession(j2, radius, mu, a) + precession.nodal_precession(j2, radius, mu, a)
    assert both == pytest.approx(1.5 * j2 * (radius / a) ** 2 * n, rel=1e-14)


def test_a_be_stars_disc_precesses_in_years():
    """Papaloizou, Savonije & Henrichs 1992: V/R variations of some ten years from the flattening of the star."""
    from astroinertia.bodies import apsidal, clairaut, earth
    from astroinertia.rotation.wobble import secular_love_number

    # A fluid Earth of PREM, and back to the k2 that it came from.
    found = clairaut.hydrostatic_figure(earth.prem(), earth.EARTH_ROTATION_RATE)
    k2, mu = float(found.love_number), body("Earth").gravitational_parameter
    j2 = precession.rotational_j2(k2, earth.EARTH_ROTATION_RATE, 6371e3, mu)
    assert j2 == pytest.approx(float(found.j2), rel=1e-3)
    assert secular_love_number(j2, mu, 6371e3, earth.EARTH_ROTATION_RATE) == pytest.approx(k2, rel=1e-14)
    # 10 solar masses and 5 radii at 0.9 of break-up, as condensed as n = 3; a ring at 3 radii.
    mu, radius = 10 * GRAVITATIONAL_CONSTANT * SOLAR_MASS, 5 * 6.957e8
    spin = 0.9 * np.sqrt(mu / radius**3)
    j2 = precession.rotational_j2(apsidal.love_number(3.0), spin, radius, mu)
    orbit = (j2, radius, mu, 3 * radius)
    years = 2 * np.pi / (precession.apsidal_precession(*orbit) + precession.nodal_precession(*orbit)) / JULIAN_YEAR
    assert 1 < years < 30


def test_orbit_and_spin_go_round_their_sum_together():
    orbit, spin = np.array([0.0, 0.6, 0.8]) * 3.0, np.array([0.0, 0.0, 1.0]) * 2.0
    rate = 0.01 * np.cross(spin / 2.0, orbit)  # of the orbit's angular momentum: node rate 0.01 about the spin
    total = orbit + spin
    about = precession.mutual_precession_rate(0.01, 3.0, 2.0, np.arccos(0.8))
    np.testing.assert_allclose(about * np.cross(total / np.linalg.norm(total), orbit), rate, rtol=1e-14, atol=1e-16)
    # Two as large that lie nearly against each other leave 2 cos(i/2) of one.
    nearly = np.pi - 1e-6
    assert precession.mutual_precession_rate(1.0, 3.0, 3.0, nearly) == pytest.approx(1e-6, rel=1e-9)


def test_saturn_precesses_with_titan():
    """Ward & Hamilton 2004: moons add 0.0516 to J2 and 0.0028 to C/(M R^2); alpha is 0.83 arc seconds a year."""
    saturn, radius = body("Saturn"), 60268e3
    inner = [(8978.13710e9, 1221870e3), (153.94e9, 527068e3)]  # Titan and Rhea: GM and semi-major axis
    bulge, momentum = precession.moons_of_the_equator(
        saturn.gravitational_parameter, radius, saturn.angular_velocity, *zip(*inner, strict=True)
    )
    assert bulge == pytest.approx(0.0492, rel=0.01)  # Iapetus, beyond the Laplace radius, does the rest
    assert momentum == pytest.approx(0.0028, rel=0.05)
    ratio = 0.2199  # their C/(M R^2)
    ellipticity = (saturn.zonal_harmonic(radius) + 0.05164) / (ratio + 0.00278)
    sun = body("Sun").gravitational_parameter
    alpha = precession.precession_constant(ellipticity, saturn.angular_velocity, sun, 9.5549 * 149597870700.0, 0.0555)
    assert alpha / ARCSECOND_PER_YEAR == pytest.approx(0.83, abs=0.02)


def test_charon_turns_about_pluto_in_its_observed_period():
    """6.3872 d at 19596 km: a moon of an eighth of its planet counts in its orbit, by Kepler's third law."""
    share, arm, spin = 106.1 / 869.3, (19595.8 / 1188.3) ** 2, 1e-5
    bulge, momentum = precession.moons_of_the_equator(869.3e9, 1188.3e3, spin, [106.1e9], [19595.8e3])
    assert bulge == pytest.approx(0.5 * share * arm)
    assert momentum == pytest.approx(share * arm * 2 * np.pi / (6.387222 * 86400) / spin, rel=1e-3)


@pytest.mark.parametrize("orbit", [(-1.0, 0.0), (1.0, 1.0), (1.0, -0.1), (1.0, np.nan)])
def test_what_is_no_ellipse_is_refused(orbit):
    for function in (
        lambda: precession.precession_constant(0.003, 1.0, 1.0, *orbit),
        lambda: precession.geodesic_precession(1.0, *orbit),
        lambda: precession.nodal_precession(0.001, 1.0, 1.0, *orbit),
    ):
        with np.errstate(invalid="ignore"), pytest.raises(ValueError, match="ellipse"):
            function()


def test_without_a_spin_no_axis_precesses() -> None:
    orbit = 1.32712e20, 1.495979e11
    for spins in (0.0, np.array([7.292115e-5, 0.0])):
        with pytest.raises(ValueError, match="spin_rate must not be 0"):
            precession.precession_rate(1 / 305.5, spins, 0.4, *orbit)
    with pytest.raises(ValueError, match="node_rate must not be 0"):
        precession.node_nutation(1 / 305.5, 7.292115e-5, 0.4, *orbit, 0.0, 0.1, 0.0)
    with pytest.raises(ValueError, match="spin_rate must not be 0"):
        precession.moons_of_the_equator(1.267e17, 7.15e7, 0.0, np.array([9.89e12]), np.array([1.0704e9]))


def test_what_attracts_nothing_is_refused():
    """A negative GM turned the axis forwards."""
    orbit = {"gravitational_parameter": -1.3e20, "semi_major_axis": 1.5e11}
    with pytest.raises(ValueError, match="gravitational_parameter must not be negative"):
        precession.precession_constant(1 / 305.5, 7.292115e-5, **orbit)
    with pytest.raises(ValueError, match="gravitational_parameter must not be negative"):
        precession.geodesic_precession(**orbit)
    with pytest.raises(ValueError, match="gravitational_parameter must not be negative"):
        precession.nodal_precession(1e-3, 6.4e6, **orbit)
    with pytest.raises(ValueError, match="radius must not be negative"):
        precession.apsidal_precession(1e-3, -6.4e6, 4e14, 7e6)


def test_a_radius_in_whole_metres_gives_the_j2_of_rotation():
    """J2 = (k2/3) omega^2 R^3/(GM): R^3 of the Earth is 2.6e20 m3, beyond 64 bits."""
    expected = 0.9 / 3 * 7.292e-5**2 * float(6371000**3) / 3.986e14
    assert precession.rotational_j2(0.9, 7.292e-5, 6371000, 3.986e14) == pytest.approx(expected, rel=1e-14)
