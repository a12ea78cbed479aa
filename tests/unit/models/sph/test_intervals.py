"""Hierarchical splitting of time steps: rungs, clock, base steps, and weights of nested sets."""

import numpy as np
import pytest

from astroinertia.errors import NumericalError
from astroinertia.models.sph.intervals import DEEPEST, Clock, base_step, merged, rungs, rungs_that_pay, weighted_sets
from astroinertia.sph import rung_costs

MANY = 1000  # of each particle: a step of a hundred takes mostly what does not depend on them


def test_a_rung_is_the_coarsest_whose_interval_is_within_the_limit() -> None:
    limits = np.array([1.0, 0.999, 0.5, 0.4, 0.125, 7.0])
    assert rungs(limits, 1.0).tolist() == [0, 1, 1, 2, 3, 0]


def test_the_clock_comes_by_every_end_of_an_interval() -> None:
    clock, levels = Clock(2.0), []
    while not clock.ended:
        clock = clock.after(3)
        levels.append(clock.level)
    assert levels == [3, 2, 3, 1, 3, 2, 3, 0]
    assert clock.elapsed == 2.0


def test_middles_of_intervals_under_way() -> None:
    clock = Clock(1.0, 3 << (DEEPEST - 3))  # at 3/8
    assert [clock.middle(rung) for rung in range(4)] == [0.5, 0.25, 0.375, 0.4375]


def test_the_last_interval_as_a_base_step() -> None:
    clock = Clock(2.0, 3 << (DEEPEST - 2)).last()  # at 3/4, where intervals of rung 2 end
    assert (clock.base, clock.elapsed, clock.level, clock.ended) == (0.5, 0.5, 0, True)


@pytest.mark.parametrize(
    ("limits", "remaining", "base"),
    [
        ([1.0] + [5.0] * 99, 100.0, 3.8),  # nearly all take the shortest times a power of two
        ([1.0] * 99 + [5.0], 100.0, 1.0),  # one particle is not worth it
        ([1.0] + [5.0] * 99, 0.5, 0.5),
        ([1.0] + [5.0] * 99, 6.0, 3.0),  # two equal ones rather than 4 and what is left
    ],
)
def test_the_base_step(limits: list[float], remaining: float, base: float) -> None:
    each = np.repeat(limits, MANY)
    found, rung = base_step(each, remaining)
    assert found == pytest.approx(base, rel=1e-15)
    assert (found / 2.0**rung <= each).all()


@pytest.mark.parametrize(("short", "finest"), [(60, 0), (40, 0), (20, 0), (5, 1)])
def test_several_rungs_are_for_where_few_particles_need_short_intervals(short: int, finest: int) -> None:
    """Of 100, `short` need half the interval of the others: what base steps and nested sets take is to be saved too."""
    limits = np.repeat([1.0] * short + [2.1] * (100 - short), MANY)
    assert rungs_that_pay(limits, 1, 100.0) == finest
    base, rung = base_step(limits, 100.0, 1)
    assert base == pytest.approx(0.95 * 4.0 if finest else 1.0, rel=1e-15)
    assert rung.any() == bool(finest)


def test_a_base_step_may_be_longer_than_every_interval() -> None:
    """All are then evaluated at each end of a rung above the base step, which begins less often."""
    base, rung = base_step(np.repeat([1.0] + [5.0] * 99, MANY), 100.0, 2)
    assert base == pytest.approx(15.2, rel=1e-15)
    assert rung[::MANY].tolist() == [4] + [2] * 99


def test_a_base_step_need_not_be_an_equal_part_of_what_remains() -> None:
    """Of 131 shortest intervals one part would take 256; 128, and then what is left, take 132."""
    limits = np.repeat([1.0] * 10 + [1000.0] * 90, MANY) / 0.95
    base, rung = base_step(limits, 131.0)
    assert base == pytest.approx(128.0, rel=1e-12)
    assert rung[::MANY].tolist() == [7] * 10 + [0] * 90


