"""The spin of a body that its rotation deforms, which a root gives, and its derivatives."""

from dataclasses import replace

import jax
import numpy as np
import pytest

from astroinertia.models.rigid import body as rigid

pytestmark = pytest.mark.usefixtures("float64")

M = np.array([0.3, -0.5, 1.7])
ELASTIC = rigid.body(2.0, [1.0, 2.0, 2.5], spin=0.6, deformability=0.4)


def spin(m, moments=ELASTIC.moments, deformability=ELASTIC.deformability):
    return rigid.spin_in_body(replace(ELASTIC, moments=moments, deformability=deformability), 0.0, m)


@pytest.mark.slow
def test_the_angular_momentum_is_that_of_the_deformed_body():
    turn = spin(M)
    assert rigid.inertia_in_body(ELASTIC, 0.0, turn) @ turn == pytest.approx(M, rel=1e-14)


@pytest.mark.full
def test_derivatives_are_those_of_differences():
    given, along = (M, ELASTIC.moments, 0.4), (np.array([0.2, 0.7, -0.4]), np.array([0.3, -0.1, 0.2]), 0.5)

    def at(share):
        return tuple(value + share * change for value, change in zip(given, along, strict=True))

    def slope(share):
        return jax.jvp(spin, at(share), along)[1]

    step = 1e-4
    difference = np.asarray(spin(*at(step)) - spin(*at(-step)))
    assert np.asarray(slope(0.0)) == pytest.approx(difference / (2.0 * step), rel=1e-7)
    second, difference = jax.jvp(slope, (0.0,), (1.0,))[1], np.asarray(slope(step) - slope(-step))
    assert np.asarray(second) == pytest.approx(difference / (2.0 * step), rel=1e-6)
    backwards = jax.grad(lambda *values: spin(*values).sum(), argnums=(0, 1, 2))(*given)
    total = sum(np.sum(np.asarray(part) * change) for part, change in zip(backwards, along, strict=True))
    assert total == pytest.approx(float(slope(0.0).sum()), rel=1e-12)
