"""Linear modes against the full equations of motion: their automatic derivatives, and small motions in time."""

import itertools
import math
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.bodies import affine_motion, ellipsoid_secular, ellipsoid_stability, jacobi, maclaurin, riemann, roche
from astroinertia.bodies.bar_analysis import bar_history, growth_rate
from astroinertia.engines.adaptive import advance

ENERGY, MOMENT = -0.8, 0.2  # of the sphere with M = R = 1 and pi G rho = 1
TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
GRAVITY = 4 / 3  # G with these


def _force(deformation, rate, tide, viscosity):
    others = MOMENT * tide[:, None] * deformation + affine_motion.shear_force(deformation, rate, viscosity)
    return affine_motion.incompressible_acceleration(deformation, rate, ENERGY, MOMENT, others)


def _in_frame(shape, rate, turning, internal, tide, viscosity):
    """d2G/dt2 of x = R(Omega t) G R(Lambda t) X."""
    whole = rate + turning * TURN @ shape + internal * shape @ TURN
    frame = turning**2 * TURN @ TURN @ shape + 2 * turning * internal * TURN @ shape @ TURN
    frame = frame + internal**2 * shape @ TURN @ TURN + 2 * (turning * TURN @ rate + internal * rate @ TURN)
    return _force(shape, whole, tide, viscosity) - frame


@cache
def _derivatives():
    return jax.jit(jax.jacfwd(_in_frame, argnums=(0, 1)))


def _jacobian(body, viscosity=0.0):
    """The whole Jacobian (16, 16) on displacements that keep the volume, the axes, and the basis (9, 8) of those."""
    frame = ellipsoid_stability.steady_frame(body)
    with jax.enable_x64(True):
        shape = jnp.diag(jnp.asarray(frame.axes))
        tide = jnp.asarray(frame.tide)
        slopes = _derivatives()(shape, 0 * shape, frame.turning, frame.internal, tide, jnp.float64(viscosity))
    stiffness, gyration = (np.asarray(each).reshape(9, 9) for each in slopes)
    normal = np.diag(1 / frame.axes).ravel()  # the gradient of det G
    basis = np.linalg.svd(normal[None])[2][1:].T
    whole = np.block([[np.zeros((8, 8)), np.eye(8)], [basis.T @ stiffness @ basis, basis.T @ gyration @ basis]])
    return whole, frame.axes, basis


def _all_rates(body, viscosity=0.0):
    """Its eigenvalues, in (pi G rho)^(1/2)."""
    return np.linalg.eigvals(_jacobian(body, viscosity)[0])


FIGURES = {
    "maclaurin": maclaurin.from_eccentricity(0.7),
    "unstable maclaurin": maclaurin.from_eccentricity(0.97),
    "jacobi": jacobi.from_axis_ratio(0.5),
    "riemann": riemann.from_vorticity_ratio(0.6, -0.7),
    "unstable riemann": riemann.from_rate_ratio(0.2, -0.9),
    "roche": roche.from_axis_ratio(1.0, 0.55),
    "unstable roche": roche.from_axis_ratio(0.0, 0.4),
}


@pytest.mark.full
@pytest.mark.parametrize("name", FIGURES)
def test_spectrum_is_that_of_the_jacobian(name):
    body = FIGURES[name]
    found = ellipsoid_stability.spectrum(body)
    unit = math.pi * body.density
    rates = np.sqrt(np.concatenate([found.even, found.odd]) / unit)
    whole = _all_rates(body)
    for rate in np.concatenate([rates, -rates]):
        assert min(abs(whole - rate)) < 3e-7  # the Jacobian's own zeros are defective: good to the root of round-off
    assert whole.real.max() == pytest.approx(found.growth_rate / math.sqrt(unit), abs=3e-7)
    if found.growth_rate:
        assert whole.real.max() == pytest.approx(found.growth_rate / math.sqrt(unit), rel=1e-9)


@pytest.mark.full
@pytest.mark.parametrize("name", ["maclaurin", "jacobi", "roche"])
def test_viscous_changes_are_those_of_the_jacobian(name):
    body, viscosity = FIGURES[name], 1e-5
    found = ellipsoid_secular.viscous_modes(body, viscosity * math.sqrt(math.pi * body.density))
    shifted = (found.rates + found.changes) / math.sqrt(math.pi * body.density)
    whole = _all_rates(body, viscosity)
    for rate in shifted[shifted.real < 0]:
        assert min(abs(whole - rate), abs(whole - rate.conjugate()), key=np.min).min() < 2e-8  # second order: 3e-9


