"""Tabulated equations of state: exact thermodynamics whatever the table, what they tabulate, and their edges."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.engines.elementwise import Table, elementwise, totals
from astroinertia.matter import isentropes as tables, tillotson
from astroinertia.matter.interior import isentrope

IRON, ROCK = tillotson.IRON, tillotson.BASALT
GAMMA = 1.4


def gas(rho, u):
    """P of the ideal gas."""
    return (GAMMA - 1) * rho * u


def gas_table(nodes, span=(0.05, 20.0)):
    return tables.isentropes("gas", gas, 1.0, 1.0, span, 30.0, nodes=nodes, coldest=0.5)


def of(material, nodes=(tables.DENSITIES, tables.LABELS)):
    rho = material.reference_density
    return tables.isentropes(
        "it", material.fluid_pressure_at, rho, material.incipient_vaporisation, (1e-5 * rho, 30 * rho), 1e9, nodes=nodes
    )


@pytest.fixture(scope="module")
def both():
    """Iron and rock in code units of 1000 kg/m3 and (3 km/s)^2."""
    return tables.tabulated([of(IRON, (512, 64)), of(ROCK, (512, 64))], 1e3, 9e6)


random = np.random.default_rng(4)
COUNT = 400
MATERIAL = random.integers(0, 2, COUNT)
RHO = np.array([7.8, 2.7])[MATERIAL] * np.exp(random.uniform(-9.0, 3.0, COUNT))
LABEL = np.expm1(random.uniform(0.0, 4.0, COUNT))


@pytest.mark.slow
def test_pressure_and_sound_are_derivatives_of_the_energy(both):
    """By automatic differentiation: that conserves energy, however wrong a table may be."""
    with jax.enable_x64(True):
        for number in (0, 1):
            mine = both.of(number)
            rho, label = RHO[number == MATERIAL], LABEL[number == MATERIAL]
            P, c, u, thermal, per_heat = mine.state(np, rho, label)

            @jax.jit
            def by_density(r, a, mine=mine):
                found = jax.jvp(lambda x: mine.state(jnp, x, a), (r,), (jnp.ones_like(r),))[1]
                return found[2], found[0], jax.jvp(lambda b: mine.energy(jnp, r, b), (a,), (jnp.ones_like(a),))[1]

            slope, stiffness, by_label = (np.asarray(each) for each in by_density(rho, label))
            np.testing.assert_allclose(rho**2 * slope, P, rtol=1e-9, atol=1e-10)
            floor = np.sqrt(both.numbers[6 * number + 5])
            np.testing.assert_allclose(np.sqrt(np.maximum(stiffness, floor**2)), c, rtol=1e-8)
            np.testing.assert_allclose(1 / np.maximum(by_label, 3e-3), per_heat, rtol=1e-9)
            np.testing.assert_allclose(u - thermal, mine.energy(np, rho, 0 * u), rtol=1e-12, atol=1e-13)


@pytest.mark.slow
def test_each_particle_has_its_own_material_in_both_namespaces(both):
    mixed = both.of(MATERIAL)
    found = mixed.state(np, RHO, LABEL)
    with jax.enable_x64(True):
        theirs = jax.jit(lambda e, r, a: e.state(jnp, r, a))(mixed, RHO, LABEL)
    for number in (0, 1):
        chosen = number == MATERIAL
        alone = both.of(number).state(np, RHO[chosen], LABEL[chosen])
        for whole, one, other in zip(found, alone, theirs, strict=True):
            np.testing.assert_array_equal(whole[chosen], one)
            np.testing.assert_allclose(whole, np.asarray(other), rtol=1e-9, atol=1e-10)
    assert not np.allclose(both.of(0).pressure(np, RHO, LABEL), both.of(1).pressure(np, RHO, LABEL))


def test_a_gas_converges_at_the_order_of_the_spline():
    """u to h^4, P to h^3 and c^2 to h^2, against the closed form; beyond the table its slopes go on."""
    label = np.expm1(random.uniform(0.1, 3.3, COUNT))
    errors = []
    for nodes in ((31, 16), (61, 31), (121, 61)):
        table = tables.tabulated([gas_table(nodes)])
        rho = np.exp(random.uniform(np.log(0.06), np.log(18.0), COUNT))
        exact = (label + 0.5) * rho ** (GAMMA - 1)
        P, c, u, _, per_heat = table.state(np, rho, label)
        errors.append(
            [
                np.abs(u / exact - 1).max(),
                np.abs(P / ((GAMMA - 1) * rho * exact) - 1).max(),
                np.abs(c**2 / (GAMMA * (GAMMA - 1) * exact) - 1).max(),
                np.abs(per_heat * rho ** (GAMMA - 1) - 1).max(),
            ]
        )
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    assert (orders[-1] > [3.3, 2.5, 1.5, 2.5]).all(), orders  # 4, 3, 2, 3; random places leave some noise
    assert errors[-1][0] < 1e-7
    outside = table.pressure(np, np.array([1e-4, 1e-3]), np.array([1.0, 1.0]))
    assert outside[1] / outside[0] == pytest.approx(10.0)  # P in proportion to rho below the table
    assert table.sound_speed(np, np.array([40.0]), np.array([1.0])) > table.sound_speed(
        np, np.array([20.0]), np.ones(1)
    )


@pytest.mark.full
def test_pressures_are_those_of_tillotson_and_none_is_in_tension():
    """Away from corners of the equation to 1e-6 of K; at them by less than what a cell adds to P, which is 1% of K."""
    for material in (IRON, ROCK):
        coarse, fine = (tables.tabulated([of(material, nodes)]) for nodes in ((768, 80), (1536, 160)))
        rho = material.reference_density * np.exp(random.uniform(-8.0, 3.0, 4000))
        label = np.minimum(material.incipient_vaporisation * np.expm1(random.uniform(0.0, 6.0, 4000)), 9e8)
        wrong = []
        for table in (coarse, fine):
            P, _, u, *_ = table.state(np, rho, label)
            with jax.enable_x64(True):
                exact = np.asarray(material.fluid_pressure_at(rho, u))
            wrong.append(np.abs(P - exact) / (material.bulk_modulus * np.minimum(rho / material.reference_density, 1)))
            assert P.min() > -2e-3 * material.bulk_modulus
        assert np.median(wrong[1]) < 1e-6
        assert np.mean(wrong[1]) < 0.6 * np.mean(wrong[0])  # the corners: first order
        assert wrong[1].max() < 1e-2
        expanded = np.full(3, 0.5 * material.reference_density)
        cold = fine.pressure(np, expanded, np.array([0.0, 0.2, 0.5]) * material.incipient_vaporisation)
        assert np.abs(cold).max() < 1e-8 * material.bulk_modulus


@pytest.mark.full
def test_the_cold_isentrope_is_that_of_the_interiors():
    """The same curve as matter/tillotson.py integrates for planets, in compression."""
    table = tables.tabulated([of(IRON)])
    rho = IRON.reference_density * np.array([1.2, 1.6, 2.2])
    with jax.enable_x64(True):
        energy = np.asarray(IRON.energy(rho))
    np.testing.assert_allclose(table.energy(np, rho, np.zeros(3)), energy, rtol=1e-6)


@pytest.mark.full
def test_an_isentrope_is_a_material_for_interiors():
    """Its pressure is the cold curve's of planets, down to where none is left, and its density inverts it."""
    matter = tables.tabulated([of(IRON), of(ROCK)])
    for number, material in enumerate((IRON, ROCK)):
        with jax.enable_x64(True):
            cold = isentrope(matter, number, 0.0)
            assert cold.reference_density == pytest.approx(material.reference_density, rel=2e-4)
            assert cold.bulk_modulus == pytest.approx(material.bulk_modulus, rel=2e-2)
            rho = material.reference_density * np.array([1.03, 1.1, 2.2])
            exact = np.asarray(material.fluid_pressure_at(rho, np.asarray(material.energy(rho))))
            np.testing.assert_allclose(
                np.asarray(cold.pressure(rho)), exact, rtol=1e-6, atol=1e-4 * material.bulk_modulus
            )
            np.testing.assert_allclose(np.asarray(cold.density(exact)), rho, rtol=1e-4)
            warm = isentrope(matter, number, 1e6)
            assert warm.reference_density < 0.99 * material.reference_density
    with pytest.raises(ValueError, match="is a gas"):
        isentrope(matter, 1, 1e8)
    with pytest.raises(ValueError, match="reach from 0 to"):
        isentrope(matter, 1, 1e12)


