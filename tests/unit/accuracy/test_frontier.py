"""Which settings are worth their cost."""

import numpy as np

from astroinertia.accuracy.frontier import knee, pareto


def test_the_front_holds_what_nothing_else_beats():
    cost = np.array([1.0, 2.0, 2.0, 3.0, 4.0, np.nan, 0.5])
    error = np.array([1e-1, 1e-2, 2e-2, 1e-2, 1e-3, 1e-9, np.nan])
    assert pareto(cost, error).tolist() == [True, True, False, False, True, False, False]
    assert pareto(cost[::-1], error[::-1]).tolist() == [False, False, True, False, False, True, True]


def test_the_front_is_that_of_a_direct_search():
    rng = np.random.default_rng(3)
    cost, error = rng.uniform(size=(2, 200))
    beaten = [
        bool(np.any((cost <= c) & (error <= e) & ((cost < c) | (error < e)))) for c, e in zip(cost, error, strict=True)
    ]
    assert pareto(cost, error).tolist() == [not each for each in beaten]


def test_the_knee_is_where_more_cost_stops_to_pay():
    cost = np.array([1.0, 2.0, 4.0, 40.0, 400.0])
    error = np.array([1e-1, 1e-3, 1e-5, 5e-6, 4e-6])
    assert knee(cost, error) == 2
    assert knee(cost[[4, 2, 0, 3, 1]], error[[4, 2, 0, 3, 1]]) == 1  # in any order
    # Of x + y = 0.8 and 0.7 in scaled logarithms the second is farther from the line x + y = 1.
    assert knee(10.0 ** np.array([0.0, 0.3, 0.6, 1.0]), 10.0 ** np.array([1.0, 0.5, 0.1, 0.0])) == 2
    assert knee(10.0 ** np.array([0.0, 0.1, 0.4, 1.0]), 10.0 ** np.array([1.0, 0.6, 0.4, 0.0])) == 1
    assert knee(cost[:2], error[:2]) is None
    assert knee(np.array([1.0, 10.0, 100.0]), np.array([1.0, 0.9, 0.01])) is None  # bulges outwards


def test_the_knee_depends_neither_on_units_nor_on_settings_without_a_logarithm():
    cost, error = np.array([1.0, 3.0, 9.0, 27.0, 81.0]), np.array([1.0, 0.3, 0.012, 0.01, 0.008])
    for seconds in (1e-6, 1.0, 1e6):
        for relative in (1e-12, 1.0, 1e6):
            assert knee(seconds * cost, relative * error) == 2
    assert knee(np.append(cost, 1e3), np.append(error, 0.0)) == 2  # without an error: nothing to compare
    assert knee(np.append(0.0, cost), np.append(2.0, error)) == 3
