"""Homogeneous ellipsoids where formulas cancel, branches meet or axes vanish."""

import math

import mpmath
import numpy as np
import pytest

from astroinertia.bodies import darwin, ellipsoid_gravity, jacobi, maclaurin, roche


def _closed_forms(l):  # noqa: E741
    """Omega^2/(pi G rho) and T/|W| of a Maclaurin spheroid from the textbook's closed forms, in 200 digits."""
    with mpmath.workdps(400):
        e = l / mpmath.sqrt(1 + l * l)
        omega2 = 2 * ((3 + l * l) * mpmath.atan(l) - 3 * l) / l**3
        ratio = 3 / (2 * e * e) * (1 - e * mpmath.sqrt(1 - e * e) / mpmath.asin(e)) - 1
        return float(omega2), float(ratio)


@pytest.mark.parametrize("l", [1e-100, 1e-12, 1e-6, 1e-3, 0.1, 1.0, 30.0, 1e6, 1e15])
def test_maclaurin_from_sphere_to_disc(l):  # noqa: E741
    """In double precision the closed form of Omega^2 has lost every digit at l = 1e-6, and its sign below."""
    body = maclaurin.from_second_eccentricity(l)
    omega2, ratio = _closed_forms(mpmath.mpf(l))
    assert body.omega2 == pytest.approx(omega2, rel=2e-15)
    assert body.rotational_to_gravitational == pytest.approx(ratio, rel=2e-15)


def test_energy_ratio_at_both_limits():
    """The bifurcation and the dynamical limit from closed forms in thirty digits."""
    with mpmath.workdps(40):

        def b_11(l):  # noqa: E741
            q = 1 / (1 + l * l)  # c^2/a^2
            a_1 = (mpmath.atan(l) * (1 + l * l) - l) / l**3
            a_11 = (3 * a_1 - 2 * q) / (4 * (1 - q))  # from 3 A_11 + A_12 + A_13 = 2
            return a_1 - a_11

        def omega2(l):  # noqa: E741
            return 2 * ((3 + l * l) * mpmath.atan(l) - 3 * l) / l**3

        secular = mpmath.findroot(lambda l: omega2(l) - 2 * b_11(l), 1.39)  # noqa: E741
        dynamical = mpmath.findroot(lambda l: omega2(l) - 4 * b_11(l), 3.14)  # noqa: E741
    for body, l in ((maclaurin.bifurcation(), secular), (maclaurin.dynamical_limit(), dynamical)):  # noqa: E741
        assert body.second_eccentricity == pytest.approx(float(l), rel=4e-15)
        assert body.rotational_to_gravitational == pytest.approx(_closed_forms(l)[1], rel=4e-15)
    assert maclaurin.bifurcation().rotational_to_gravitational == pytest.approx(0.137528147873934, rel=1e-14)
    assert maclaurin.dynamical_limit().rotational_to_gravitational == pytest.approx(0.273822938416717, rel=1e-14)


def test_energy_ratio_found_next_to_its_ends():
    for target in (1e-250, 1e-12, 0.5 - 1e-12):
        body = maclaurin.from_energy_ratio(target)
        assert body.rotational_to_gravitational == pytest.approx(target, rel=1e-15)
    assert 0.5 - maclaurin.from_energy_ratio(0.5 - 1e-12).rotational_to_gravitational == pytest.approx(1e-12, rel=1e-3)
    assert maclaurin.from_energy_ratio(1e-250).second_eccentricity == pytest.approx(math.sqrt(7.5) * 1e-125, rel=1e-14)


def test_both_branches_meet_at_the_fastest_spheroid():
    top = maclaurin.fastest()
    assert maclaurin.from_angular_velocity(top.angular_velocity).omega2 == top.omega2
    rate = top.angular_velocity * (1 - 1e-12)
    slow, fast = (maclaurin.from_angular_velocity(rate, branch) for branch in ("slow", "fast"))
    assert slow.eccentricity < top.eccentricity < fast.eccentricity
    assert fast.eccentricity - slow.eccentricity < 1e-5
    with pytest.raises(ValueError, match=r"0\.449331"):
        maclaurin.from_angular_velocity(top.angular_velocity * (1 + 1e-12))


