"""Kernels: normalisation, derivatives, softened potentials against the mass integral and exact rationals."""

import ast
import inspect
import itertools
import math
from fractions import Fraction

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.sph import kernels
from astroinertia.sph.kernels import KERNELS, eta_for_neighbours, neighbour_number

# Knots of the piecewise polynomials; quadrature is exact between them.
KNOTS = {
    "cubic": (0, 1, 2),
    "quartic": (0, Fraction(1, 2), Fraction(3, 2), Fraction(5, 2)),
    "quintic": (0, 1, 2, 3),
    "wendland_c2": (0, 2),
    "wendland_c4": (0, 2),
    "wendland_c6": (0, 2),
}
NAMES = sorted(KERNELS)


def exact_w(name, q: Fraction) -> Fraction:
    """The value pi w(q) in exact rationals, from the textbook definitions."""
    if name in ("cubic", "quartic", "quintic"):
        order = {"cubic": 3, "quartic": 4, "quintic": 5}[name]
        scale = {"cubic": Fraction(1, 4), "quartic": Fraction(1, 20), "quintic": Fraction(1, 120)}[name]
        edge = Fraction(order + 1, 2)
        total = Fraction(0)
        for k in range(order + 1):
            total += (-1) ** k * math.comb(order + 1, k) * max(Fraction(0), edge - k - q) ** order
        return scale * total
    x = q / 2
    power, polynomial, scale = {
        "wendland_c2": (4, 1 + 4 * x, Fraction(21, 16)),
        "wendland_c4": (6, 1 + 6 * x + Fraction(35, 3) * x**2, Fraction(495, 256)),
        "wendland_c6": (8, 1 + 8 * x + 25 * x**2 + 32 * x**3, Fraction(1365, 512)),
    }[name]
    return scale * max(Fraction(0), 1 - x) ** power * polynomial


def nodes(order=12):
    """Gauss-Legendre nodes and weights on (0, 1): exact for polynomials of degree 23."""
    x, weight = np.polynomial.legendre.leggauss(order)
    return 0.5 * (x + 1.0), 0.5 * weight


def integral(function, name, low, high):
    """Integral between low and high by quadrature on each polynomial piece."""
    x, weight = nodes()
    total = 0.0
    edges = [float(k) for k in KNOTS[name]]
    for a, b in itertools.pairwise(edges):
        a, b = max(a, low), min(b, high)
        if b > a:
            total += (b - a) * np.sum(weight * function(a + (b - a) * x))
    return total


@pytest.mark.parametrize("name", NAMES)
def test_value_is_the_textbook_kernel(name):
    kernel = KERNELS[name]
    for numerator in range(4 * 16 + 1):
        q = Fraction(numerator, 16)
        expected = float(exact_w(name, q)) / math.pi
        assert kernel.w(np, float(q)) == pytest.approx(expected, rel=2e-15, abs=1e-16), q


@pytest.mark.parametrize("name", NAMES)
def test_mass_is_one_and_the_second_moment_is_what_is_stated(name):
    kernel = KERNELS[name]
    mass = integral(lambda s: 4 * np.pi * s**2 * kernel.w(np, s), name, 0.0, kernel.support)
    assert mass == pytest.approx(1.0, abs=4e-15)
    variance = integral(lambda s: 4 / 3 * np.pi * s**4 * kernel.w(np, s), name, 0.0, kernel.support)
    assert kernel.variance == pytest.approx(variance, rel=1e-13)


@pytest.mark.parametrize("name", NAMES)
def test_the_change_of_the_potential_with_h(name):
    """h^2 dphi/dh = -(phi + q dphi) is the integral of 4 pi w s from q to the support, where it vanishes."""
    kernel = KERNELS[name]
    q = np.linspace(0.0, 1.2 * kernel.support, 241)
    found = kernel.softening(np, q)
    assert np.max(np.abs(found + kernel.phi(np, q) + q * kernel.dphi(np, q))) < 1e-12  # of terms up to 300
    assert np.all(found[q >= kernel.support] == 0.0)
    for k in range(0, 200, 20):
        expected = integral(lambda s: 4 * np.pi * s * kernel.w(np, s), name, q[k], kernel.support)
        assert found[k] == pytest.approx(expected, rel=1e-11, abs=1e-16)


@pytest.mark.full
@pytest.mark.parametrize("name", NAMES)
def test_derivatives_match_automatic_differentiation(name):
    kernel = KERNELS[name]
    with jax.enable_x64(True):
        q = jnp.linspace(0.0, 1.2 * kernel.support, 1201)
        slope = jax.vmap(jax.grad(lambda x: kernel.w(jnp, x)))(q)
        curvature = jax.vmap(jax.grad(lambda x: kernel.dw(jnp, x)))(q)
        gradient = jax.vmap(jax.grad(lambda x: kernel.phi(jnp, x)))(q)
        second = jax.vmap(jax.grad(lambda x: kernel.dphi(jnp, x)))(q)
        # Poisson's equation: (q^2 phi')' = 4 pi q^2 w, so phi'' = 4 pi w - 2 phi'/q
        safe = jnp.maximum(q, 1e-6)
        poisson = 4 * jnp.pi * kernel.w(jnp, q) - 2 * kernel.dphi(jnp, q) / safe
        assert np.max(np.abs(slope - kernel.dw(jnp, q))) < 1e-13
        smooth = np.min(np.abs(np.asarray(q)[:, None] - np.array([float(knot) for knot in KNOTS[name]])), axis=1) > 1e-9
        assert np.max(np.abs(curvature - kernel.d2w(jnp, q))[smooth]) < 1e-13
        assert np.max(np.abs(gradient - kernel.dphi(jnp, q))) < 1e-13
        assert np.max(np.abs(second - poisson)[q > 0.01]) < 1e-12


