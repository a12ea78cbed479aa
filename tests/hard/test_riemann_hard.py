"""Riemann ellipsoids, their modes and cold spheroids where axes vanish, branches meet or a body is almost a sphere."""

import math

import numpy as np
import pytest

from astroinertia.bodies import jacobi, maclaurin, riemann, roche
from astroinertia.bodies.cold_spheroid import ColdSpheroid
from astroinertia.bodies.ellipsoid_gravity import gravitational_energy, index_integral, index_symbols
from astroinertia.bodies.ellipsoid_secular import radiative_modes, viscous_modes
from astroinertia.bodies.ellipsoid_stability import onset, spectrum

VORTICITIES = [0.0, 0.5, 2.0, 2.0 + 1e-9, 5.0, 1e12, math.inf, -0.5, -2.0 + 1e-9, -2.0, -2.0 - 1e-9, -10.0, -1e12]


def _imbalance(body):
    """The three forces along the axes, each times its axis, in units of the largest of gravity's: equal in balance."""
    a, b, c = body.axes / body.equatorial_radius
    one, other = math.sqrt(body.omega2), body.internal_rate
    pull = 2 * index_symbols([a, b, c]) * [a * a, b * b, c * c]
    centrifugal = (one**2 + other**2) * np.array([a * a, b * b, 0]) + 2 * a * b * one * other * np.array([1, 1, 0])
    forces = pull - centrifugal
    return abs(forces - forces[2]).max(), pull.max(), pull[2]


@pytest.mark.parametrize("ratio", [1.0, 1 - 1e-15, 1 - 1e-9, 0.999, 0.5, 1e-2, 1e-5, 1e-8])
@pytest.mark.parametrize("f", VORTICITIES)
def test_equilibria_from_spheres_to_needles(ratio, f):
    body = riemann.from_vorticity_ratio(ratio, f)
    left, gravity, pole = _imbalance(body)
    assert left < 2e-15 * gravity
    assert left < 1e-13 * pole  # even of the pressure, which is a share b^2/a^2 of gravity's work along a needle
    if math.isfinite(f):
        assert body.vorticity_ratio == pytest.approx(f, rel=4e-15)
    assert ratio <= 0.99 or f > -1 or body.c_over_a > 0.58


def test_irrotational_and_dedekind_limits_are_approached_evenly():
    """Next to f = -2 and f = infinity nothing jumps."""
    for ratio in (0.9, 0.1):
        middle = riemann.irrotational(ratio)
        for step in (1e-6, -1e-6):
            near = riemann.from_vorticity_ratio(ratio, -2 + step)
            assert near.circulation / near.axes[:2].prod() == pytest.approx(
                math.pi * step * near.angular_velocity, rel=1e-8
            )
            assert near.c_over_a == pytest.approx(middle.c_over_a, rel=1e-6)
        far = riemann.from_vorticity_ratio(ratio, 1e15)
        assert far.c_over_a == pytest.approx(riemann.dedekind(ratio).c_over_a, rel=1e-14)


@pytest.mark.parametrize("step", [1e-3, 1e-6, 1e-9])
def test_branches_leave_the_spheroids_smoothly(step):
    """At fixed f the momentum changes with (1 - b/a)^2 only, and the self-adjoint figures end on the sphere."""
    for f in (0.0, 0.8, -1.0, math.inf):
        one, spheroid = riemann.from_vorticity_ratio(1 - step, f), riemann.from_vorticity_ratio(1.0, f)
        assert abs(one.kinetic_energy / spheroid.kinetic_energy - 1) < 5 * step**2 + 1e-14
    figure = riemann.from_rate_ratio(1 - step, -1.0)
    assert 1 - step < figure.c_over_a < 1 and 1 - figure.c_over_a == pytest.approx(step / 2, rel=2 * step + 1e-6)


@pytest.mark.full
def test_needles_swing_like_cylinders():
    """sigma^2 = 2 pi G rho (m - 1) of a liquid cylinder for m = 2 (Chandrasekhar 1961, section 108)."""
    for ratio in (1e-3, 1e-4, 1e-6):
        found = spectrum(jacobi.from_axis_ratio(ratio))
        unit = math.pi * jacobi.from_axis_ratio(ratio).density
        assert found.is_stable and min(abs(found.even / unit + 2.0)) < 30 * ratio**2 + 1e-14


