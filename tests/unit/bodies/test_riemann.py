"""Riemann ellipsoids against their equations of motion, known sequences, theorems and published numbers."""

import math

import jax
import numpy as np
import pytest

from astroinertia.bodies import affine_motion, jacobi, maclaurin, riemann
from astroinertia.bodies.ellipsoid_gravity import gravitational_energy
from astroinertia.errors import AstroinertiaError

SCALE = {"mass": 2.0, "mean_radius": 3.0, "gravitational_constant": 0.5}
TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


@pytest.fixture(scope="module")
def acceleration():
    """d2F/dt2 of a homogeneous incompressible body, compiled once."""

    @jax.jit
    def of(deformation, rate, energy, moment):
        return affine_motion.incompressible_acceleration(deformation, rate, energy, moment)

    def with_scale(body, time):
        energy = gravitational_energy(np.full(3, body.mean_radius), body.mass, body.gravitational_constant)
        with jax.enable_x64(True):
            arrays = (body.deformation(time), body.deformation_rate(time), energy, body.mass * body.mean_radius**2 / 5)
            return np.asarray(of(*arrays))

    return with_scale


@pytest.mark.parametrize("ratio", [1.0, 0.999999, 0.8, 0.3, 0.05])
@pytest.mark.parametrize("f", [0.0, 1.0, 2.0, 7.5, math.inf, -0.5, -1.999999, -2.0, -2.1, -40.0])
def test_figures_move_as_the_equations_say(acceleration, ratio, f):
    """F(t) with two steady rates solves Dirichlet's equations at any time: shape, both rates and their signs."""
    body = riemann.from_vorticity_ratio(ratio, f, **SCALE)
    one, other = body.angular_velocity, body.internal_angular_velocity
    for time in (0.0, 2.3):
        moved = body.deformation(time)
        exact = one**2 * TURN @ TURN @ moved + 2 * one * other * TURN @ moved @ TURN + other**2 * moved @ TURN @ TURN
        size = (body.axes / body.mean_radius).max() * (one**2 + other**2)
        assert np.abs(acceleration(body, time) - exact).max() < 1e-13 * size


def test_rate_of_deformation_is_its_derivative():
    body = riemann.from_vorticity_ratio(0.6, -1.0)
    step = 1e-5
    slope = (body.deformation(0.7 + step) - body.deformation(0.7 - step)) / (2 * step)
    np.testing.assert_allclose(body.deformation_rate(0.7), slope, atol=1e-10)


def test_sequences_meet_the_ones_known():
    for ratio in (1.0, 0.9, 0.4, 0.01):
        body, known = riemann.from_vorticity_ratio(ratio, 0.0), jacobi.from_axis_ratio(ratio)
        assert body.c_over_a == pytest.approx(known.c_over_a, rel=4e-15)
        assert body.omega2 == pytest.approx(known.omega2, rel=4e-15)
        assert body.kinetic_energy == pytest.approx(known.kinetic_energy, rel=4e-15)
        dedekind = riemann.dedekind(ratio)
        assert dedekind.angular_velocity == 0 and dedekind.c_over_a == body.c_over_a
        assert dedekind.internal_rate == pytest.approx(math.sqrt(known.omega2), rel=4e-15)
    assert riemann.from_rate_ratio(1.0, 1.0).eccentricity == pytest.approx(0.952886702034254, abs=1e-15)
    assert riemann.from_rate_ratio(1.0, 0.0).eccentricity == pytest.approx(0.812670010611743, abs=1e-15)
    sphere = riemann.irrotational(1.0)
    assert sphere.c_over_a == 1 and sphere.angular_momentum == pytest.approx(0, abs=1e-15)
    one = riemann.from_rate_ratio(1.0, 0.4)  # a spheroid, whose two rates are one rotation
    whole = maclaurin.from_axis_ratio(one.c_over_a)
    assert one.angular_momentum == pytest.approx(whole.angular_momentum, rel=1e-14)
    assert one.rotational_to_gravitational == pytest.approx(whole.rotational_to_gravitational, rel=1e-14)


def test_adjoint_exchanges_momentum_and_circulation():
    """Dedekind's theorem; the circulation is in the units of L when multiplied by M/(5 pi)."""
    for f in (-5.0, -1.0, 0.7):
        body = riemann.from_vorticity_ratio(0.55, f, **SCALE)
        adjoint = body.adjoint
        sign = math.copysign(1.0, f)  # turned about, if need be, for a positive Omega
        assert adjoint.angular_momentum == pytest.approx(sign * body.mass / (5 * math.pi) * body.circulation, rel=1e-14)
        assert adjoint.kinetic_energy == pytest.approx(body.kinetic_energy, rel=1e-14)
        assert adjoint.adjoint.angular_momentum == pytest.approx(body.angular_momentum, rel=1e-14)
        assert adjoint.vorticity_ratio == pytest.approx((0.55 + 1 / 0.55) ** 2 / f, rel=1e-14)


@pytest.mark.parametrize("f", [-3.0, -2.0, -0.5, 0.0, 1.5])
def test_energy_changes_with_momentum_and_circulation(f):
    """dE = Omega dL + Lambda d(M C/(5 pi)) along any sequence, from the variational principle of the figures."""

    def state(ratio):
        body = riemann.from_vorticity_ratio(ratio, f)
        return np.array([body.total_energy, body.angular_momentum, body.circulation / (5 * math.pi)])

    step, middle = 1e-4, 0.6
    change = (
        8 * (state(middle + step) - state(middle - step)) - state(middle + 2 * step) + state(middle - 2 * step)
    ) / 12
    body = riemann.from_vorticity_ratio(middle, f)
    expected = body.angular_velocity * change[1] + body.internal_angular_velocity * change[2]
    assert change[0] == pytest.approx(expected, rel=1e-9)