@pytest.mark.slow
def test_an_isentrope_of_matter_without_heat_has_its_bulk_modulus_and_begins_where_pressure_does():
    """P = K (rho/rho_0 - 1) at any energy, and none where that is below zero."""
    law, span = lambda rho, u: np.maximum(5.0 * (rho / 2.0 - 1.0), 0.0) + 0.0 * u, (0.2, 20.0)
    matter = tables.tabulated([tables.isentropes("it", law, 2.0, 1.0, span, 10.0, nodes=(400, 8))])
    with jax.enable_x64(True):
        cold = isentrope(matter, 0, 0.0)
        rho = np.array([2.3, 3.7, 11.0])
        np.testing.assert_allclose(np.asarray(cold.pressure(rho)), 5.0 * (rho / 2.0 - 1.0), rtol=1e-4)
    assert cold.reference_density == pytest.approx(2.0, rel=1e-3)
    assert cold.bulk_modulus == pytest.approx(5.0, rel=2e-2)


@pytest.mark.slow
def test_entropy_inverts_energy_and_heat_moves_it(both):
    mixed = both.of(MATERIAL)
    rho = np.array([7.8, 2.7])[MATERIAL] * np.exp(random.uniform(-0.4, 1.5, COUNT))
    u = mixed.energy(np, rho, LABEL)
    np.testing.assert_allclose(mixed.entropy(np, rho, u), LABEL, rtol=1e-9, atol=1e-9)
    assert (mixed.entropy(np, rho, mixed.energy(np, rho, 0 * u) - 0.1) < 1e-9).all()  # colder than the coldest
    heat = 1e-7
    warmer = mixed.energy(np, rho, LABEL + heat * mixed.state(np, rho, LABEL)[4])
    np.testing.assert_allclose((warmer - u) / heat, 1.0, rtol=1e-4)


