"""Equations of state: thermodynamic identities, continuity, published constants, and both array namespaces."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.matter import cold_matter, gases

RHO = np.geomspace(0.05, 40.0, 401)
PIECES = cold_matter.piecewise_polytropic([0.3, 1.0, 5.0], [4 / 3, 1.6, 3.0, 2.2], 0.4)
HYBRID = cold_matter.hybrid(nuclear_density=2.0, gamma_1=1.31, gamma_2=2.5, gamma_thermal=1.5, constant=0.7)
EVERY = {
    "ideal": gases.ideal(5 / 3),
    "isothermal": gases.isothermal(0.3, reference_density=2.0),
    "polytropic": gases.polytropic(2.0, 0.6),
    "piecewise_polytropic": PIECES,
    "hybrid": HYBRID,
}
A = 0.1 + 0.05 * np.sin(RHO)


@pytest.mark.parametrize("kind", EVERY)
def test_first_law_and_sound_speed(kind):
    """P = rho^2 du/drho and c^2 = dP/drho at constant A, the derivatives by automatic differentiation."""
    equation = EVERY[kind]
    with jax.enable_x64(True):
        rho, entropy = jnp.asarray(RHO), jnp.asarray(A)
        slope = jax.vmap(jax.grad(lambda r, a: equation.internal_energy(jnp, r, a)))(rho, entropy)
        np.testing.assert_allclose(RHO**2 * np.asarray(slope), equation.pressure(np, RHO, A), rtol=1e-13)
        slope = jax.vmap(jax.grad(lambda r, a: equation.pressure(jnp, r, a)))(rho, entropy)
        np.testing.assert_allclose(np.sqrt(np.asarray(slope)), equation.sound_speed(np, RHO, A), rtol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("kind", EVERY)
def test_namespaces_agree_and_shapes_are_kept(kind):
    equation = EVERY[kind]
    with jax.enable_x64(True):
        for name in ("pressure", "internal_energy", "sound_speed", "entropy", "entropy_rate"):
            ours = getattr(equation, name)(np, RHO, A)
            theirs = jax.jit(lambda e, r, a, name=name: getattr(e, name)(jnp, r, a))(equation, RHO, A)
            assert ours.shape == RHO.shape
            np.testing.assert_allclose(ours, np.asarray(theirs), rtol=1e-14)


@pytest.mark.parametrize("kind", EVERY)
def test_entropy_inverts_internal_energy(kind):
    equation = EVERY[kind]
    entropy = equation.entropy(np, RHO, equation.internal_energy(np, RHO, A))
    np.testing.assert_allclose(entropy, A if equation.thermal else 0 * A, rtol=1e-12, atol=0)


@pytest.mark.parametrize("kind", EVERY)
def test_entropy_rate_is_the_rate_of_entropy_at_constant_density(kind):
    """Internal energy rises by q dt exactly as A rises by entropy_rate(q) dt; not at all in a barotrope."""
    equation, q, dt = EVERY[kind], 0.3 + 0 * RHO, 0.01
    rate = equation.entropy_rate(np, RHO, q)
    gained = equation.internal_energy(np, RHO, A + dt * rate) - equation.internal_energy(np, RHO, A)
    np.testing.assert_allclose(gained, q * dt if equation.thermal else 0 * q, rtol=1e-11)


@pytest.mark.parametrize(("equation", "edges"), [(PIECES, PIECES.densities), (HYBRID, (2.0,))])
def test_pieces_join(equation, edges):
    for edge in edges:
        below, above = np.array([np.nextafter(edge, 0)]), np.array([edge])
        for name in ("pressure", "internal_energy"):
            values = [getattr(equation, name)(np, rho, 0 * rho)[0] for rho in (below, above)]
            assert values[1] == pytest.approx(values[0], rel=1e-14)
        assert equation.sound_speed(np, above, 0 * above) != pytest.approx(equation.sound_speed(np, below, 0 * below))


def test_one_piece_is_a_polytrope():
    single, plain = cold_matter.piecewise_polytropic([], [1.7], 0.9), gases.polytropic(1.7, 0.9)
    np.testing.assert_array_equal(single.pressure(np, RHO, A), plain.pressure(np, RHO, A))


def test_cold_hybrid_matter_has_no_negative_entropy():
    too_cold = 0.5 * HYBRID.internal_energy(np, RHO, 0 * RHO)
    assert (HYBRID.entropy(np, RHO, too_cold) == 0).all()


def test_core_collapse_constants_hold_the_chandrasekhar_mass():
    """K = 4.897e14 cgs with gamma 4/3 is n = 3: M = 4 pi 2.01824 (K/pi G)^(3/2), Chandrasekhar's for Y_e = 1/2."""
    values = cold_matter.CORE_COLLAPSE
    constant = gases.polytropic_constant(values["reference_density"], values["reference_pressure"], 4 / 3)
    unit = Polytrope(3.0).constant  # K of M = 1 with G = 1: K = unit G M^(2/3)
    mass = (constant / (unit * 6.6743e-11)) ** 1.5
    assert mass / 1.98841e30 == pytest.approx(1.44, abs=0.01)


def test_core_collapse_constant_is_the_same_number_in_cgs_for_every_gamma():
    for gamma in (1.28, 1.31, 4 / 3):
        assert gases.polytropic_constant(1.0, 4.897e14, gamma) == 4.897e14
        si = gases.polytropic_constant(1.0e3, 4.897e13, gamma)
        assert si * 1.0e13**gamma == pytest.approx(0.1 * 4.897e14 * 1.0e10**gamma, rel=1e-12)


def test_gamma_is_differentiable():
    with jax.enable_x64(True):
        slope = jax.grad(lambda e: e.pressure(jnp, jnp.float64(2.0), jnp.float64(0.3)))(gases.ideal(1.4))
        assert float(slope.gamma) == pytest.approx(0.3 * 2**1.4 * np.log(2), rel=1e-14)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: gases.ideal(1.0), "above 1"),
        (lambda: gases.ideal(1.0 + 1e-9), "above 1, by 1e-06 at least"),
        (lambda: gases.ideal(float("nan")), "finite"),
        (lambda: gases.polytropic(2.0, -1.0), "constant must be positive"),
        (lambda: gases.isothermal(0.0), "sound_speed must be positive"),
        (lambda: cold_matter.piecewise_polytropic([1.0], [2.0], 1.0), "need 2 gammas"),
        (lambda: cold_matter.piecewise_polytropic([2.0, 1.0], [2.0, 2.0, 2.0], 1.0), "ascend"),
        (lambda: cold_matter.hybrid(2.0, 1.3, 2.5, 1.0, 1.0), "gamma_thermal must be above 1"),
    ],
)
def test_bad_parameters_get_one_sentence(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()