def test_second_harmonics_of_extreme_spheroids():
    """From e = 1e-6 to discs of axis ratio 1e-6 the growth of bars is the closed form's."""
    for l in (1e-6, 1e-3, 1.0, 3.2, 100.0, 1e4, 1e6):  # noqa: E741
        body = maclaurin.from_second_eccentricity(l)
        q = 1 / (1 + l * l)
        square = body.omega2 - 4 * float(index_integral((1.0, 1.0, q), (0, 1), 1))
        exact = math.sqrt(max(0.0, square) * math.pi * body.density)
        assert spectrum(body).growth_rate == pytest.approx(exact, rel=1e-10)


def test_friction_next_to_the_fork():
    """Both frictions change their sign at the fork, one as a fifth power: even a rate of 1e-37 has the right one."""
    fork = maclaurin.bifurcation()
    for step in (1e-4, 1e-7, -1e-7, -1e-4):
        body = maclaurin.from_second_eccentricity(fork.second_eccentricity * (1 + step))
        slow = abs(body.bar_mode_frequencies[0] - body.bar_mode_frequencies[1]) / 2
        apart = body.angular_velocity - slow
        viscous, radiative = viscous_modes(body, 1.0).changes.real.max(), radiative_modes(body, 1.0).changes.real.max()
        radius = body.equatorial_radius
        assert viscous == pytest.approx(5 / radius**2 * apart / slow, rel=1e-7)
        assert radiative == pytest.approx(2 / 25 * radius**2 * apart**5 / slow, rel=1e-6)
        assert math.copysign(1, viscous) == math.copysign(1, radiative) == math.copysign(1, step)


@pytest.mark.full
@pytest.mark.parametrize("ratio", [1e-6, 1e4, 1e8])
def test_roche_bodies_of_any_mass_lose_stability_beyond_the_limit(ratio):
    limit = roche.limit(ratio)
    share = onset(lambda c: roche.from_axis_ratio(ratio, c), 0.3, limit.c_over_a)
    assert share < limit.c_over_a


@pytest.mark.parametrize("apart", [1e-3, 1e-6, 1e-9, 1e-12, -1e-3, -1e-6, -1e-9, -1e-12])
def test_almost_spherical_collapse(apart):
    """A body that is round to 1e-12 ends 1e-12 across, and its motion keeps the energy, of 1e12 times what it had."""
    body = ColdSpheroid(1.0, 1 - apart)
    end = body.collapse()
    assert end.kind == ("pancake" if apart > 0 else "spindle")
    across = (end.equatorial_radius + end.polar_radius) / abs(apart)
    assert 1 < across < 10
    assert end.time == pytest.approx(body.free_fall_time, abs=abs(apart) ** 1.4 + 1e-14)
    if end.kind == "pancake":
        kinetic = (2 * end.equatorial_rate**2 + end.polar_rate**2) / 10
        potential = -0.3 * math.pi / end.equatorial_radius
        assert kinetic + potential == pytest.approx(gravitational_energy([1.0, 1.0, 1 - apart]), abs=1e-9 * kinetic)


def test_collapse_grows_anisotropic_as_linear_theory_says():
    """The axis left is the first difference times a power of it that is the same for each decade."""
    left = [ColdSpheroid(1.0, 1 - 10.0**-k).collapse().equatorial_radius * 10.0**k for k in (8, 9, 10, 11)]
    steps = np.diff(np.log(left))
    np.testing.assert_allclose(steps, steps[0], rtol=1e-4)


@pytest.mark.parametrize(
    ("polar", "rate"), [(2.0, 1e-12), (2.0, 1e-6), (20.0, 0.1), (1e-4, 0.0), (1e3, 0.0), (1.0, 30.0)]
)
def test_bounces_needles_and_discs(polar, rate):
    """The least rotation turns a spindle into a bounce and then a pancake; sheets and rods fall as they should."""
    body = ColdSpheroid(1.0, polar, rate)
    end = body.collapse()
    assert end.kind == ("pancake" if rate or polar < 1 else "spindle")
    if end.kind == "pancake":
        energy = gravitational_energy([1.0, 1.0, polar]) + 0.2 * rate**2
        kinetic = (2 * end.equatorial_rate**2 + end.polar_rate**2) / 10 + 0.2 * rate**2 / end.equatorial_radius**2
        kept = kinetic - 0.3 * math.pi / end.equatorial_radius
        assert kept == pytest.approx(energy, abs=1e-9 * kinetic)
    if polar == 1e-4:  # a sheet: c = c_0 - 3 G M t^2/(2 a^2)
        assert end.time == pytest.approx(math.sqrt(polar / 1.5), rel=2e-4)
    if polar == 1e3:  # a cylinder: t = a (pi/(2 lambda))^(1/2)/..., by its line density 3 M/(4 c)
        assert end.time == pytest.approx(math.sqrt(math.pi / 2) / math.sqrt(2 * 0.75 / polar), rel=2e-3)
