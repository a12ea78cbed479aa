"""Processes that share out passes get, together, the bits of one alone; shares follow the times that they took."""

import threading
from itertools import pairwise

import numpy as np
import pytest

from astroinertia.effects.kinds.gravity import SOFTENING
from astroinertia.engines.numba_cpu import Engine
from astroinertia.engines.together import FEWEST, SMALLEST, Together
from astroinertia.gravity import multipole

KERNEL = "wendland_c2"
COUNT, PROCESSES = 3000, 3


class Communicator:
    """What mpi4py offers, among threads of one process."""

    def __init__(self, count, number, table, barrier):
        self._count, self._number, self._table, self._barrier = count, number, table, barrier

    def Get_rank(self):
        return self._number

    def Get_size(self):
        return self._count

    def _all(self, array):
        self._table[self._number] = np.array(array)
        self._barrier.wait()
        parts = list(self._table)
        self._barrier.wait()
        return parts

    def Allgatherv(self, own, received):
        every, counts = received
        parts = self._all(own)
        assert [part.size for part in parts] == list(counts)
        every.ravel()[:] = np.concatenate([part.ravel() for part in parts])

    def Allgather(self, own, every):
        every[:] = np.concatenate(self._all(own))

    def Allreduce(self, own, total):
        total[...] = sum(self._all(own))


def by_processes(count, action):
    """What action(together) returns in each of so many processes."""
    table, barrier, results = [None] * count, threading.Barrier(count), [None] * count

    def one(number):
        try:
            results[number] = action(Together(Communicator(count, number, table, barrier)))
        except BaseException:
            barrier.abort()
            raise

    threads = [threading.Thread(target=one, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(result is not None for result in results)
    return results


@pytest.fixture(scope="module")
def cloud():
    """Mass and place of particles that lie closer towards the middle."""
    random = np.random.default_rng(5)
    directions = random.normal(size=(COUNT, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return np.full(COUNT, 1.0 / COUNT), directions * random.uniform(size=COUNT)[:, None]


def evaluated(together, mass, position, targets):
    """Densities, sums over neighbours with their virial, and gravity, of targets or of all, as named arrays."""
    engine = Engine("float64", 1, together=together) if together else Engine("float64", 1)
    order, arrangement = engine.arrange(position, np.full(COUNT, 0.1))
    position, mass, guess = position[order], mass[order], np.full(COUNT, 0.1)
    arrangement = engine.listed(arrangement, KERNEL, position, guess, targets)
    solved = engine.density(arrangement, KERNEL, position, mass, guess, 1.2, 1e-6, True, targets)
    length = guess.copy()
    length[slice(None) if targets is None else targets] = solved.smoothing_length
    fields = {"mass": mass, "position": position, "smoothing_length": length, "zeta_over_omega": np.ones(COUNT)}
    everyone = targets is None
    sums = engine.neighbour_sums(arrangement, KERNEL, (SOFTENING,), fields, virial=everyone, targets=targets)
    arrays = {"length": solved.smoothing_length, "density": solved.density, "zeta": solved.zeta, **sums["gravity"]}
    if everyone:
        more = () if together is None else (together,)
        arrays["far"], arrays["potential"] = multipole.gravity(
            mass, position, length, None, 1e-4, None, 1, None, "float64", *more
        )
    return arrays


@pytest.mark.slow
@pytest.mark.parametrize("some", [pytest.param(False, marks=pytest.mark.full), True])
def test_several_processes_get_the_bits_of_one(cloud, some):
    targets = np.flatnonzero(np.random.default_rng(3).uniform(size=COUNT) < 0.6) if some else None
    alone = evaluated(None, *cloud, targets)
    rows = len(alone["density"])
    for arrays in by_processes(PROCESSES, lambda together: evaluated(together, *cloud, targets)):
        assert arrays.keys() == alone.keys()
        for name, array in arrays.items():
            np.testing.assert_array_equal(array, alone[name], err_msg=name)
    assert rows > PROCESSES * FEWEST  # else nothing was shared out


@pytest.mark.slow
def test_every_process_does_its_part_alone(cloud):
    def received(together):
        evaluated(together, *cloud, None)
        return together.received, together.part("neighbours", np.arange(COUNT + 1))

    found = by_processes(PROCESSES, received)
    assert min(bytes_got for bytes_got, _ in found) > 0
    ends = [(part.first, part.last) for _, part in found]
    assert ends[0][0] == 0
    assert ends[-1][1] == COUNT
    assert all(before[1] == after[0] for before, after in pairwise(ends))


def test_shares_follow_the_times_that_they_took():
    def shares(together):
        together.part("pass", np.arange(10_001))
        for _ in range(20):  # the first is four times as slow as the others
            together.taken["pass"] = together.shares["pass"][together.number] * (4.0 if together.number == 0 else 1.0)
            together.rebalance()
        return together.shares["pass"]

    first, *others = by_processes(PROCESSES, shares)
    for other in others:
        np.testing.assert_array_equal(first, other)
    np.testing.assert_allclose(first, np.array([1.0, 4.0, 4.0]) / 9.0, rtol=1e-3)


def test_a_process_that_stands_still_keeps_a_little_and_times_of_nothing_say_nothing():
    def shares(together):
        together.part("pass", np.arange(10_001))
        together.taken["pass"] = 1e-6
        together.rebalance()
        unchanged = together.shares["pass"].copy()
        for _ in range(50):
            together.taken["pass"] = 1e6 if together.number == 0 else 1.0
            together.rebalance()
        return unchanged, together.shares["pass"]

    for unchanged, last in by_processes(2, shares):
        np.testing.assert_array_equal(unchanged, [0.5, 0.5])
        assert last[0] == pytest.approx(SMALLEST / 2 / (SMALLEST / 2 + 1.0), rel=0.3)


def test_passes_of_few_rows_are_made_everywhere():
    def part(together):
        return together.part("pass", np.arange(2 * FEWEST))

    for share in by_processes(2, part):
        assert (share.first, share.last) == (0, 2 * FEWEST - 1)
        np.testing.assert_array_equal(share.whole(np.arange(5)), np.arange(5))
