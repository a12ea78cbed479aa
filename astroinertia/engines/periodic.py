"""Pair sums in a periodic box: an engine that also sees the images of particles beyond the faces.

Images are sources only. They lie where the particles are that they are images of, moved by whole lengths of the box,
and have all else from those. The positions of the state are never wrapped: a particle that leaves through a face goes
on, and is brought back into the box for the search of neighbours alone. With x_i - (x_j + L) = -(x_j - (x_i - L)) a
pair's two sides remain opposite to round-off.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from itertools import product
from typing import Any

import numpy as np

from astroinertia.engines import numba_cpu
from astroinertia.engines.terms import Density, PairTerm
from astroinertia.errors import NumericalError

MOST_LENGTHS = 1000  # of the box along an axis, over which particles may reach
MOST_IMAGES, MANY = 300, 10_000  # of each particle, where there are that many: they are to fit into memory
IMAGES_OF_FEW = 16  # of each of few particles, among which all are still looked at sooner than listed
MARGIN = 1.1  # images are made for reaches so much larger, so that they serve for some steps


@dataclass(frozen=True, eq=False)
class Images:
    """Particles and images as the inner engine has them sorted, M in all.

    source (M,): which particle each is or is an image of; shift (M, 3): how far from it; place (N,): where each
    particle itself is; present: {(axis, lengths of the box): (N,) whether it has an image there}; pairs: the inner
    arrangement.
    """

    source: np.ndarray
    shift: np.ndarray
    place: np.ndarray
    present: dict[tuple[int, int], np.ndarray]
    pairs: numba_cpu.Arrangement

    @cached_property
    def everyone(self) -> np.ndarray:
        """All particles as targets of the inner engine, ascending."""
        return np.sort(self.place)

    def targets(self, chosen: Any) -> tuple[np.ndarray, np.ndarray | None]:
        """Some particles, or all (None), as ascending targets; what puts their rows of a result back in order."""
        place = self.place if chosen is None else self.place[chosen]
        if np.all(place[1:] > place[:-1]):
            return place, None
        order = np.argsort(place)
        back = np.empty_like(order)
        back[order] = np.arange(len(order))
        return place[order], back


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Images for some positions (None: to be made when it is known where particles are), and those of all points."""

    images: Images | None
    position: np.ndarray | None = None
    points: np.ndarray | None = None