def test_jacobi_joins_maclaurin_exactly():
    fork, first = maclaurin.bifurcation(), jacobi.from_axis_ratio(1.0)
    assert first.c_over_a == pytest.approx(fork.c_over_a, rel=2e-15)
    assert first.omega2 == pytest.approx(fork.omega2, rel=2e-15)
    assert first.angular_momentum == pytest.approx(fork.angular_momentum, rel=4e-15)
    near = jacobi.from_axis_ratio(1 - 1e-9)
    assert near.omega2 == pytest.approx(fork.omega2, rel=4e-15)
    # all changes are of second order in 1 - b/a at fixed volume
    one, two = (jacobi.from_axis_ratio(1 - x).angular_momentum - first.angular_momentum for x in (1e-3, 2e-3))
    assert two / one == pytest.approx(4.0, rel=3e-3)


def test_jacobi_exists_from_the_bifurcation_on_only():
    least = jacobi.from_axis_ratio(1.0).angular_momentum
    for quantity, value in ((jacobi.from_angular_momentum, least), (jacobi.from_energy_ratio, 0.13752814787393)):
        with pytest.raises(ValueError, match="Jacobi ellipsoids have"):
            quantity(value * (1 - 1e-10))
        assert 1 - 1e-4 < quantity(value * (1 + 1e-10)).b_over_a <= 1
    assert jacobi.from_angular_momentum(least).b_over_a == pytest.approx(1.0, abs=1e-7)


def test_pear_shaped_figures_branch_off():
    """Chandrasekhar 1969, section 40: b/a = 0.432232, c/a = 0.345069; Darwin's hand values agree to four digits."""
    body = jacobi.pear_bifurcation()
    assert body.b_over_a == pytest.approx(0.432232, abs=5e-7)
    assert body.c_over_a == pytest.approx(0.345069, abs=5e-7)
    assert body.omega2 == pytest.approx(0.284030, abs=5e-7)
    np.testing.assert_allclose(body.axes, [1.885827, 0.814975, 0.650659], rtol=2e-4)


def test_third_harmonic_of_the_pear_is_neutral():
    """The potential of a layer as thick as the perpendicular times the harmonic undoes gravity: by quadrature."""
    body = jacobi.pear_bifurcation()
    a, b, c = squares = body.axes**2
    s = np.roots([5, 4 * (b + c) + 2 * a, 3 * b * c + a * (b + c)]).min()
    assert 3 / (a + s) + 1 / (b + s) + 1 / (c + s) == pytest.approx(0.0, abs=1e-12)

    def harmonic(x):
        return x[..., 0] * ((x**2 / (squares + s)).sum(-1) - 1)

    x, weights = np.polynomial.legendre.leggauss(300)
    angle = 2 * np.pi * np.arange(600) / 600
    polar, around = np.meshgrid(x, angle, indexing="ij")
    sphere = np.stack([polar, np.sqrt(1 - polar**2) * np.cos(around), np.sqrt(1 - polar**2) * np.sin(around)], axis=-1)
    # an area element times the perpendicular is abc times the solid angle of the sphere that is stretched
    layer = body.axes.prod() * harmonic(sphere * body.axes) * weights[:, None] * (2 * np.pi / 600)
    inside = np.array([0.9, 0.05, 0.03])
    potential = body.density * (layer / np.linalg.norm(sphere * body.axes - inside, axis=-1)).sum()
    gravity = 2 * np.pi * body.density * c * ellipsoid_gravity.index_symbols(body.axes)[2]
    assert potential == pytest.approx(gravity * harmonic(inside), rel=1e-8)


@pytest.mark.parametrize("b", [1e-4, 1e-6, 1e-9, 1e-12])
def test_jacobi_needles(b):
    """For b -> 0: c -> b and Omega^2/(pi G rho) -> 4 (b/a)^2 (ln(2a/b) - 3/2), from the potential of a thin rod."""
    body = jacobi.from_axis_ratio(b)
    assert body.c_over_a == pytest.approx(b, rel=100 * b * b + 4e-15)
    assert body.omega2 == pytest.approx(4 * b * b * (math.log(2 / b) - 1.5), rel=100 * b * b + 1e-14)


