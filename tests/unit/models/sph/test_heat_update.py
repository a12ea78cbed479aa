"""Heat in matter whose energy is not linear in A: all of it arrives, and the ledger has what did."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.matter import isentropes as tables
from astroinertia.matter.tillotson import BASALT, IRON
from astroinertia.models.sph.heat import exchange_of, heat_update

COUNT = 300
random = np.random.default_rng(11)
MATERIAL = random.integers(0, 2, COUNT)
# From a thousandth of the reference density, where du/dA falls to 1/50, to ten times it.
RHO = np.array([7.8, 2.7])[MATERIAL] * np.exp(random.uniform(-7.0, 2.3, COUNT))
LABEL = np.expm1(random.uniform(0.0, 4.0, COUNT)) * (random.random(COUNT) > 0.2)
MASS = random.uniform(0.5, 1.5, COUNT)


@pytest.fixture(scope="module")
def matter() -> Any:
    """Iron and rock in code units of 1000 kg/m3 and (3 km/s)^2: u is of order 1, and A reaches to 111."""

    def of(material: Any) -> tables.Isentropes:
        rho, spans = material.reference_density, (1e-4, 30.0)
        return tables.isentropes(
            "it", material.fluid_pressure_at, rho, material.incipient_vaporisation,
            (spans[0] * rho, spans[1] * rho), 1e9, nodes=(256, 48),
        )  # fmt: skip

    return tables.tabulated([of(IRON), of(BASALT)], 1e3, 9e6)


@pytest.mark.slow
@pytest.mark.parametrize("size", [1e-8, 1e-3, 0.3, 30.0, 3000.0])
def test_matter_has_all_the_heat_and_loses_all_of_it_again(matter: Any, size: float) -> None:
    """To rounding, from less than a cell of the table to far beyond its hottest isentrope."""
    mixed, heat = matter.of(MATERIAL), size * random.random(COUNT)
    u = mixed.energy(np, RHO, LABEL)
    rounding = 1e-14 * (np.abs(u) + heat + 1.0)
    hot, missed = mixed.heated(np, RHO, LABEL, heat, -np.inf)
    assert (np.abs(mixed.energy(np, RHO, hot) - u - heat) <= rounding).all()
    assert (np.abs(missed) <= rounding).all()
    assert (hot > LABEL).all()
    cold = mixed.heated(np, RHO, hot, -heat, -np.inf)[0]
    assert (np.abs(mixed.energy(np, RHO, cold) - u) <= rounding).all()


def test_heat_in_proportion_to_the_slope_alone_would_miss(matter: Any) -> None:
    mixed, heat = matter.of(MATERIAL), 0.3
    slope = 1.0 / mixed.state(np, RHO, LABEL)[4]
    wrong = mixed.energy(np, RHO, LABEL + heat / slope) - mixed.energy(np, RHO, LABEL) - heat
    assert np.abs(wrong).max() > 0.01


@pytest.mark.slow
@pytest.mark.parametrize("size", [1e-4, 1e-2, 30.0])
def test_xla_gives_the_ledger_what_matter_has_and_misses_little(matter: Any, size: float) -> None:
    """Newton's second step: half of all matter misses less than a hundredth of what the slope alone does."""
    mixed, heat = matter.of(MATERIAL), size * random.random(COUNT)
    with jax.enable_x64(True):
        program = jax.jit(lambda rho, label, heat: mixed.heated(jnp, rho, label, heat, -jnp.inf))
        after, missed = (np.asarray(array) for array in program(RHO, LABEL, heat))
    u, slope = mixed.energy(np, RHO, LABEL), 1.0 / mixed.state(np, RHO, LABEL)[4]
    np.testing.assert_allclose(mixed.energy(np, RHO, after), u + heat + missed, rtol=1e-13, atol=1e-12)
    by_slope = mixed.energy(np, RHO, LABEL + heat / slope) - u - heat
    assert np.median(np.abs(missed)) < 0.01 * np.median(np.abs(by_slope))


