"""Whole generated modules: density, sums over neighbours, sums over all pairs."""

import functools
from collections.abc import Callable
from types import ModuleType
from typing import NamedTuple

from astroinertia.engines.numba_cache import load_module
from astroinertia.engines.numba_density import DENSITY, SOFTENING, WITHOUT_SOFTENING
from astroinertia.engines.numba_loops import leaf_loop, neighbour_loop
from astroinertia.engines.numba_passes import Needs, effect_names, header, listed, loader, origin, packer, results
from astroinertia.engines.numba_source import Sources
from astroinertia.engines.terms import PairTerm
from astroinertia.sph.kernels import KERNELS, Kernel

NEIGHBOUR = """
copy_rows = row_copier({width})
spread_rows = row_spreader({spread}, 0)
spread_places = row_spreader(4, 0)
spread_reaches = row_spreader(4, {reaches})


@njit(**ENTRY)
def neighbour_pass_{tag}(
    counter, position, h, mass, support{arrays}, table, chosen, begin, active, offset, number, pool{results}
):
    # table: what `pack` made of all particles, or none: then each leaf packs what is near enough to its targets.
    room = columns_for(512)
    like = np.empty(0, real)
    sources, rows = whole_lines(room, {width}, like), whole_lines({spread}, room, like)
    search = whole_lines(8, room, like)
    index, own = np.empty(room, np.int32 if RELATIVE else np.int64), np.arange(room)
    box, centre, zero = np.empty((2, 3)), np.empty(3), np.zeros({width})
    slots = np.empty(0, np.int64)
    sparse = len(table) == 0
    if sparse:
        near, packed = np.empty(room, pool.dtype), np.empty((room, {width}))
    else:
        near, packed = pool[:0], table
    while True:
        turn = take(counter)
        if turn >= len(active):
            break
        leaf = active[turn]
        first, last, count = begin[leaf], begin[leaf + 1], number[leaf]
        found = pool[offset[leaf] : offset[leaf] + count]
        if count + 3 * LANES > room:
            room = columns_for(count)
            sources, rows = whole_lines(room, {width}, like), whole_lines({spread}, room, like)
            search, index, own = whole_lines(8, room, like), np.empty(room, index.dtype), np.arange(room)
            if sparse:
                near, packed = np.empty(room, pool.dtype), np.empty((room, {width}))
        slots = with_room(slots, last - first)
        largest = target_box(position, h, chosen, first, last, box)
        box_centre(box, centre)
        if sparse:
            for k in range(count):
                near[k] = found[k]
            count = close_to(box, support, largest, position, h, near, count)
            for k in range(count):
                pack_row(near[k], k, position, h, mass, support{arrays}, packed)
            found = near[:count]
            places(chosen, first, last, found, count, slots)
            set_origin(centre, packed, slots[0], zero)
            copy_rows(packed, own, count, zero, sources)
        else:
            places(chosen, first, last, found, count, slots)
            set_origin(centre, packed, chosen[first], zero)
            copy_rows(packed, found, count, zero, sources)
        for k in range({width}):  # a massless copy of the last source stands at the loose end
            sources[count, k] = sources[count - 1, k]
        sources[count, 3] = 0
        spread_places(sources, own, padded(count), search)
        spread_reaches(sources, own, padded(count), search[4:])
        neighbour_leaf_{tag}(leaf, first, last, slots, count, sources, rows, search, index{results})
"""

ALL_PAIRS = """
@njit(**ENTRY)
def all_pairs_pass_{tag}(counter, x, y, z, h, mass, support, factor, nodes, first_of, last_of, leaves{arrays}{results}):
    block = 1024
    parents, listed = np.empty(leaves + LANES, np.int64), np.empty(leaves + LANES, np.int64)
    near, far = np.empty(2048, np.int64), np.empty(2048, np.int64)
    ranges = np.empty((leaves + 1, 2), np.int64)
    run, slots = np.empty(block, np.int64), np.empty(0, np.int64)
    sources = np.empty(({rows}, 2048), real)
    far_sources = np.empty(({far_rows}, block + 2 * LANES), real)
    targets = np.empty(({far_rows}, block + 2 * LANES), real)
    key, index = np.empty(2048, real), np.empty(2048, np.int32 if RELATIVE else np.int64)
    box, centre = np.empty((2, 3)), np.empty(3)
    while True:
        leaf = take(counter)
        if leaf >= leaves:
            break
        node = leaves + leaf
        first, last = first_of[node], last_of[node]
        node_box(nodes, node, box, centre)
        near_count, far_count, range_count, near, far = divide(
            x, y, z, h, factor, nodes, first_of, last_of, leaves, box, factor * nodes[6, node], parents, listed,
            near, far, ranges
        )
        key, index = with_room(key, near_count), with_room(index, near_count)
        sources = with_columns(sources, near_count)
        slots = with_room(slots, last - first)
        for n in range(last - first):
            slots[n] = place_of(first, near, near_count) + n
        load_sources(near, near_count, centre, first, sources, x, y, z, mass, h, support{arrays})
        near_leaf_{tag}(leaf, first, last, slots, near_count, sources, sources, key, index{results})
        if {distant}:
            for n in range(last - first):
                run[n] = first + n
            load_far_sources(run, last - first, centre, first, targets, x, y, z, mass, h, support{far_arrays})
            for k in range(range_count):
                for begin in range(ranges[k, 0], ranges[k, 1], block):
                    count = min(block, ranges[k, 1] - begin)
                    for n in range(count):
                        run[n] = begin + n
                    load_far_sources(run, count, centre, first, far_sources, x, y, z, mass, h, support{far_arrays})
                    far_leaf_{tag}(leaf, first, last, slots, count, targets, far_sources, key, index{results})
            for begin in range(0, far_count, block):
                count = min(block, far_count - begin)
                for n in range(count):
                    run[n] = far[begin + n]
                load_far_sources(run, count, centre, first, far_sources, x, y, z, mass, h, support{far_arrays})
                far_leaf_{tag}(leaf, first, last, slots, count, targets, far_sources, key, index{results})
"""


