"""The solar system's table: whole, cited, and in agreement with astropy, with itself and with published conversions."""

import csv
import json
import math
from pathlib import Path

import jax
import numpy as np
import pytest

from astroinertia.bodies import moment_ratios
from astroinertia.bodies.planets import body, own_body, solar_system
from astroinertia.storage.data_tables import data_path
from astroinertia.units import quantity

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "planets.json").read_text())
NAMES = (
    "Sun", "Mercury", "Venus", "Earth", "Moon", "Mars", "Jupiter", "Saturn", "Uranus", "Neptune", "Io", "Europa",
    "Ganymede", "Callisto", "Enceladus", "Rhea", "Titan", "Ceres", "Vesta",
)  # fmt: skip


def _rows() -> list[dict[str, str]]:
    with data_path("planets.csv").open(encoding="utf-8") as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith("#")))


def _meaning(row: dict[str, str]) -> tuple[str, str]:
    return row["body"], "moment_ratio" if row["quantity"].endswith("moment_ratio") else row["quantity"]


def test_every_number_has_a_source_a_status_and_one_adopted_row():
    rows = _rows()
    assert {row["body"] for row in rows} == set(NAMES)
    adopted = [_meaning(row) for row in rows if row["use"] == "adopted"]
    assert len(adopted) == len(set(adopted))
    assert {_meaning(row) for row in rows} == set(adopted)
    for row in rows:
        assert len(row["source"]) > 10
        assert row["status"] in ("measured", "hydrostatic", "model", "convention", "assumed")
        assert float(row["value"]) != 0
        assert (row["uncertainty"] == "") == (row["sigmas"] == "")
        normalised = row["quantity"].endswith("_ratio") or row["quantity"] in ("j2", "c22")
        assert normalised == (row["radius_km"] != "")


@pytest.mark.parametrize("name", NAMES)
def test_each_body_has_what_a_moment_ratio_needs(name):
    one = body(name)
    for wanted in ("gm", "mean_radius", "equatorial_radius", "rotation_rate", "j2"):
        assert one.has(wanted), wanted
    ratio = one.moment_ratio()
    assert 0 < ratio.value < 0.4
    assert ratio.kind == "mean"
    assert ratio.radius == one.mean_radius
    assert ratio.value == one.moment_ratio_rows()[0].value


@pytest.mark.parametrize(("name", "unit"), [("Sun", "Msun"), ("Earth", "Mearth"), ("Jupiter", "Mjup")])
def test_masses_are_those_of_astropy(name, unit):
    assert body(name).mass == pytest.approx(quantity(f"1 {unit}", "mass"), rel=2e-7)


@pytest.mark.parametrize(("name", "unit"), [("Sun", "Rsun"), ("Earth", "Rearth"), ("Jupiter", "Rjup")])
def test_equatorial_radii_are_those_of_astropy(name, unit):
    """Nominal ones: that of Earth, 6378.1 km, is rounded."""
    assert body(name).equatorial_radius == pytest.approx(quantity(f"1 {unit}", "length"), rel=6e-6)


@pytest.mark.parametrize("name", ["Mercury", "Earth", "Mars", "Jupiter", "Saturn", "Uranus", "Neptune", "Io", "Ceres"])
def test_mean_radii_are_those_of_the_same_volume(name):
    one = body(name)
    a, c = one.equatorial_radius, one.adopted("polar_radius").value
    assert one.mean_radius == pytest.approx(moment_ratios.volumetric_radius(a, a, c), rel=5e-4)


@pytest.mark.parametrize(
    ("name", "density", "flattening"),
    [("Earth", 5513, 1 / 298.257), ("Mars", 3934, 1 / 169.89), ("Jupiter", 1326, 0.06487), ("Saturn", 687, 0.09796)],
)
def test_densities_and_flattenings_are_those_of_fact_sheets(name, density, flattening):
    """NSSDC planetary fact sheets; m is what Kepler's period at the mean radius is over the day, squared."""
    one = body(name)
    assert one.mean_density == pytest.approx(density, abs=1)
    assert one.flattening == pytest.approx(flattening, rel=1e-3)
    orbit = 2 * math.pi * math.sqrt(one.mean_radius**3 / one.gravitational_parameter)
    assert one.small_m == pytest.approx((orbit * abs(one.angular_velocity) / (2 * math.pi)) ** 2, rel=1e-12)


