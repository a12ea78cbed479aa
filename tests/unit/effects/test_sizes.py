"""Sizes of effects against independent numbers, what `effects = "auto"` makes of them, and how it is refused."""

import math
import tomllib
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.effects.characteristic import Characteristic, Neighbour, tidal_parameter
from astroinertia.effects.heat_exchange import heat_change
from astroinertia.effects.kinds.gravity_gradient import gradient_turn
from astroinertia.effects.kinds.radiation_reaction import inspiral_time
from astroinertia.effects.kinds.tidal_torque import tidal_spin_down
from astroinertia.effects.kinds.tide import nearest_approach
from astroinertia.effects.measure import tidal_change
from astroinertia.effects.one_zone import Zone, braked, difference, lasting, motion, spread
from astroinertia.effects.sizes import effect_size
from astroinertia.errors import SceneError
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.load import load_file, loads
from astroinertia.scene.plan import plan
from astroinertia.scene.plan_effects import number_lines

ROOT = Path(__file__).parents[3]
SCENES = ROOT / "tests" / "data" / "effects_auto"
EXPECTED = tomllib.loads((SCENES / "expected.toml").read_text())
YEAR, ARCSECOND = 3.15576e7, math.pi / 648000.0
G, C = 6.6743e-11, 299792458.0
SIZES = {kind: entry.size for kind, entry in CATALOGUE.items()}
SUN, EARTH = 1.98841e30, 5.97217e24


def earth(end: float) -> Characteristic:
    return replace(characteristic(load_file(SCENES / "earth_in_a_century.toml")), end=end)


def test_every_effect_has_a_size():
    assert all(SIZES.values())


def test_sun_and_moon_precess_the_earth_by_fifty_arc_seconds_a_year():
    body = earth(YEAR)
    # the axis moves by sin(obliquity) of what it goes round by: 50.4 arc seconds, 15.9 of the Sun and 34.5 of the Moon
    # on orbits in the ecliptic; what the Moon's is inclined by takes 1 % off in the mean over its node
    flat = [replace(other, normal=(0.0, 0.0, 1.0)) for other in body.neighbours]
    turns = {other.name: gradient_turn(body, other) / math.sin(math.radians(23.4393)) for other in flat}
    assert turns["Sun"] / ARCSECOND == pytest.approx(15.9, rel=0.02)
    assert turns["Moon"] / ARCSECOND == pytest.approx(34.5, rel=0.02)
    assert sum(turns.values()) / ARCSECOND == pytest.approx(50.3, rel=0.1)


def test_a_light_mass_inside_a_body_is_no_tide_however_small_its_softening():
    """In the middle of a uniform sphere its share of the virial is M' <1/R> over 3/5 M/R, which is 5/2 M'/M."""
    body, mass = earth(YEAR), 1e-6 * EARTH
    options = dict.fromkeys(CATALOGUE["external_field"].options)

    def number(away: float, softening: float) -> float:
        given = {"point_mass": mass, "softening": softening * body.radius, "origin": (away * body.radius, 0.0, 0.0)}
        found = effect_size(SIZES["external_field"], body, {**options, **given}).number
        assert found is not None
        return found * body.mass / mass

    assert number(0.0, 1e-4) == pytest.approx(2.5, rel=1e-6)
    assert number(0.0, 20.0) == pytest.approx(20.0**-3, rel=1e-2)
    assert number(10.0, 1e-4) == pytest.approx(1e-3, rel=1e-12)


def test_the_earth_turns_366_times_a_year():
    assert earth(YEAR).turns == pytest.approx(366.24, rel=1e-4)


def test_the_moon_brakes_the_earth_by_two_milliseconds_a_day_in_a_century():
    body = earth(100.0 * YEAR)
    options = {"love_number": 0.3, "radius": 6378136.6, "quality": 12.0, "time_lag": None, "relaxation_time": None}
    moon = next(each for each in body.neighbours if each.name == "Moon")
    share = tidal_spin_down(body, moon, options)
    assert 86400e3 * share == pytest.approx(2.3, rel=0.6)  # ms
    # the same Q at twice the rate below the Moon, of a solid that flows: -Im k2 = 0.3/12
    rate = 2 * (body.spin - moon.rate)
    late = 0.3 / 1.5 * 1.2 * 12 / 0.3 / rate  # (k_f - k_e) chi tau = k_f/k_e of the Debye peak's far side
    options |= {"quality": None, "relaxation_time": late, "fluid_love_number": 1.5, "exponent": None}
    assert tidal_spin_down(body, moon, options) == pytest.approx(share, rel=3e-3)


