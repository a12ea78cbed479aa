"""Loops over particles: what they compute, in every shape, and that threads and chunks leave no trace."""

from contextvars import copy_context
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numba.core import event

from astroinertia.engines import elementwise as loops
from astroinertia.engines.elementwise import COMPILED, elementwise, totals
from astroinertia.engines.few import FEW
from astroinertia.engines.threads import noting

random = np.random.default_rng(8)
COUNT = 2 * loops.ALONE + 700  # two threads, and a part of a chunk
MASS, VECTOR, MATRIX = random.random(COUNT), random.normal(size=(COUNT, 3)), random.normal(size=(COUNT, 3, 3))


def turned(xp, mass, vector, matrix, factor):
    """Some of everything: M v, m |v| and the transposed matrix."""
    x, y, z = vector
    a, b, c = matrix
    size = xp.sqrt(x**2 + y**2 + z**2)
    product = (a[0] * x + a[1] * y + a[2] * z, b[0] * x + b[1] * y + b[2] * z, c[0] * x + c[1] * y + c[2] * z)
    return product, xp.where(mass > 0.5, factor * mass * size, xp.inf), ((a[0], b[0], c[0]), (a[1], b[1], c[1]), c)


def elementary(xp, x):
    """What pair functions do not have."""
    return xp.exp(x), xp.log(xp.abs(x)), xp.power(xp.abs(x), 0.37)


def weighted(xp, mass, vector, other):
    """m, m v and m v.v'."""
    x, y, z = vector
    return mass, (mass * x, mass * y, mass * z), mass * (x * other[0] + y * other[1] + z * other[2])


@pytest.mark.parametrize("count", [0, 1, 5, FEW, FEW + 1, COUNT])
def test_every_shape_goes_in_and_comes_out(count: int) -> None:
    product, number, matrix = elementwise(np, turned, MASS[:count], VECTOR[:count], MATRIX[:count], 0.3)
    assert np.allclose(product, np.einsum("nij,nj->ni", MATRIX[:count], VECTOR[:count]), rtol=1e-12, atol=1e-14)
    expected = np.where(MASS > 0.5, 0.3 * MASS * np.linalg.norm(VECTOR, axis=1), np.inf)[:count]
    assert np.allclose(number, expected, rtol=1e-14)
    assert np.array_equal(matrix[:, :2], np.swapaxes(MATRIX[:count], 1, 2)[:, :2])
    assert np.array_equal(matrix[:, 2], MATRIX[:count, 2])


def looked_up(xp, x, table):
    """An entry by its number, and one over it, which is infinite for a table of noughts."""
    value = xp.take(table, xp.int64(xp.floor(x)))
    return value, 1.0 / value


def test_few_particles_have_the_same_results_without_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    """In every shape, with an unknown number and sums of several cases; few of many have theirs by programs."""
    mass, vector, matrix = MASS[:FEW].copy(), VECTOR[:FEW], MATRIX[:FEW]
    mass[3] = np.nan

    def results(xp: Any) -> list[np.ndarray]:
        return [
            *elementwise(xp, turned, mass, vector, matrix, 0.3), *elementwise(xp, elementary, vector[:, 0]),
            *totals(xp, weighted, MASS[:FEW], vector, cases=[(vector,), (2.0 * vector,)]),
        ]  # fmt: skip

    with event.install_recorder("numba:compile") as recorder:
        few = results(np)
    assert not recorder.buffer
    monkeypatch.setattr(loops, "_numpy_values", None)
    for one, other in zip(few, results(COMPILED), strict=True):
        assert one.shape == other.shape
        assert one.flags.c_contiguous
        assert one.flags.writeable
        assert np.allclose(one, other, rtol=1e-14, atol=1e-11 if len(one) == 2 else 1e-14, equal_nan=True)


def test_what_looks_things_up_is_compiled_for_few_particles_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """In a table with a division by zero; a step of a planet of 500 takes numpy alone two to three times as long."""
    entries, places = np.array([0.0, 3.0, 5.0]), 3.0 * MASS[:5]
    monkeypatch.setattr(loops, "_numpy_values", None)
    value, inverse = elementwise(np, looked_up, places, loops.Table(entries))
    expected = entries[np.floor(places).astype(int)]
    assert np.array_equal(value, expected)
    with np.errstate(divide="ignore"):
        assert np.array_equal(inverse, 1.0 / expected)


