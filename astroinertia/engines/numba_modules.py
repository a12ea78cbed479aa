"""Whole generated modules: density, sums over neighbours, sums over all pairs."""

import functools
from collections.abc import Callable
from types import ModuleType

from astroinertia.engines.numba_cache import load_module
from astroinertia.engines.numba_density import DENSITY, SOFTENING, WITHOUT_SOFTENING
from astroinertia.engines.numba_passes import (
    Needs,
    effect_names,
    header,
    leaf_loop,
    loader,
    output_kinds,
    virial_effects,
)
from astroinertia.engines.numba_source import Sources
from astroinertia.engines.terms import PairTerm
from astroinertia.sph.kernels import KERNELS, Kernel

NEIGHBOUR = """
@njit(cache=True, nogil=True, error_model="numpy")
def neighbour_pass_{tag}(
    counter, x, y, z, mass, smoothing_length, support, reach, lo, hi, node_reach, start{arrays}{results}
):
    leaves = len(start) - 1
    group = min(leaves, GROUP)
    key, listed, found = np.empty(1024), np.empty(1024, np.int64), np.empty(1024, np.int64)
    leaf_rows = np.empty((8, 1024))
    buffer = np.empty(({rows}, 1024), real)
    pair_key, index = np.empty(1024, real), np.empty(1024, np.int32 if RELATIVE else np.int64)
    box = np.empty((2, 3))
    while True:
        task = take(counter)
        if task * group >= leaves:
            break
        node = leaves // group + task
        box[0], box[1] = lo[node], hi[node]
        leaf_count, leaf_rows = reachable_leaves(lo, hi, node_reach, box, node_reach[node], leaf_rows)
        for leaf in range(task * group, (task + 1) * group):
            first, last = start[leaf], start[leaf + 1]
            box[0], box[1] = lo[leaves + leaf], hi[leaves + leaf]
            count, key, listed, found = gather(
                x, y, z, reach, start, leaf_rows, leaf_count, box, node_reach[leaves + leaf], key, listed, found
            )
            slot = place_of(first, found[:count])
            buffer = load_sources(found, count, first, buffer, x, y, z, mass, smoothing_length, support{arrays})
            pair_key, index = with_room(pair_key, 0, count), with_room(index, 0, count)
            neighbour_leaf_{tag}(leaf, first, last, slot, count, buffer, buffer, pair_key, index{results})

"""

ALL_PAIRS = """
@njit(cache=True, nogil=True, error_model="numpy")
def all_pairs_pass_{tag}(
    counter, x, y, z, mass, smoothing_length, support, reach, lo, hi, node_reach, first_of, last_of, level{arrays}{results}
):
    leaves = 1 << level
    block = 512
    near, far = np.empty(2048, np.int64), np.empty(2048, np.int64)
    ranges = np.empty((64, 2), np.int64)
    run = np.empty(block, np.int64)
    sources = np.empty(({rows}, 1024), real)
    far_sources = np.empty(({far_rows}, block + 64), real)
    targets = np.empty(({far_rows}, block + 64), real)
    no_key, no_index = np.empty(0, real), np.empty(0, np.int64)
    box = np.empty((2, 3))
    while True:
        leaf = take(counter)
        if leaf >= leaves:
            break
        node = leaves + leaf
        first, last = first_of[node], last_of[node]
        box[0], box[1] = lo[node], hi[node]
        near_count, near, far_count, far, range_count, ranges = divide(
            x, y, z, reach, lo, hi, node_reach, first_of, last_of, level, box, node_reach[node], near, far, ranges
        )
        slot = place_of(first, near[:near_count])
        sources = load_sources(near, near_count, first, sources, x, y, z, mass, smoothing_length, support{near_arrays})
        near_leaf_{tag}(leaf, first, last, slot, near_count, sources, sources, no_key, no_index{results})
        own = near[slot : slot + last - first]
        targets = load_far_sources(own, last - first, first, targets, x, y, z, mass, smoothing_length, support{far_arrays})
        for k in range(range_count):
            for begin in range(ranges[k, 0], ranges[k, 1], block):
                count = min(block, ranges[k, 1] - begin)
                for n in range(count):
                    run[n] = begin + n
                far_sources = load_far_sources(
                    run, count, first, far_sources, x, y, z, mass, smoothing_length, support{far_arrays}
                )
                far_leaf_{tag}(leaf, first, last, 0, count, targets, far_sources, no_key, no_index{results})
        for begin in range(0, far_count, block):
            count = min(block, far_count - begin)
            far_sources = load_far_sources(
                far[begin : begin + count], count, first, far_sources, x, y, z, mass, smoothing_length, support{far_arrays}
            )
            far_leaf_{tag}(leaf, first, last, 0, count, targets, far_sources, no_key, no_index{results})

"""


