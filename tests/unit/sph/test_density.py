"""The density that the fluid uses: what a kernel counts too much of the particle itself is taken off."""

import numpy as np
import pytest

from astroinertia.engines.numba_cpu import Engine
from astroinertia.sph import profiles
from astroinertia.sph.density import density
from astroinertia.sph.kernels import KERNELS, self_excess
from astroinertia.sph.placement import place
from tests.pairs import BruteEngine


def solved(kernel, position, mass, engine, corrected=True):
    """The density of the fluid, or what the engine's plain sums give for the same smoothing condition."""
    eta = KERNELS[kernel].eta
    order, arrangement = engine.arrange(position, np.full(len(mass), 0.1))
    arguments = arrangement, kernel, position[order], mass[order], np.full(len(mass), 0.1), eta, 1e-12, True
    return order, density(engine, *arguments) if corrected else engine.density(*arguments)


@pytest.mark.full
@pytest.mark.parametrize("kernel", ["wendland_c2", "wendland_c4", "wendland_c6"])
def test_a_settled_body_has_its_density(kernel: str) -> None:
    """A glass of unit density, away from its surface: within 0.3 %, and nearer than the plain sum, 1 % too dense."""
    position = place(profiles.uniform(), 2000) * (3.0 / (4.0 * np.pi)) ** (1.0 / 3.0)
    mass, engine = np.full(2000, 1.0 / 2000), Engine()
    errors = []
    for corrected in (True, False):
        order, found = solved(kernel, position, mass, engine, corrected)
        inside = np.linalg.norm(position[order], axis=1) < 0.35
        errors.append(found.density[inside].mean() - 1.0)
    assert abs(errors[0]) < 3e-3, errors
    assert errors[1] - errors[0] > 1e-3, errors


@pytest.mark.parametrize("kernel", list(KERNELS))
def test_gradient_factors_belong_to_the_corrected_density(kernel: str) -> None:
    """Omega and zeta against differences of sum_j m_j W(r, h) - excess m/h^3 and of sum_j m_j phi(r, h) in h."""
    generator = np.random.default_rng(4)
    position, mass = generator.normal(size=(150, 3)), generator.uniform(0.5, 1.5, 150)
    shape = KERNELS[kernel]
    _, found = solved(kernel, position, mass, BruteEngine())
    h, excess = found.smoothing_length, self_excess(shape, shape.eta)
    r = np.linalg.norm(position[:, None] - position[None, :], axis=2)

    def rho(h):
        return (shape.w(np, r / h[:, None]) @ mass - excess * mass) / h**3

    def potential(h):
        return (shape.phi(np, r / h[:, None]) @ mass) / h

    step = 1e-5 * h
    slope = (rho(h + step) - rho(h - step)) / (2 * step)
    np.testing.assert_allclose(rho(h), found.density, rtol=1e-10)
    np.testing.assert_allclose(found.density, mass * (shape.eta / h) ** 3, rtol=1e-10)
    np.testing.assert_allclose(1 + h / (3 * rho(h)) * slope, found.grad_h, rtol=1e-7)
    potential_slope = (potential(h + step) - potential(h - step)) / (2 * step)
    np.testing.assert_allclose(-h / (3 * rho(h)) * potential_slope, found.zeta, rtol=1e-6)
