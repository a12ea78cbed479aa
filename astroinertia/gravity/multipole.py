"""Gravity in O(N): multipole expansions of the nodes of a tree, opened by a wanted force error (G = 1)."""

import functools
import math
from types import ModuleType
from typing import Any

import numpy as np

from astroinertia.engines.numba_cache import load_module
from astroinertia.engines.numba_modules import neighbour_functions
from astroinertia.engines.numba_passes import header
from astroinertia.engines.numba_vectors import COMPACTED_BITS
from astroinertia.engines.processor import mean_estimates
from astroinertia.engines.templates import template
from astroinertia.engines.threads import available_threads, share_out
from astroinertia.engines.together import ALONE, Alone, Part
from astroinertia.gravity import tree as trees
from astroinertia.gravity.clamped_points import CLAMP, SOFTENED_LESS_POINT
from astroinertia.gravity.expansions import expansions, harmonic, indices, padded_moments
from astroinertia.gravity.tree import MOST_LEVELS, Tree, tree
from astroinertia.sph.kernels import KERNELS

__all__ = ["gravity", "tree"]

OPENING = 0.9  # no expansion where (r_A + r_B)/d is larger
FIRST_OPENING = 0.5  # the same where no accelerations are known yet
SHEET = 2.0  # times M/s^2 of a node: what attracts like a sky full of such nodes
ALIKE = 3.0  # times the tolerance of one node: that of all in one direction together
LEAST = 1e-3  # times M/R^2 of the whole: no particle's tolerance is finer than for this acceleration
GROUPED = 256  # particles of the nodes whose leaves share a list of leaves that are near enough for softening
CLOSER = 4.0  # how much more accurate the evaluation is that accelerations are checked by
CARRIED = 10_000  # particles up to which the program of steps makes that in float64, too: 13 s less to compile
# By order of the expansions, the finest rms error that it is taken for, of few and of MANY particles, and (rms error,
# tolerance) as measured on uniform, Evrard, Plummer and clustered sets of 3000 to 1e5 particles, which agree within a
# factor of 2: on the safe side. Order 7 takes 5 s more to compile, and at 2e-4 3 to 13 % less of an evaluation.
ORDERS = {
    5: ((6e-5, 2.5e-4), ((1.4e-5, 1e-5), (6.5e-5, 1e-4), (1.45e-4, 3e-4), (3.8e-4, 1e-3), (9e-4, 3e-3))),
    7: ((0.0, 0.0), ((8e-7, 1e-6), (5e-6, 1e-5), (3.3e-5, 1e-4), (1e-4, 3.9e-4), (2.5e-4, 9e-4))),
}
MANY = 30_000
COARSE = 6e-5  # errors that the program of accelerations checks itself by
# By bits of vectors, the finest errors for which near pairs take the processor's estimate of 1/r, in mixed precision.
# It leaves rms errors of 5e-6 to 1.5e-5 with 512 bits and of 1e-5 to 7e-5 with 256, of this many particles: errors of
# single pairs average out.
ESTIMATED = {512: 6e-5, 256: 2e-4, 0: math.inf}
AVERAGED = 3000


@functools.lru_cache(maxsize=32)
def _module(p: int, precision: str, estimated: bool) -> ModuleType:
    roots, share, cubed = "once", 1.0, 1.0
    if estimated:
        roots, (share, cubed) = "estimated_roots", mean_estimates(COMPACTED_BITS)
    text = [
        *header(precision),
        template("gravity/compaction.py"),
        "TEST_FLAGS = {'contract', 'nsz', 'arcp', 'afn'}",  # sums keep their order: the same from both sides
        f"CLAMP, LEAST, RADIUS_SLACK = {CLAMP}, {LEAST}, {'1.0 + 1e-6' if precision == 'mixed' else '1.0'}",
        f"MOMENTS = {padded_moments(p)}",
        f"SHEET, ALIKE = real({SHEET}), real({ALIKE})",
        f"roots_of_pairs, OF_FORCE, OF_POTENTIAL = {roots}, real({1.0 / cubed}), real({1.0 / share})",
        *expansions(p),
        template("gravity/refit.py"),
        template("gravity/walk.py"),
    ]
    return load_module(f"multipole_{p}", "\n".join(text))


@functools.lru_cache(maxsize=32)
def _softening(kernel: str, precision: str) -> ModuleType:
    needs, functions = neighbour_functions(kernel, (SOFTENED_LESS_POINT,), precision, "softened_leaf")
    text = [
        *header(precision),
        f"SUPPORT, WIDTH, SPREAD = {float(KERNELS[kernel].support)}, {needs.width}, {needs.spread}",
        f"REACHES = {needs.reaches}",
        *functions,
        template("gravity/softening.py"),
    ]
    return load_module(f"softening_{kernel}", "\n".join(text))