def test_both_ways_of_naming_a_figure_agree():
    for x in (-0.9, -0.2, 0.0, 0.6):
        body = riemann.from_rate_ratio(0.7, x, **SCALE)
        again = riemann.from_axis_ratios(0.7, body.c_over_a, **SCALE)
        assert again.angular_velocity == pytest.approx(body.angular_velocity, rel=1e-13)
        assert again.internal_rate == pytest.approx(body.internal_rate, abs=1e-13)
        other = riemann.from_axis_ratios(0.7, body.c_over_a, "adjoint", **SCALE)
        assert other.angular_velocity == pytest.approx(abs(body.internal_angular_velocity), abs=1e-13)
    figures = [riemann.from_vorticity_ratio(b, -2.0) for b in (0.9, 0.5)]
    assert [each.vorticity_ratio for each in figures] == pytest.approx([-2.0, -2.0], rel=1e-14)
    assert [each.circulation for each in figures] == pytest.approx([0.0, 0.0], abs=1e-14)
    assert all(each.b_over_a < each.c_over_a < 1 for each in figures)  # irrotational ones are longest, then highest
    assert figures[0].vorticity == pytest.approx(0, abs=1e-14)


@pytest.mark.parametrize(
    ("momentum", "flow"),
    [
        (0.3, 0.2),
        (0.3, 0.2999999),
        (0.3, 0.3),
        (0.6, 0.6),
        (0.1, 0.4),
        (-0.4, 0.1),
        (0.0, 0.3),
        (0.2, 0.0),
        (1e-4, 0.0),
    ],
)
def test_figure_of_given_momentum_and_circulation(momentum, flow):
    """Both come out, but for a common sign, and no ellipsoid near it that keeps both has less energy."""
    unit = math.sqrt(0.5 * 2.0**3 * 3.0)
    body = riemann.from_invariants(momentum * unit, flow * unit * 5 * math.pi / 2.0, **SCALE)
    found = body.angular_momentum / unit, body.mass * body.circulation / (5 * math.pi) / unit
    assert [abs(each) for each in found] == pytest.approx([abs(momentum), abs(flow)], abs=1e-14)
    assert found[0] * found[1] == pytest.approx(momentum * flow, abs=1e-14)

    def energy(b, c):
        a, b, c = np.array([1.0, b, c]) / (b * c) ** (1 / 3)
        both = (momentum + flow) ** 2 / (a + b) ** 2 + ((momentum - flow) / (a - b)) ** 2 if momentum != flow else (
            2 * momentum / (a + b)
        ) ** 2  # fmt: skip
        return 1.25 * both + gravitational_energy([a, b, c])

    least = energy(body.b_over_a, body.c_over_a)
    assert least == pytest.approx(body.total_energy / (0.5 * 2.0**2 / 3.0), rel=1e-12)
    gap = 1e-3 * max(1 - body.b_over_a, 1e-2)
    for step in ((-gap, 0), (gap if body.b_over_a < 1 else 0, 0), (0, 1e-4), (0, -1e-4), (-gap, -1e-4), (-gap, 1e-4)):
        if any(step):
            assert energy(body.b_over_a + step[0], body.c_over_a + step[1]) > least


def test_published_figure():
    """b/a = 0.41, c/a = 0.385 in Ou 2006, ApJ 639, 549: 0.547874 and 0.079886 in (pi G rho)^(1/2)."""
    body = riemann.from_axis_ratios(0.41, 0.385)
    assert math.sqrt(body.omega2) == pytest.approx(0.547874, abs=5e-7)
    assert abs(body.internal_rate) == pytest.approx(0.079886, abs=5e-7)


def test_central_pressure_holds_the_pole_up():
    """Hydrostatic equilibrium along the axis: p_c is the weight of the column, from the energy tensor."""
    body = riemann.from_rate_ratio(0.5, -0.5, **SCALE)
    alone = maclaurin.from_eccentricity(0.0, **SCALE)
    uniform = 3 * SCALE["gravitational_constant"] * SCALE["mass"] ** 2 / (8 * math.pi * SCALE["mean_radius"] ** 4)
    sphere = riemann.RiemannEllipsoid(1.0, 1.0, 0.0, **SCALE)
    assert sphere.central_pressure == pytest.approx(uniform, rel=1e-14)
    assert alone.density == body.density
    # scalar virial theorem: 2 T + W + 3 (2/5) p_c V = 0
    volume = body.mass / body.density
    total = 2 * body.kinetic_energy + body.gravitational_energy + 1.2 * body.central_pressure * volume
    assert total == pytest.approx(0, abs=1e-14 * abs(body.gravitational_energy))


def test_what_does_not_exist_is_refused():
    with pytest.raises(ValueError, match=r"c/a from 0\.207978.* to 0\.639930"):
        riemann.from_axis_ratios(0.5, 0.2)
    for call in (
        lambda: riemann.from_axis_ratios(0.5, 0.4, "third"),  # type: ignore[arg-type]
        lambda: riemann.from_axis_ratios(1.5, 0.4),
        lambda: riemann.from_vorticity_ratio(0.0, 1.0),
        lambda: riemann.from_vorticity_ratio(0.5, math.nan),
        lambda: riemann.from_rate_ratio(0.5, math.nan),
        lambda: riemann.dedekind(0.5, mass=-1.0),
        lambda: riemann.from_invariants(math.inf, 0.0),
        lambda: riemann.from_invariants(1e9, 0.0),
    ):
        with pytest.raises((ValueError, AstroinertiaError)):
            call()
