"""The free wobble: periods by name, damping and excitation, against independent values and direct integration."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.bodies.earth import elastic_prem, prem_shear_quality
from astroinertia.bodies.love_numbers import YieldingBody, love_numbers
from astroinertia.bodies.planets import body
from astroinertia.rotation import wobble
from astroinertia.rotation.wobble import DAY

KNOWN = {
    entry["name"]: entry
    for entry in json.loads((Path(__file__).parents[2] / "reference" / "precession.json").read_text())
}


def test_periods_of_the_rigid_and_the_wholly_elastic_earth():
    known, earth = KNOWN["chandler"]["value"], body("Earth")
    ellipticity, spin = earth.value("dynamical_ellipticity"), earth.angular_velocity
    rigid = wobble.euler_frequency(ellipticity, spin)
    assert spin / rigid == pytest.approx(known["euler_sidereal_d"], rel=1e-9)
    assert 2 * np.pi / rigid / DAY == pytest.approx(known["euler_d"], rel=1e-7)
    j2 = earth.adopted("j2")
    secular = wobble.secular_love_number(j2.value, earth.gravitational_parameter, j2.radius, spin)
    assert secular == pytest.approx(known["secular_love_number"], rel=3e-6)

    def days(*arguments):
        return 2 * np.pi / wobble.chandler_frequency(ellipticity, spin, *arguments) / DAY

    assert days(0.298, secular) == pytest.approx(known["elastic_d"], rel=1e-6)
    assert days(0.298, secular, 0.886) == pytest.approx(known["decoupled_core_0.886_d"], rel=1e-6)
    assert days(known["love_number_of_433_d"], secular) == pytest.approx(433.0, rel=1e-6)


def test_each_cause_has_its_share_of_the_observed_period():
    found, observed = wobble.chandler_wobble(), KNOWN["chandler_wobble"]["value"]
    causes = ["rigid", "elasticity", "fluid core", "coupling", "flattening", "oceans", "dispersion", "anelasticity"]
    assert [share.name for share in found.shares] == causes
    change = {share.name: share.change / DAY for share in found.shares}
    # Smith & Dahlen 1981: about 395 d with a fluid core, oceans + 29.8 d, anelasticity + 8.5 d.
    assert found.shares[2].period / DAY == pytest.approx(395.0, abs=2)
    assert change["oceans"] == pytest.approx(29.8, abs=0.5)
    assert change["anelasticity"] == pytest.approx(8.5, abs=1.0)
    assert found.period / DAY == pytest.approx(observed["period_d"], abs=0.5)
    assert 50 < found.quality < 150
    assert sum(share.change for share in found.shares) == pytest.approx(found.period, rel=1e-14)
    assert found.mantle_share == pytest.approx(0.886, abs=5e-4)  # Smith & Dahlen 1981
    elastic = wobble.chandler_wobble(0.298).shares
    assert elastic[1].period / DAY == pytest.approx(KNOWN["chandler"]["value"]["elastic_d"], rel=1e-6)


def test_love_numbers_of_the_wobble_against_published_ones():
    # kappa = k omega^2 R^5/(3 G A) of PREM is 1.039e-3: Mathews, Buffett, Herring & Shapiro 1991, JGR 96, 8243
    earth = body("Earth")
    ellipticity, j2 = earth.value("dynamical_ellipticity"), earth.adopted("j2")
    secular = wobble.secular_love_number(j2.value, earth.gravitational_parameter, j2.radius, earth.angular_velocity)
    ellipticity /= 1 - ellipticity  # of A
    assert ellipticity * wobble.elastic_love_number() / secular == pytest.approx(1.039e-3, rel=2e-3)
    # PREM's Q of each layer, in the Love numbers of complex rigidities, has the size of Wahr & Bergen 1986
    earth, small = elastic_prem(), 1e-3
    laws = [lambda rate, q=q: 1 / (1 + 1j * small / q) for q in prem_shear_quality()[:-1]]
    yields = love_numbers(YieldingBody(earth.layers, earth.rigidity, earth.bulk_modulus, laws), 2, 1.0).k
    assert yields.imag / small == pytest.approx(-5.796e-4, rel=0.06)
    assert wobble.dispersion_love_number() == pytest.approx(6.08e-4 * 2 / np.pi * np.log(200), rel=0.02)


def test_the_free_core_nutation_of_prem():
    # hydrostatic: e = 3.247e-3, e_f = 2.548e-3, A_f/A = 0.1137, and -457 to -460 d: Mathews et al. 1991; Wahr 1981
    hydrostatic = 3.247e-3 / (1 + 3.247e-3), 7.292115e-5, 1.039, 3.247, 0.1137
    wobbling, nutation = wobble.wobble_and_nutation(*hydrostatic, 2.548e-3)
    assert 2 * np.pi / (7.292115e-5 + nutation) / DAY == pytest.approx(-458, abs=2)
    # a core that is round and yields nothing only stays behind
    rigid = wobble.wobble_and_nutation(*hydrostatic[:2], 0.0, 1.0, 0.1137, 0.0, 0.0, 0.0)
    first_order = wobble.chandler_frequency(*hydrostatic[:2], 0.0, 1.0, 1 - 0.1137)
    assert rigid[0] == pytest.approx(first_order, rel=1e-3) and rigid[1] == pytest.approx(-7.292115e-5, rel=1e-12)
    assert wobbling.real < first_order


def test_the_nutation_of_the_moons_node_in_a_yielding_earth_with_a_fluid_core():
    earth, node = body("Earth"), 2 * np.pi / (6798.38 * DAY)
    ellipticity, spin, tilt = earth.value("dynamical_ellipticity"), earth.angular_velocity, earth.value("obliquity")
    j2 = earth.adopted("j2")
    secular = wobble.secular_love_number(j2.value, earth.gravitational_parameter, j2.radius, spin)
    planet = ellipticity, spin, wobble.elastic_love_number(), secular, 1 - wobble.mantle_share()
    # rigid: REN-2000, Souchay et al. 1999; as it is: IAU 2000A. A nutation is the sum of two circular ones.
    longitude, obliquity = 17.2806 * np.sin(tilt), 9.2278
    ratios = wobble.nutation_ratio(np.array([-node, node, 0.0]), *planet)
    backward, forward = ratios[:2] * (obliquity + longitude, obliquity - longitude) / 2
    known = KNOWN["nutation_of_the_node"]["value"]
    assert (backward - forward) / np.sin(tilt) == pytest.approx(known["longitude"], abs=0.1 * (17.2806 - 17.2064))
    assert backward + forward == pytest.approx(known["obliquity"], abs=0.1 * (9.2278 - 9.2052))
    assert ratios[2] == 1
    assert wobble.nutation_ratio("-1 cycle/day", *planet) == wobble.nutation_ratio(-2 * np.pi / DAY, *planet)
    with pytest.raises(ValueError, match="frequency: must be in rad/s"):
        wobble.nutation_ratio("-1 Hz", *planet)
    free = wobble.wobble_and_nutation(*planet)[1].real + spin
    assert abs(wobble.nutation_ratio(free * (1 + 1e-6), *planet)) > 1e3  # resonance


def test_a_forced_nutation_solves_the_equations_of_mantle_and_core():
    """Sasao, Okubo & Saito 1980, of wobbles m and m_f: angular momentum of the whole, and of the core, under a torque.

    (sigma - e) m + (1 + sigma) (f m_f + c) = -e phi and sigma m + (1 + sigma + e_f) m_f + sigma c_f = 0, over the
    moments A and A_f = f A, with c = kappa (m - phi) + f gamma m_f and c_f = gamma (m - phi) + beta m_f.
    """
    h, k, secular, share, core, gamma, beta = 0.2, 0.3 - 0.01j, 0.9, 0.3, 0.05, 0.02, 0.07
    e = h / (1 - h)
    kappa = e * k / secular
    for in_space in (-0.3, 0.01, 0.4):
        sigma = in_space - 1
        equations = [
            [sigma - e + in_space * kappa, in_space * share * (1 + gamma)],
            [sigma * (1 + gamma), 1 + sigma + core + sigma * beta],
        ]
        pole = np.linalg.solve(equations, [in_space * kappa - e, sigma * gamma])[0]
        found = wobble.nutation_ratio(2.0 * in_space, h, 2.0, k, secular, share, core, gamma, beta)
        assert found == pytest.approx(pole / (-e / (sigma - e)), rel=1e-13)


def test_anelasticity_at_its_reference_and_at_the_chandler_period():
    assert wobble.anelastic_love_number(200.0) == pytest.approx(-5.796e-4j, abs=1e-18)
    year = wobble.anelastic_love_number(365.25 * DAY)
    # IERS TN 36, table 6.5b: k of the annual zonal tide Sa, 0.30775 with the elastic 0.29525 taken off.
    assert year.real == pytest.approx(0.0121, abs=3e-4) and year.imag == pytest.approx(-0.0035, abs=1e-4)
    with pytest.raises(ValueError, match="above 0"):
        wobble.anelastic_love_number(0.0)


def test_the_wobble_under_any_excitation():
    frequency = 2 * np.pi / 433 * (1 + 1j / 160)
    times = np.concatenate([np.linspace(0, 300, 40), np.linspace(301, 2000, 60)])
    drive = 1e-7 * (np.sin(times / 50) + 1j * np.cos(times / 37) + times / 500)
    found = wobble.wobble(times, frequency, 3e-7 + 1e-7j, drive)

    def rate(time, pole):
        chi = np.interp(time, times, drive.real) + 1j * np.interp(time, times, drive.imag)
        return 1j * frequency * (pole - chi)

    state, worst = np.array([3e-7 + 1e-7j]), 0.0
    for k in range(len(times) - 1):
        state = solve_ivp(rate, (times[k], times[k + 1]), state, rtol=1e-11, atol=1e-18).y[:, -1]
        worst = max(worst, abs(state[0] - found[k + 1]))
    assert worst < 1e-15


def test_the_free_wobble_decays_by_its_quality_and_a_forced_one_does_not():
    frequency = 2 * np.pi / 433 * (1 + 1j / 160)
    assert wobble.quality(frequency) == pytest.approx(80.0, rel=1e-13)
    assert wobble.quality(1.0 + 0j) == wobble.quality(1.0) == np.inf
    end = 433 * 80 / np.pi * np.array([0.0, 1.0])
    assert abs(wobble.wobble(end, frequency, 1.0)[1]) == pytest.approx(np.exp(-1), rel=1e-12)
    np.testing.assert_allclose(
        wobble.wobble(np.array([0.0, 1e7]), frequency, 1.0, np.array([0.5j, 0.5j]))[1], 0.5j, rtol=1e-14
    )
    annual = 2 * np.pi / 365.25
    times = np.linspace(0.0, 4000.0, 40001)
    amplitude = wobble.forced_wobble(frequency, annual, 1.0)
    found = wobble.wobble(times, frequency, amplitude, np.exp(1j * annual * times))
    np.testing.assert_allclose(found, amplitude * np.exp(1j * annual * times), atol=2e-6)


def test_the_pole_stays_at_its_excitation():
    """Where it is the axis of the largest moment of all that is there: figure, load, and the bulge that follows it."""
    axial, transverse, yields, load = 1.0, 1 - 1e-3, 0.3 / 0.9, -0.3
    change = 1e-9 * np.array([[0.4, 0.2, 0.7], [0.2, -0.1, -0.5], [0.7, -0.5, 0.3]])
    chi = wobble.polar_excitation(change, axial, transverse, 0.3, 0.9, load)
    bulge = np.zeros((3, 3))
    bulge[:2, 2] = bulge[2, :2] = yields * (axial - transverse) * np.array([chi.real, chi.imag])
    axes = np.linalg.eigh(np.diag([transverse, transverse, axial]) + (1 + load) * change + bulge)[1]
    pole = axes[:, 2] / axes[2, 2]
    assert complex(*pole[:2]) == pytest.approx(chi, rel=1e-5)
    assert wobble.polar_excitation(np.array([change, 2 * change]), axial, transverse).shape == (2,)


def test_excitations_of_the_earth_of_the_literature():
    """1.608 (1 - 0.316) (Delta I_xz + i Delta I_yz)/(C - A): Gross 2007, Treatise on Geophysics 3, chapter 9."""
    found = wobble.chandler_wobble()
    number = sum(share.love_number for share in found.shares)
    change = np.zeros((3, 3))
    change[1, 2] = change[2, 1] = 2.6e35
    bare, loaded = (
        wobble.polar_excitation(change, 8.0365e37, 8.0105e37, number, found.secular_love_number, load)
        for load in (0.0, -0.316)
    )
    assert bare.imag == pytest.approx(1.608, abs=5e-4)
    assert loaded.imag == pytest.approx(1.608 * 0.684, abs=5e-4)
    elastic = love_numbers(elastic_prem(), load=True).k
    assert elastic - 0.011 == pytest.approx(-0.316, abs=2e-3)  # with what anelasticity adds to it


def test_a_day_gets_longer_with_the_moment_of_what_turns():
    momentum, moment, change = 3.0, 2.0, np.diag([5.0, 7.0, 1e-8])
    before, after = (2 * np.pi * c / momentum for c in (moment, moment + 1e-8))
    found = wobble.length_of_day_change(change, moment, length_of_day=before)
    assert found == pytest.approx(after - before, rel=1e-7)
    assert wobble.length_of_day_change(change, moment, -0.25, 0.5, before) == pytest.approx(1.5 * found, rel=1e-14)
    assert wobble.length_of_day_change(1e7 * change, "2e7 g m2", length_of_day=before) == pytest.approx(1e3 * found)


def test_what_has_no_wobble_is_refused():
    for call, message in (
        (lambda: wobble.polar_excitation(np.eye(3), 2.0, 1.0, 0.94, 0.938), "keeps no pole"),
        (lambda: wobble.polar_excitation(np.eye(3), 2.0, 2.0), "no axis of figure"),
        (lambda: wobble.length_of_day_change(np.eye(3), 2.0, 0.0, 1.1), "share of the moment"),
        (lambda: wobble.euler_frequency(1.0, 1.0), "below 1"),
        (lambda: wobble.chandler_frequency(0.003, 1.0, 0.94, 0.938), "no free wobble"),
        (lambda: wobble.chandler_frequency(0.003, 1.0, 0.938, 0.938), "no free wobble"),
        (lambda: wobble.chandler_frequency(0.003, 1.0, 0.3, 0.94, 0.0), "share of the moment"),
        (lambda: wobble.chandler_frequency(0.003, 1.0, 0.3, 0.94, 1.01), "share of the moment"),
        (lambda: wobble.wobble([0.0, 0.0], 1.0), "increase"),
        (lambda: wobble.wobble([0.0, np.nan], 1.0), "increase"),
        (lambda: wobble.wobble([0.0, 1.0], 1.0 - 0.1j), "damps"),
        (lambda: wobble.wobble([0.0, 1.0], np.nan), "damps"),
        (lambda: wobble.forced_wobble(np.nan, 0.5, 1e-6), "damps"),
        (lambda: wobble.forced_wobble(0.0, 0.5, 1e-6), "damps"),
        (lambda: wobble.forced_wobble(1.0, [0.5, 1.0], 1e-6), "grows without end"),
        (lambda: wobble.wobble([0.0, 1.0], 1.0, 0.0, [1.0]), "one value"),
    ):
        with pytest.raises(ValueError, match=message):
            call()


def test_frequencies_of_a_wobble_need_finite_numbers():
    with pytest.raises(ValueError, match="the numbers of a wobble must be finite"):
        wobble.wobble_and_nutation(np.nan, 7.292115e-5, 0.297, 0.938, 0.1137)