def test_heat_too_little_for_the_digits_of_the_energy_adds_up(matter: Any) -> None:
    """1000 times 1e-17, which the digits of A itself hold to 2 %; without heat nothing moves at all."""
    mixed, label = matter.of(MATERIAL), np.full(COUNT, 1e-3)
    rho = np.array([7.8, 2.7])[MATERIAL]
    np.testing.assert_array_equal(mixed.heated(np, rho, label, 0.0 * rho, -np.inf)[0], label)
    for _ in range(1000):
        label = mixed.heated(np, rho, label, 1e-17 + 0.0 * rho, -np.inf)[0]
    np.testing.assert_allclose(label - 1e-3, 1e-14 * mixed.state(np, rho, label)[4], rtol=0.02)


def test_pairs_and_surroundings_are_in_the_ledger_to_rounding(matter: Any) -> None:
    """Two effects by pairs, one of which cools, and one that radiates: what they bring is what u gains."""
    mixed = matter.of(MATERIAL)
    heats = (0.2 * random.random(COUNT), None, -0.1 * random.random(COUNT), None)
    exchange = exchange_of([None, None, None, (0.3 + 0.0 * RHO, 2.0 + 0.0 * RHO)], np.ones(COUNT))
    after, brought = heat_update(np, mixed, MASS, RHO, LABEL, heats, exchange, np.float64(0.4), -np.inf)
    gained = mixed.energy(np, RHO, after) - mixed.energy(np, RHO, LABEL)
    thermal = mixed.state(np, RHO, LABEL)[3]
    assert MASS @ gained == pytest.approx(sum(brought), abs=1e-14 * (MASS @ (thermal + 1.0)))
    assert brought[0] == pytest.approx(MASS @ heats[0], rel=1e-12)
    assert brought[1] == 0.0
    assert brought[2] == pytest.approx(MASS @ heats[2], rel=1e-12)
    # du/dt = q/dt + g - k u of the thermal energy, in closed form.
    level = (0.3 + (heats[0] + heats[2]) / 0.4) / 2.0
    exact = level + (thermal - level) * np.exp(-0.8)
    np.testing.assert_allclose(thermal + gained, exact, rtol=1e-12, atol=1e-12)


@pytest.mark.full
def test_what_a_limit_takes_is_not_in_the_ledger(matter: Any) -> None:
    """A stays at half of what it was; the ledger gives the two effects the heat that came, in proportion to theirs."""
    mixed = matter.of(MATERIAL)
    label = 1.0 + LABEL
    heats = (-1e3 * (1.0 + random.random(COUNT)), None, 0.0 * MASS)
    after, brought = heat_update(np, mixed, MASS, RHO, label, heats, None, np.float64(1.0), 0.5 * label)
    np.testing.assert_array_equal(after, 0.5 * label)
    gained = mixed.energy(np, RHO, after) - mixed.energy(np, RHO, label)
    assert brought[0] == pytest.approx(MASS @ gained, rel=1e-10)
    assert brought[1] == brought[2] == 0.0


def test_numbers_that_are_none_are_seen(matter: Any) -> None:
    bad = np.array([np.nan, 1.0, 1.0, 1.0])
    label, heat = np.array([1.0, np.nan, 1.0, 1.0]), np.array([0.1, 0.1, np.nan, 0.1])
    after = matter.of(np.zeros(4, int)).heated(np, bad, label, heat, -np.inf)[0]
    np.testing.assert_array_equal(np.isnan(after), [True, True, True, False])


def test_tables_of_too_many_labels_are_refused() -> None:
    def gas(rho: Any, u: Any) -> Any:
        return 0.4 * rho * u

    many = tables.isentropes("gas", gas, 1.0, 1.0, (0.5, 2.0), 30.0, nodes=(8, 300), coldest=0.5)
    with pytest.raises(ValueError, match="at most 257 labels, not 300"):
        tables.tabulated([many])
