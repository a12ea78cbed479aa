"""Lists of neighbours in the numba engine, where some particles reach much further than others beside them."""

import os
import subprocess
import sys

import numpy as np
import pytest

from astroinertia.engines import numba_cpu
from astroinertia.engines.numba_cpu import Engine
from astroinertia.engines.numba_vectors import LANES
from astroinertia.engines.terms import Output, PairTerm
from tests.processors import PROCESSORS

KERNEL, SUPPORT, COUNT = "wendland_c2", 2.0, 6000


def one_pair(xp, r):
    return (1.0 + 0.0 * r,)


NEIGHBOURS = PairTerm("neighbours", one_pair, (Output("number", "sum"),))


pytestmark = pytest.mark.slow  # compilation


@pytest.fixture(scope="module")
def escaping():
    """A dense body, particles that escape from it in all directions, and smoothing lengths that solve for both."""
    random = np.random.default_rng(6)
    direction = random.normal(size=(COUNT, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    radius = np.where(
        np.arange(COUNT) % 8 == 0, 4.0 * random.uniform(size=COUNT) ** 2, 0.05 * random.uniform(size=COUNT)
    )
    position, mass = radius[:, None] * direction, np.full(COUNT, 1.0 / COUNT)
    order, arrangement = Engine().arrange(position, np.ones(COUNT))
    position = position[order]
    length = Engine().density(arrangement, KERNEL, position, mass, np.full(COUNT, 0.1), 1.3, 1e-8).smoothing_length
    length[::501] *= 6.0  # some reach all through the body
    return arrangement, position, length


@pytest.mark.parametrize(
    "scale",
    [
        1.0,
        pytest.param(1e-20, id="tiny", marks=pytest.mark.full),
        pytest.param(1e20, id="huge", marks=pytest.mark.full),
    ],
)
def test_lists_hold_what_a_leaf_needs_and_little_else(escaping, scale):
    """Whatever the unit of length: in squares of these, float32 would run out of its range."""
    arrangement, position, length = escaping
    assert length.max() > 100.0 * length.min()
    lists = Engine().listed(arrangement, KERNEL, scale * position, scale * length / 1.05).lists
    assert lists is not None
    held, needed = 0, 0
    for leaf in range(arrangement.leaves.count):
        own = slice(*arrangement.leaves.start[leaf : leaf + 2])
        apart = np.linalg.norm(position[own, None] - position[None], axis=2)
        near = np.any(apart < SUPPORT * np.maximum(length[own, None], length[None]), axis=0)
        found = lists.pool[lists.offset[leaf] : lists.offset[leaf] + lists.count[leaf]]
        assert np.all(np.diff(found) > 0)
        assert np.all(np.isin(np.flatnonzero(near), found))
        held, needed = held + len(found), needed + near.sum()
    assert scale != 1.0 or held < 1.01 * needed


@pytest.mark.parametrize("size", [numba_cpu.LEAF_SIZE, 1], ids=["guessed", "counted"])
def test_lists_take_the_memory_of_what_they_hold_and_of_a_vector_that_passes_read_on(escaping, monkeypatch, size):
    """Also where room was guessed too small, and counted then: they read beyond its end."""
    arrangement, position, length = escaping
    monkeypatch.setattr(numba_cpu, "LEAF_SIZE", size)
    lists = Engine().listed(arrangement, KERNEL, position, length).lists
    assert lists is not None
    assert len(lists.pool) == lists.count.sum() + LANES


def test_lists_stay_as_long_as_lengths_are_within_them(escaping):
    arrangement, position, length = escaping
    listed = Engine().listed(arrangement, KERNEL, position, length)
    assert Engine().listed(listed, KERNEL, position, 0.999 * numba_cpu.LISTED * length).lists is listed.lists
    longer = length.copy()
    longer[7] *= 1.001 * numba_cpu.LISTED
    again = Engine().listed(listed, KERNEL, position, longer)
    assert again.lists is not None and again.lists is not listed.lists
    assert np.array_equal(again.lists.length, numba_cpu.LISTED * longer)


def test_sums_count_every_pair_within_the_longer_of_two_reaches(escaping):
    arrangement, position, length = escaping
    fields = {"mass": np.ones(COUNT), "position": position, "smoothing_length": length}
    found, other = (
        Engine(threads=threads).neighbour_sums(arrangement, KERNEL, (NEIGHBOURS,), fields)["neighbours"]["number"]
        for threads in (1, 3)
    )
    assert np.array_equal(found, other)
    few = np.arange(0, COUNT, 7)
    apart = np.linalg.norm(position[few, None] - position[None], axis=2)
    expected = np.sum(apart < SUPPORT * np.maximum(length[few, None], length[None]), axis=1)
    assert np.array_equal(found[few], expected)
    assert expected.max() > 20 * np.median(expected)


def test_smoothing_lengths_grow_out_of_the_lists_beside_others_that_do_not(escaping):
    """Each target has the neighbours up to its own length, whatever the longest in its leaf."""
    arrangement, position, length = escaping
    mass, random = np.full(COUNT, 1.0 / COUNT), np.random.default_rng(7)
    roots = Engine().density(arrangement, KERNEL, position, mass, length, 1.3, 1e-14)
    guess = roots.smoothing_length * random.choice([0.5, 0.9, 1.0, 1.5], COUNT)
    found = Engine().density(arrangement, KERNEL, position, mass, guess, 1.3, 1e-14)
    assert np.max(np.abs(found.smoothing_length / roots.smoothing_length - 1.0)) < 1e-12
    few = np.arange(0, COUNT, 7)
    q = np.linalg.norm(position[few, None] - position[None], axis=2) / found.smoothing_length[few, None]
    kernel = 21.0 / (16.0 * np.pi) * np.maximum(1.0 - q / 2.0, 0.0) ** 4 * (2.0 * q + 1.0)
    rho = (mass * kernel).sum(axis=1) / found.smoothing_length[few] ** 3
    assert np.max(np.abs(rho / (mass[few] * (1.3 / found.smoothing_length[few]) ** 3) - 1.0)) < 1e-12


COMPILED = """
from numba import njit, types
from astroinertia.engines.numba_lists import least_excess


@njit
def entry(x, y, z, reach2, count, balls, key):
    least_excess(x, y, z, reach2, count, balls, 0, count, key)


row, table = (types.Array(types.float32, dimensions, "C") for dimensions in (1, 2))
entry.compile((row, row, row, row, types.int64, table, row))
print(*entry.inspect_asm().values())
"""


@pytest.mark.skipif(not PROCESSORS, reason="names processors of another kind")
def test_distances_are_stored_whole_vectors_at_a_time_without_avx512():
    """A store of chosen lanes takes such processors ten times as long."""
    environment = os.environ | PROCESSORS["AVX2"].environment
    done = subprocess.run([sys.executable, "-c", COMPILED], env=environment, capture_output=True, text=True, check=True)
    assert "vmaxps" in done.stdout
    assert "vmaskmov" not in done.stdout