def test_ends_of_intervals_of_few_particles_cost_as_much_as_particles() -> None:
    """Of 1e4 particles a quarter of the interval pays for a fifth; of 300 an end takes half as long as all of them."""
    shares = np.array([60, 0, 240])
    assert rung_costs.that_pay(shares * 33.0, 1, 40) == 2
    assert rung_costs.that_pay(shares * 33.0, 1, 1) == 0  # of base steps as short as two of the shortest intervals
    assert rung_costs.that_pay(shares, 1, 40) == 0
    limits = np.repeat([1.0, 4.5], [60, 240])
    assert base_step(limits, 100.0, 1)[0] == 1.0 and not base_step(limits, 100.0, 1)[1].any()


@pytest.mark.parametrize(("short", "drifts"), [(900, 2), (10_000, 128)])
def test_the_others_drift_at_few_ends_of_intervals_of_a_few(short: int, drifts: int) -> None:
    """Of 128 ends, but not where half of all particles have such short intervals: few are taken out of the body."""
    small, large = (rung_costs.of_base_step(np.array([count, *[0] * 6, short])) for count in (1e4, 1.1e4))
    once = 1.0 + rung_costs.FAR + rung_costs.BASE
    assert large - small == pytest.approx((once + drifts * rung_costs.END) * 1e3)


@pytest.mark.parametrize(("short", "count"), [(500, 1000), (100, 10_000), (1, 300)])
def test_no_base_step_outlasts_a_few_hundred_global_steps(
    short: int, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run is saved between base steps alone: with limits 2^20 apart one took a million global steps."""
    limits = np.repeat([1.0, 2.0**20], [short, count - short])

    def cost() -> tuple[float, float]:
        base, rung = base_step(limits, 1e9, 1)
        whole = rung_costs.of_base_step(np.bincount(rung)) / rung_costs.of_global_step(count)
        return whole, whole / base

    whole, pace = cost()
    assert 0.25 * rung_costs.LONGEST < whole <= rung_costs.LONGEST
    monkeypatch.setattr(rung_costs, "LONGEST", np.inf)
    endless, ideal = cost()
    assert endless > 1e5 and pace < 1.02 * ideal  # it loses little


def test_few_particles_do_not_make_another_nested_set() -> None:
    assert merged(np.array([2] + [4] * 9 + [5] * 9), 2).tolist() == [4] + [4] * 9 + [5] * 9
    assert merged(np.array([2] * 9 + [4] + [5] * 9), 2).tolist() == [2] * 9 + [5] + [5] * 9
    assert merged(np.array([2, 2, 2]), 2).tolist() == [2, 2, 2]


def test_a_step_that_falls_to_nothing_is_reported() -> None:
    with pytest.raises(NumericalError, match="time step fell"):
        rungs(np.array([1.0, 1e-13]), 1.0)


def test_nested_sets_weigh_every_pair_by_the_longer_of_its_two_intervals() -> None:
    """The sums over sets with their weights are half of sum_j max(dt_i, dt_j) a_ij, pair by pair."""
    generator = np.random.default_rng(1)
    rung, base, level = generator.choice([2, 3, 6, 7], 30), 0.7, 2
    pairs = generator.normal(size=(30, 30))
    interval = base / 2.0**rung
    wanted = 0.5 * (np.maximum(interval[:, None], interval[None, :]) * pairs).sum(axis=1)
    found = np.zeros(30)
    distinct = weighted_sets(base, rung, level)
    for chosen, _, weight in distinct:
        found[chosen] += weight * pairs[np.ix_(chosen, chosen)].sum(axis=1)
    assert [which for _, which, _ in distinct] == [[2], [3], [4, 5, 6], [7]]
    np.testing.assert_allclose(found, wanted, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize(
    ("longest", "base", "ends"), [(30.0, 15.2, 16), (15.0, 15.0, 16), (9.0, 7.6, 8), (4.1, 3.8, 4)]
)
def test_a_longest_base_step_is_no_time_to_be_met(longest: float, base: float, ends: int) -> None:
    """Equal parts of it would be: intervals far shorter than the limits. Below it powers of two suit these."""
    limits = np.repeat([1.0] * 10 + [8.0] * 90, MANY)
    found, rung = base_step(limits, 1e3, 1, longest)
    assert found == pytest.approx(base, rel=1e-12)
    assert 2 ** rung.max() == ends
    assert (found / 2.0**rung <= limits).all()
