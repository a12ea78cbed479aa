"""The command `precession`: what it prints, writes and refuses."""

import re

import numpy as np
import pytest
import xarray as xr

from astroinertia.cli.main import main

OWN = ["--mass", "5.97e24 kg", "--radius", "6378 km", "--period", "23.93 h", "--obliquity", "23.4 deg"]
SUN = ["--companion", "Sun, semi_major_axis=1 au"]


def rate(arguments, capsys):
    assert main(["precession", *arguments]) == 0
    match = re.search(r"goes (back|forward) by (\S+) \"/yr", capsys.readouterr().out)
    assert match
    return float(match[2]) * (1 if match[1] == "back" else -1)


@pytest.mark.parametrize(
    ("arguments", "published", "within"),
    [
        (["--body", "Earth"], 50.3848, 2e-4),  # IAU 2006: Capitaine, Wallace & Chapront 2003, A&A 412, 567
        (["--body", "Mars", "--moment-ratio", "0.36367"], 7.6083, 2e-4),  # Konopliv et al. 2016, Icarus 274, 253
        (
            ["--body", "saturn", "--moment-ratio", "0.2199", "--period", "10.6562 h"],
            0.742,
            0.015,
        ),  # Ward & Hamilton 2004
        (["--body", "Venus"], -44.58, 0.075),  # 44.58 +- 3.3: Margot et al. 2021, Nature Astronomy 5, 676
    ],
)
def test_published_rates_of_planets(arguments, published, within, capsys):
    assert rate(arguments, capsys) == pytest.approx(published, rel=within)


def test_each_companion_has_its_share_and_its_nutation(elsewhere, capsys):
    assert main(["precession", "--body", "Earth", "--netcdf", "earth.nc"]) == 0
    rows = {line.split()[0]: line.split() for line in capsys.readouterr().out.splitlines() if line}
    assert rows["Sun"][1:3] == ["15.949", "31.66"]
    assert rows["Moon"][-2:] == ["17.28", "9.227"]
    assert float(rows["Sun"][2]) + float(rows["Moon"][2]) + float(rows["relativity"][2]) == pytest.approx(100, abs=0.02)
    with xr.open_dataset(elsewhere / "earth.nc") as written:
        assert written.attrs["body"] == "Earth"
        assert written["total_rate"].attrs["units"] == "rad s-1"
        assert float(written["total_period"]) / 31557600.0 == pytest.approx(25725, rel=1e-3)


@pytest.mark.parametrize("j2", ["1e-5", "-1e-5", "-.00001", "-1.0E-05"])
def test_a_negative_number_is_a_value_and_no_option(j2, capsys):
    found = rate([*OWN, *SUN, "--moment-ratio", "0.33", "--j2", j2], capsys)
    assert found == pytest.approx(np.copysign(0.14758, float(j2)) - 0.019188, abs=1e-5)  # the torque, and relativity


def test_options_replace_what_the_tables_have(capsys):
    alone = rate(["--body", "Earth", "--companion", "Sun"], capsys)
    assert alone == pytest.approx(15.93, abs=0.01)
    # Twice as near and with a node of its own: the tables' mass, but not their orbit.
    assert rate(["--body", "Earth", "--companion", "Sun, semi_major_axis=0.5 au"], capsys) > 7.9 * alone
    # J2 goes with the ratio, H with itself: either alone keeps the other number of the tables.
    assert rate(["--body", "Earth", "--j2", "2.1652718e-3", *SUN], capsys) == pytest.approx(2 * alone, rel=2e-3)
    assert rate(["--body", "Earth", "--ellipticity", "6.5476e-3", *SUN], capsys) == pytest.approx(2 * alone, rel=2e-3)
    assert rate(["--body", "Earth", "--moment-ratio", "0.165349", *SUN], capsys) == pytest.approx(2 * alone, rel=2e-3)


def test_a_body_of_ones_own_by_any_two_numbers_of_its_shape(capsys):
    shapes = [
        ["--j2", "1.0826e-3", "--moment-ratio", "0.3307"], ["--j2", "1.0826e-3", "--ellipticity", "3.27366e-3"],
        ["--ellipticity", "3.27366e-3", "--polar-moment", "8.03117e37 kg m2"],
    ]  # fmt: skip
    rates = [rate([*OWN, *shape, *SUN], capsys) for shape in shapes]
    assert rates == pytest.approx(np.full(3, 15.92), rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "--mass is missing"),
        (["--body", "Pluto"], "no body 'Pluto'"),
        (["--body", "Moon"], "Moon turns in step with its orbit"),
        (["--body", "Ceres"], "say --companion"),
        (["--body", "Earth", "--radius", "3 km"], "--radius does not go with the J2"),
        (["--body", "Earth", "--obliquity", "23"], "obliquity: '23' is not a number and a unit"),
        (["--body", "Earth", "--period", "-1 d"], "period must be a finite number above 0"),
        (["--body", "Earth", "--companion", "Sun, mass"], "takes NAME, KEY=VALUE, ..., not 'mass'"),
        (["--body", "Earth", "--companion", "Sun, a=1 au"], "has the key 'a'"),
        (["--body", "Earth", "--companion", "Planet X"], "Planet X needs a mass, and one of"),
        (["--body", "Earth", "--companion", "Sun, eccentricity=0.1, eccentricity=0.2"], "says something twice"),
        ([*OWN, "--j2", "1e-3", *SUN], "a shape takes two of --j2, --ellipticity and one of"),
        (["--body", "Earth", "--netcdf", "x.csv"], "must be a .nc file"),
    ],
)
def test_what_cannot_be_gets_one_sentence_and_writes_nothing(arguments, words, elsewhere, capsys):
    assert main(["precession", *arguments]) == 2
    caught = capsys.readouterr()
    assert words in caught.err
    assert caught.err.count("\n") == 1
    assert caught.out == ""
    assert list(elsewhere.iterdir()) == []
