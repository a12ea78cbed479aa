"""Poles, spins and orbits from SPICE kernels that are written here: from the IAU's numbers and from known orbits."""

import sys

import numpy as np
import pytest

from astroinertia.bodies import j2000
from astroinertia.errors import SceneError
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.orbits.states import states
from astroinertia.rotation import spice
from astroinertia.rotation.precession import JULIAN_YEAR
from astroinertia.studies import turning_planets
from astroinertia.studies.precession import precession

DAY, DEGREE = 86400.0, np.pi / 180.0
# Archinal et al. 2011, CMDA 109, 101, table 1.
PCK = r"""KPL/PCK
\begindata
BODY499_POLE_RA  = ( 317.68143  -0.1061      0. )
BODY499_POLE_DEC = (  52.88650  -0.0609      0. )
BODY499_PM       = ( 176.630   350.89198226  0. )
BODY299_POLE_RA  = ( 272.76      0.          0. )
BODY299_POLE_DEC = (  67.16      0.          0. )
BODY299_PM       = ( 160.20     -1.4813688   0. )
\begintext
"""
NUMBERS = {"Sun": 10, "Mercury": 1, "Venus": 2, "Earth": 3, "Mars": 4, "Jupiter": 5, "Saturn": 6, "Uranus": 7,
           "Neptune": 8}  # fmt: skip
YEARS = 9.5


@pytest.fixture
def pck(tmp_path):
    path = tmp_path / "iau.tpc"
    path.write_text(PCK)
    return path


@pytest.fixture(scope="module")
def spk(tmp_path_factory):
    """The orbits of the study of Mars by REBOUND, every second day, about the Sun and in ICRF axes."""
    spiceypy = pytest.importorskip("spiceypy")
    path = tmp_path_factory.mktemp("kernels") / "orbits.bsp"
    mars = turning_planets.mars()
    others = [
        Companion(name, one.gravitational_parameter, position=tuple(one.position), velocity=tuple(one.velocity))
        for name, one in mars.others.items()
    ]
    bodies = simulation(mars.parameter, others)
    half = 0.5 * YEARS * JULIAN_YEAR + 20 * DAY
    bodies.integrate(-half)
    times = np.arange(-half, half, 2 * DAY)
    place, speed = (part @ mars.axes for part in states(bodies, times))
    rows = {name: np.concatenate([place[:, k], speed[:, k]], axis=1) / 1e3 for k, name in enumerate(mars.others)}
    rows["Mars"] = np.zeros_like(rows["Sun"])
    handle = spiceypy.spkopn(str(path), "test", 0)
    for name, number in NUMBERS.items():
        if name != "Sun":
            about_sun = np.ascontiguousarray(rows[name] - rows["Sun"])
            spiceypy.spkw13(handle, number, 10, "J2000", times[0], times[-1], name, 11, len(times), about_sun, times)
    spiceypy.spkcls(handle)
    return path


def test_without_the_toolkit_one_sentence_says_how_to_have_it(monkeypatch, pck):
    monkeypatch.setitem(sys.modules, "spiceypy", None)
    with pytest.raises(SceneError, match=r"need spiceypy: pip install 'astroinertia\[spice\]'"):
        precession("Mars", kernels=[pck])


def test_pole_and_spin_are_those_of_the_iaus_formulae(pck):
    """W is counted from the node of the equator on that of ICRF, which moves with the pole."""
    pytest.importorskip("spiceypy")
    centuries = 0.3
    found = spice.orientation(pck, "Mars", f"{100 * centuries} yr")
    right_ascension, declination = 317.68143 - 0.1061 * centuries, 52.88650 - 0.0609 * centuries
    assert found.right_ascension == pytest.approx(right_ascension * DEGREE, rel=1e-14)
    assert found.declination == pytest.approx(declination * DEGREE, rel=1e-14)
    across = np.cos(found.declination)
    expected = [across * np.cos(found.right_ascension), across * np.sin(found.right_ascension)]
    np.testing.assert_allclose(found.pole, [*expected, np.sin(found.declination)], rtol=1e-14)
    moving = 350.89198226 - 0.1061 / 36525 * np.sin(found.declination)
    assert found.spin_rate == pytest.approx(moving * DEGREE / DAY, rel=1e-13)
    assert spice.orientation([str(pck)], "venus").spin_rate == pytest.approx(-1.4813688 * DEGREE / DAY, rel=1e-13)


def test_orbits_are_those_of_the_kernel(spk):
    """In axes of one's own; Earth and Moon go as one, and Mars is its centre of mass where nothing else is known."""
    for name, one in j2000.states("Mars", np.eye(3)).items():
        place, speed = spice.state(spk, name, "Mars")
        np.testing.assert_allclose(place, one.position, atol=1e-9 * np.linalg.norm(one.position))
        np.testing.assert_allclose(speed, one.velocity, atol=1e-8 * np.linalg.norm(one.velocity))
    axes = j2000.ecliptic_axes()
    orbits = spice.orbits(spk, "Mars", {"Sun": 2.0, "Earth": 3.0}, ("-1 yr", "2 yr"), axes)
    assert orbits.names == ("Sun", "Earth")
    np.testing.assert_array_equal(orbits.mass, [2.0, 3.0])
    for time in (-JULIAN_YEAR, 1e6, 2 * JULIAN_YEAR):
        for k, name in enumerate(orbits.names):
            place, speed = (axes @ part for part in spice.state(spk, name, "Mars", time))
            np.testing.assert_allclose(orbits.position(time)[k], place, atol=1e-8 * np.linalg.norm(place))
            np.testing.assert_allclose(orbits.velocity(time)[k], speed, atol=1e-6 * np.linalg.norm(speed))