@pytest.mark.parametrize("entry", [each for each in REFERENCE if each["name"] == "radius_normalisation_factor"],
                         ids=lambda entry: entry["inputs"]["body"])  # fmt: skip
def test_radius_normalisation_factor(entry):
    inputs = entry["inputs"]
    factor = moment_ratios.convert_moment_ratio(1.0, inputs["Re_km"], inputs["Rm_km"])
    assert factor == pytest.approx(float(entry["value"]), abs=5.1e-9)
    one = body(inputs["body"])
    assert one.equatorial_radius == pytest.approx(1e3 * inputs["Re_km"])
    assert one.mean_radius == pytest.approx(1e3 * inputs["Rm_km"])


def test_moments_of_earth_from_precession():
    (entry,) = (each for each in REFERENCE if each["name"] == "earth_moments")
    expected = {key: float(value) for key, value in entry["value"].items()}
    one = body("Earth")
    j2, ellipticity = one.adopted("j2").value, one.adopted("dynamical_ellipticity").value
    polar = moment_ratios.polar_from_precession(j2, ellipticity)
    assert polar == pytest.approx(expected["C_MRe2"], rel=2e-10)
    assert moment_ratios.principal_moment_ratios(polar, j2)[0] == pytest.approx(expected["A_MRe2"], rel=2e-10)
    assert moment_ratios.mean_from_polar(polar, j2) == pytest.approx(expected["Imean_MRe2"], rel=2e-10)
    assert one.moment_ratio("polar").value == pytest.approx(expected["C_MRmean2"], rel=2e-7)  # the table is rounded
    assert one.moment_ratio().value == pytest.approx(expected["Imean_MRmean2"], rel=2e-7)


def test_conversions_agree_with_the_papers_that_give_both():
    """A wrong sign of the J2 term, or a radius forgotten, shifts each of these by ten times its tolerance."""
    assert body("Mars").moment_ratio().value == pytest.approx(0.36428, abs=5e-6)  # Le Maistre et al. 2023, supplement
    assert body("Moon").moment_ratio().value == pytest.approx(0.393112, abs=6e-7)  # Williams et al. 2014
    assert body("Vesta").moment_ratio("mean", 265e3).value == pytest.approx(0.3734, abs=6e-5)  # Park et al. 2025
    assert body("Jupiter").moment_ratio("polar").value == pytest.approx(0.2760, abs=2e-4)  # Militzer & Hubbard 2023


def test_the_moment_of_the_earth_is_that_of_groten():
    """8.0365e37 kg m2 (Groten 2004, J. Geod. 77, 724), with another G."""
    assert body("Earth").moment_of_inertia("polar") == pytest.approx(8.0365e37, rel=5e-4)
    assert body("Earth").moment_of_inertia() == pytest.approx((8.0101e37 + 8.0103e37 + 8.0365e37) / 3, rel=5e-4)


def test_three_sigma_uncertainties_become_one_sigma():
    ratio = body("Mercury").moment_ratio("polar", 2440e3)
    assert ratio.uncertainty == pytest.approx(0.005 / 3)
    assert math.isnan(body("Sun").moment_ratio().uncertainty)


def test_mean_and_polar_moment_of_a_triaxial_body():
    """A homogeneous ellipsoid, whose moments are known in closed form."""
    a, b, c, radius = 1.3, 1.1, 0.8, 1.0
    principal = np.array([b * b + c * c, a * a + c * c, a * a + b * b]) / 5.0
    j2, c22 = (principal[2] - principal[:2].mean()) / radius**2, (principal[1] - principal[0]) / (4 * radius**2)
    np.testing.assert_allclose(moment_ratios.principal_moment_ratios(principal[2], j2, c22), principal, rtol=1e-14)
    assert moment_ratios.mean_from_polar(principal[2], j2) == pytest.approx(principal.mean(), rel=1e-14)
    assert moment_ratios.polar_from_mean(principal.mean(), j2) == pytest.approx(principal[2], rel=1e-14)
    with pytest.raises(ValueError, match="none may exceed the sum"):
        moment_ratios.principal_moment_ratios([0.33, 0.33], 0.2)
    with pytest.raises(ValueError, match="are not negative"):
        moment_ratios.principal_moment_ratios(-0.33, 1e-3)


