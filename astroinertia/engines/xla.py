"""The xla engine: pair sums traced with jax.numpy over dense tiles, for CPU, GPU and TPU, and differentiable.

Every method works inside jax.jit, with arrays in the order that `arrange` gave; `arrange` and `stale` run on the host.
For a fixed arrangement all results can be differentiated forwards and backwards, and again; smoothing lengths are
differentiated implicitly. x64 must be enabled (`jax.enable_x64(True)`).
"""

from dataclasses import dataclass, replace
from functools import partial, reduce
from typing import Any, ClassVar, Literal

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.engines import xla_density, xla_lists, xla_places, xla_tiles
from astroinertia.engines.terms import KERNEL_NAMES, SEPARATION, Density, PairTerm, argument_names, field_named, side_of
from astroinertia.engines.xla_lists import Arrangement
from astroinertia.sph.kernels import KERNELS

Array = Any
Sums = dict[str, dict[str, Any]]


@dataclass(frozen=True)
class Engine:
    """Pair sums by XLA.

    precision: "float64", or "mixed": pairs in float32 on coordinates relative to their leaf, summed in float64.
    support: the reach of the neighbour lists in smoothing lengths. A particle may move by `motion` of its reach and its
    smoothing length grow by `growth` before lists go stale; wider margins put more pairs out of reach into the lists.
    Sums beyond what the lists reach are right, but slow.
    wide_leaf is the leaf of sums over all pairs.
    pairs_in_chunk: how many pairs are in work at once (None: what suits the machine); it bounds the memory.
    """

    precision: Literal["float64", "mixed"] = "float64"
    support: float = 2.0
    motion: float = 0.01
    growth: float = 0.04
    wide_leaf: int = 128
    pairs_in_chunk: int | None = None

    name: ClassVar[str] = "xla"
    bounded: ClassVar[bool] = True
    xp: ClassVar[Any] = jnp

    def __post_init__(self) -> None:
        if self.precision not in ("float64", "mixed"):
            raise ValueError(f"precision must be float64 or mixed, not {self.precision!r}")

    @property
    def chunk(self) -> int:
        """How many pairs are in work at once."""
        # On CPU the arrays of a chunk should stay in the second-level cache; a GPU wants enough work to fill it.
        return self.pairs_in_chunk or (1 << 17 if jax.default_backend() == "cpu" else 1 << 23)

    @property
    def near_leaf(self) -> int:
        """Particles in the leaves of multipole gravity: as expansions and near pairs take about the same time."""
        return 16 if jax.default_backend() == "cpu" else 32

    def arrange(self, position: Array, smoothing_length: Array) -> tuple[np.ndarray, Arrangement]:
        """Sort particles (N, 3), (N,) into leaves and list neighbours.

        Returns the order (N,) and the arrangement of the particles in that order.
        """
        if not jax.config.jax_enable_x64:  # type: ignore[attr-defined]
            raise ValueError("the xla engine computes in 64 bits: use it within jax.enable_x64(True)")
        return xla_lists.arrange(
            np.asarray(position, dtype=np.float64),
            np.asarray(smoothing_length, dtype=np.float64),
            xla_lists.Reach(self.support, self.motion, self.growth),
            self.wide_leaf,
            self.chunk,
        )

    def stale(self, arrangement: Arrangement, position: Array, smoothing_length: Array) -> bool:
        """Whether the lists no longer hold all pairs within reach here; sums stay right, but become slow."""
        return not bool(_covers(arrangement, jnp.asarray(position), jnp.asarray(smoothing_length)))

    def held(self, arrangement: Arrangement) -> Arrangement:
        """The same, beyond whose lists no smoothing length is solved for: what has `outgrown` them is short of its own.

        Else sums over lists that do not hold go through all tiles, which takes up to a hundred times as long.
        """
        return replace(arrangement, longest=(1.0 + self.growth) * arrangement.smoothing_length)

    def outgrown(self, arrangement: Arrangement, smoothing_length: Array) -> Array:
        """Which of the smoothing lengths (N,) that were solved for within these lists have come to their end, (N,)."""
        return jnp.asarray(smoothing_length) >= self.held(arrangement).longest

    def density(
        self,
        arrangement: Arrangement,
        kernel: str,
        position: Array,
        mass: Array,
        guess: Array,
        eta: Array | float,
        tolerance: float,
        softening: bool,
    ) -> Density:
        """Densities of particles (N, 3), (N,) with h = eta (m/rho)^(1/3) to a relative tolerance, from any guess of h.

        Differentiable in position, mass and eta; zeta only with softening.
        """
        arrays = map(_of_its_type, (position, mass, guess, eta))
        return Density(*xla_density.density(kernel, self.precision, tolerance, softening, arrangement, *arrays))

    def neighbour_sums(
        self,
        arrangement: Arrangement,
        kernel: str,
        terms: tuple[PairTerm, ...],
        fields: dict[str, Any],
        virial: bool = False,
    ) -> Sums:
        """{effect: {output: array}} over pairs with r < support max(h_i, h_j); `virial` adds V_e (3, 3)."""
        if not terms:
            return {}
        return _neighbour_sums(kernel, self.precision, tuple(terms), virial, arrangement, _needed(terms, fields))

    def all_pair_sums(
        self,
        arrangement: Arrangement,
        kernel: str,
        terms: tuple[PairTerm, ...],
        fields: dict[str, Any],
        virial: bool = False,
    ) -> Sums:
        """The same over all pairs, with each term's `far` where leaves are out of reach of each other."""
        if not terms:
            return {}
        return _all_pair_sums(kernel, self.precision, tuple(terms), virial, arrangement, _needed(terms, fields))