def test_the_tide_of_the_moon_on_the_earth():
    body = Characteristic(end=1.0, gravitational_constant=G, mass=EARTH, radius=6.371e6)
    assert tidal_parameter(body, 7.3458e22, 3.84399e8) == pytest.approx(5.6e-8, rel=0.01)


def test_the_crab_slows_down_as_its_age_says():
    body = characteristic(load_file(SCENES / "crab_in_a_century.toml"))
    options = load_file(SCENES / "crab_in_a_century.toml").effects["dipole_braking"]
    later = 33.3924123e-3 * (1.0 + 1.51 * 4.20972e-13 / 33.3924123e-3 * 100.0 * YEAR) ** (1.0 / 1.51)
    assert effect_size(SIZES["dipole_braking"], body, options).change == pytest.approx(
        1.0 - 33.3924123e-3 / later, rel=1e-3
    )


EXPONENTS = {  # of mass, length and time
    "end": (0, 0, 1), "gravitational_constant": (-1, 3, -2), "speed_of_light": (0, 1, -1), "mass": (1, 0, 0),
    "radius": (0, 1, 0), "moments": (1, 2, 0), "second_moment": (1, 2, 0), "central_density": (1, -3, 0),
    **dict.fromkeys(("shear", "expansion", "spin", "rate"), (0, 0, -1)),
    **dict.fromkeys(("gravitational", "rotational", "thermal_energy"), (1, 2, -2)),
    **dict.fromkeys(("triple_pressure", "further_pressure"), (1, 2, -2)),
    **dict.fromkeys(("distance", "nearest"), (0, 1, 0)), "masses": (1, 0, 0),
}  # fmt: skip


def in_units(what, units):
    """The same in other units of mass, length and time."""
    if isinstance(what, tuple):
        return tuple(in_units(each, units) for each in what)
    found = {}
    for field in fields(what):
        value, powers = getattr(what, field.name), EXPONENTS.get(field.name)
        if powers is not None and value is not None:
            factor = math.prod(unit**power for unit, power in zip(units, powers, strict=True))
            value = tuple(each / factor for each in value) if isinstance(value, tuple) else value / factor
        elif field.name in ("neighbours", "pair") and value is not None:
            value = in_units(value, units)
        found[field.name] = value
    return replace(what, **found)


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["earth_in_a_century", "star_that_cools_slowly", "hot_cloud_let_go"])
def test_sizes_of_effects_do_not_depend_on_units(scene):
    body = characteristic(load_file(SCENES / f"{scene}.toml"))
    assert body.mass is not None and body.radius is not None
    bodies = body, in_units(body, (1e3 * body.mass, 1e4 * body.radius, 1e5 * body.end))
    sizes = [[effect_size(SIZES[kind], each) for kind in ("gravity", "pressure", "viscosity")] for each in bodies]
    numbers = np.array([[(each.number, each.change) for each in found] for found in sizes], dtype=float)
    np.testing.assert_allclose(numbers[1], numbers[0], rtol=1e-6, atol=1e-12)
    names = ("run_length", "turns", "compactness", "thermal_to_gravitational", "rotational_to_gravitational",
             "rotation_over_break_up", "mach_number", "falling", "support")  # fmt: skip
    own = np.array([[getattr(each, name) for name in names] for each in bodies], dtype=float)
    np.testing.assert_allclose(own[1], own[0], rtol=1e-12)
    tides = [tidal_parameter(each, 2.0 * each.mass, 5.0 * each.radius) for each in bodies]
    assert tides == pytest.approx([0.016, 0.016], rel=1e-14)


CLOUD = Characteristic(
    end=1.0, gravitational_constant=1.0, speed_of_light=10.0, mass=2.0, radius=1.5, second_moment=2.0,
    gravitational=4.0, triple_pressure=2.0, thermal_energy=3.0, rotational=0.4, spin=0.3, fallen=0.5,
)  # fmt: skip
SURFACE = ("dynamical_time", "run_length", "free_fall_time", "compactness", "rotation_over_break_up", "mach_number")


