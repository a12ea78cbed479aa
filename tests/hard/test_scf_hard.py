"""Rotating stars where solvers go wrong: at mass shedding, around hollows, into rings, nearly at rest, nearly flat."""

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies import maclaurin
from astroinertia.bodies.rotating_star import end_of_sequence, rotating_star, rotating_star_with
from astroinertia.bodies.rotation_laws import RotationLaw
from astroinertia.bodies.scf import Resolution
from astroinertia.errors import NumericalError
from astroinertia.matter.barotropes import polytropic_matter
from tests.exact_polytropes import SHEDDING, exact_polytrope

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "rapid_rotation.json").read_text())


@pytest.mark.full
@pytest.mark.parametrize(("resolution", "error"), [(None, 1e-5), (Resolution(24, 96, 96), 3e-6)])
def test_mass_shedding_of_index_one_is_that_of_the_spectral_solution(resolution, error):
    star, exact = end_of_sequence(polytropic_matter(1.0), resolution=resolution), exact_polytrope(**SHEDDING)
    assert star.keplerian_fraction == pytest.approx(1.0, abs=1e-8)
    assert star.field.axis_ratio == pytest.approx(exact.axis_ratio, rel=error)
    assert star.rotation_parameter == pytest.approx(exact.rotation_parameter, rel=3 * error)
    assert star.rotational_to_gravitational == pytest.approx(exact.rotational_to_gravitational, rel=error)


def test_a_star_as_flat_as_nothing_is_refused():
    with pytest.raises(NumericalError, match="no star as flat as an axis ratio of 4"):
        rotating_star(polytropic_matter(1.5), 5e-324)


@pytest.mark.parametrize("index", [1.5, *(pytest.param(index, marks=pytest.mark.full) for index in (2.0, 3.0))])
def test_stars_are_solved_up_to_mass_shedding_and_refused_beyond(index):
    last = end_of_sequence(polytropic_matter(index))
    ratio = last.field.axis_ratio
    assert 0.999 < last.keplerian_fraction < 1
    # published ends are of the last model computed, a little before the limit
    assert 0 <= 1 - ratio - REFERENCE["mass_shedding_oblateness"][str(index)] < 0.003
    before = rotating_star(polytropic_matter(index), ratio + 1e-6)
    assert before.rotational_to_gravitational == pytest.approx(last.rotational_to_gravitational, rel=1e-4)
    for beyond in (ratio - 1e-6, ratio - 0.01, ratio - 0.2, 0.1):
        with pytest.raises(NumericalError, match=r"mass shedding|would not close|did not converge"):
            rotating_star(polytropic_matter(index), beyond)


@pytest.mark.full
def test_soft_stars_shed_mass_as_roches_model_does():
    """With all mass at the centre: polar over equatorial radius 2/3, Omega^2 a^3/(G M) = 1."""
    ends = [end_of_sequence(polytropic_matter(index)) for index in (3.0, 3.5, 4.0)]
    gaps = [2 / 3 - star.field.axis_ratio for star in ends]
    assert all(b < 0.35 * a for a, b in pairwise(gaps)), gaps
    assert ends[-1].rotation_parameter == pytest.approx(1.0, abs=3e-4)


def test_nothing_happens_at_index_three():
    stars = [rotating_star(polytropic_matter(index), 0.75) for index in (2.999, 3.0, 3.001, 3.002)]
    energies = np.array([star.rotational_to_gravitational for star in stars])
    assert np.abs(np.diff(energies, 3)).max() < 1e-10
    assert np.abs(np.diff(energies, 1)).min() > 1e-6
    assert max(star.virial_error for star in stars) < 1e-9


@pytest.mark.parametrize("flattening", [1e-3, 1e-6, 1e-9])
def test_a_star_nearly_at_rest_answers_in_proportion(flattening):
    """To first order f = (3 J2 + m)/2 whatever the matter: what of Omega^2 and J2 is lost in differences would show."""
    star = rotating_star(polytropic_matter(1.5), 1 - flattening)
    second, small = star.zonal_harmonics[0], star.small_m
    assert (3 * second + small) / 2 == pytest.approx(flattening, rel=3 * flattening + 1e-6)
    # the fluid Love number of n = 1.5, k2 = 3 J2/m (Brooker & Olle 1955, MNRAS 115, 101: apsidal constant 0.14327)
    assert 3 * second / small == pytest.approx(2 * 0.14327, rel=1e-4 + 5 * flattening)