def test_what_is_only_noted_is_computed_by_numpy() -> None:
    """However many particles there are, in a table too, and nothing is compiled."""
    entries, places = loops.Table(np.array([0.0, 3.0, 5.0])), 3.0 * MASS
    noted: list[str] = []

    def results() -> list[np.ndarray]:
        sums = totals(np, weighted, MASS, VECTOR, cases=[(VECTOR,), (2.0 * VECTOR,)])
        return [
            *elementwise(np, turned, MASS, VECTOR, MATRIX, 0.3),
            *elementwise(np, looked_up, places, entries),
            *sums,
        ]

    def only_noted() -> list[np.ndarray]:
        noting.set(lambda function, *_: noted.append(function.py_func.__module__))
        with event.install_recorder("numba:compile") as recorder:
            found = results()
        assert not recorder.buffer
        return found

    for one, other in zip(copy_context().run(only_noted), results(), strict=True):
        assert np.allclose(one, other, rtol=1e-12, atol=1e-11)
    assert ["_".join(name.split("_")[:-1]) for name in noted] == [
        "totals_weighted",
        "particlewise_turned",
        "particlewise_looked_up",
    ]


@pytest.mark.slow
def test_jax_computes_the_same() -> None:
    with jax.enable_x64(True):
        found = elementwise(jnp, turned, *map(jnp.asarray, (MASS, VECTOR, MATRIX)), 0.3)
        for one, other in zip(found, elementwise(np, turned, MASS, VECTOR, MATRIX, 0.3), strict=True):
            assert np.allclose(one, other, rtol=1e-13, atol=1e-14)
        given = [jnp.asarray(a) for a in (MASS, VECTOR)]
        sums = totals(jnp, weighted, *given, cases=[(given[1],), (2.0 * given[1],)])
        for one, other in zip(sums, totals(np, weighted, MASS, VECTOR, cases=[(VECTOR,), (2 * VECTOR,)]), strict=True):
            assert one.shape == other.shape
            assert np.allclose(one, other, rtol=1e-12, atol=1e-11)


def test_elementary_functions_are_right_to_the_last_place_or_nearly() -> None:
    """Against long double, over all magnitudes, and where they are not finite."""
    x = np.concatenate([np.linspace(-700.0, 700.0, 20001), 10.0 ** random.uniform(-300, 2.8, 20000), [1.0, 0.5, 2.0]])
    exp, log, power = elementwise(np, elementary, x)
    exact = np.abs(x.astype(np.longdouble))
    for found, expected in ((exp, np.exp(x.astype(np.longdouble))), (log, np.log(exact[exact > 0]))):
        found = found[exact > 0] if len(expected) < len(found) else found
        assert (np.abs(found - expected) <= np.spacing(np.abs(expected.astype(float)))).all()
    some = exact > 0
    allowed = 2e-16 * (1.0 + np.abs(0.37 * np.log(exact[some])))
    assert (np.abs(power[some] / exact[some] ** np.longdouble(0.37) - 1.0) <= allowed).all()
    with np.errstate(all="ignore"):
        special = np.array([0.0, np.inf, -np.inf, np.nan, 800.0, -800.0])
        assert np.array_equal(
            elementwise(np, elementary, special)[0], np.exp(special) * (special > -800), equal_nan=True
        )
        assert np.array_equal(elementwise(np, elementary, special)[1][:4], np.log(np.abs(special[:4])), equal_nan=True)
        assert np.array_equal(elementwise(np, elementary, special)[2][:4], np.abs(special[:4]) ** 0.37, equal_nan=True)


def test_bits_do_not_depend_on_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for threads in (1, 2, 3):
        monkeypatch.setattr(loops, "available_threads", lambda threads=threads: threads)
        found.append([*elementwise(np, turned, MASS, VECTOR, MATRIX, 0.3), *totals(np, weighted, MASS, VECTOR, VECTOR)])
    for arrays in zip(*found, strict=True):
        assert all(np.array_equal(arrays[0], array) for array in arrays[1:])


def test_sums_lose_no_more_than_pairwise_ones() -> None:
    """A plain sum of so many equal numbers is off by 1e-13 and more."""
    count = 300_000
    ones = np.full(count, 0.1)
    mass, momentum, energy = totals(np, weighted, ones, np.ones((count, 3)), np.ones((count, 3)))
    exact = float(count * np.longdouble(0.1))
    assert abs(mass[0] / exact - 1.0) < 1e-14
    assert np.abs(momentum[0] / exact - 1.0).max() < 1e-14
    assert abs(energy[0] / (3.0 * exact) - 1.0) < 1e-14


def test_arrays_that_are_no_rows_of_particles_are_refused() -> None:
    with pytest.raises(ValueError, match="each particle"):
        elementwise(np, elementary, np.ones((4, 2)))
    with pytest.raises(ValueError, match="each particle"):
        elementwise(np, turned, np.ones(4), np.ones((5, 3)), np.ones((4, 3, 3)), 1.0)