@pytest.mark.parametrize(
    ("unknown", "those"),
    [
        ("mass", SURFACE),
        ("radius", SURFACE),
        ("speed_of_light", ("compactness",)),
        ("spin", ("turns", "rotation_over_break_up")),
        ("second_moment", ("zone", "support")),
        ("gravitational", ("zone", "support", "thermal_to_gravitational", "rotational_to_gravitational")),
        ("triple_pressure", ("zone", "support", "mach_number")),
        ("rotational", ("zone", "support", "rotational_to_gravitational")),
        ("thermal_energy", ("thermal_to_gravitational",)),
    ],
)
def test_what_is_made_of_an_unknown_number_is_unknown_and_all_else_known(unknown, those):
    body = replace(CLOUD, **{unknown: None})
    every = {*SURFACE, "turns", "zone", "support", "thermal_to_gravitational", "rotational_to_gravitational"}
    assert {name for name in every if getattr(body, name) is None} == set(those)


def test_what_is_held_up_in_part_falls_by_the_rest():
    """(3 Pi + 2 T)/|W| is (2 + 0.8)/4; without pressure 0.8/4, with weight of another half less."""
    assert CLOUD.support == pytest.approx(0.7) and CLOUD.falling == pytest.approx(0.3 * 0.5)
    assert replace(CLOUD, presses=False).support == pytest.approx(0.2)
    assert replace(CLOUD, further_pressure=0.6).support == pytest.approx(0.85)
    assert replace(CLOUD, added_weight=0.5).support == pytest.approx(0.7 / 1.5)
    assert replace(CLOUD, weighs=False).support is None and replace(CLOUD, weighs=False).falling == 0.0
    assert replace(CLOUD, triple_pressure=3.2).falling == replace(CLOUD, triple_pressure=9.0).falling == 0.0


@pytest.mark.parametrize(
    ("pressure", "gamma", "steep"),
    [
        (4.0, 5 / 3, 2.0),  # in balance: ln R = ln A/(3 gamma - 4)
        (3.0, 1.6, 2.5),  # falls
        (4.0, 1.45, 4.0),  # near 4/3, no steeper than that
        (7.0, 1.6, 2.5),  # pushed out, by less than twice its weight
        (9.0, 1.6, 2.0),  # flies apart
    ],
)
def test_a_share_of_the_heat_changes_the_size_as_the_gas_holds_the_body(pressure, gamma, steep):
    body = replace(CLOUD, end=100.0, triple_pressure=pressure, gamma=gamma, rotational=0.0)
    assert heat_change(body, 1e-4) == pytest.approx(steep * 1e-4, rel=1e-12)
    assert heat_change(body, 1e4) == 1.0


@pytest.mark.parametrize(
    ("end", "parameter", "change"),
    [
        (3.0, 0.01, 0.05),  # bound: the bulge of a tide that comes suddenly
        (0.5, 0.01, 0.0025),  # before that
        (0.5, 0.1, 0.025),
        (1.5, 0.1, 1.0),  # torn
        (1.5, 0.04, 0.09),
    ],
)
def test_a_tide_raises_a_bulge_or_tears_the_body_when_there_is_time_for_it(end, parameter, change):
    body = replace(CLOUD, triple_pressure=3.2, spin=None)
    assert body.dynamical_time is not None
    assert tidal_change(replace(body, end=end * body.dynamical_time), parameter) == pytest.approx(change, rel=1e-12)


def test_compactness_of_a_white_dwarf_and_of_a_neutron_star():
    dwarf = Characteristic(end=1.0, gravitational_constant=G, speed_of_light=C, mass=0.6 * SUN, radius=8.9e6)
    assert dwarf.compactness == pytest.approx(1.0e-4, rel=0.02)  # a gravitational redshift of 30 km/s
    assert replace(dwarf, mass=1.4 * SUN, radius=12e3).compactness == pytest.approx(0.172, rel=0.01)


def test_two_neutron_stars_on_a_circle_meet_when_peters_says():
    # PSR B1913+16 if its orbit were round: 1.67 billion years (Peters 1964; 0.3 with its eccentricity of 0.617)
    assert inspiral_time(G, C, (1.44 * SUN, 1.387 * SUN), 1.950e9) / (1e9 * YEAR) == pytest.approx(1.66, rel=0.03)