@pytest.mark.parametrize("c", [0.999999, 0.5, 1e-3, 1e-5])
def test_jeans_spheroids_have_their_closed_form(c):
    """Prolate in a tide without rotation: mu = 2 (1 - c^2) B_13/(2 + c^2), with A_1 from the logarithm."""
    with mpmath.workdps(60):
        z = mpmath.mpf(c) ** 2
        e = mpmath.sqrt(1 - z)
        a_1 = z / e**3 * (mpmath.log((1 + e) / (1 - e)) - 2 * e)
        a_3 = 1 - a_1 / 2
        expected = 2 * (a_1 - z * a_3) / (2 + z)
    body = roche.from_axis_ratio(-1, c)
    assert body.tide == pytest.approx(float(expected), rel=4e-15 if c < 0.9 else 1e-10)  # 1 - c of a float


def test_mass_ratio_limits():
    """p -> -1 and p -> 0 are regular; p -> infinity reaches the bifurcation, a corner of the sequence, as p^(-1/3)."""
    jeans, next_to_it = roche.limit(-1), roche.limit(-1 + 1e-9)
    assert next_to_it.tide == pytest.approx(jeans.tide, rel=1e-8)
    assert next_to_it.b_over_a > next_to_it.c_over_a
    assert roche.limit(1e-12).scaled_distance == pytest.approx(roche.limit(0).scaled_distance, rel=1e-11)
    assert roche.limit(0).distance == math.inf
    gaps = [1 - roche.limit(p).b_over_a for p in (1e6, 1e9, 1e12)]
    np.testing.assert_allclose(np.divide(gaps[:-1], gaps[1:]), 10.0, rtol=0.02)
    assert roche.limit(1e12).omega2 == pytest.approx(maclaurin.bifurcation().omega2, rel=1e-7)
    # well before the corner a heavy body is Maclaurin's spheroid but for the tide
    assert roche.from_axis_ratio(1e12, 0.8).omega2 == pytest.approx(maclaurin.from_axis_ratio(0.8).omega2, rel=1e-11)
    free = roche.from_axis_ratio(math.inf, 0.4)
    assert roche.from_axis_ratio(1e12, 0.4).b_over_a == pytest.approx(free.b_over_a, rel=1e-9)


def test_roche_needles_and_spheres_stay_in_balance():
    for mass_ratio in (0.0, 1.0, 1e3):
        for c in (1e-5, 1e-3, 1 - 1e-9):
            body = roche.from_axis_ratio(mass_ratio, c)
            squares = (1.0, body.b_over_a**2, c * c)
            excess = (1 + mass_ratio) * body.tide + 2 * body.tide + body.tide * c * c
            strength = 2 * (1 - c) * (1 + c) * ellipsoid_gravity.index_integral(squares, (0, 2), 1)
            assert excess == pytest.approx(strength, rel=1e-13)
            assert c <= body.b_over_a <= 1


@pytest.mark.parametrize("branch", ["stable", "unstable"])
def test_at_the_roche_limit_itself(branch):
    closest = roche.limit(0.0)
    assert roche.at_distance(0.0, closest.scaled_distance, branch).c_over_a == pytest.approx(closest.c_over_a, abs=1e-6)
    with pytest.raises(ValueError, match=r"2\.45517564"):
        roche.at_distance(0.0, closest.scaled_distance * (1 - 1e-12), branch)
    near = roche.at_distance(0.0, closest.scaled_distance * (1 + 1e-10), branch)
    assert (near.c_over_a > closest.c_over_a) == (branch == "stable")


def test_least_energy_and_least_angular_momentum_coincide():
    """Found from J alone; the slope of E there, by differences of separate solutions, is zero as well."""
    gap = darwin.secular_limit().gap
    step = 1e-4
    rise = darwin.from_gap(gap + step).orbital_energy - darwin.from_gap(gap - step).orbital_energy
    steep = darwin.from_gap(1.2).orbital_energy - darwin.from_gap(1.2 - 2 * step).orbital_energy
    assert abs(rise) < 1e-6 * abs(steep)