@jax.jit
def _covers(arrangement: Arrangement, position: Array, smoothing_length: Array) -> Array:
    # On the device: only the answer comes back.
    return xla_lists.covers(jnp, arrangement, position, smoothing_length)


def _needed(terms: tuple[PairTerm, ...], fields: dict[str, Any]) -> dict[str, Array]:
    names = {"mass", "position", "smoothing_length"}
    for term in terms:
        scalars = {*argument_names(term.pair), *(argument_names(term.far) if term.far else ())}
        names |= {"velocity"} if "v_r" in scalars else set()
        stems = {side_of(name)[0] for name in scalars - {"r", "v_r", *SEPARATION}}
        names |= stems - {"h", *KERNEL_NAMES}
        names |= {output.of for output in term.outputs if output.of}
    return {name: _of_its_type(field_named(fields, name)) for name in sorted(names)}


def _of_its_type(array: Array) -> Array:
    """The same for JAX whether a number of Python made it (a weak type) or an array: one program for both."""
    return jnp.asarray(array, dtype=jnp.asarray(array).dtype)


@partial(jax.jit, static_argnames=("kernel", "precision", "terms", "virial"))
def _neighbour_sums(
    kernel: str,
    precision: str,
    terms: tuple[PairTerm, ...],
    virial: bool,
    arrangement: Arrangement,
    fields: dict[str, Array],
) -> Sums:
    shape = KERNELS[kernel]
    work = _Work(kernel, terms, virial)
    tiles = arrangement.neighbours
    h = fields["smoothing_length"]
    covered = xla_lists.holds(arrangement, fields["position"], h, shape.support)
    places = xla_places.places_of(precision, fields)
    boxes = xla_tiles.boxes_of(places, shape.support, tiles, covered)
    zero = xla_tiles.empty_sums(terms, tiles, virial, h.dtype)
    sums = xla_tiles.sum_over_tiles(tiles, covered, boxes, places, partial(work.chunk, far=False, limited=True), zero)
    return work.named([sums], tiles)


@partial(jax.jit, static_argnames=("kernel", "precision", "terms", "virial"))
def _all_pair_sums(
    kernel: str,
    precision: str,
    terms: tuple[PairTerm, ...],
    virial: bool,
    arrangement: Arrangement,
    fields: dict[str, Array],
) -> Sums:
    shape = KERNELS[kernel]
    work = _Work(kernel, terms, virial)
    near, far = arrangement.near, arrangement.far
    h = fields["smoothing_length"]
    covered = xla_lists.holds(arrangement, fields["position"], h, shape.support)
    places = xla_places.places_of(precision, fields)
    zero = xla_tiles.empty_sums(terms, near, virial, h.dtype)
    parts = [xla_tiles.sum_over_tiles(near, covered, None, places, partial(work.chunk, far=False, limited=False), zero)]
    if far.leaf.shape[0]:
        # Where the lists do not hold, the near pass takes all pairs and this one takes none.
        chunk = partial(work.chunk, far=True, limited=False)
        parts.append(xla_tiles.sum_over_tiles(far, covered, None, places, chunk, zero, otherwise_all=False))
    return work.named(parts, near)


@dataclass(frozen=True)
class _Work:
    """What the chunks of one pass share."""

    kernel: str
    terms: tuple[PairTerm, ...]
    virial: bool

    def chunk(
        self, places: xla_places.Places, target: Array, source: Array, far: bool, limited: bool
    ) -> dict[str, Array]:
        """The sums of one chunk, targets (C, S) and sources (C, B)."""
        shape = KERNELS[self.kernel]
        targets, sources, mass = places.tile(target, source)
        pairs = xla_tiles.Pairs(shape, targets, sources)
        within = None
        if limited:
            within = pairs["r"] < shape.support * jnp.maximum(pairs["h_i"], pairs["h_j"])
        empty = places.empty
        other = (target[:, :, None] != source[:, None, :]) & (target < empty)[:, :, None] & (source < empty)[:, None, :]
        return xla_tiles.term_sums(pairs, self.terms, far, mass, within, other, self.virial)

    def named(self, parts: list[dict[str, Array]], tiles: xla_lists.Tiles) -> Sums:
        """{effect: {output: array}} from what was gathered for each leaf."""
        results: Sums = {}
        used = {"sum": 0, "max": 0, "total": 0}

        def take(key: str, width: int) -> Array:
            start = used[key]
            used[key] = start + width
            join = jnp.maximum if key == "max" else jnp.add
            whole = reduce(join, [part[key] for part in parts])
            return whole[start] if key == "total" else whole[:, :, start : start + width][tiles.row, tiles.column]

        for term in self.terms:
            mine = results.setdefault(term.effect, {})
            for output in term.outputs:
                width = xla_tiles.columns(output)
                array = take("sum", width) if width else take("max", 1)
                array = array.reshape(-1, 3, 3) if output.how == "outer" else array
                array = array[:, 0] if array.ndim == 2 and array.shape[1] == 1 else array
                mine[output.name] = mine[output.name] + array if output.name in mine else array
                if self.virial and output.how == "central":
                    tensor = _symmetric(take("total", 1))
                    mine["virial"] = mine["virial"] + tensor if "virial" in mine else tensor
        return results


def _symmetric(six: Array) -> Array:
    xx, xy, xz, yy, yz, zz = six
    return jnp.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz]).reshape(3, 3)