def test_numbers_that_are_none_stay_so_and_harm_nothing(both):
    """A density of NaN or infinity asks for no entry outside the table, and is seen in the result."""
    bad = np.array([np.nan, np.inf, 1.0, 1.0])
    label = np.array([0.1, 0.1, np.nan, 1e30])
    found = both.of(np.zeros(4, int)).pressure(np, bad, label)
    assert not np.isfinite(found[:3]).any()
    assert np.isfinite(found[3])


def test_a_table_is_looked_up_by_every_particle():
    entries = random.random(50)
    index = random.integers(0, 50, 3000).astype(float)
    assert np.array_equal(elementwise(np, looked_up, index, Table(entries))[0], entries[index.astype(int)])
    assert np.isclose(totals(np, looked_up, index, Table(entries))[0][0], entries[index.astype(int)].sum())


def looked_up(xp, index, table):
    """The entry of that number."""
    return (xp.take(table, xp.int64(index)),)


def test_tables_that_cannot_be_are_refused():
    with pytest.raises(ValueError, match="leave the numbers"):
        tables.isentropes("odd", lambda rho, u: jnp.log(-rho), 1.0, 1.0, (0.1, 10.0), 10.0, nodes=(16, 16))
    with pytest.raises(ValueError, match="isentropes meet"):
        tables.isentropes("odd", gas, 1.0, 1.0, (0.1, 1.0), 10.0, coldest=1e20, nodes=(16, 16))
    with pytest.raises(ValueError, match="of one size"):
        tables.tabulated([gas_table((16, 16)), gas_table((20, 16))])


def test_a_cache_can_tell_two_tables_apart():
    one, other = gas_table((16, 16)), gas_table((16, 16), (0.05, 21.0))
    assert repr(tables.tabulated([one])) == repr(tables.tabulated([one]))
    assert repr(tables.tabulated([one])) != repr(tables.tabulated([other]))


@pytest.mark.full
def test_shocked_matter_is_on_the_hugoniot_of_the_equation():
    """Entropy, found from the energy of a shock into cold matter at rest, gives the pressure of the jump conditions.

    u_H = P_H (1/rho_0 - 1/rho)/2 with P_H = P(rho, u_H) of the equation itself, by bisection (Melosh 1989, sec. 3.4);
    at small compressions the shock has the speed of sound.
    """
    for material in (IRON, ROCK):
        matter, zero = tables.tabulated([of(material)]), material.reference_density
        rho = zero * np.array([1.02, 1.1, 1.3, 1.6, 1.9])
        low, high = 0.0 * rho, 1e8 + 0.0 * rho
        with jax.enable_x64(True):
            for _ in range(60):
                u = 0.5 * (low + high)
                short = u < 0.5 * np.asarray(material.pressure_at(rho, u)) * (1 / zero - 1 / rho)
                low, high = np.where(short, u, low), np.where(short, high, u)
            exact = np.asarray(material.pressure_at(rho, u))
        found = matter.pressure(np, rho, matter.entropy(np, rho, u))
        # The corner where matter comes apart is felt by the spline two cells away: 1e-4 of K at a compression of 2%.
        np.testing.assert_allclose(found, exact, rtol=1e-6, atol=2e-4 * material.bulk_modulus)
        np.testing.assert_allclose(found[2:], exact[2:], rtol=1e-6)
        speed = np.sqrt(exact / (zero * (1 - zero / rho)))
        assert (np.diff(speed) > 0).all()
        assert speed[0] == pytest.approx(np.sqrt(material.bulk_modulus / zero), rel=0.05)