def gravity(
    mass: Any,
    position: Any,
    smoothing_length: Any,
    kernel: str | None,
    accuracy: float,
    strength: Any = None,
    threads: int | None = None,
    tree: Tree | None = None,
    precision: str = "mixed",
    together: Alone = ALONE,
) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration (N, 3) and potential (N,) of mass (N,) at position (N, 3), softened as by gravity.direct.

    kernel: of the softening, None for clamped points (gravity.clamped_points); self pairs are included. accuracy: the
    wanted rms of |da|/|a|; strength (N,): |a| as far as it is known, None for a first evaluation, which takes another
    to find it; tree: `tree(position)` of these particles, or of where they were a little earlier; precision: "mixed"
    (float32 between particles and nodes) or "float64"; together: the processes that share out the sums. Results have
    the same bits for any number of threads and processes. Tested in tests/unit/gravity/test_multipole.py.
    """
    particles = _Particles(mass, position, smoothing_length, tree, precision, threads, together)
    return particles.points(accuracy, strength, kernel=kernel)


def virial(
    mass: Any,
    position: Any,
    smoothing_length: Any,
    accuracy: float,
    strength: Any,
    threads: int,
    tree: Tree,
    precision: str = "mixed",
    together: Alone = ALONE,
) -> np.ndarray:
    """V = sum m x (x) a of clamped points, (3, 3), symmetric; arguments as of `gravity`.

    It is that of an evaluation of its own, CLOSER times as accurate, so that it tells whether accelerations are what
    they should be: an error of 2e-4 leaves 4e-7 to 2e-6 of sum m |x| |a| in their tensor, and 5e-8 to 3e-7 in this one.
    Where coarse errors do, the program of accelerations makes it, which in mixed precision takes the least time, too
    (0.55 to 0.7 of float64's); else, and for more than CARRIED particles in float64, one of a higher order in float64.
    """
    order, _ = settings(accuracy, len(mass))
    same = accuracy >= COARSE and (precision == "mixed" or len(mass) <= CARRIED)
    chosen = precision if same else "float64"
    particles = _Particles(mass, position, smoothing_length, tree, chosen, threads, together)
    closer, _ = particles.points(accuracy, strength, order if same else None, closer=CLOSER)
    tensor = (np.asarray(mass)[:, None] * (position - np.mean(position, axis=0))).T @ closer
    return 0.5 * (tensor + tensor.T)


def strengths(acceleration: np.ndarray) -> np.ndarray:
    """|a| of (N, 3)."""
    return np.sqrt(np.einsum("ij,ij->i", acceleration, acceleration))


def settings(accuracy: float, particles: int, order: int | None = None) -> tuple[int, float]:
    """The order of expansion that takes the least time at a wanted rms error, or the one given, and its tolerance."""
    order = order or next(p for p, (finest, _) in ORDERS.items() if accuracy >= finest[particles >= MANY])
    errors, tolerances = np.log(np.array(ORDERS[order][1])).T
    wanted = math.log(accuracy)
    k = min(max(int(np.searchsorted(errors, wanted)), 1), len(errors) - 1)
    slope = (tolerances[k] - tolerances[k - 1]) / (errors[k] - errors[k - 1])
    return order, math.exp(tolerances[k] + slope * (wanted - errors[k]))


def _estimated(accuracy: float, precision: str, particles: int) -> bool:
    return precision == "mixed" and particles >= AVERAGED and accuracy >= ESTIMATED[COMPACTED_BITS]


class _Particles:
    """Particles and their tree in units in which lengths and masses are about 1, so that float32 holds them."""

    def __init__(
        self, mass: Any, position: Any, smoothing_length: Any, tree: Tree | None, precision: str, threads: int | None,
        together: Alone = ALONE,
    ) -> None:  # fmt: skip
        self.together = together
        self.position = np.ascontiguousarray(position, dtype=np.float64)
        self.mass = np.ascontiguousarray(mass, dtype=np.float64)
        self.smoothing_length = np.ascontiguousarray(smoothing_length, dtype=np.float64)
        self.precision, self.threads = precision, threads or available_threads()
        self.nodes = tree if tree is not None else trees.tree(self.position, threads=self.threads)
        low, high = trees.box(self.position)
        self.origin = 0.5 * (low + high)
        size = float(max(0.5 * (high - low).max(), self.smoothing_length.max()))
        self.scale = _power_of_two(1.0 / size)
        self.mass_scale = _power_of_two(1.0 / max(float(self.mass.sum()), 1e-300))
        self.units = self.scale**2 / self.mass_scale, self.scale / self.mass_scale  # of accelerations and potentials

    def points(
        self, accuracy: float, strength: Any, order: int | None = None, kernel: str | None = None, closer: float = 1.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Acceleration and potential by expansions of an order or of the best, softened by a kernel, or clamped.

        closer: how many times more accurate than the program for that accuracy is by itself.
        """
        order, tolerance = settings(accuracy / closer, len(self.mass), order)
        module = _module(order, self.precision, _estimated(accuracy, self.precision, len(self.mass)))
        if strength is None:
            first, _ = self.sums(module, order, math.inf, FIRST_OPENING, None)
            strength = strengths(first)
        return self.sums(module, order, tolerance, OPENING, strength, kernel)

    def sums(
        self, module: ModuleType, order: int, tolerance: float, theta: float, strength: Any, kernel: str | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Acceleration and potential by a program for an order, softened by a kernel, or of clamped points."""
        real = np.float32 if self.precision == "mixed" else np.float64
        nodes, count = self.nodes, len(self.mass)
        # Without strengths geometry alone opens nodes: no particle asks for an error.
        strength = np.full(count, np.inf) if strength is None else np.ascontiguousarray(strength, dtype=np.float64)
        x, y, z = columns = np.zeros((3, count + 64))
        m, clamp = np.zeros((2, count + 64), real)
        where_is, about = np.empty((nodes.count, 4)), np.empty((nodes.count, 8), real)
        raw = np.empty((nodes.count, len(indices(order - 1))))
        multipoles = np.empty((nodes.count, padded_moments(order)), real)
        structure = (nodes.first, nodes.last, nodes.child)
        share_out(
            module.upward, self.threads, *structure, nodes.task, nodes.begin, nodes.end, nodes.order, self.position,
            self.mass, self.smoothing_length, strength, self.origin, self.scale, self.mass_scale, x, y, z, m, clamp,
            where_is, about, raw, multipoles,
        )  # fmt: skip
        module.upward_top(*structure, nodes.top, where_is, about, raw, multipoles)
        acceleration, potential = np.zeros((count, 3)), np.zeros(count)
        task_of = np.full(nodes.count, -1, np.int32)
        task_of[nodes.task] = np.arange(len(nodes.task))
        handed_end = np.zeros(len(nodes.task), np.int64)
        handed_local = np.zeros((len(nodes.task), len(harmonic(order))))
        rest = (
            *structure, MOST_LEVELS, nodes.parent, where_is, about, multipoles, x, y, z, m, clamp, nodes.order,
            real(theta), real(tolerance), acceleration, potential, *self.units, nodes.leaf_size, handed_end,
            handed_local, task_of,
        )  # fmt: skip
        root, nothing = np.zeros(1, nodes.task.dtype), np.empty(0, np.int32)
        none = np.zeros(1, np.int64)
        handed = module.descend(
            np.zeros(1, np.int64), True, root, nothing, none, none, np.zeros_like(handed_local[:1]), *rest
        )
        handed_begin = np.concatenate([[0], handed_end[:-1]])
        edges = np.append(nodes.first[nodes.task], count)
        part = self.together.part("gravity", edges)
        mine, held = slice(part.first, part.last), nodes.order[edges[part.first] : edges[part.last]]
        share_out(
            module.descend, self.threads, False, nodes.task[mine], handed, handed_begin[mine], handed_end[mine],
            handed_local[mine], *rest,
        )  # fmt: skip
        if kernel is not None:
            self._soften(kernel, columns, m, part, acceleration, potential)
        if len(held) < count:
            for sums in (acceleration, potential):
                sums[nodes.order] = part.whole(sums[held])
        return acceleration, potential

    def _soften(
        self, kernel: str, columns: np.ndarray, mass: np.ndarray, part: Part, acceleration: np.ndarray,
        potential: np.ndarray,
    ) -> None:  # fmt: skip
        # Adds what softening changes about clamped points; columns, mass: of the particles in the tree's order.
        module = _softening(kernel, self.precision)
        nodes, count = self.nodes, len(self.mass)
        first = np.sort(nodes.first[nodes.child == 0])
        start, every = np.append(first, count), np.arange(count)
        small = nodes.last - nodes.first <= GROUPED
        group = np.union1d(nodes.first[small & ~small[nodes.parent]], nodes.first[nodes.task])
        groups = np.append(np.searchsorted(first, group), len(first))
        tasks = np.append(np.searchsorted(group, nodes.first[nodes.task]), len(group))
        length, table, boxes = np.zeros(count + 64), np.empty((count, module.WIDTH)), np.empty((8, len(first) + 64))
        share_out(
            module.fit_boxes, self.threads, nodes.order, self.smoothing_length, self.scale, columns, mass, every, start,
            groups, tasks, length, table, boxes,
        )  # fmt: skip
        share_out(
            module.soften, self.threads, columns, length, table, boxes, every, start, groups,
            tasks[part.first : part.last + 1], nodes.order, *self.units, acceleration, potential,
        )  # fmt: skip


def _power_of_two(value: float) -> float:
    return 2.0 ** math.floor(math.log2(value)) if 0.0 < value < math.inf else 1.0
