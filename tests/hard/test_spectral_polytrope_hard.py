"""The rotating polytrope of index 1 next to mass shedding, next to rest, and where its functions change."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies import null_field, spectral_polytrope
from astroinertia.bodies.spectral_polytrope import mass_shedding, rotating_polytrope
from astroinertia.errors import NumericalError

ENTRIES = json.loads((Path(__file__).parents[1] / "reference" / "rotating_polytropes.json").read_text())


@pytest.mark.full
def test_mass_shedding_is_a_cusp_and_converges():
    """The equator has no effective gravity, and the limits of rising degree approach one value as degree^-4."""
    limits = [
        spectral_polytrope._converged("saddle", 0.0, spectral_polytrope._milestones()[-1], (degree - 6, degree), 1.0)
        for degree in (20, 28, 40)
    ]
    q = [body.rotation_parameter for body in limits]
    order = math.log((q[0] - q[1]) / (q[1] - q[2])) / math.log(2**0.5)
    assert 3 < order < 6
    body = limits[-1]
    gravity = body.trial.unknowns @ body.trial.radial
    assert abs(gravity[-2] / gravity[-1]) < 1e-9
    assert abs(body.virial_error) < 1e-11
    radii = body.surface_radius([0.0, 1e-3, 2e-3])
    fall = (radii[0] - radii[1:]) / radii[0]
    assert fall[1] / fall[0] == pytest.approx(2.0, rel=0.02)  # a smooth equator would give 4


@pytest.mark.full
def test_published_star_next_to_mass_shedding():
    """Yoshida 2022: f = 0.4425 of at most 0.443022, given to four digits; q changes fastest there."""
    [entry] = [each for each in ENTRIES if each["inputs"].get("f_oblateness=1-Rp/Re") == 0.4425]
    body = rotating_polytrope(axis_ratio=1 - 0.4425, tolerance=1e-4)
    assert body.rotation_parameter == pytest.approx(entry["value"]["q_Omega2Re3_GM"], rel=6e-4)
    assert body.polar_moment_ratio_equatorial == pytest.approx(entry["value"]["Izz_MRe2"], rel=2e-3)


@pytest.mark.full
def test_solved_just_below_and_refused_just_beyond():
    limit = mass_shedding()
    assert limit.rotation_parameter == pytest.approx(1.10339, abs=1e-5)
    assert limit.axis_ratio == pytest.approx(0.556978, abs=2e-6)
    assert limit.central_rotation_parameter == pytest.approx(0.0418720, abs=2e-7)
    for name in ("rotation_parameter", "small_m", "central_rotation_parameter"):
        at = getattr(limit, name)
        body = rotating_polytrope(**{name: at * (1 - 1e-3)}, tolerance=1e-4)
        assert getattr(body, name) == pytest.approx(at * (1 - 1e-3), rel=1e-12)
        assert body.axis_ratio > limit.axis_ratio
        with pytest.raises(NumericalError, match="sheds mass"):
            rotating_polytrope(**{name: at * (1 + 1e-4)}, tolerance=1e-4)
    with pytest.raises(NumericalError, match="sheds mass"):
        rotating_polytrope(axis_ratio=0.5)


@pytest.mark.full
def test_what_has_not_converged_is_refused():
    """Degree 80 reaches 1e-8 at q = 1.05: asked for more, it says how far it came."""
    with pytest.raises(NumericalError, match=r"converged to \d\.\de-(0[89]|10) only"):
        rotating_polytrope(1.05, tolerance=1e-12)
    assert rotating_polytrope(1.05, tolerance=1e-6).truncation_error < 1e-6


@pytest.mark.full
def test_truncation_error_is_honest():
    for q in (0.4, 0.8, 1.0):
        exact = rotating_polytrope(q, tolerance=1e-9 if q < 1 else 1e-7)
        for degree in (16, 26):
            rough = rotating_polytrope(q, degree=degree)
            estimate = rough.truncation_error
            for name in ("polar_moment_ratio_equatorial", "flattening"):
                assert abs(getattr(rough, name) / getattr(exact, name) - 1) <= estimate
            assert np.max(np.abs(rough.zonal_harmonics[:3] / exact.zonal_harmonics[:3] - 1)) <= estimate


@pytest.mark.parametrize("q", [1e-12, 1e-8, 1e-5, 1e-4])
def test_slow_rotation_keeps_relative_accuracy(q):
    """J_2l goes as q^l (1 + O(q)): both orders, from rotations of 1e-3 and 5e-4, hold at 1e-12."""
    powers = np.array([1, 2, 3])
    one, two = (rotating_polytrope(each).zonal_harmonics[:3] / each**powers for each in (1e-3, 5e-4))
    expected = 2 * two - one + (one - two) / 5e-4 * q
    body = rotating_polytrope(q)
    found = body.zonal_harmonics[:3] / q**powers
    assert found[0] == pytest.approx(expected[0], rel=2e-6)
    assert body.flattening / q == pytest.approx(7.5 / math.pi**2, rel=1e-12 + 2 * q)
    if q >= 1e-8:
        assert found[1] == pytest.approx(expected[1], rel=1e-5)
    if q >= 1e-5:
        assert found[2] == pytest.approx(expected[2], rel=2e-2 if q < 1e-4 else 1e-4)


@pytest.mark.full
@pytest.mark.parametrize("q", [0.02, 0.15, 0.3])
def test_spherical_and_spheroidal_functions_agree(q, monkeypatch):
    """The same body in Bessel functions and in functions that fit its flattening: two expansions, one answer."""
    bodies = []
    for switch in (1.0, 0.0):
        monkeypatch.setattr(null_field, "_PLAIN_FLATTENING", switch)
        spectral_polytrope._milestones.cache_clear()
        spectral_polytrope._solution.cache_clear()
        bodies.append(rotating_polytrope(q, degree=24))
    monkeypatch.undo()
    spectral_polytrope._milestones.cache_clear()
    spectral_polytrope._solution.cache_clear()
    assert bodies[0].trial.basis.focal_radius == 0 < bodies[1].trial.basis.focal_radius
    np.testing.assert_allclose(bodies[0].zonal_harmonics[:3], bodies[1].zonal_harmonics[:3], rtol=1e-9, atol=1e-14)
    for name in ("polar_moment_ratio_equatorial", "flattening", "rotational_to_gravitational"):
        assert getattr(bodies[0], name) == pytest.approx(getattr(bodies[1], name), rel=1e-12)
