"""Pulsars: the Crab's numbers, conventions of the field, ages and histories for any braking index."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from astroinertia.errors import SceneError
from astroinertia.inertia.evolution import gravitational_wave_strain
from astroinertia.rotation import accretion, braking, pulsars
from astroinertia.rotation.pulsar_table import KINDS, pulsar, pulsars as table
from astroinertia.units import GRAVITATIONAL_CONSTANT, SPEED_OF_LIGHT

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "spin_up.json").read_text())
PULSARS = [entry for entry in REFERENCE if entry["name"] == "pulsar_braking"]
P, DOT = 0.0333924123, 4.20972e-13
YEAR = 365.25 * 86400


@pytest.mark.parametrize("entry", PULSARS, ids=lambda entry: entry["inputs"]["name"])
def test_reference_values(entry):
    inputs, value = entry["inputs"], {name: float(text) for name, text in entry["value"].items()}
    period, slowing, moment, radius = inputs["P"], inputs["Pdot"], inputs["I"] * 1e-7, inputs["R"] * 1e-2
    found = {
        "Edot_erg_s": 1e7 * pulsars.spin_down_luminosity(period, slowing, moment),
        "tau_char_yr": pulsars.characteristic_age(period, slowing) / YEAR,
        "B_eq_G": 1e4 * pulsars.dipole_field(period, slowing, moment, radius),
        "Erot_erg": 1e7 * pulsars.rotational_energy(period, moment),
    }
    assert set(found) == set(value)
    for name, number in found.items():
        assert float(number) == pytest.approx(value[name], rel=1e-9), name


def test_the_crab_of_the_literature():
    (entry,) = (entry for entry in REFERENCE if entry["name"] == "crab_pulsar")
    assert entry["inputs"] == {"P": P, "Pdot": DOT}
    assert pulsars.spin_down_luminosity(P, DOT) == pytest.approx(4.5e31, rel=0.01)
    assert pulsars.characteristic_age(P, DOT) / YEAR == pytest.approx(entry["value"]["tau_char_yr"], abs=0.05)
    # Born in 1054, timed in mid-1991, with the index 2.51 (Lyne, Pritchard & Graham-Smith 1993): 19 ms.
    assert pulsars.period_at_birth(P, DOT, 937 * YEAR, 2.51) == pytest.approx(0.019, abs=0.0005)


def test_conventions_of_the_field():
    equator = pulsars.dipole_field(P, DOT)
    assert equator == pytest.approx(3.2e15 * math.sqrt(P * DOT), rel=1e-3)  # tesla
    assert pulsars.dipole_field(P, DOT, place="pole") == pytest.approx(2 * equator)
    tilted = pulsars.dipole_field(P, DOT, inclination=math.radians(30))
    assert tilted == pytest.approx(2 * equator)
    # A conducting magnetosphere takes 1 + sin^2 where vacuum takes (2/3) sin^2: three times the loss at right angles.
    assert pulsars.dipole_field(P, DOT, magnetosphere="force_free") == pytest.approx(equator / math.sqrt(3))
    aligned = pulsars.dipole_field(P, DOT, magnetosphere="force_free", inclination=0.0)
    assert aligned == pytest.approx(equator * math.sqrt(2 / 3))
    for options in ({}, {"place": "pole", "inclination": 0.4}, {"magnetosphere": "force_free", "inclination": 1.0}):
        field = pulsars.dipole_field(P, DOT, 1.3e38, 1.2e4, **options)
        assert pulsars.dipole_period_derivative(P, field, 1.3e38, 1.2e4, **options) == pytest.approx(DOT, rel=1e-13)
    for wrong in ({"place": "middle"}, {"magnetosphere": "plasma"}, {"inclination": 0.0}):
        with pytest.raises(ValueError, match=r"a field is|a magnetosphere is|loses nothing"):
            pulsars.dipole_field(P, DOT, **wrong)
    cylinder = pulsars.light_cylinder_radius(P)
    assert cylinder == pytest.approx(1.593e6, rel=1e-3)
    assert pulsars.light_cylinder_field(equator, P) == pytest.approx(equator * (1e4 / cylinder) ** 3)


@pytest.mark.parametrize("n", [-1.0, 0.0, 0.9, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.5, 2.51, 3.0, 5.0, 7.0])
def test_history_obeys_its_law_for_any_index(n):
    later = 300 * YEAR
    period = pulsars.period_history(later, P, DOT, n)
    slowing = pulsars.period_derivative_history(later, P, DOT, n)
    # Omega' = -K Omega^n, that is P^(n - 2) P' stays.
    assert period ** (n - 2) * slowing == pytest.approx(P ** (n - 2) * DOT, rel=1e-12)
    step = 1e-3 * YEAR
    rise = pulsars.period_history(later + step, P, DOT, n) - pulsars.period_history(later - step, P, DOT, n)
    assert rise / (2 * step) == pytest.approx(slowing, rel=1e-7)
    # There and back, and the age from both ends.
    assert pulsars.period_at_birth(period, slowing, later, n) == pytest.approx(P, rel=1e-13)
    assert pulsars.true_age(period, slowing, P, n) == pytest.approx(later, rel=1e-11)
    # n again, from the two ends alone.
    found = pulsars.braking_index_between(later, 1 / P, -DOT / P**2, 1 / period, -slowing / period**2)
    assert found == pytest.approx(n, abs=1e-11)


def test_a_short_age_has_all_its_digits():
    """1 - (1 - x)^2 = 2 x - x^2 and -ln(1 - x) = x + x^2/2 + ..., of a period that is x longer than at birth."""
    x, period = 2.0**-30, 2.0**-5
    for n, turns in ((3.0, x - x**2 / 2), (1.0, x + x**2 / 2)):
        age = pulsars.true_age(period, DOT, period * (1 - x), n)
        assert age == pytest.approx(period / DOT * turns, rel=1e-15)
        back = pulsars.true_age(period * (1 - x), DOT, period, n)  # what has yet to come is negative
        assert back == pytest.approx(-period * (1 - x) / DOT * (x + x**2 * (1.5 if n == 3 else 0.5)), rel=1e-15)


def test_measured_indices():
    n = 2.84
    second = (2 - n) * DOT**2 / P
    assert pulsars.braking_index(P, DOT, second) == pytest.approx(n, rel=1e-14)
    assert pulsars.braking_index(f"{1e3 * P} ms", DOT, f"{second * YEAR} yr-1") == pytest.approx(n, rel=1e-13)
    nu, nu1 = 1 / P, -DOT / P**2
    nu2, nu3 = n * nu1**2 / nu, n * (2 * n - 1) * nu1**3 / nu**2
    assert pulsars.frequency_braking_index(nu, nu1, nu2) == pytest.approx(n, rel=1e-14)
    assert pulsars.second_braking_index(nu, nu1, nu3) == pytest.approx(n * (2 * n - 1), rel=1e-14)
    later = pulsars.period_history(YEAR, P, DOT, n), pulsars.period_derivative_history(YEAR, P, DOT, n)
    spins = f"{nu:.17g} Hz", f"{nu1:.17g} Hz/s", f"{1 / later[0]:.17g} Hz", f"{-later[1] / later[0] ** 2:.17g} Hz/s"
    assert pulsars.braking_index_between("1 yr", *spins) == pytest.approx(n, rel=1e-9)


def test_before_infinite_spin_and_after_rest_there_is_nothing():
    age = pulsars.characteristic_age(P, DOT)
    assert np.isnan(pulsars.period_history(-1.001 * age, P, DOT))
    assert pulsars.period_history(-0.999 * age, P, DOT) == pytest.approx(P * math.sqrt(0.001), rel=1e-9)
    assert np.isnan(pulsars.period_history(3 * P / DOT, P, DOT, 0.0))  # P (1 - t P'/P)^-1 ends at rest
    assert pulsars.characteristic_age(P, DOT, 1.0) == math.inf


def test_a_star_that_never_was_infinitely_fast_has_no_finite_age():
    # Glitches leave J0537-6910 with -1.2 (Antonopoulou et al. 2018, MNRAS 473, 1644).
    # Its law then has no time at which it was infinitely fast.
    indices = np.array([3.0, 1.5, 1.0, 0.9, -1.2])
    ages = pulsars.characteristic_age(P, DOT, indices)
    np.testing.assert_allclose(ages[:2], [P / (2 * DOT), 2 * P / DOT], rtol=1e-15)
    assert np.all(np.isposinf(ages[2:]))
    # What it is of: as long ago the star had a period still.
    assert np.all(pulsars.period_history(-1e3 * P / DOT, P, DOT, indices[2:]) >= 0.0)
    assert np.all(np.isnan(pulsars.period_history(-1.001 * ages[:2], P, DOT, indices[:2])))


def test_the_table_of_pulsars():
    crab = pulsar("crab")
    assert (crab.jname, crab.period, crab.period_derivative) == ("J0534+2200", P, DOT)
    assert crab.braking_index == 2.51 and "1993" in crab.braking_index_source
    assert crab == pulsar("PSR B0531+21") == pulsar("PSR J0534+2200")
    everyone = table()
    assert {each.kind for each in everyone} == set(KINDS)
    assert all(each.period > 0 and each.period_derivative > 0 and each.source for each in everyone)
    assert len({each.jname for each in everyone}) == len(everyone) > 50
    # Kinds by what they are known for: magnetars above 1e14 G, recycled pulsars below 1e11 G.
    for each in everyone:
        gauss = 1e4 * pulsars.dipole_field(each.period, each.period_derivative)
        assert each.kind != "recycled" or gauss < 1e11, each.name
        assert each.kind != "magnetar" or gauss > 2e13, each.name
    with pytest.raises(KeyError, match="no pulsar"):
        pulsar("J0000+0000")


@pytest.mark.parametrize("wrong", [math.nan, 0.0, -1.0, [1.0, -2.0]], ids=str)
@pytest.mark.parametrize("formula", [
    pulsars.rotational_energy,
    lambda period: pulsars.spin_down_luminosity(period, DOT),
    lambda period: pulsars.dipole_field(period, DOT),
    lambda period: pulsars.dipole_period_derivative(period, 4e8),
    pulsars.light_cylinder_radius,
    lambda period: pulsars.light_cylinder_field(4e8, period),
    lambda period: pulsars.characteristic_age(period, DOT),
    lambda period: pulsars.true_age(period, DOT, 0.02),
    lambda period: pulsars.period_at_birth(period, DOT, YEAR),
    lambda period: pulsars.period_history(YEAR, period, DOT),
    lambda period: pulsars.period_derivative_history(YEAR, period, DOT),
    lambda period: pulsars.braking_index(period, DOT, 1e-24),
    lambda period: pulsars.shklovskii_effect(period, 1e-14, 1e19),
    lambda period: pulsars.spin_down_strain(period, DOT, 1e19),
    lambda period: pulsars.strain_of_ellipticity(1e-6, period, 1e19),
    lambda period: pulsars.ellipticity_of_strain(1e-25, period, 1e19),
    accretion.corotation_radius,
    lambda period: accretion.mass_to_spin_up(period, 1e4, 1e14),
    accretion.spin_up_line,
    lambda period: braking.decaying_field_period(YEAR, period, DOT, YEAR),
    lambda period: braking.decaying_field_index(period, DOT, YEAR),
])  # fmt: skip
def test_periods_that_cannot_be_are_refused(formula, wrong):
    with pytest.raises(SceneError, match=r"^period must be above 0 s, not (nan|0|-1|-2) s$"):
        formula(wrong)


def test_a_star_was_born_with_a_period():
    with pytest.raises(SceneError, match=r"^period_at_birth must be above 0 s, not 0 s$"):
        pulsars.true_age(P, DOT, 0.0)


def test_a_star_at_rest_has_no_energy_of_rotation():
    assert pulsars.rotational_energy(math.inf) == 0.0


def test_spin_down_limits_of_the_literature():
    """Aasi et al. 2014, ApJ 785, 119: 1.4e-24 of the Crab at 2.0 kpc and 3.3e-24 of Vela at 290 pc."""
    vela = pulsar("Vela")
    assert pulsars.spin_down_strain(P, DOT, "2.0 kpc") == pytest.approx(1.4e-24, abs=5e-26)
    assert pulsars.spin_down_strain(vela.period, vela.period_derivative, "290 pc") == pytest.approx(3.3e-24, abs=5e-26)
    assert pulsars.ellipticity_of_strain(1.1e-24, vela.period, "290 pc") == pytest.approx(6.0e-4, abs=5e-6)
    assert np.isnan(pulsars.spin_down_strain(P, -DOT, "2.0 kpc"))
    for formula in (pulsars.spin_down_strain, pulsars.strain_of_ellipticity, pulsars.ellipticity_of_strain):
        with pytest.raises(SceneError, match="distance must be positive and finite"):
            formula(P, DOT, 0.0)


def test_the_strain_of_an_ellipticity_is_that_of_the_turning_quadrupole():
    second, distance, rate = np.diag([5.0, 3.0, 1.0]) * 1e37, 3e19, 2 * math.pi / P
    spin = rate * np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    turned = spin @ second - second @ spin
    plus, _ = gravitational_wave_strain(spin @ turned - turned @ spin, 0.0, distance=distance)
    moment = 8e37  # C, and B - A = 2e37
    assert pulsars.strain_of_ellipticity(0.25, P, distance, moment) == pytest.approx(abs(plus), rel=1e-14)
    assert pulsars.ellipticity_of_strain(abs(plus), P, distance, moment) == pytest.approx(0.25, rel=1e-14)


def test_at_the_spin_down_limit_waves_take_all_that_is_lost():
    """32 G/(5 c^5) eps^2 I^2 Omega^6, of Peters & Mathews, at any distance."""
    moment = 1.3e38
    strain = pulsars.spin_down_strain(P, DOT, 7e18, moment)
    ellipticity = pulsars.ellipticity_of_strain(strain, P, 7e18, moment)
    power = 6.4 * GRAVITATIONAL_CONSTANT / SPEED_OF_LIGHT**5 * (ellipticity * moment) ** 2 * (2 * math.pi / P) ** 6
    assert power == pytest.approx(pulsars.spin_down_luminosity(P, DOT, moment), rel=1e-13)


def test_a_pulsar_that_crosses_the_sky_seems_to_slow_down():
    """On a straight path the distance grows faster and faster, and with it the time that pulses take."""
    distance, motion, step = 4.8e18, 2e-14, 1e9  # m, rad/s, s
    longer = np.hypot(distance, distance * motion * step) - distance  # of r = d + r'' t^2/2
    effect = pulsars.shklovskii_effect(1.0, motion, distance)
    assert effect == pytest.approx(2 * longer / step**2 / SPEED_OF_LIGHT, rel=1e-4)
    # J0437-4715: a quarter of its 5.7294e-20 is its own
    assert pulsars.shklovskii_effect("5.7574519 ms", "140.91 mas/yr", "156.79 pc") == pytest.approx(4.36e-20, abs=1e-22)
