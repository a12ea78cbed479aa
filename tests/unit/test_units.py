"""Quantities from text, and code units."""

import math
import subprocess
import sys
from fractions import Fraction

import pytest
import xarray as xr
from astropy import constants, units as u
from hypothesis import given, strategies as st

from astroinertia import units
from astroinertia.errors import SceneError
from astroinertia.units import DIMENSIONS, EXAMPLES, CodeUnits, Dimension, dimension_of, quantity
from tests.sims import SIMS

GOOD = [
    ("1500 km", "length", 1.5e6),
    ("1.4 Msun", "mass", 1.4 * constants.M_sun.si.value),
    ("5km", "length", 5e3),
    ("-3e2 m", "length", -300.0),
    ("33 ms", "time", 0.033),
    ("2e14 g/cm3", "density", 2e17),
    ("1 1/s", "angular_velocity", 1.0),
    ("1 rad/s", "angular_velocity", 1.0),
    ("30 cycle/s", "angular_velocity", 60.0 * math.pi),
    ("1800 rpm", "angular_velocity", 60.0 * math.pi),
    ("180 deg", "angle", math.pi),
    ("0 m", "length", 0.0),
    ("1e51 erg", "energy", 1e44),
]

BAD = [
    ("5", "not a number and a unit"),
    ("km", "not a number and a unit"),
    ("", "not a number and a unit"),
    ("nan m", "not a finite number"),
    ("-inf m", "not a finite number"),
    ("1e400 m", "not a finite number"),
    ("1e-400 m", "too small"),
    ("1e99999999 m", "not a finite number"),
    ("1 m**1000000", "exponent beyond"),
    ("1 m^1000000", "exponent beyond"),
    ("1 m1000000", "exponent beyond"),
    ("1 m**99999999999999999999999999", "exponent beyond"),
    ("1 kg", "not a length"),
    ("1 m2", "not a length"),
    ("1 m rad", "not a length"),
    ("1 K", "not a unit of mechanics"),
    ("1 mag", "no finite size"),
    ("1 dex(m)", "not a unit"),
    ("1 m**(1/0)", "not a unit"),
    ("1 parsnips", "not a unit"),
    ("1 km/s/Mpc", "not a unit"),
    ("1_000 m", "not a number and a unit"),
    ("٣ m", "not a number and a unit"),
    ("1 m\x00", "not a unit"),
    ("0x10 m", "not a unit"),
    ("1 " + "m " * 100, "longer than"),
    ("(" * 70 + "m", "not a number and a unit"),
    ("3 m2/s/km", r"'m2/s/km' is not a unit .*; write what it divides by in brackets, as in kg/\(m s\)"),
]


@pytest.mark.parametrize(("text", "dimension", "expected"), GOOD)
def test_good_quantities_have_their_si_value(text, dimension, expected):
    assert quantity(text, dimension) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(("text", "message"), BAD)
def test_bad_quantities_are_refused_in_a_sentence(text, message):
    with pytest.raises(SceneError, match=message) as caught:
        quantity(text, "length")
    assert str(caught.value).endswith(".")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 200


def test_a_dimension_that_has_no_name_is_refused_with_those_that_have():
    with pytest.raises(SceneError, match=r"no dimension named 'specific power': there are .* specific_power, .*"):
        dimension_of("specific power")


def test_units_of_most_scenes_are_those_of_astropy_to_the_last_bit(monkeypatch):
    known = dict(units._OF_SCENES)
    monkeypatch.setattr(units, "_OF_SCENES", {})
    units._unit.cache_clear()
    assert {text: units._unit(text) for text in known} == known
    units._unit.cache_clear()