@pytest.mark.full
@pytest.mark.parametrize(("axis_ratio", "error"), [(0.5827241, 2e-5), (0.3032, 1e-3), (0.25, 1e-3)])
def test_liquids_at_their_bifurcation_and_dynamical_limit(axis_ratio, error):
    exact, star = maclaurin.from_axis_ratio(axis_ratio), rotating_star(polytropic_matter(0.0), axis_ratio)
    assert star.rotational_to_gravitational == pytest.approx(exact.rotational_to_gravitational, rel=error)
    assert star.zonal_harmonics[0] == pytest.approx(exact.second_zonal_harmonic, rel=3 * error)


@pytest.mark.full
@pytest.mark.parametrize("axis_ratio", [0.2, 0.1, 0.05])
def test_discs_of_liquid_are_right_or_refused(axis_ratio):
    exact = maclaurin.from_axis_ratio(axis_ratio)
    try:
        star = rotating_star(polytropic_matter(0.0), axis_ratio)
    except NumericalError as error:
        assert "harmonics" in str(error) or "did not converge" in str(error) or "mass shedding" in str(error)  # noqa: PT017
    else:
        assert star.rotational_to_gravitational == pytest.approx(exact.rotational_to_gravitational, rel=3e-3)


@pytest.mark.parametrize("scale", [0.3, 0.1, 0.03])
def test_constant_angular_momentum_digs_a_hollow_and_then_a_hole(scale):
    """With small A the densest matter leaves the axis; flattened further the star is a ring, without a jump."""
    law = RotationLaw("j_constant", scale)
    star, ring = (rotating_star(polytropic_matter(1.5), ratio, law) for ratio in (0.003, -0.003))
    for body in (star, ring):
        assert body.virial_error < 1e-6
        assert body.keplerian_fraction < 1
    centre = star.density(0.0, 0.0) / star.max_density
    assert centre < 0.2
    # a hole of three thousandths holds no mass, but on the scale A of the law it is not small
    assert ring.polar_moment == pytest.approx(star.polar_moment, rel=0.04 * 0.03 / scale + 0.01)
    # specific angular momentum rises outwards (Solberg and Hoiland: the star is stable), to a constant
    w = np.linspace(0.01, 1, 50)
    momentum = star.rotation_rate(w) * w**2
    assert (np.diff(momentum) > 0).all()
    assert momentum[-1] / momentum[24] < 1 + 4 * scale**2 * 1.01


@pytest.mark.full
def test_small_scales_are_resolved_or_refused():
    """The core that turns is as narrow as A: what 96 harmonics make of it is checked against 192."""
    law = RotationLaw("j_constant", 0.01)
    coarse = rotating_star(polytropic_matter(1.5), 0.5, law)
    fine = rotating_star(polytropic_matter(1.5), 0.5, law, resolution=Resolution(32, 192, 192))
    assert coarse.rotational_to_gravitational == pytest.approx(fine.rotational_to_gravitational, rel=0.01)
    assert coarse.polar_moment == pytest.approx(fine.polar_moment, rel=1e-3)


@pytest.mark.parametrize("ratio", [-0.1, -0.3, -0.97])
def test_rings_that_do_not_exist_or_are_too_thin_are_refused(ratio):
    with pytest.raises(NumericalError, match=r"mass shedding|would not close|harmonics|did not converge"):
        rotating_star(polytropic_matter(1.5), ratio)


@pytest.mark.full
def test_thin_rings_turn_as_ostrikers():
    """A thin homogeneous ring turns with Omega^2 = G M/(2 pi R^3) (ln(8R/a) - 5/4): Ostriker 1964, ApJ 140, 1067."""
    for inner in (0.5, 0.75):
        ring = rotating_star(polytropic_matter(0.0), -inner, resolution=Resolution(32, 192, 192))
        middle, half = (1 + inner) / 2, (1 - inner) / 2
        thin = ring.mass / (2 * np.pi * middle**3) * (np.log(8 * middle / half) - 1.25)
        assert 0.35 < (ring.angular_velocity**2 / thin - 1) / (half / middle) ** 2 < 0.45


@pytest.mark.full
def test_sequences_of_differential_rotation_reach_far_beyond_rigid_ones():
    law = RotationLaw("v_constant", 0.1)
    star = rotating_star_with("rotational_to_gravitational", 0.2, polytropic_matter(1.5), law)
    assert star.rotational_to_gravitational == pytest.approx(0.2, rel=1e-9)
    assert 0 < star.field.axis_ratio < 0.4
    assert star.virial_error < 1e-8