@pytest.mark.parametrize("name", NAMES)
def test_potential_is_that_of_the_kernels_mass(name):
    """It has phi' = M(q)/q^2 and phi = -M/q - 4 pi int_q w s ds, to 1e-14 relative, from the origin to the support."""
    kernel = KERNELS[name]
    for q in np.concatenate([np.geomspace(1e-3, 0.1, 7), np.linspace(0.1, kernel.support, 41)]):
        mass = integral(lambda s: 4 * np.pi * s**2 * kernel.w(np, s), name, 0.0, q)
        shell = integral(lambda s: 4 * np.pi * s * kernel.w(np, s), name, q, kernel.support)
        assert kernel.dphi(np, q) == pytest.approx(mass / q**2, rel=1e-14), q
        assert kernel.phi(np, q) == pytest.approx(-mass / q - shell, rel=1e-14), q


@pytest.mark.parametrize("name", NAMES)
def test_newtonian_outside_and_continuous_at_the_support(name):
    kernel = KERNELS[name]
    outside = np.array([kernel.support, 1.01 * kernel.support, 7.3, 1e3, 1e9])
    assert np.all(kernel.w(np, outside) == 0.0)
    assert np.all(kernel.dw(np, outside) == 0.0)
    assert np.max(np.abs(kernel.phi(np, outside) * outside + 1.0)) < 1e-15
    assert np.max(np.abs(kernel.dphi(np, outside) * outside**2 - 1.0)) < 1e-15
    for function in (kernel.w, kernel.dw, kernel.d2w, kernel.phi, kernel.dphi):
        for edge in (*KNOTS[name][1:], Fraction(3, 5)):
            below, above = float(edge) * (1 - 1e-15), float(edge) * (1 + 1e-15)
            assert abs(function(np, below) - function(np, above)) < 2e-14


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in ("cubic", "wendland_c2") else pytest.mark.full) for name in NAMES]
)
def test_finite_and_flat_at_the_origin(name):
    kernel = KERNELS[name]
    assert kernel.dw(np, 0.0) == pytest.approx(0.0, abs=1e-17)
    assert kernel.dphi(np, 0.0) == 0.0
    depth = integral(lambda s: 4 * np.pi * s * kernel.w(np, s), name, 0.0, kernel.support)
    assert kernel.phi(np, 0.0) == pytest.approx(-depth, rel=1e-14)
    with jax.enable_x64(True):
        for function in (kernel.w, kernel.dw, kernel.d2w, kernel.phi, kernel.dphi):
            for derivative in (jax.grad, lambda f: jax.grad(jax.grad(f))):
                assert np.isfinite(derivative(lambda x, f=function: f(jnp, x))(jnp.float64(0.0)))


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_single_precision_stays_single_and_accurate(name):
    kernel = KERNELS[name]
    with jax.enable_x64(True):
        q = jnp.linspace(0.0, 1.1 * kernel.support, 501)
        for function in (kernel.w, kernel.dw, kernel.d2w, kernel.phi, kernel.dphi):
            single = function(jnp, q.astype(jnp.float32))
            assert single.dtype == jnp.float32
            scale = float(jnp.max(jnp.abs(function(jnp, q))))
            assert float(jnp.max(jnp.abs(single - function(jnp, q)))) < 3e-6 * scale


def test_functions_can_be_compiled_from_their_source():
    """Only literals, arithmetic and the agreed functions of xp: no globals, no powers."""
    for kernel in KERNELS.values():
        for function in (kernel.w, kernel.dw, kernel.d2w, kernel.phi, kernel.dphi):
            tree = ast.parse(inspect.getsource(function))
            assert not any(isinstance(node, ast.Pow | ast.If | ast.IfExp) for node in ast.walk(tree))
            local = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
            assigned = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
            assert local - assigned <= {"xp", "q"}
            used = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
            assert used <= {"where", "maximum", "minimum", "abs", "sqrt"}
            assert getattr(kernels, function.__name__) is function


def test_neighbour_numbers():
    assert neighbour_number(KERNELS["cubic"], 1.2) == pytest.approx(57.9, abs=0.05)
    for kernel in KERNELS.values():
        assert eta_for_neighbours(kernel, neighbour_number(kernel, kernel.eta)) == pytest.approx(kernel.eta, rel=1e-14)