def test_a_usual_scene_is_read_without_astropy():
    read = (
        "import sys; from astroinertia.scene import load; load.load_file(sys.argv[1]); print('astropy' in sys.modules)"
    )
    command = [sys.executable, "-c", read, str(SIMS / "pulsar_collapse.toml")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip() == "False"


def test_a_series_may_be_in_turns_a_minute():
    series = xr.DataArray([30.0], attrs={"units": "rpm"})
    assert units.in_si(units.with_unit(series), "angular_velocity") == pytest.approx([math.pi])


@pytest.mark.parametrize("unit", ["Hz", "kHz", "1 Hz"])
def test_hertz_is_refused_for_an_angular_velocity(unit):
    with pytest.raises(SceneError, match="radians or turns"):
        quantity(f"3 {unit}", "angular_velocity")


def test_a_rate_without_angle_may_be_in_hertz_but_not_in_radians():
    assert quantity("3 Hz", "rate") == 3.0
    with pytest.raises(SceneError, match="not a rate"):
        quantity("3 rad/s", "rate")


@pytest.mark.slow
@given(st.text(max_size=90), st.sampled_from(sorted(DIMENSIONS)))
def test_any_text_is_a_finite_number_or_refused(text, dimension):
    try:
        value = quantity(text, dimension)
    except SceneError as error:
        value, message = 0.0, str(error)
    else:
        message = "."
    assert math.isfinite(value)
    assert message.endswith(".")


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_examples_are_of_their_dimension(name):
    assert math.isfinite(quantity(EXAMPLES[name], name))


@pytest.mark.parametrize("name", sorted(DIMENSIONS))
def test_si_units_are_read_back_by_astropy(name):
    # the same text goes into the units attributes of the dataset
    unit = u.Unit(units.si_unit(name))
    expected = u.kg ** DIMENSIONS[name].mass * u.m ** DIMENSIONS[name].length * u.s ** DIMENSIONS[name].time
    assert unit == expected


def test_pressure_constant_makes_a_pressure():
    gamma = 5.0 / 3.0
    constant, density = units.pressure_constant_dimension(gamma), DIMENSIONS["density"]
    made = tuple(k + gamma * d for k, d in zip(constant, density, strict=True))
    assert made == pytest.approx(DIMENSIONS["pressure"], abs=1e-14)
    assert quantity("1e14 cm4 g^(-2/3) s-2", constant) == pytest.approx(1e14 * 1e-8 * 100.0, rel=1e-13)
    for exponent in (gamma, 4.0 / 3.0, 1.5, 1.333, 2.7182818):
        constant = units.pressure_constant_dimension(exponent)
        unit = units.si_unit(constant)  # as messages and attributes of datasets have it
        assert quantity(f"2 {unit}", constant) == pytest.approx(2.0), unit


def test_code_units_make_the_gravitational_constant_one():
    code = CodeUnits(constants.M_sun.si.value, 1.0e6)
    g_dimension = Dimension(-1, 3, -2)
    assert code.to_code(constants.G.si.value, g_dimension) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("name", sorted(DIMENSIONS))
def test_code_units_agree_with_their_dimensions(name):
    # an independent route: each derived unit from the printed relation, not from exponents
    code = CodeUnits(2.0e30, 7.0e8)
    assert code.to_si(code.to_code(3.0, name), name) == pytest.approx(3.0, rel=1e-14)
    velocity = math.sqrt(units.GRAVITATIONAL_CONSTANT * code.mass / code.length)
    relations = {
        "velocity": velocity,
        "energy": code.mass * velocity**2,
        "density": code.mass / code.length**3,
        "pressure": code.mass * velocity**2 / code.length**3,
        "angular_momentum": code.mass * velocity * code.length,
        "force": code.mass * velocity**2 / code.length,
    }
    if name in relations:
        assert code.unit(name) == pytest.approx(relations[name], rel=1e-13)


@pytest.mark.parametrize(("mass", "length"), [(0.0, 1.0), (-1.0, 1.0), (1.0, math.nan), (math.inf, 1.0)])
def test_code_units_must_be_positive_and_finite(mass, length):
    with pytest.raises(SceneError, match="must be positive"):
        CodeUnits(mass, length)


def test_dimensionless_units_change_nothing():
    assert all(units.DIMENSIONLESS.unit(name) == 1.0 for name in DIMENSIONS)


def test_a_magnetic_field_is_a_root_of_a_pressure():
    field = quantity("2e12 G", "magnetic_field")
    assert field**2 / 2 == pytest.approx((2e12) ** 2 / (8 * math.pi) * 0.1, rel=1e-9)  # erg cm-3 in J m-3
    assert quantity("2e8 T", "magnetic_field") == pytest.approx(field, rel=1e-15)
    with pytest.raises(SceneError, match="not a magnetic field"):
        quantity("2 A", "magnetic_field")


def test_units_of_steep_pressures_are_found_where_their_factors_are_beyond_all_numbers():
    """K of P = K rho^10 has kg^-9 m^29 s^-2, and (7.9e12 m)^29 is 1e374."""
    code = CodeUnits(1.85e21, 7.851e12)
    steep = units.pressure_constant_dimension(10.0)
    powers = {code.mass: -9, code.length: 29, code.time: -2}
    expected = math.prod(Fraction(base) ** exponent for base, exponent in powers.items())
    assert code.unit(steep) == pytest.approx(float(expected), rel=1e-12)
    assert CodeUnits(1.85e21, 7.851e20).unit(steep) == math.inf
    assert CodeUnits(1.85e45, 7.851e-10).unit(steep) == 0.0


def test_constants_are_those_of_codata_and_the_iau_to_the_last_bit():
    names = {
        "GRAVITATIONAL_CONSTANT": "G", "SPEED_OF_LIGHT": "c", "SOLAR_MASS": "M_sun", "SOLAR_RADIUS": "R_sun",
        "VACUUM_PERMEABILITY": "mu0", "PARSEC": "pc", "ELECTRON_MASS": "m_e", "ATOMIC_MASS": "u",
        "REDUCED_PLANCK_CONSTANT": "hbar", "BOLTZMANN_CONSTANT": "k_B", "STEFAN_BOLTZMANN_CONSTANT": "sigma_sb",
    }  # fmt: skip
    written = {name for name in vars(units) if name.endswith(("_CONSTANT", "_MASS", "PARSEC", "_RADIUS", "_LIGHT"))}
    assert written | {"VACUUM_PERMEABILITY"} == set(names)
    assert {name: getattr(units, name) for name in names} == {
        name: float(getattr(constants, symbol).si.value) for name, symbol in names.items()
    }


@pytest.mark.slow
def test_imperial_units_are_known_and_no_other_unit_changes_by_them():
    """By the definition of the pound and the yard of 1959."""
    for text, size in (("lb", 0.45359237), ("ft", 0.3048), ("mi", 1609.344), ("yd", 0.9144)):
        assert units.any_quantity(f"2 {text}")[0] == pytest.approx(2.0 * size, rel=1e-15)
    known = {name: unit for part in (u.si, u.cgs, u.astrophys) for name, unit in vars(part).items()}
    plain = {name: u.Unit(name) for name, unit in known.items() if isinstance(unit, u.UnitBase) and name in dir(u)}
    assert len(plain) > 1000
    with u.imperial.enable():
        assert {name: u.Unit(name) for name in plain} == plain
