"""Cold spheroids against independent integrations, exact solutions, linear theory and conservation of energy."""

import json
import math
from pathlib import Path

import mpmath
import numpy as np
import pytest

from astroinertia.bodies import cold_spheroid
from astroinertia.bodies.cold_spheroid import ColdSpheroid
from astroinertia.bodies.ellipsoid_gravity import gravitational_energy, index_symbols
from astroinertia.bodies.homologous_core import HomologousCore

REFERENCE = Path(__file__).parents[2] / "reference"
ENTRIES = json.loads((REFERENCE / "cold_spheroids.json").read_text())
COLLAPSES = [entry for entry in ENTRIES if entry["name"] == "cold_spheroid_LMS65"]


@pytest.mark.parametrize("entry", COLLAPSES, ids=lambda entry: str(entry["inputs"]))
def test_collapse_reference_values(entry):
    given, value = entry["inputs"], entry["value"]
    body = ColdSpheroid(given["a0"], given["c0"], given["Omega"])
    end = body.collapse()
    assert end.kind == value["kind"].split()[0]
    assert end.time == pytest.approx(float(value["t_collapse"]), abs=2e-11)
    other = end.equatorial_radius if end.kind == "pancake" else end.polar_radius
    assert other == pytest.approx(float(value["other_axis_at_collapse"]), abs=6e-11)
    if end.kind == "pancake":  # the rates of the reference break the conservation of energy by 1e-7 of itself
        assert end.polar_rate == pytest.approx(float(value["velocity_of_collapsing_axis"]), rel=1e-7)
        assert end.equatorial_rate == pytest.approx(float(value["velocity_other"]), rel=1e-7)
    else:  # the rate of the vanishing axis has no limit; the reference stopped short of it
        assert end.equatorial_rate == -math.inf
        assert end.polar_rate == pytest.approx(float(value["velocity_other"]), rel=1e-7)


def test_collapse_of_a_nearly_round_body():
    """Against the same equations in 25 digits, by extrapolated midpoint steps in psi."""
    end = ColdSpheroid(1.0, 0.99).collapse()
    assert end.time == pytest.approx(1.104665183006037301594, rel=2e-14)
    assert end.equatorial_radius == pytest.approx(0.01507251642903011392512, rel=2e-13)
    assert end.equatorial_rate == pytest.approx(-13.92565877174760501, rel=1e-12)
    assert end.polar_rate == pytest.approx(-15.21274331157711337, rel=1e-12)


def test_sphere():
    for entry in ENTRIES:
        if entry["name"] == "cold_sphere":
            assert cold_spheroid.sphere_free_fall_time(1.0) == pytest.approx(float(entry["value"]["t_ff"]), abs=2e-14)
        if entry["name"] == "cold_sphere.radius":
            time = entry["inputs"]["t/tff"] * cold_spheroid.sphere_free_fall_time(3.0, 2.0, 0.5)
            radius = float(cold_spheroid.sphere_radius(time, 3.0, 2.0, 0.5))
            assert radius / 3.0 == pytest.approx(float(entry["value"]["r"]), rel=1e-13)
            motion = ColdSpheroid(3.0, 3.0, mass=2.0, gravitational_constant=0.5).motion(time)
            assert motion.polar_radius == pytest.approx(radius, rel=1e-14)
            assert motion.polar_rate == pytest.approx(-math.sqrt(2 * (1 / radius - 1 / 3)), rel=1e-12)
    end = ColdSpheroid(3.0, 3.0).collapse()
    assert end.kind == "point" and end.time == ColdSpheroid(3.0, 3.0).free_fall_time


@pytest.mark.parametrize("share", [1e-12, 0.1, 0.9, 1 - 2.0**-30, 1 - 2.0**-52])
def test_the_cycloid_of_free_fall_keeps_its_digits_to_the_end(share):
    with mpmath.workdps(40):
        left = mpmath.pi / 2 * (1 - mpmath.mpf(share))
        angle = mpmath.findroot(lambda v: v - mpmath.sin(v) * mpmath.cos(v) - left, mpmath.cbrt(1.5 * left))
        exact = float(mpmath.sin(angle) ** 2)
    assert cold_spheroid.fallen(share) == pytest.approx(exact, rel=1e-15)