class NeighbourPass(NamedTuple):
    """A generated sum over neighbours: the module, its entry functions and the arrays that `pack` puts in a table."""

    module: ModuleType
    pack: Callable
    sums: Callable
    arrays: list[str]
    width: int


def _kernel(name: str) -> Kernel:
    if name not in KERNELS:
        raise ValueError(f"there is no kernel {name!r}; there are {', '.join(KERNELS)}")
    return KERNELS[name]


@functools.lru_cache(maxsize=128)
def neighbour_pass(
    kernel: str, terms: tuple[PairTerm, ...], precision: str, virial: bool, impulses: bool = False
) -> NeighbourPass:
    """The generated pass of a sum over neighbours.

    impulses: with results that are multiplied by the intervals of their pairs, besides the plain ones.
    """
    needs = Needs(_kernel(kernel), terms, [term.pair for term in terms], masked=True, impulses=impulses)
    tag = "_".join(effect_names(terms))
    sources = Sources()
    loop = neighbour_loop(f"neighbour_leaf_{tag}", sources, terms, needs, virial)
    partners = len(needs.sides[0])
    body = NEIGHBOUR.format(
        tag=tag,
        arrays=listed(needs.arrays),
        results=listed(results(terms, virial, impulses)),
        width=needs.width,
        spread=-(-partners // 4) * 4,
        reaches=needs.table.index("reach2") // 4 * 4,
    )
    load = packer(needs) + origin("set_origin", needs, precision)
    module = load_module(f"neighbour_pass_{tag}", _joined(precision, sources, load, loop, body))
    return NeighbourPass(module, module.pack, getattr(module, f"neighbour_pass_{tag}"), needs.arrays, needs.width)


@functools.lru_cache(maxsize=128)
def all_pairs_pass(
    kernel: str, terms: tuple[PairTerm, ...], precision: str, virial: bool
) -> tuple[ModuleType, Callable, list[str], bool]:
    """As `neighbour_pass`, for a sum over all pairs; also whether all of its terms have a form for far pairs."""
    distant = all(term.far is not None for term in terms)
    pair, far = [term.pair for term in terms], [term.far for term in terms if distant]
    needs = Needs(_kernel(kernel), terms, pair + far, masked=distant)
    far_needs = Needs(_kernel(kernel), terms if distant else (), far, masked=False)
    tag = "_".join(effect_names(terms))
    sources = Sources()
    loops = leaf_loop(f"near_leaf_{tag}", sources, terms, needs, "near" if distant else "all", virial)
    loops += loader("load_far_sources", far_needs, precision)
    loops += leaf_loop(f"far_leaf_{tag}", sources, far_needs.terms, far_needs, "far", virial) if distant else []
    body = ALL_PAIRS.format(
        tag=tag,
        arrays=listed(needs.arrays),
        far_arrays=listed(far_needs.arrays),
        results=listed(results(terms, virial)),
        rows=len(needs.rows),
        far_rows=len(far_needs.rows),
        distant=distant,
    )
    if not distant:  # everything is near: the walk finds nothing out of an infinite reach
        body = body[: body.index("        if False:")]
    text = _joined(precision, sources, loader("load_sources", needs, precision), loops, body)
    module = load_module(f"all_pairs_pass_{tag}", text)
    return module, getattr(module, f"all_pairs_pass_{tag}"), needs.arrays, distant


@functools.lru_cache(maxsize=64)
def density_pass(kernel: str, precision: str, softening: bool) -> tuple[ModuleType, Callable]:
    """The generated module that solves for smoothing lengths, and its entry function."""
    chosen = _kernel(kernel)
    sources = Sources()
    names = {"w": sources.add(chosen.w), "dw": sources.add(chosen.dw)}
    if softening:
        names["softening"] = sources.add(chosen.softening)
    gradient = (SOFTENING if softening else WITHOUT_SOFTENING).format(**names)
    tag = f"{kernel}_softening" if softening else kernel
    module = load_module(
        f"density_pass_{tag}",
        "\n".join([*header(precision), sources.text(), gradient, DENSITY.format(tag=tag, **names)]),
    )
    return module, getattr(module, f"density_pass_{tag}")


def _joined(precision: str, sources: Sources, load: list[str], loops: list[str], body: str) -> str:
    return "\n".join([*header(precision), sources.text(), "", "", *load, *loops, body])
