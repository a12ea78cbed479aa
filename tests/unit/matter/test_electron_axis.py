"""A table along its electron fractions: a spline that differentiates to P and mu, and is that of the exact matter."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.errors import SceneError
from astroinertia.matter.electron_axis import along_electrons, electron_axis
from tests import synthetic_table as exact

REFERENCE = 1e13  # kg/m^3
DENSITY = np.geomspace(3e9, 3e17, 60)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return exact.write(tmp_path_factory.mktemp("table") / "exact.h5")


@pytest.fixture(scope="module")
def axis(path):
    return electron_axis(path, REFERENCE, (0.278, 0.47))


def fermi_energy(density, fraction):
    """What one electron more costs a nucleon, J/kg: m_e c^2 ((1 + x^2)^(1/2) - 1)."""
    x = exact._momentum(density, fraction)
    return exact.ELECTRON_MASS * exact.SPEED_OF_LIGHT**2 * (np.sqrt(1 + x**2) - 1) / exact.ATOMIC_MASS


@pytest.mark.slow
@pytest.mark.parametrize("fraction", [0.278, 0.3333, 0.41, 0.47])
def test_it_is_worth_what_the_matter_is(axis, fraction):
    """P lost between two fractions, at any temperature, u and mu: to 2e-6 (of P) and 2e-5 from 3e9 to 3e17 kg/m^3.

    Only electrons know the fraction here, so that what P and u lose is the same at every temperature.
    """
    energy, pressure, potential = axis.worth(np, DENSITY, np.full_like(DENSITY, fraction))
    full_energy, full_pressure, _ = axis.worth(np, DENSITY, 0.47)
    lost = [f(DENSITY, 3.0, fraction) - f(DENSITY, 3.0, 0.47) for f in (exact.pressure, exact.energy)]
    cold = exact.pressure(DENSITY, 1e-6, 0.47)
    assert np.abs((pressure - full_pressure - lost[0]) / cold).max() < 2e-6
    assert np.abs((energy - full_energy - lost[1]) / exact.energy(DENSITY, 1e-6, 0.47)).max() < 2e-5
    np.testing.assert_allclose(potential, fermi_energy(DENSITY, fraction), rtol=2e-5)


@pytest.mark.slow
def test_pressure_and_potential_are_slopes_of_one_energy(axis):
    """P = rho^2 df/drho, mu = df/dY and so Maxwell's relation dP/dY = rho^2 dmu/drho, beyond it as well."""
    tables = (axis.coefficients, axis.numbers, float(axis.rows), float(axis.columns))
    with jax.enable_x64(True):
        tables = tuple(jnp.asarray(each) for each in tables)

        @jax.jit
        def values_and_slopes(density, fraction):
            def found(*at):
                return jnp.stack(along_electrons(jnp, *at, *tables))

            return found(density, fraction), *jax.jacfwd(found, argnums=(0, 1))(density, fraction)

        for density in (1e7, 3e12, 2.2e16, 1e19):
            for fraction in (0.2, 0.3, 0.411, 0.5):
                value, by_density, by_fraction = (np.asarray(each) for each in values_and_slopes(density, fraction))
                assert value[1] == pytest.approx(density**2 * by_density[0], rel=1e-12)
                assert value[2] == pytest.approx(by_fraction[0], rel=1e-12)
                assert by_fraction[1] == pytest.approx(density**2 * by_density[2], rel=1e-9)


def test_units_do_not_matter(axis):
    other = axis.in_units(1e13, 5e12).worth(np, DENSITY / 1e13, 0.4)
    for found, own, unit in zip(other, axis.worth(np, DENSITY, 0.4), (5e12, 5e25, 5e12), strict=True):
        np.testing.assert_allclose(found * unit, own, rtol=1e-11)


@pytest.mark.parametrize(
    ("reference", "fractions", "words"),
    [
        (REFERENCE, (0.05, 0.47), "electron fractions from 0.1 to 0.5, not from 0.05 to 0.47"),
        (REFERENCE, (0.47, 0.278), "must rise, not go from 0.47 to 0.278"),
        (1e30, (0.278, 0.47), "is not among those of"),
    ],
)
def test_what_the_table_has_not_is_refused(path, reference, fractions, words):
    with pytest.raises(SceneError, match=words):
        electron_axis(path, reference, fractions)