@pytest.mark.parametrize(
    "body", [maclaurin.from_eccentricity(0.9), riemann.dedekind(0.5)], ids=["spheroid", "dedekind"]
)
def test_radiative_changes_are_those_of_the_whole_problem(body):
    """With the fifth derivative of the quadrupole along the motion without it, a linear function of the state."""
    whole, axes, basis = _jacobian(body)
    coupling = 1e-7  # (2/5) G/c^5 M R^2/5
    shape = np.diag(axes)
    pull = np.zeros((8, 16))
    fifth = np.linalg.matrix_power(whole, 5)[:8]
    for k in range(16):
        moved = (basis @ fifth[:, k]).reshape(3, 3)
        moment = moved @ shape + shape @ moved.T
        pull[:, k] = basis.T @ (-coupling * (moment - np.trace(moment) / 3 * np.eye(3)) @ shape).ravel()
    rates = np.linalg.eigvals(whole + np.vstack([np.zeros((8, 16)), pull]))
    unit = math.sqrt(math.pi * body.density)
    speed = (2 / 25 * unit**3 / coupling) ** 0.2
    found = ellipsoid_secular.radiative_modes(body, speed)
    for rate, change in zip(found.rates / unit, found.changes / unit, strict=True):
        closest = min(rates, key=lambda each: min(abs(each - rate), abs(each.conjugate() - rate)))
        assert closest.real == pytest.approx(change.real, rel=1e-4, abs=1e-13)


def _rate(_time, state, arguments):
    deformation, rate = state
    tide, turning, viscosity = arguments
    angle = turning * _time
    cosine, sine = jnp.cos(angle), jnp.sin(angle)
    axis = jnp.array([cosine, sine, 0.0])
    strength = tide * (3 * jnp.outer(axis, axis) - jnp.eye(3))
    shear = affine_motion.shear_force(deformation, rate, viscosity)
    others = MOMENT * strength @ deformation + shear
    return rate, affine_motion.incompressible_acceleration(deformation, rate, ENERGY, MOMENT, others)


def _follow(deformation, rate, times, tide=0.0, turning=0.0, viscosity=0.0):
    """F and dF/dt at times, with a companion that circles."""
    with jax.enable_x64(True):
        state = jnp.asarray(deformation), jnp.asarray(rate)
        arguments = jnp.float64(tide), jnp.float64(turning), jnp.float64(viscosity)
        history = []
        for begin, end in itertools.pairwise(times):
            done = advance(_rate, arguments, state, begin, end, 0.05, 1e-11, 1e-12)
            assert not done.failed
            state = done.state
            history.append((np.asarray(state[0]), np.asarray(state[1])))
    return (np.array(each) for each in zip(*history, strict=True))


@pytest.mark.parametrize(("ratio", "f"), [(0.6, -0.7), (0.8, -2.0), (0.5, math.inf), (0.7, 3.0)])
def test_equilibria_stay_put(ratio, f):
    """Over about four turns of the figure or of its fluid, to what the steps allow."""
    body = riemann.from_vorticity_ratio(ratio, f, gravitational_constant=GRAVITY)
    end = 25 / max(body.angular_velocity, abs(body.internal_angular_velocity))
    moved, rate = _follow(body.deformation(), body.deformation_rate(), [0.0, end])
    np.testing.assert_allclose(moved[-1], body.deformation(end), atol=1e-9)
    np.testing.assert_allclose(rate[-1], body.deformation_rate(end), atol=1e-9)


@pytest.mark.full
def test_a_bar_grows_as_fast_as_the_spectrum_says():
    """A spheroid of e = 0.97 disturbed by 1e-7: the bar grows exponentially up to one that is far from small."""
    body = maclaurin.from_eccentricity(0.97)
    shape = np.diag(body.axes) @ np.diag([1 + 1e-7, 1 - 1e-7, 1.0])
    turning = math.sqrt(body.omega2)
    times = np.linspace(0, 130, 131)
    moved, rate = _follow(shape, turning * TURN @ shape, times)
    seen = bar_history(moved, rate, gravitational_constant=GRAVITY)
    expected = ellipsoid_stability.spectrum(body).growth_rate / math.sqrt(math.pi * body.density)
    assert growth_rate(times[1:], seen.bar_strength, 3e-6, 3e-4) == pytest.approx(expected, rel=2e-3)
    assert seen.bar_strength.max() > 0.3
    late = (seen.bar_strength > 1e-5) & (seen.bar_strength < 1e-3)
    np.testing.assert_allclose(seen.pattern_speed[late], turning / 2, rtol=1e-3)  # lambda = -i Omega + growth
    np.testing.assert_allclose(seen.angular_momentum[:, 2], seen.angular_momentum[0, 2], rtol=1e-9)
    np.testing.assert_allclose(seen.circulation[:, 2], seen.circulation[0, 2], rtol=1e-9)


def test_roche_limit_tells_which_satellites_come_apart():
    """Released as the last stable ellipsoid into a tide 1% stronger or weaker than at the limit, with viscosity."""
    limit = roche.limit(0.0)
    shape = np.diag(limit.axes)
    longest = []
    for factor in (0.98, 1.02):
        tide = factor * limit.tide
        turning = math.sqrt(tide)
        moved, _ = _follow(shape, turning * TURN @ shape, [0.0, 40.0, 80.0], tide, turning, 0.01)
        longest.append(float(np.linalg.svd(moved[-1])[1][0]) / limit.axes[0])
    assert longest[0] < 1.05 and longest[1] > 2