def test_conversions_are_traced_by_jax_and_whole_numbers_do_not_overflow():
    def ratio(polar, j2, a, c):
        return moment_ratios.convert_moment_ratio(
            moment_ratios.mean_from_polar(polar, j2), a, moment_ratios.volumetric_radius(a, a, c)
        )

    whole = 6378137, 6356752
    with jax.enable_x64(True):
        earth = 0.3307, 1.0826e-3, *map(float, whole)
        assert jax.jit(ratio)(*earth) == pytest.approx(ratio(*earth), rel=1e-14)
        # It goes as a^(2/3) and c^(-2/3).
        assert jax.grad(ratio, 2)(*earth) == pytest.approx(2 / 3 * ratio(*earth) / whole[0], rel=1e-12)
    # WGS84, 6371000.790 m, with its polar radius cut by 0.314 m.
    assert moment_ratios.volumetric_radius(whole[0], *whole) == pytest.approx(6371000.685, abs=1e-3)
    with pytest.raises(ValueError, match="semi-axes must not be negative"):
        moment_ratios.volumetric_radius(-1.0, 2.0, 3.0)


def test_names_are_found_in_any_case_and_unknown_ones_are_reported():
    assert body("mars") is body("Mars")
    with pytest.raises(KeyError, match=r"'marss' in the table \(did you mean Mars\?\); it has Sun"):
        body("marss")
    with pytest.raises(KeyError, match=r"Pluto.*Vesta"):
        body("Pluto")
    with pytest.raises(KeyError, match="no core radius of Venus"):
        body("Venus").adopted("core_radius")
    with pytest.raises(ValueError, match="mean"):
        body("Mars").moment_ratio("equatorial")


def test_mars_is_less_centrally_condensed_than_earth():
    assert body("Mars").moment_ratio().value > body("Earth").moment_ratio().value


def test_the_table_cannot_be_changed():
    with pytest.raises(TypeError):
        solar_system()["Pluto"] = body("Mars")  # type: ignore[index]


def test_a_body_of_ones_own_has_quantities_of_the_table_only():
    for wrong, meant in (("core_densty", "core_density"), ("mean_moment_ratio_uncertanty", "mean_moment_ratio")):
        with pytest.raises(ValueError, match=f"{wrong} is no quantity of the table of bodies; did you mean {meant}?"):
            own_body("mine", 6e24, 6.4e6, **{wrong: 0.3})


def test_quantities_of_an_own_body_may_have_units():
    given = {"rotation_rate": "360 deg/d", "central_density": "13 g/cm3"}
    planet = own_body("mine", "1 Mearth", "1 Rearth", **given)
    assert planet.angular_velocity == pytest.approx(2.0 * np.pi / 86400.0)
    assert planet.value("central_density") == pytest.approx(13000.0)
    with pytest.raises(ValueError, match="j2 of mine must be a finite number"):
        own_body("mine", 6e24, 6.4e6, j2="1e-3")


def test_tides_hold_the_large_moons_and_what_one_says_of_a_body_of_ones_own():
    held = {"Moon", "Io", "Europa", "Ganymede", "Callisto", "Enceladus", "Rhea", "Titan"}
    assert {name for name, one in solar_system().items() if one.synchronous} == held
    given = {"rotation_rate": 2e-5}
    assert own_body("moon", 9e22, 1.7e6, synchronous=True, **given).synchronous
    assert not own_body("moon", 9e22, 1.7e6, **given).synchronous
    with pytest.raises(ValueError, match="the synchronous body moon needs its rotation_rate"):
        own_body("moon", 9e22, 1.7e6, synchronous=True)


def test_j2_of_an_own_body_is_of_its_equatorial_radius():
    given = {"j2": 1.0826e-3, "equatorial_radius": 6378137.0, "mean_moment_ratio": 0.3307}
    planet = own_body("mine", 5.97e24, 6371e3, **given)
    assert planet.zonal_harmonic() == 1.0826e-3
    j2 = 1.0826e-3 * (6378137.0 / 6371e3) ** 2
    assert planet.moment_ratio("polar").value == pytest.approx(0.3307 + 2 / 3 * j2, rel=1e-12)
    assert own_body("mine", 5.97e24, 6371e3, j2=1e-3).zonal_harmonic(6371e3) == 1e-3
    with pytest.raises(ValueError, match="takes the reference radius of J2 in m, not 2"):
        body("Earth").zonal_harmonic(2)  # which would be the degree of a field
