"""Whole generated modules: lists of neighbours, density, sums over neighbours, sums over all pairs."""

import functools
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import NamedTuple

from astroinertia.engines.numba_cache import load_module
from astroinertia.engines.numba_loops import leaf_loop, neighbour_loop
from astroinertia.engines.numba_passes import Needs, effect_names, header, loader, origin, packer, results
from astroinertia.engines.numba_source import Sources
from astroinertia.engines.templates import template
from astroinertia.engines.terms import PairTerm
from astroinertia.sph.kernels import KERNELS, Kernel

KERNEL_PARTS = ("w", "dw", "softening")


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


def neighbour_functions(
    kernel: str, terms: Sequence[PairTerm], precision: str, leaf: str, virial: bool = False, impulses: bool = False
) -> tuple[Needs, list[str]]:
    """What a sum over neighbours needs, and the lines of the functions that its template calls; leaf: name of one."""
    needs = Needs(_kernel(kernel), terms, [term.pair for term in terms], masked=True, impulses=impulses)
    sources = Sources()
    loop = neighbour_loop(leaf, sources, terms, needs, virial)
    return needs, [sources.text(), "", "", *packer(needs), *origin("set_origin", needs, precision), *loop]


def all_pairs_functions(
    kernel: str, terms: Sequence[PairTerm], precision: str, near: str, far: str, virial: bool = False
) -> tuple[Needs, Needs, list[str]]:
    """As `neighbour_functions`, of a sum over all pairs: near, far (nothing where a term has no form for those)."""
    distant, sources = all(term.far is not None for term in terms), Sources()
    pairs, fars = [term.pair for term in terms], [term.far for term in terms if distant]
    needs = Needs(_kernel(kernel), terms, pairs + fars, masked=distant)
    far_needs = Needs(_kernel(kernel), terms if distant else (), fars, masked=False)
    loops = leaf_loop(near, sources, terms, needs, "near" if distant else "all", virial)
    loops += loader("load_far_sources", far_needs, precision, needs.arrays)
    loops += leaf_loop(far, sources, far_needs.terms, far_needs, "far", virial) if distant else []
    return needs, far_needs, [sources.text(), "", "", *loader("load_sources", needs, precision, needs.arrays), *loops]


@functools.lru_cache(maxsize=128)
def neighbour_pass(
    kernel: str, terms: tuple[PairTerm, ...], precision: str, virial: bool, impulses: bool = False
) -> NeighbourPass:
    """The generated pass of a sum over neighbours.

    impulses: with results that are multiplied by the intervals of their pairs, besides the plain ones.
    """
    tag = "_".join(effect_names(terms))
    needs, functions = neighbour_functions(kernel, terms, precision, f"neighbour_leaf_{tag}", virial, impulses)
    body = template(
        "engines/numba_neighbours.py",
        neighbour_pass=f"neighbour_pass_{tag}",
        neighbour_leaf=f"neighbour_leaf_{tag}",
        arrays=needs.arrays,
        results=results(terms, virial, impulses),
        WIDTH=needs.width,
        SPREAD=needs.spread,
        REACHES=needs.reaches,
    )
    module = load_module(f"neighbour_pass_{tag}", _joined(precision, functions, body))
    return NeighbourPass(module, module.pack, getattr(module, f"neighbour_pass_{tag}"), needs.arrays, needs.width)


@functools.lru_cache(maxsize=128)
def all_pairs_pass(
    kernel: str, terms: tuple[PairTerm, ...], precision: str, virial: bool
) -> tuple[ModuleType, Callable, list[str], bool]:
    """As `neighbour_pass`, for a sum over all pairs; also whether all of its terms have a form for far pairs."""
    tag = "_".join(effect_names(terms))
    leaves = f"near_leaf_{tag}", f"far_leaf_{tag}"
    needs, far_needs, functions = all_pairs_functions(kernel, terms, precision, *leaves, virial)
    distant = len(far_needs.terms) > 0
    body = template(
        "engines/numba_all_pairs.py",
        all_pairs_pass=f"all_pairs_pass_{tag}",
        near_leaf=f"near_leaf_{tag}",
        far_leaf=f"far_leaf_{tag}",
        arrays=needs.arrays,
        results=results(terms, virial),
        ROWS=len(needs.rows),
        FAR_ROWS=len(far_needs.rows),
        DISTANT=distant,
    )
    if not distant:  # everything is near: the walk finds nothing out of an infinite reach
        body = body[: body.index("        if False:")]
    module = load_module(f"all_pairs_pass_{tag}", _joined(precision, functions, body))
    return module, getattr(module, f"all_pairs_pass_{tag}"), needs.arrays, distant


@functools.lru_cache(maxsize=64)
def density_pass(kernel: str, precision: str, softening: bool, outgrown: bool = True) -> tuple[ModuleType, Callable]:
    """The generated module that solves for smoothing lengths, and its entry function.

    outgrown: whether there may be lengths that outgrow the lists of neighbours.
    """
    chosen = _kernel(kernel)
    sources = Sources()
    names = {f"kernel_{name}": sources.add(getattr(chosen, name)) for name in KERNEL_PARTS[: 2 + softening]}
    tag = f"{kernel}_softening" if softening else kernel
    body = template(
        "engines/numba_density.py", density_pass=f"density_pass_{tag}", SOFTENED=softening, OUTGROWN=outgrown, **names
    )
    module = load_module(f"density_pass_{tag}", _joined(precision, [sources.text(), "", ""], body))
    return module, getattr(module, f"density_pass_{tag}")


@functools.cache
def lists_pass() -> Callable:
    """The entry function of the generated module that lists neighbours."""
    text = "\n".join([*header("float64"), template("engines/numba_lists.py")])
    return load_module("neighbour_lists", text).neighbour_lists


def _joined(precision: str, functions: list[str], body: str) -> str:
    return "\n".join([*header(precision), *functions, body])