def _kernel(name: str) -> Kernel:
    if name not in KERNELS:
        raise ValueError(f"there is no kernel {name!r}; there are {', '.join(KERNELS)}")
    return KERNELS[name]


def _results(terms, virial: bool) -> str:
    names = [f"out_{effect}_{output}" for effect, output in output_kinds(terms)]
    names += [f"virial_{effect}" for effect in virial_effects(terms)] if virial else []
    return "".join(f", {name}" for name in names)


def _listed(names) -> str:
    return "".join(f", {name}" for name in names)


@functools.lru_cache(maxsize=128)
def neighbour_pass(
    kernel: str, terms: tuple[PairTerm, ...], precision: str, virial: bool
) -> tuple[ModuleType, Callable, list[str]]:
    """The generated module of a sum over neighbours, its entry function, and what it must be given."""
    needs = Needs(_kernel(kernel), terms, [term.pair for term in terms], masked=True)
    tag = "_".join(effect_names(terms))
    sources = Sources()
    loop = leaf_loop(f"neighbour_leaf_{tag}", sources, terms, needs, "neighbour", virial)
    body = NEIGHBOUR.format(
        tag=tag, arrays=_listed(needs.arrays), results=_results(terms, virial), rows=len(needs.rows)
    )
    text = _joined(precision, sources, loader("load_sources", needs, precision), loop, body)
    module = load_module(f"neighbour_pass_{tag}", text)
    return module, getattr(module, f"neighbour_pass_{tag}"), needs.arrays


@functools.lru_cache(maxsize=128)
def all_pairs_pass(
    kernel: str, terms: tuple[PairTerm, ...], precision: str, virial: bool
) -> tuple[ModuleType, Callable, list[str], bool]:
    """As `neighbour_pass`, for a sum over all pairs; also whether all of its terms have a form for far pairs."""
    needs = Needs(_kernel(kernel), terms, [term.pair for term in terms], masked=False)
    distant = all(term.far is not None for term in terms)
    far_terms = terms if distant else ()
    far_needs = Needs(_kernel(kernel), far_terms, [term.far for term in far_terms], masked=False)
    arrays = list(dict.fromkeys(needs.arrays + far_needs.arrays))
    tag = "_".join(effect_names(terms))
    sources = Sources()
    loops = leaf_loop(f"near_leaf_{tag}", sources, terms, needs, "near", virial)
    loops += loader("load_far_sources", far_needs, precision)
    if distant:
        loops += leaf_loop(f"far_leaf_{tag}", sources, terms, far_needs, "far", virial)
    else:  # everything is near: the walk finds nothing out of an infinite reach
        results = _results(terms, virial)
        loops += [
            "@njit",
            f"def far_leaf_{tag}(leaf, first, last, slot, count, targets, buffer, key, index{results}):",
            "    return",
        ]
    body = ALL_PAIRS.format(
        tag=tag,
        arrays=_listed(arrays),
        near_arrays=_listed(needs.arrays),
        far_arrays=_listed(far_needs.arrays),
        results=_results(terms, virial),
        rows=len(needs.rows),
        far_rows=len(far_needs.rows),
    )
    text = _joined(precision, sources, loader("load_sources", needs, precision), loops, body)
    module = load_module(f"all_pairs_pass_{tag}", text)
    return module, getattr(module, f"all_pairs_pass_{tag}"), arrays, distant


@functools.lru_cache(maxsize=64)
def density_pass(kernel: str, precision: str, softening: bool) -> tuple[ModuleType, Callable]:
    """The generated module that solves for smoothing lengths, and its entry function."""
    chosen = _kernel(kernel)
    sources = Sources()
    names = {"w": sources.add(chosen.w), "dw": sources.add(chosen.dw)}
    if softening:
        names |= {"phi": sources.add(chosen.phi), "dphi": sources.add(chosen.dphi)}
    gradient = (SOFTENING if softening else WITHOUT_SOFTENING).format(**names)
    tag = f"{kernel}_softening" if softening else kernel
    module = load_module(
        f"density_pass_{tag}",
        "\n".join([*header(precision), sources.text(), gradient, DENSITY.format(tag=tag, **names)]),
    )
    return module, getattr(module, f"density_pass_{tag}")


def _joined(precision: str, sources: Sources, load: list[str], loops: list[str], body: str) -> str:
    return "\n".join([*header(precision), sources.text(), "", "", *load, *loops, body])