@dataclass(frozen=True)
class Engine:
    """Pair sums by `inner` in a box of `lengths` (3,), infinite along axes that are open.

    support: the reach of the kernel in smoothing lengths.
    """

    inner: numba_cpu.Engine
    lengths: tuple[float, float, float]
    support: float
    name = "numba_cpu"
    bounded = False

    @property
    def precision(self) -> str:
        """That of the inner engine."""
        return self.inner.precision

    @property
    def threads(self) -> int | None:
        """How many threads; None for all."""
        return self.inner.threads

    @property
    def xp(self) -> Any:
        """That of the inner engine."""
        return self.inner.xp

    def within(self, count: int) -> "Engine":
        """The same for parts of a body of so many particles."""
        return replace(self, inner=self.inner.within(count))

    def arrange(self, position: Any, smoothing_length: Any) -> tuple[np.ndarray, Arrangement]:
        """Sort particles into leaves with their images: order (N,), and the arrangement of position[order]."""
        images = self._images(position, smoothing_length)
        order = np.argsort(images.place)
        new = np.empty_like(order)
        new[order] = np.arange(len(order))
        present = {key: mask[order] for key, mask in images.present.items()}
        return order, Arrangement(
            replace(images, source=new[images.source], place=images.place[order], present=present)
        )

    def subset(self, arrangement: Arrangement, indices: Any, smoothing_length: Any) -> Arrangement:
        """The arrangement of some particles alone, in the order that they have; sorted when they are listed."""
        return Arrangement(None)

    def stale(self, arrangement: Arrangement, position: Any, smoothing_length: Any) -> bool:
        """Whether particles are to be sorted again, in leaves that are as compact as before."""
        images = arrangement.images
        if images is None:
            return True
        points, h = self._points(images, position), np.asarray(smoothing_length)[images.source]
        return self.inner.stale(images.pairs, points, h) or not self._covers(images, position, smoothing_length)

    def listed(
        self, arrangement: Arrangement, kernel: str, position: Any, smoothing_length: Any, targets: Any = None
    ) -> Arrangement:
        """The arrangement with the images and lists of neighbours that all passes at these positions then share."""
        images, points = self._seen(arrangement, position, smoothing_length)
        chosen, _ = images.targets(targets)
        pairs = self.inner.listed(images.pairs, kernel, points, np.asarray(smoothing_length)[images.source], chosen)
        return Arrangement(replace(images, pairs=pairs), position, points)

    def near(self, arrangement: Arrangement, kernel: str, position: Any, reach: Any, members: Any) -> np.ndarray:
        """Particles that may be within reach of the members, or these of them, (N,) bool."""
        images = self._covering(None, position, reach)
        chosen, _ = images.targets(members)
        reached = self.inner.near(images.pairs, kernel, self._points(images, position), reach[images.source], chosen)
        near = np.zeros(len(position), bool)
        near[images.source[reached]] = True
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
        """Smoothing lengths and densities as the inner engine's; images are added until all that is in reach is."""
        first, mass = np.array(guess, dtype=np.float64), np.asarray(mass)
        while True:
            images, points = self._seen(arrangement, position, first)
            chosen, back = images.targets(targets)
            solved = self.inner.density(
                images.pairs, kernel, points, mass[images.source], first[images.source], eta, tolerance, softening,
                chosen,
            )  # fmt: skip
            rows = [solved.smoothing_length, solved.density, solved.grad_h, solved.zeta]
            solved = Density(*(row if row is None or back is None else row[back] for row in rows))
            reached = np.array(guess, dtype=np.float64)
            reached[slice(None) if targets is None else targets] = solved.smoothing_length
            if self._covers(images, position, reached):
                return solved
            arrangement, first = Arrangement(None), np.maximum(first, reached)

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
        """Sums over pairs as the inner engine's, a row for each particle or target; there is no virial tensor."""
        if virial:
            raise ValueError("a periodic box has no virial tensor: its matter has no place of its own")
        position, count = fields["position"], len(fields["mass"])
        images, points = self._seen(arrangement, position, fields["smoothing_length"])

        def spread(array: Any) -> Any:
            return array[images.source] if getattr(array, "ndim", 0) and len(array) == count else array

        seen = {name: spread(array) for name, array in fields.items()} | {"position": points}
        spans = None if interval is None else tuple(spread(span) for span in interval)
        chosen, back = images.targets(targets)
        sums = self.inner.neighbour_sums(images.pairs, kernel, terms, seen, False, chosen, spans)
        if back is None:
            return sums
        return {effect: {name: rows[back] for name, rows in outputs.items()} for effect, outputs in sums.items()}

    def all_pair_sums(
        self, arrangement: Arrangement, kernel: str, terms: Sequence[PairTerm], fields: dict, virial: bool = False
    ) -> dict[str, dict[str, np.ndarray]]:
        """Refused: what acts over all distances has no end in a periodic box."""
        raise ValueError("sums over all pairs have no end in a periodic box")

    def _seen(self, arrangement: Arrangement, position: Any, h: Any) -> tuple[Images, np.ndarray]:
        images = self._covering(arrangement.images, position, h)
        if images is arrangement.images and arrangement.position is position and arrangement.points is not None:
            return images, arrangement.points
        return images, self._points(images, position)

    def _covering(self, images: Images | None, position: Any, h: Any) -> Images:
        if images is not None and self._covers(images, position, h):
            return images
        return self._images(position, h)

    def _points(self, images: Images, position: Any) -> np.ndarray:
        return position[images.source] + images.shift

    def _covers(self, images: Images, position: Any, h: Any) -> bool:
        home = np.asarray(position) + images.shift[images.place]
        wanted = self._wanted(home, self.support * np.asarray(h))
        nowhere = np.zeros(len(home), bool)
        return all(np.all(images.present.get(key, nowhere) >= mask) for key, mask in wanted.items())

    def _wanted(self, home: np.ndarray, reach: np.ndarray) -> dict[tuple[int, int], np.ndarray]:
        """Which particles need an image so many lengths along an axis: {(axis, lengths): (N,)}, lengths not 0.

        Those are in reach of a particle, or have one in their own reach, that lies as far out as any does.
        NumericalError for a box that is much smaller than their reach.
        """
        wanted = {}
        for axis, length in enumerate(self.lengths):
            if not np.isfinite(length):
                continue
            x = home[:, axis]
            low, high = x.min(), x.max()
            seen_from, seen_to = (x - reach).min(), (x + reach).max()
            lengths = (high - low + reach.max()) / length
            if not lengths <= MOST_LENGTHS:
                message = f"particles reach over {lengths:.2g} lengths of the box along {'xyz'[axis]}"
                raise NumericalError(f"{message}: it is too small for them")
            far = int(np.ceil(lengths))
            for k in range(-far, far + 1):
                image = x + k * length
                mask = (image >= np.minimum(low - reach, seen_from)) & (image <= np.maximum(high + reach, seen_to))
                if k and mask.any():
                    wanted[axis, k] = mask
        return wanted

    def _images(self, position: Any, smoothing_length: Any) -> Images:
        position, h = np.asarray(position, dtype=np.float64), np.asarray(smoothing_length, dtype=np.float64)
        count, lengths = len(position), np.array(self.lengths)
        finite = np.isfinite(lengths)
        size = np.where(finite, lengths, 1.0)
        wrap = np.where(finite, -size * np.round(position / size), 0.0)
        present = self._wanted(position + wrap, MARGIN * self.support * h)
        steps = [[0, *(k for a, k in present if a == axis)] for axis in range(3)]
        every = np.ones(count, bool)
        sources, shifts, made = [np.arange(count)], [wrap], 0
        for cell in product(*steps):
            if any(cell):
                masks = [present[axis, k] for axis, k in enumerate(cell) if k]
                chosen = np.flatnonzero(reduce(np.logical_and, masks, every))
                sources.append(chosen)
                shifts.append(wrap[chosen] + np.array(cell) * size)
                made += len(chosen)
                if made > MOST_IMAGES * max(count, MANY):
                    message = f"the box is so small for its particles that each needs over {made // count} images"
                    raise NumericalError(message)
        source, shift = np.concatenate(sources), np.concatenate(shifts)
        order, pairs = self.inner.arrange(position[source] + shift, h[source])
        place = np.empty(len(order), np.int64)
        place[order] = np.arange(len(order))
        return Images(source[order], shift[order], place[:count], present, pairs)
