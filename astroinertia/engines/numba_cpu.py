"""The numba engine: pair sums on the processor's cores, in loops compiled for just the terms that are asked for.

Particles are sorted into the leaves of a balanced tree (engines/tree.py). A leaf gathers the particles that can reach
it, and each of its particles sums over them in one vectorised loop. Every sum is one-sided and has a fixed order, so
results have the same bits whatever the number of threads.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from astroinertia.engines import tree
from astroinertia.engines.elementwise import COMPILED
from astroinertia.engines.few import FEW
from astroinertia.engines.few_sources import rows_of, sources_of, tables_of
from astroinertia.engines.numba_modules import (
    all_pairs_pass,
    density_pass,
    few_all_pairs_pass,
    few_neighbour_pass,
    lists_pass,
    neighbour_pass,
)
from astroinertia.engines.numba_parts import GROUP, PACKED
from astroinertia.engines.numba_passes import AXES, INTERVALS, VIRIAL_AXES, Needs, virial_effects
from astroinertia.engines.numba_vectors import LANES
from astroinertia.engines.pytree import with_fields
from astroinertia.engines.terms import Density, PairTerm, field_named
from astroinertia.engines.threads import available_threads, carry_out
from astroinertia.engines.together import ALONE, Alone, Part
from astroinertia.sph.kernels import KERNELS

LEAF_SIZE = 32  # most particles in a leaf
ALL_PAIRS_SIZE = 128  # most particles in a target node of a sum over all pairs
WORTH = 4  # pieces of a pass that a thread must have to be worth starting, which takes some 15 us
LISTING = 8  # times as many of lists, which take an eighth as long as sums over the neighbours in them
CARRIED = 6000  # particles that settle sooner with a run's larger programs than others for them are compiled
LISTED = 1.05  # how far h may grow before the neighbours of a particle are gathered again
LOOSENED = 1.3  # growth of the work in a neighbour pass at which sorting again pays
SHAPES = {"central": (3,), "sum": (), "max": (), "outer": (3, 3), "symmetric": (3, 3)}
FINEST = {"float64": 1e-15, "mixed": 3e-7}  # relative steps in h below this are round-off


@dataclass(frozen=True, eq=False)
class Targets:
    """Particles that a pass has results for: ascending indices, of which leaf l has begin[l] to begin[l+1]-1.

    groups, leaves: the groups of neighbouring leaves, and the leaves, that have any.
    """

    indices: np.ndarray
    begin: np.ndarray
    groups: np.ndarray
    leaves: np.ndarray


@dataclass(frozen=True, eq=False)
class Lists:
    """The particles that can reach each leaf that has targets: pool[offset[l] : offset[l] + count[l]].

    They hold for these positions and for smoothing lengths up to `length`, both (N,) in arranged order.
    """

    position: np.ndarray
    length: np.ndarray
    support: float
    nodes: tree.Nodes
    targets: Targets
    offset: np.ndarray
    count: np.ndarray
    pool: np.ndarray


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Leaves of particles in arranged order; nodes [first, last) of their tree; all particles as targets.

    volume: the compactness that the leaves started with. lists: neighbours at some positions (see `Engine.listed`).
    """

    leaves: tree.Leaves
    first: np.ndarray
    last: np.ndarray
    everyone: Targets
    volume: float
    lists: Lists | None = None