def test_one_zone_falls_in_the_free_fall_time_and_expands_as_dysons_gas():
    # x'' = -1/x^2 from rest is at the centre at pi/(2 sqrt 2); gas of 5/3 alone has s^2 = 1 + p t^2
    fall = motion(Zone(1.0, 0.0, 0.0, 5 / 3), 2.0)
    assert fall.time[-1] == pytest.approx(math.pi / math.sqrt(8.0), abs=2.0 / 400)
    assert motion(Zone(0.0, 3.0, 0.0, 5 / 3), 2.0).size[-1] ** 2 == pytest.approx(13.0, rel=1e-6)


@pytest.mark.parametrize("field", [0.2, 0.0, -0.05])
def test_one_zone_keeps_its_energy_and_swings_at_the_slope_of_its_force(field):
    """s'^2/2 + 2 T/(2 s^2) - |W|/s + 3 Pi s^(3 - 3 gamma)/(3 gamma - 3) + k s^2/2, all over tr Q."""
    zone = Zone(1.3, 0.7, 0.4, 1.4, expansion=0.6, field=field)
    path = motion(zone, 3.0)
    s = path.size
    held = 0.5 * zone.turning / s**2 - zone.weight / s + zone.pressure * s**-1.2 / 1.2 + 0.5 * field * s**2
    np.testing.assert_allclose(0.5 * path.speed**2 + held, (0.5 * path.speed**2 + held)[0], atol=1e-8)
    assert s[0] == 1.0 and path.speed[0] == pytest.approx(0.6) and np.ptp(s) > 0.2
    slope = (zone.force(s + 1e-5) - zone.force(s - 1e-5)) / 2e-5
    np.testing.assert_allclose(zone.stiffness(s), -slope, rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize(
    ("zone", "escapes"),
    [
        (Zone(1.0, 0.0, 0.99, 5 / 3, expansion=1.0), False),
        (Zone(1.0, 0.0, 1.01, 5 / 3, expansion=1.0), True),
        (Zone(1.0, 0.99, 0.0, 4 / 3), False),
        (Zone(1.0, 1.01, 0.0, 4 / 3), True),
        (Zone(1.0, 0.1, 0.0, 1.0), True),
        (Zone(1.0, 0.1, 0.0, 5 / 3, field=-1e-6), True),
        (Zone(1.0, 9.0, 0.0, 5 / 3, field=1e-6), False),
        (Zone(1.0, 0.1, 0.0, 1.0, field=1e-6), False),
    ],
)
def test_one_zone_escapes_where_its_energy_or_what_has_no_end_lets_it(zone, escapes):
    """T + U against |W|, with 3 Pi over 3 (gamma - 1) the heat; gas of one temperature has no end of it."""
    assert zone.escapes == escapes


def test_little_pressure_means_nothing_before_the_end_of_a_fall_and_all_after_it():
    cold = Zone(1.0, 1e-4, 0.0, 5 / 3)
    early, late = (difference(cold, end, pressure=0.0) for end in (0.6, 1.3))
    assert early < 3e-4 and late == 1.0
    assert braked(cold, 0.6) == 0.0 and braked(cold, 1.3) > 1.0


def test_small_pressures_count_in_proportion():
    changes = [difference(Zone(1.0, p, 0.0, 5 / 3), 0.5, pressure=0.0) for p in (1e-6, 1e-5)]
    assert changes[1] / changes[0] == pytest.approx(10.0, rel=0.01)


def test_what_is_in_balance_needs_both_forces():
    star = Zone(1.0, 1.0, 0.0, 5 / 3)
    assert difference(star, 1e9, pressure=0.0) == difference(star, 1e9, weight=0.0) == 1.0


def test_times_all_over_a_run_keep_no_time_with_what_turns():
    """Of 1 to 3000 turns in it the mean is hardly any, 0.05 by chance; by multiples of the golden ratio up to 0.98."""
    times = spread(1.0)
    turns = np.exp(2j * np.pi * np.arange(1, 3001)[:, None] * times).mean(axis=1)
    assert np.abs(turns).max() < 0.2 and times.min() == 0.0 and times.max() < 1.0
    long = lasting(Zone(1.0, 0.7, 0.0, 5 / 3), 1e5).time
    np.testing.assert_allclose(long[:-1], 1e5 * times[:-1])
    assert long[-1] == 1e5


def test_forces_beyond_all_numbers_have_no_size_and_are_not_followed():
    body = replace(characteristic(load_file(SCENES / "hot_cloud_let_go.toml")), triple_pressure=math.inf)
    found = effect_size(SIZES["gravity"], body)
    assert body.zone is None and found.change is None


def test_pressures_beyond_all_numbers_are_infinite():
    """Of an entropy that is stated, and an exponent of a density of 1e40: without a warning, as of any power."""
    star = """
name = "star"
units = "code"
body = {kind = "uniform", particles = 100, mass = 1, radius = 1e-13}
effects = {gravity = {}, pressure = {}}
time = {end = 1}
equation_of_state = {kind = "polytropic", gamma = 10, constant = 1}
"""
    assert characteristic(loads(star)).triple_pressure == np.inf
    soft = characteristic(loads(star.replace("1e-13", "1")))
    assert soft.triple_pressure == pytest.approx(3.0 * (3.0 / (4.0 * np.pi)) ** 9)


def test_viscosity_decays_a_flow_in_the_viscous_time():
    # the quadrupole mode of a liquid sphere decays at 5 nu/R^2 (Lamb)
    body = characteristic(load_file(SCENES / "thick_liquid_for_long.toml"))
    assert body.shear > 0.1
    found = effect_size(SIZES["shear_viscosity"], body, {"kinematic_viscosity": 1e-4})
    assert found.change == pytest.approx(5e-4 * body.end, rel=1e-3)


def test_rigid_rotation_has_no_friction():
    text = (SCENES / "star_that_cools_slowly.toml").read_text()
    body = characteristic(loads(text))
    assert effect_size(SIZES["shear_viscosity"], body, {"kinematic_viscosity": 1.0}).change < 1e-6


def test_a_compact_body_that_is_round_about_its_axis_sends_no_waves_and_one_that_is_not_does():
    body = characteristic(load_file(SCENES / "liquid_at_a_large_reynolds_number.toml"))
    loud = effect_size(SIZES["radiation_reaction"], body, {"speed_of_light": 2.0}).change
    assert body.moments is not None
    least, _, largest = body.moments
    steady = replace(body, moments=(least, least, largest), triple_pressure=body.gravitational - 2 * body.rotational)
    assert loud > 1e-2 and effect_size(SIZES["radiation_reaction"], steady, {"speed_of_light": 2.0}).change < 1e-20


def test_a_perturber_is_nearest_at_its_pericentre_only_if_the_run_gets_there():
    orbit = {"position": (1.0, 0.0, 0.0), "eccentricity": 0.5, "period": 10.0, "mean_anomaly": -1.0}
    assert nearest_approach(5.0, orbit) == 1.0
    # eccentric anomaly -0.9 at the end: r = a (1 - e cos E) with a = 2
    end = (1.0 - 0.9 + 0.5 * math.sin(0.9)) * 10.0 / (2.0 * math.pi)
    assert nearest_approach(end, orbit) == pytest.approx(2.0 - math.cos(0.9), rel=1e-12)


STAR = """
name = "star"
body = {kind = "polytrope", index = 3, mass = "1.5 Msun", radius = "1800 km", particles = 200}
effects = {gravity = {}, pressure = {}, viscosity = {}}
time.end = "0.2 s"
"""


def supported(gamma: float) -> float:
    """3 Pi/|W| of an n = 3 polytrope whose centre alone has the K of P = K rho^gamma, by Lane and Emden's equation."""
    xi = np.linspace(1e-6, 6.89, 4000)
    path = solve_ivp(
        lambda x, y: [y[1], -(max(y[0], 0.0) ** 3) - 2.0 * y[1] / x], xi[[0, -1]], [1.0, 0.0], t_eval=xi, rtol=1e-9
    )
    theta = np.maximum(path.y[0], 0.0)
    return np.trapezoid(theta ** (3.0 * gamma) * xi**2, xi) / np.trapezoid(theta**4 * xi**2, xi)


@pytest.mark.parametrize(
    ("matter", "fraction", "gamma", "says"),
    [
        ('kind = "hybrid", gamma_1 = 1.28, nuclear_density = "2e14 g/cm3"', 1.0, 1.28, "swells at first"),
        ('kind = "polytropic", gamma = 1.25', 1.0, 1.25, "swells at first"),
        ('kind = "polytropic", gamma = 1.25', 0.7, 1.25, "falls at first"),
        ('kind = "polytropic", gamma = "4/3"', 1.0, 4.0 / 3.0, "in balance"),
        ('kind = "ideal", gamma = 1.2', 1.0, None, "not stable"),
    ],
)
def test_the_plan_says_whether_a_star_falls_or_swells(matter, fraction, gamma, says):
    scene = loads(STAR + f"equation_of_state = {{{matter}}}\n", [f"body.pressure_fraction={fraction}"])
    value, meaning = next(row[1:] for row in number_lines(scene) if row[0] == "(3 Pi + 2 T)/|W|")
    assert says in meaning
    assert float(value) == pytest.approx(fraction * (1.0 if gamma is None else supported(gamma)), rel=0.01)


@pytest.mark.parametrize(("fit", "first", "dense"), [("G15", 3e7, 0.278), ("N13", 2e7, 0.285)])
def test_a_core_whose_electrons_are_captured_falls(fit, first, dense):
    """By Lane and Emden's equation and the fit of Liebendoerfer 2005, with P = 4.897e14 (2 Y_e/0.9942 rho)^(4/3)."""
    core = (Path(__file__).parents[3] / "sims" / "deleptonising_core.toml").read_text()
    xi = np.linspace(1e-6, 6.89, 4000)
    path = solve_ivp(
        lambda x, y: [y[1], -(max(y[0], 0.0) ** 3) - 2.0 * y[1] / x], xi[[0, -1]], [1.0, 0.0], t_eval=xi, rtol=1e-9
    )
    theta = np.maximum(path.y[0], 1e-9)
    x = np.clip((2 * np.log10(1e10 * theta**3) - np.log10(2e13 * first)) / np.log10(2e13 / first), -1, 1)
    size = abs(x)
    left = 0.5 * (dense + 0.5) + x / 2 * (dense - 0.5) + 0.035 * (1 - size + 4 * size * (size - 0.5) * (size - 1))
    share = (np.minimum(left, 0.4971) / 0.4971) ** (4 / 3)
    expected = np.trapezoid(share * theta**4 * xi**2, xi) / np.trapezoid(theta**4 * xi**2, xi)
    scene = loads(core, [f"effects.deleptonisation.fit='{fit}'"])
    value, meaning = next(row[1:] for row in number_lines(scene) if row[0] == "(3 Pi + 2 T)/|W|")
    compact = characteristic(scene).compactness
    assert compact is not None and 1e-3 < compact < 2e-3  # for which relativity makes it heavier
    assert float(value) == pytest.approx(expected / (1 + 4 * compact), abs=1e-3) and 0.8 < expected < 0.95
    assert f"falls at first: {100 * (1 - expected):.2g} % of the pressure" in meaning
    without = core.replace("[effects.deleptonisation]", "").replace("[effects.relativistic_potential]", "")
    assert "in balance" in next(row[2] for row in number_lines(loads(without)) if row[0] == "(3 Pi + 2 T)/|W|")


def test_a_spinning_earth_has_its_numbers():
    body = earth(YEAR)
    assert body.rotation_over_break_up == pytest.approx(0.0588, rel=0.01)
    assert body.wobble == 0.0 and body.dynamical_time == pytest.approx(806.8, rel=1e-3)


def test_what_a_scene_does_not_tell_is_kept_on_with_that_reason(tmp_path):
    text = 'name = "a"\neffects = "auto"\nunits = "code"\n[body]\nkind = "table"\nfile = "a.csv"\n'
    text += '[equation_of_state]\nkind = "ideal"\n[time]\nend = 1.0\n'
    scene = loads(text, origin=str(tmp_path))
    assert set(scene.effects) == {"gravity", "pressure", "viscosity"}
    assert all("not known" in reason for reason in scene.reasons.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", EXPECTED)
def test_the_list_is_chosen_exactly_and_with_its_orders_of_magnitude(name):
    scene = load_file(SCENES / f"{name}.toml")
    wanted = EXPECTED[name]
    assert set(scene.effects) == set(wanted["on"])
    assert set(scene.reasons) == set(wanted["on"]) | set(wanted["off"])
    body = characteristic(scene)
    for kind, entry in {**wanted["on"], **wanted["off"]}.items():
        given = {**scene.candidates, **scene.effects}.get(kind, {})
        change = effect_size(SIZES[kind], body, given).change
        if entry["change"] > 1e-9 and kind not in ("gravity", "pressure"):
            assert 0.1 < change / entry["change"] < 10.0 or kind == "shear_viscosity", kind


def test_enough_of_the_list_looks_small_and_must_be_on():
    small = {name: each["small_looking"] for name, each in EXPECTED.items() if "small_looking" in each}
    assert len(small) >= 4
    for name, kinds in small.items():
        assert set(kinds) <= set(EXPECTED[name]["on"])
        asked = load_file(SCENES / f"{name}.toml").accuracy
        assert all(EXPECTED[name]["on"][kind]["looks"] < asked for kind in kinds)


def test_a_finer_accuracy_calls_for_more():
    file = SCENES / "hot_cloud_let_go.toml"
    assert "gravity" not in load_file(file).effects
    assert {"gravity", "pressure"} <= set(load_file(file, ["accuracy=1e-6"]).effects)


def test_companions_of_particles_go_with_their_effect():
    before, _, after = (ROOT / "sims" / "star_and_companion.toml").read_text().partition("[effects.gravity]")
    text = f'effects = "auto"\n{before}[time]{after.partition("[time]")[2]}'
    near = loads(text)
    far = loads(text, ["companions.0.semi_major_axis=4000.0", "companions.0.mass=1e-3"])
    assert "companions" in near.effects and near.companions
    assert "companions" not in far.effects and not far.companions and "companions" in far.reasons


def test_the_plan_tells_reasons_and_keeps_them_for_the_dataset():
    scene = load_file(SCENES / "crab_in_a_century.toml")
    planned = plan(scene)
    sizes = {line.kind: line.size for line in planned.effects}
    assert sizes["dipole_braking"].startswith("on: ") and sizes["constant_torque"].startswith("off: ")
    assert scene.reasons["dipole_braking"] in planned.text() and scene.reasons["constant_torque"] in planned.text()
    assert "relativity" in {line.name for line in planned.sections["characteristic numbers"]}  # G M/(R c^2) = 0.17


def test_the_plan_points_out_what_is_negligible_and_warns_of_what_is_missing():
    file = ROOT / "sims" / "cold_spheroid.toml"
    thin = ["body.specific_internal_energy=1e-9", "effects.pressure={}"]
    sizes = {line.kind: line.size for line in plan(load_file(file, thin)).effects}
    assert sizes["pressure"].startswith("NEGLIGIBLE") and "WARNING" not in sizes["gravity"]
    sizes = {line.kind: line.size for line in plan(load_file(file, ["body.specific_internal_energy=0.3"])).effects}
    assert sizes["pressure"].startswith("WARNING, large and not listed")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ('effects = "atuo"', "effects: 'atuo' is not known; did you mean 'auto'"),
        (
            'effects = "auto"\n[candidates.colling]',
            "[candidates] colling is not a known effect; did you mean 'cooling'",
        ),
        ('effects = "auto"\n[candidates.pivot]\ngravity = 1', "[candidates.pivot] gravity: must be a list"),
        ("[effects.gravity]\n[candidates.cooling]", '[candidates] are for effects = "auto"'),
        ('effects = "auto"\naccuracy = 2.0', "accuracy: must be at most 0.3"),
        ('effects = "auto"\n[candidates.gravity_gradient]', "belongs to the model rigid"),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(text, sentence):
    rest = '[body]\nkind = "uniform"\nparticles = 64\nmass = 1.0\nradius = 1.0\n[equation_of_state]\nkind = "ideal"\n'
    with pytest.raises(SceneError) as refused:
        loads(f'name = "a"\nunits = "code"\n{text}\n{rest}[time]\nend = 1.0\n')
    assert sentence in str(refused.value) and "\n" not in str(refused.value)


def test_explicit_effects_stay_as_they_are():
    scene = load_file(ROOT / "sims" / "evrard.toml")
    assert list(scene.effects) == ["gravity", "pressure", "viscosity"] and not scene.reasons


def test_neighbours_on_given_orbits_are_where_they_are():
    body = characteristic(load_file(ROOT / "sims" / "earth_precession.toml"))
    moon = next(each for each in body.neighbours if each.name == "Moon")
    assert isinstance(moon, Neighbour) and moon.distance == pytest.approx(3.844e8, rel=0.02)
    tilt = math.degrees(math.acos(moon.normal[2]))
    assert tilt == pytest.approx(5.145, abs=0.3) and moon.rate == pytest.approx(2.66e-6, rel=0.02)
