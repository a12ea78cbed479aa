"""Passes over particles that several processes carry out together: each sums for its share, and all have all sums.

Every process holds all particles and takes the same steps; what is sent is the results of a pass, some ten numbers a
particle. A particle's sum does not depend on who makes it, so results have the same bits for any number of processes.
Shares follow the times that the last passes took. Tests: tests/unit/engines/test_together.py, tests/scale/test_mpi.py.
"""

import time as clock
from typing import Any

import numpy as np

FEWEST = 256  # rows for each process, below which it takes less time to make all of them everywhere than to send them
NOTICED = 1e-3  # seconds, below which the times of passes say nothing about shares
SMALLEST = 0.2  # of an equal share, that a process is left with at least


class Part:
    """The pieces [first, last) of a pass, here all there are, and what puts the results of all processes together."""

    def __init__(self, first: int, last: int) -> None:
        self.first, self.last = first, last

    def whole(self, rows: np.ndarray) -> np.ndarray:
        """The rows of all processes, (all, ...), in their order; rows: of this one, (own, ...)."""
        return rows

    def added(self, array: np.ndarray) -> np.ndarray:
        """The sum over processes of an array, of which each has set elements of its own and left the others 0."""
        return array


class Alone:
    """One process, which does all of every pass."""

    def part(self, name: str, edges: np.ndarray) -> Part:
        """What this process does of the pass of that name, whose pieces lie between edges (pieces + 1,).

        edges: rows of the results before each piece, from 0 to all of them. No piece is divided.
        """
        return Part(0, len(edges) - 1)

    def rebalance(self) -> None:
        """Share passes out by the times that they took; all processes do so at the same point of a step."""


class Together(Alone):
    """Processes that share out every pass, by a communicator of mpi4py.

    shares: of each process, (processes,), by the name of a pass; taken: seconds that this one has worked on its own
    since they were made; received: bytes of results.
    """

    def __init__(self, communicator: Any) -> None:
        self.communicator = communicator
        self.number, self.count = communicator.Get_rank(), communicator.Get_size()
        self.shares: dict[str, np.ndarray] = {}
        self.taken: dict[str, float] = {}
        self.received = 0

    def part(self, name: str, edges: np.ndarray) -> Part:
        """As of one process; all of a pass of few rows."""
        rows = int(edges[-1])
        if rows < FEWEST * self.count:
            return Part(0, len(edges) - 1)
        shares = self.shares.setdefault(name, np.full(self.count, 1.0 / self.count))
        ends = np.searchsorted(edges, np.cumsum(shares)[:-1] * rows)
        cuts = np.concatenate([[0], ends, [len(edges) - 1]])
        return Share(self, name, cuts, np.diff(np.asarray(edges)[cuts]))

    def rebalance(self) -> None:
        """The same of those passes whose times say something."""
        for name, shares in self.shares.items():
            times = np.empty(self.count)
            self.communicator.Allgather(np.array([self.taken.pop(name, 0.0)]), times)
            if times.min() > NOTICED:
                wanted = shares / np.sqrt(times)
                wanted = np.maximum(wanted / wanted.sum(), SMALLEST / self.count)
                self.shares[name] = wanted / wanted.sum()


class Share(Part):
    """One process's part of a pass that is shared out; cuts: pieces, (processes + 1,); rows: of each process."""

    def __init__(self, together: Together, name: str, cuts: np.ndarray, rows: np.ndarray) -> None:
        super().__init__(int(cuts[together.number]), int(cuts[together.number + 1]))
        self._together, self._name, self._rows, self._begun = together, name, rows, clock.perf_counter()

    def whole(self, rows: np.ndarray) -> np.ndarray:
        """As of a part of one process; what is waited for here does not count as work."""
        taken, name = self._together.taken, self._name
        taken[name] = taken.get(name, 0.0) + clock.perf_counter() - self._begun
        every = np.empty((int(self._rows.sum()), *rows.shape[1:]), rows.dtype)
        counts = self._rows * int(np.prod(rows.shape[1:], dtype=np.int64))
        self._together.communicator.Allgatherv(np.ascontiguousarray(rows), [every, counts])
        self._together.received += every.nbytes - rows.nbytes
        self._begun = clock.perf_counter()
        return every

    def added(self, array: np.ndarray) -> np.ndarray:
        """As of a part of one process."""
        total = np.empty_like(array)
        self._together.communicator.Allreduce(array, total)
        return total


ALONE = Alone()