@dataclass(frozen=True)
class Engine:
    """Pair sums with numba; precision "float64", or "mixed": float32 pairs relative to the leaf, float64 sums.

    threads: how many; None for all that numba would use (NUMBA_NUM_THREADS). programs: the terms of sums over
    neighbours that are compiled anyway; one of them does for sums of some of its effects, up to CARRIED particles.
    images: how many of each of few particles there may be, itself among them, until they are no longer few.
    among: particles of the body that those at hand are part of: where these are many, so are those.
    together: the processes that share out sums over neighbours; sums over all pairs, which are of few particles, each
    makes for itself.
    """

    precision: str = "float64"
    threads: int | None = None
    programs: tuple[tuple[PairTerm, ...], ...] = ()
    together: Alone = ALONE
    images: int = 1
    among: int = 0
    name = "numba_cpu"
    bounded = True  # matter comes to an end somewhere

    def __post_init__(self) -> None:
        if self.precision not in FINEST:
            raise ValueError(f"precision must be one of {', '.join(FINEST)}, not {self.precision!r}")

    @property
    def xp(self) -> Any:
        """What work on each particle by itself is done with (elementwise)."""
        return np if self.among <= FEW else COMPILED

    @property
    def workers(self) -> int:
        """Number of threads."""
        return self.threads or available_threads()

    def within(self, count: int) -> "Engine":
        """The same for parts of a body of so many particles, by the programs that these have."""
        return replace(self, among=count)

    def arrange(self, position: Any, smoothing_length: Any) -> tuple[np.ndarray, Arrangement]:
        """Sort particles into leaves: order (N,), and the arrangement of position[order]."""
        position = _array(position)
        order, leaves = tree.arrange(position, LEAF_SIZE, self.workers)
        volume = _expanded_volume(leaves, position[order], _array(smoothing_length)[order], self.workers)
        return order, _arrangement(leaves, volume)

    def subset(self, arrangement: Arrangement, indices: Any, smoothing_length: Any) -> Arrangement:
        """The arrangement of some particles alone, in the order that they have: that of position[indices].

        indices: ascending. Leaves are of the usual size, and never called stale.
        """
        return _of_balanced_leaves(len(indices))

    def stale(self, arrangement: Arrangement, position: Any, smoothing_length: Any) -> bool:
        """Whether the leaves have loosened so much that sorting particles again pays."""
        volume = _expanded_volume(arrangement.leaves, _array(position), _array(smoothing_length), self.workers)
        return not volume <= LOOSENED * arrangement.volume

    def listed(
        self, arrangement: Arrangement, kernel: str, position: Any, smoothing_length: Any, targets: Any = None
    ) -> Arrangement:
        """The arrangement with the lists of neighbours that all passes at these positions then share.

        smoothing_length: (N,) as it is known so far; where it has become known better, lists that hold still stay. A
        pass that is given another array of positions, targets that are not listed or lengths grown by more than LISTED
        makes lists for itself. Whoever changes the positions within their array must list again before they have moved
        by as much as the lengths were handed in too large. Programs of few particles need none.
        """
        if arrangement.lists is None:
            self.together.rebalance()
        if self._few(len(position)):
            return arrangement
        mine, _ = self._part(arrangement, _targets(arrangement, targets))
        where = arrangement, mine, kernel, _array(position)
        length = _array(smoothing_length)
        lists = self._holding(*where, length) or self._lists(*where, LISTED * length)
        return with_fields(arrangement, lists=lists)

    def near(self, arrangement: Arrangement, kernel: str, position: Any, reach: Any, members: Any) -> np.ndarray:
        """Particles that may be within reach of the members, or these of them, (N,) bool.

        reach: in units of the kernel's support, (N,); members: ascending indices.
        """
        chosen = _targets(arrangement, members)
        lists = self._lists(arrangement, chosen, kernel, _array(position), LISTED * _array(reach))
        near = np.zeros(len(position), bool)
        for leaf in lists.targets.leaves:
            near[lists.pool[lists.offset[leaf] : lists.offset[leaf] + lists.count[leaf]]] = True
        return near

    def density(
        self,
        arrangement: Arrangement,
        kernel: str,
        position: Any,
        mass: Any,
        guess: Any,
        eta: float,
        tolerance: float,
        softening: bool = False,
        targets: Any = None,
    ) -> Density:
        """Smoothing lengths such that rho = m (eta/h)^3 to a relative tolerance in h, from a guess (N,).

        targets: ascending indices of the particles to solve for, a row of the results each; None for all.
        Raises ValueError if guess or mass is not positive, or if no smoothing length can hold enough particles.
        """
        position, mass, guess = _array(position), _array(mass), _array(guess)
        few = self._few(len(mass))
        _, function = density_pass(kernel, self.precision, softening, few)
        chosen = _targets(arrangement, targets)
        first = guess if targets is None else guess[chosen.indices]
        if first.min(initial=1.0) <= 0.0 or (targets is None and mass.min(initial=1.0) <= 0.0):
            raise ValueError("masses and the first guess of smoothing lengths must be positive")
        if targets is None and mass.sum() * KERNELS[kernel].w(np, 0.0) <= mass.max() * eta**3:
            raise ValueError(f"{len(mass)} particles are too few for a smoothing length of {eta:.3g} (m/rho)^(1/3)")
        mine, part = self._part(arrangement, chosen)
        if few:
            sides = np.ptp(position, axis=0)
            sources = rows_of((*AXES, "mass"), sources_of(position, mass, guess), KERNELS[kernel].support)
            given = sources, mine.indices, mine.begin, mine.leaves, guess
        else:
            where = arrangement, mine, kernel, position
            lists = self._holding(*where, guess, LISTED) or self._lists(*where, LISTED * guess)
            nodes = lists.nodes
            sides = nodes.rows[3:6, 1] - nodes.rows[:3, 1]
            given = (
                *nodes.columns, position, guess, mass, nodes.rows, arrangement.leaves.start, mine.indices, mine.begin,
                mine.leaves, lists.offset, lists.count, lists.pool,
            )  # fmt: skip
        # Where many particles lie in one place, no h is small enough.
        smallest = 1e-12 * float(np.sqrt((sides**2).sum()))
        options = (KERNELS[kernel].support, LISTED, eta, max(tolerance, FINEST[self.precision]), smallest)
        results = np.empty((4, len(mine.indices)))
        carry_out(function, self._workers_for(mine), *given, np.array(options, dtype=np.float64), results)
        length, density, grad_h, *zeta = map(part.whole, results if softening else results[:3])
        # The length outlasts the others, which it would hold all together.
        return Density(length.copy(), density, grad_h, zeta[0] if softening else None)

    def neighbour_sums(
        self,
        arrangement: Arrangement,
        kernel: str,
        terms: Sequence[PairTerm],
        fields: dict,
        virial: bool = False,
        targets: Any = None,
        interval: Any = None,
    ) -> dict[str, dict[str, np.ndarray]]:
        """Sums over pairs closer than the larger of their two supports: {effect: {output: array}}.

        targets: ascending indices of the particles to sum for, a row of the results each; None for all.
        interval: (closing, opening), two arrays (N,): "central" and "sum" outputs are given a second time, with
        _impulse after their names, each pair's value multiplied by the larger of their two closing intervals plus the
        larger of the opening ones. Pairs with a negative opening interval have no impulse; a closing one above 1e30
        counts as 0.
        """
        if not terms:
            return {}
        if interval is not None:
            fields = {**fields, **dict(zip(INTERVALS, interval, strict=True))}
        leaves, wanted = arrangement.leaves, {term.effect for term in terms}
        position, mass, smoothing_length = _fields(fields)
        terms = self._carried_by(tuple(terms), len(mass))
        virials = virial or (interval is None and self._in_one_program(terms, len(mass)))
        intervals = interval is not None
        few = self._few(len(mass))
        module, sums, needs = (
            few_neighbour_pass(kernel, terms, virials, intervals)
            if few
            else neighbour_pass(kernel, terms, self.precision, virials, intervals)
        )
        if wanted != {term.effect for term in terms}:  # what others ask for: nothing is made of their results
            fields = {**{name: 0.0 for name, _ in needs.fields}, **fields}
        named, support = _named(fields, needs, len(mass)), float(KERNELS[kernel].support)
        mine, part = self._part(arrangement, _targets(arrangement, targets))
        workers = self._workers_for(mine)
        results, arrays = _results(np.empty, needs, virials, len(mine.indices), leaves.count)
        if few:
            given = tables_of(needs, sources_of(position, mass, smoothing_length, needs.arrays, named), support)
            carry_out(sums, workers, *given, mine.indices, mine.begin, mine.leaves, *arrays)
        else:
            where = arrangement, mine, kernel, position
            lists = self._holding(*where, smoothing_length) or self._lists(*where, smoothing_length)
            inputs = (position, smoothing_length, mass, support, *named)
            packed = mine is arrangement.everyone or lists.count[mine.leaves].sum() > len(mass)
            table = np.empty((len(mass) if packed else 0, needs.width))
            if packed:
                carry_out(module.pack, max(1, min(workers, len(mass) // (WORTH * PACKED))), *inputs, table)
            carry_out(
                sums, workers, *inputs, table, mine.indices, mine.begin, mine.leaves, lists.offset, lists.count,
                lists.pool, *arrays,
            )  # fmt: skip
        made_here = {effect: results[effect] for effect in results if effect in wanted}
        return _finished(_of_all(made_here, part), virial)

    def _carried_by(self, terms: tuple[PairTerm, ...], count: int) -> tuple[PairTerm, ...]:
        """The terms of the program that makes sums of these; up to CARRIED particles none is compiled for a few."""
        effects = {term.effect for term in terms}
        for program in self.programs if count <= CARRIED else ():
            if tuple(term for term in program if term.effect in effects) == terms:
                return program
        return terms

    def all_pair_sums(
        self, arrangement: Arrangement, kernel: str, terms: Sequence[PairTerm], fields: dict, virial: bool = False
    ) -> dict[str, dict[str, np.ndarray]]:
        """Sums over all pairs; pairs beyond both supports go through the terms' far forms."""
        if not terms:
            return {}
        leaves = arrangement.leaves
        position, mass, smoothing_length = _fields(fields)
        virials = virial or self._in_one_program(terms, len(mass))
        support = float(KERNELS[kernel].support)
        if self._few(len(mass)):
            _, sums, needs = few_all_pairs_pass(kernel, tuple(terms), virials)
            named = _named(fields, needs, len(mass))
            sources = rows_of(needs.rows, sources_of(position, mass, smoothing_length, needs.arrays, named), support)
            results, arrays = _results(np.zeros, needs, virials, len(mass), leaves.count)
            carry_out(sums, self.workers, sources, leaves.start, *arrays)
            return _finished(results, virial)
        _, sums, needs = all_pairs_pass(kernel, tuple(terms), self.precision, virials)
        targets = leaves.count  # as many nodes of the tree, each with its targets
        while targets > 1 and -(-2 * len(mass) // targets) <= ALL_PAIRS_SIZE:
            targets //= 2
        nodes = tree.fit(leaves, position, smoothing_length, self.workers, self.among)
        results, arrays = _results(np.zeros, needs, virials, len(mass), targets)
        workers = max(1, min(self.workers, targets // WORTH))
        carry_out(
            sums, workers, *nodes.columns, mass, support, support if needs.masked else np.inf, nodes.rows,
            arrangement.first, arrangement.last, targets, *_named(fields, needs, len(mass)), *arrays,
        )  # fmt: skip
        return _finished(results, virial)

    def _few(self, count: int) -> bool:
        """Whether so many particles have programs of their own, which are shorter and take absolute coordinates."""
        return max(count, self.among) <= self.images * FEW and self.precision == "float64"

    def _in_one_program(self, terms: Sequence[PairTerm], count: int) -> bool:
        # Steps ask for no virial tensors and records do: for few particles one program, which makes them, serves both.
        return max(count, self.among) <= FEW and bool(virial_effects(terms))

    def _part(self, arrangement: Arrangement, chosen: Targets) -> tuple[Targets, Part]:
        """Of the targets those that this process sums for: of whole groups of leaves."""
        edges = _group_edges(arrangement, chosen.begin)
        part = self.together.part("neighbours", edges)
        first, last = edges[part.first], edges[part.last]
        if last - first == len(chosen.indices):
            return chosen, part
        return _chosen(arrangement, chosen.indices[first:last], np.clip(chosen.begin - first, 0, last - first)), part

    def _holding(
        self, arrangement: Arrangement, chosen: Targets, kernel: str, position: np.ndarray, h: np.ndarray,
        margin: float = 1.0,
    ) -> Lists | None:  # fmt: skip
        """The arrangement's lists if they hold for all of this, for lengths up to margin h."""
        held = arrangement.lists
        if held is None or held.position is not position or held.support != float(KERNELS[kernel].support):
            return None
        every = held.targets is arrangement.everyone  # whose lists serve any targets
        same = every or held.targets is chosen or np.array_equal(held.targets.indices, chosen.indices)
        # A density asks for the reach of its targets alone, other sums for that of all particles.
        some = slice(None) if margin == 1.0 or chosen is arrangement.everyone else chosen.indices
        return held if same and bool((margin * h[some] <= held.length[some]).all()) else None

    def _lists(
        self, arrangement: Arrangement, chosen: Targets, kernel: str, position: np.ndarray, length: np.ndarray
    ) -> Lists:
        leaves, support = arrangement.leaves, float(KERNELS[kernel].support)
        few = max(len(position), self.among) <= FEW
        length = np.full_like(length, np.inf) if few else length
        nodes = tree.fit(leaves, position, length, self.workers, self.among)
        offset, count = np.zeros((2, leaves.count), np.int64)
        if few:  # any may be near, whatever its length: the program that finds out is sooner run without than compiled
            count[chosen.leaves] = len(position)
            everyone = np.arange(len(position), dtype=np.int32)
            return Lists(position, length, support, nodes, chosen, offset, count, everyone)
        room = 32 * len(chosen.leaves) * LEAF_SIZE
        while True:
            pool, used = np.empty(room, np.int32), np.zeros(1, np.int64)
            carry_out(
                lists_pass(), self._workers_for(chosen, LISTING * WORTH), *nodes.columns, position, support, nodes.rows,
                leaves.start, chosen.indices, chosen.begin, chosen.groups, offset, count, pool, used,
            )  # fmt: skip
            if used[0] <= room:
                pool.resize(used[0] + LANES, refcheck=False)  # passes read on by up to a vector
                return Lists(position, length, support, nodes, chosen, offset, count, pool)
            room = int(used[0])

    def _workers_for(self, chosen: Targets, worth: int = WORTH) -> int:
        # Few targets are sooner done than other threads are started.
        return max(1, min(self.workers, len(chosen.groups) // worth))


def _array(values: Any) -> np.ndarray:
    return np.ascontiguousarray(values, dtype=np.float64)


def _arrangement(leaves: tree.Leaves, volume: float) -> Arrangement:
    first, last = np.zeros((2, 2 * leaves.count), np.int64)
    for level in range(leaves.depth + 1):
        edges = leaves.start[:: 1 << (leaves.depth - level)]
        first[1 << level : 2 << level], last[1 << level : 2 << level] = edges[:-1], edges[1:]
    groups = np.arange(max(leaves.count // GROUP, 1))
    everyone = Targets(np.arange(leaves.start[-1]), leaves.start, groups, np.arange(leaves.count))
    return Arrangement(leaves, first, last, everyone, volume)


@lru_cache(maxsize=8)
def _of_balanced_leaves(count: int) -> Arrangement:
    # Nested sets of the same sizes follow each other.
    return _arrangement(tree.balanced_leaves(count, LEAF_SIZE), np.inf)


def _targets(arrangement: Arrangement, targets: Any) -> Targets:
    if targets is None:
        return arrangement.everyone
    held = arrangement.lists
    if held is not None and held.targets.indices is targets:
        return held.targets
    indices = np.ascontiguousarray(targets, dtype=np.int64)
    start = arrangement.leaves.start
    if len(indices) and (indices[0] < 0 or indices[-1] >= start[-1] or (indices[1:] <= indices[:-1]).any()):
        raise ValueError(f"targets must be ascending indices of the {start[-1]} particles")
    return _chosen(arrangement, indices, np.searchsorted(indices, start))


def _chosen(arrangement: Arrangement, indices: np.ndarray, begin: np.ndarray) -> Targets:
    edges = _group_edges(arrangement, begin)
    return Targets(indices, begin, (edges[1:] > edges[:-1]).nonzero()[0], (begin[1:] > begin[:-1]).nonzero()[0])


def _group_edges(arrangement: Arrangement, begin: np.ndarray) -> np.ndarray:
    return begin[:: min(GROUP, arrangement.leaves.count)]


def _fields(fields: dict) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return _array(fields["position"]), _array(fields["mass"]), _array(fields["smoothing_length"])


def _named(fields: dict, needs: Needs, count: int) -> list[np.ndarray]:
    arrays = []
    for name, of_vectors in needs.fields:
        shape = (count, 3) if of_vectors else (count,)
        array = _array(field_named(fields, name))
        arrays.append(array if array.shape == shape else _array(np.broadcast_to(array, shape)))
    return arrays


def _results(
    made: Callable, needs: Needs, virial: bool, count: int, leaves: int
) -> tuple[dict[str, dict[str, np.ndarray]], list[np.ndarray]]:
    # made: np.zeros for what is added to, np.empty for what is set.
    results: dict[str, dict[str, np.ndarray]] = {}
    arrays = []
    for (effect, name), how in needs.results.items():
        arrays.append(made((count, *SHAPES[how])))
        results.setdefault(effect, {})[name] = arrays[-1]
    for effect in virial_effects(needs.terms) if virial else ():
        results[effect]["virial"] = np.zeros((leaves, len(VIRIAL_AXES)))
        arrays.append(results[effect]["virial"])
    return results, arrays


def _of_all(results: dict[str, dict[str, np.ndarray]], part: Part) -> dict[str, dict[str, np.ndarray]]:
    return {
        effect: {name: part.added(array) if name == "virial" else part.whole(array) for name, array in outputs.items()}
        for effect, outputs in results.items()
    }


def _finished(results: dict[str, dict[str, np.ndarray]], virial: bool) -> dict[str, dict[str, np.ndarray]]:
    # Leaves are added up in their order, whichever thread did them.
    for outputs in results.values():
        by_leaf = outputs.pop("virial", None)
        if virial and by_leaf is not None:
            outputs["virial"] = tensor = np.empty((3, 3))
            for (a, b), total in zip(VIRIAL_AXES, by_leaf.sum(axis=0), strict=True):
                tensor[a, b] = tensor[b, a] = total
    return results


def _expanded_volume(leaves: tree.Leaves, position: np.ndarray, smoothing_length: np.ndarray, threads: int) -> float:
    """Mean over leaves of the volume of the box widened by two smoothing lengths all round, in units of h^3."""
    nodes = tree.fit(leaves, position, smoothing_length, threads)
    at_leaves = nodes.rows[:, leaves.count : 2 * leaves.count]
    sides = (at_leaves[3:6] - at_leaves[:3]) / at_leaves[6] + 4.0
    return float(np.mean(np.prod(sides, axis=0)))