def test_obliquities_of_a_planet_that_turns_forwards_and_of_one_that_does_not(pck, spk):
    assert spice.obliquity([pck, spk], "Mars") / DEGREE == pytest.approx(25.19, abs=0.01)  # Archinal et al. 2011
    assert spice.obliquity([pck, spk], "Venus") / DEGREE == pytest.approx(177.36, abs=0.01)


def test_the_study_follows_kernels_as_it_follows_its_own_tables(pck, spk):
    """The orbits are REBOUND's own; the pole has another declination and the planet turns more slowly."""
    pck.write_text(PCK.replace("52.88650", "53.00000").replace("350.89198226", "340.00000000"))
    own, found = precession("Mars", YEARS), precession("Mars", YEARS, kernels=[pck, spk])
    assert found.attrs["orientation"] == found.attrs["orbits"] == "SPICE: iau.tpc, orbits.bsp"
    assert "orbits" not in own.attrs
    tilts = [turning_planets.mars().obliquity, spice.obliquity([pck, spk], "Mars")]
    assert 1e-4 < abs(tilts[1] - tilts[0]) < 1e-2
    np.testing.assert_allclose(found["obliquity"] - own["obliquity"], tilts[1] - tilts[0], rtol=0.02)
    # By the closed form the rate goes as cos(obliquity) over the spin.
    expected = np.cos(tilts[1]) / np.cos(tilts[0]) * 350.891982443297 / 340.0
    ratio = found["precession_rate"] / own["precession_rate"]
    assert float(ratio.sel(part="all")) == pytest.approx(expected, rel=2e-5)
    assert float(ratio.sel(part="Sun")) == pytest.approx(expected, rel=2e-5)


def test_a_pole_alone_leaves_the_orbits_as_they_are(pck):
    pytest.importorskip("spiceypy")
    own, found = turning_planets.mars(), turning_planets.mars(pck)
    assert found.kernels == ()
    assert not spice.has_orbits(pck)
    for name, one in own.others.items():
        np.testing.assert_allclose(
            found.axes.T @ found.others[name].position, own.axes.T @ one.position, atol=1e-14 * 1e13
        )


def test_what_kernels_lack_and_what_is_none_is_refused_in_a_sentence(pck, tmp_path):
    spiceypy = pytest.importorskip("spiceypy")
    broken = tmp_path / "broken.bsp"
    broken.write_bytes(b"DAF/SPK " + bytes(3000))
    for files, name, words in (
        (pck, "Earth", "data required .* IAU_EARTH .* were not found"),
        (tmp_path / "none.tpc", "Mars", r"none\.tpc.* failed"),
        (broken, "Mars", "unknown binary file format|has failed"),
        (pck, "Nobody", "no body 'Nobody'"),
    ):
        with pytest.raises(SceneError, match=words) as caught:
            spice.orientation(files, name)
        assert "\n" not in str(caught.value)
    with pytest.raises(SceneError, match="SPICE kernels: "):
        spice.state(pck, "Sun", "Mars")
    assert spiceypy.ktotal("ALL") == 0  # nothing stays loaded


def test_kernels_of_the_users_own_stay_loaded(pck, tmp_path):
    spiceypy = pytest.importorskip("spiceypy")
    other = tmp_path / "other.tpc"
    other.write_text(PCK.replace("499", "599"))
    spiceypy.furnsh(str(other))
    try:
        spice.orientation(pck, "Mars")
        assert spiceypy.ktotal("ALL") == 1
        assert spiceypy.bodfnd(599, "POLE_RA")
    finally:
        spiceypy.kclear()


def test_a_binary_kernel_has_the_poles_of_its_own_bodies_only(pck, tmp_path):
    spiceypy = pytest.importorskip("spiceypy")
    path = tmp_path / "mars.bpc"
    handle = spiceypy.pckopn(str(path), "test", 0)
    span = 2 * YEARS * JULIAN_YEAR
    angles = [1.0, 0.0, 0.5, 0.0, 0.1, 0.0]  # Chebyshev coefficients of degree 1, of three angles
    spiceypy.pckw02(handle, 499, "J2000", -span, span, "mars", 2 * span, 1, 1, angles, -span)
    spiceypy.pckcls(handle)
    assert spice.has_orientation(path, "Mars")
    assert not spice.has_orientation(path, "Earth")
    assert spice.has_orientation([path, pck], "Venus")
    own, found = turning_planets.earth(), turning_planets.earth(path)
    assert (found.spin_rate, found.obliquity) == (own.spin_rate, own.obliquity)