@pytest.mark.parametrize("share", [math.nan, -1e-9, 1 + 1e-9])
def test_a_free_fall_is_followed_from_its_start_to_its_end(share):
    for followed in (cold_spheroid.fallen, HomologousCore(0.5, start="rest").scale_factor):
        with pytest.raises(ValueError, match=r"is (followed|known) from"):
            followed(np.array([0.5, share if share < 1 else 1e9]))


def test_motion_of_the_rotating_reference_body():
    """An independent integration of the deformation gradient of the body a = 1, c = 0.9, Omega = 0.2."""
    entry = json.loads((REFERENCE / "cold.json").read_text())
    given = entry["inputs"]
    body = ColdSpheroid(given["F0"][0][0], given["F0"][2][2], given["L0"][1][0])
    rows = [row for row in entry["value"] if row["t"] < body.collapse().time]
    motion = body.motion([row["t"] for row in rows])
    assert len(rows) > 3
    for k, row in enumerate(rows):
        assert motion.equatorial_radius[k] == pytest.approx(row["a"][0], rel=1e-11)
        assert motion.polar_radius[k] == pytest.approx(row["a"][2], rel=1e-11)
        assert motion.angular_velocity[k] == pytest.approx(row["omega_Lz_over_Izz"], rel=1e-11)


@pytest.mark.parametrize(("polar", "rate"), [(0.3, 0.0), (0.3, 0.7), (1.0, 0.4), (3.0, 0.0), (3.0, 0.05)])
def test_energy_and_momentum_are_kept(polar, rate):
    """To within a millionth of the collapse time of the end, in units other than G = M = 1."""
    body = ColdSpheroid(2.0, 2.0 * polar, rate, mass=3.0, gravitational_constant=0.4)
    end = body.collapse()
    motion = body.motion(end.time * np.array([0.0, 0.3, 0.7, 0.99, 1 - 1e-6]))
    energies = []
    for a, c, da, dc, turn in np.array(motion).T:
        potential = gravitational_energy([a, a, c], body.mass, body.gravitational_constant)
        energies.append(body.mass / 10 * (2 * da**2 + dc**2 + 2 * (a * turn) ** 2) + potential)
        assert turn * a**2 == pytest.approx(rate * 4.0, rel=1e-14)
    np.testing.assert_allclose(energies, energies[0], rtol=0, atol=3e-12 * abs(np.max(np.abs(energies))))


def test_symbols_pass_through_the_disc():
    """As the index symbols for c > 0, and smoothly through c = 0: the same polynomial fits both sides."""
    for share in (1e-3, 0.3, 0.499999, 0.500001, 1.0, 1.3, 1.5000001, 40.0):
        symbols = index_symbols([1.0, 1.0, share])
        first, excess = cold_spheroid._symbols(share - 1)
        assert first * share == pytest.approx(symbols[0], rel=1e-14)
        assert first + excess == pytest.approx(symbols[2], rel=1e-14)
    points = np.linspace(-0.02, 0.02, 9)
    values = [cold_spheroid._symbols(point - 1)[0] for point in points]
    positive = np.polynomial.Polynomial.fit(points[4:], values[4:], 4)
    np.testing.assert_allclose(positive(points[:4]), values[:4], rtol=1e-7)


def test_bad_bodies_and_times_are_refused():
    for radii in ((0.0, 1.0), (1.0, -1.0), (1.0, math.nan), (math.inf, 1.0)):
        with pytest.raises(ValueError, match="positive, finite radii"):
            ColdSpheroid(*radii)
    body = ColdSpheroid(1.0, 0.5)
    with pytest.raises(ValueError, match=r"0 to its collapse at 0\.70728"):
        body.motion([0.1, 0.8])
    with pytest.raises(ValueError, match="free-fall time"):
        cold_spheroid.sphere_radius(-0.1)
