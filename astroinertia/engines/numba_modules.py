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


class Pass(NamedTuple):
    """A generated sum: the module, its entry function and what that is given."""

    module: ModuleType
    sums: Callable
    needs: Needs


def _kernel(name: str) -> Kernel:
    if name not in KERNELS:
        raise ValueError(f"there is no kernel {name!r}; there are {', '.join(KERNELS)}")
    return KERNELS[name]


def _neighbour_needs(kernel: str, terms: Sequence[PairTerm], impulses: bool) -> Needs:
    return Needs(_kernel(kernel), terms, [term.pair for term in terms], masked=True, impulses=impulses)


def _all_pairs_needs(kernel: str, terms: Sequence[PairTerm]) -> tuple[Needs, Needs]:
    distant = all(term.far is not None for term in terms)
    pairs, fars = [term.pair for term in terms], [term.far for term in terms if distant]
    needs = Needs(_kernel(kernel), terms, pairs + fars, masked=distant)
    return needs, Needs(_kernel(kernel), terms if distant else (), fars, masked=False)


def neighbour_functions(
    kernel: str, terms: Sequence[PairTerm], precision: str, leaf: str, virial: bool = False, impulses: bool = False
) -> tuple[Needs, list[str]]:
    """What a sum over neighbours needs, and the lines of the functions that its template calls; leaf: name of one."""
    needs, sources = _neighbour_needs(kernel, terms, impulses), Sources()
    loop = neighbour_loop(leaf, sources, terms, needs, virial)
    return needs, [sources.text(), "", "", *packer(needs), *origin("set_origin", needs, precision), *loop]


def all_pairs_functions(
    kernel: str, terms: Sequence[PairTerm], precision: str, near: str, far: str, virial: bool = False
) -> tuple[Needs, Needs, list[str]]:
    """As `neighbour_functions`, of a sum over all pairs: near, far (nothing where a term has no form for those)."""
    (needs, far_needs), sources = _all_pairs_needs(kernel, terms), Sources()
    distant = needs.masked
    loops = leaf_loop(near, sources, terms, needs, "near" if distant else "all", virial)
    loops += loader("load_far_sources", far_needs, precision, needs.arrays)
    loops += leaf_loop(far, sources, far_needs.terms, far_needs, "far", virial) if distant else []
    return needs, far_needs, [sources.text(), "", "", *loader("load_sources", needs, precision, needs.arrays), *loops]


@functools.lru_cache(maxsize=128)
def neighbour_pass(
    kernel: str, terms: tuple[PairTerm, ...], precision: str, virial: bool, impulses: bool = False
) -> Pass:
    """The generated pass of a sum over neighbours, whose module has the function `pack` that fills its table.

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
    return Pass(module, getattr(module, f"neighbour_pass_{tag}"), needs)


@functools.lru_cache(maxsize=128)
def few_neighbour_pass(kernel: str, terms: tuple[PairTerm, ...], virial: bool, impulses: bool = False) -> Pass:
    """As `neighbour_pass`, of few particles."""
    tag = "_".join(effect_names(terms))
    leaf, name = f"neighbour_leaf_{tag}", f"few_neighbour_pass_{tag}"
    needs, sources = _neighbour_needs(kernel, terms, impulses), Sources()
    loop = neighbour_loop(leaf, sources, terms, needs, virial)
    body = template(
        "engines/numba_few_neighbours.py",
        neighbour_pass=name,
        neighbour_leaf=leaf,
        results=results(terms, virial, impulses),
        SPREAD=needs.spread,
    )
    module = load_module(name, _joined("float64", [sources.text(), "", "", *loop], body))
    return Pass(module, getattr(module, name), needs)


@functools.lru_cache(maxsize=128)
def few_all_pairs_pass(kernel: str, terms: tuple[PairTerm, ...], virial: bool) -> Pass:
    """As `all_pairs_pass`, of few particles."""
    tag = "_".join(effect_names(terms))
    leaf, name = f"near_leaf_{tag}", f"few_all_pairs_pass_{tag}"
    sources, (needs, _) = Sources(), _all_pairs_needs(kernel, terms)
    loop = leaf_loop(leaf, sources, terms, needs, "near" if needs.masked else "all", virial)
    words = {"all_pairs_pass": name, "near_leaf": leaf, "results": results(terms, virial)}
    body = template("engines/numba_few_pairs.py", **words)
    module = load_module(name, _joined("float64", [sources.text(), "", "", *loop], body))
    return Pass(module, getattr(module, name), needs)


@functools.lru_cache(maxsize=128)
def all_pairs_pass(kernel: str, terms: tuple[PairTerm, ...], precision: str, virial: bool) -> Pass:
    """The same for a sum over all pairs; its needs are masked where all of its terms have a form for far pairs."""
    tag = "_".join(effect_names(terms))
    leaves = f"near_leaf_{tag}", f"far_leaf_{tag}"
    needs, far_needs, functions = all_pairs_functions(kernel, terms, precision, *leaves, virial)
    body = template(
        "engines/numba_all_pairs.py",
        all_pairs_pass=f"all_pairs_pass_{tag}",
        near_leaf=f"near_leaf_{tag}",
        far_leaf=f"far_leaf_{tag}",
        arrays=needs.arrays,
        results=results(terms, virial),
        ROWS=len(needs.rows),
        FAR_ROWS=len(far_needs.rows),
        DISTANT=needs.masked,
    )
    if not needs.masked:  # everything is near: the walk finds nothing out of an infinite reach
        body = body[: body.index("        if False:")]
    module = load_module(f"all_pairs_pass_{tag}", _joined(precision, functions, body))
    return Pass(module, getattr(module, f"all_pairs_pass_{tag}"), needs)


@functools.lru_cache(maxsize=64)
def density_pass(kernel: str, precision: str, softening: bool, few: bool = False) -> tuple[ModuleType, Callable]:
    """The generated module that solves for smoothing lengths, and its entry function; few: for few particles."""
    chosen = _kernel(kernel)
    sources = Sources()
    names = {f"kernel_{name}": sources.add(getattr(chosen, name)) for name in KERNEL_PARTS[: 2 + softening]}
    tag = "_".join(["density_pass", *(["few"] if few else []), kernel, *(["softening"] if softening else [])])
    solved = template("engines/numba_lengths.py", SOFTENED=softening, **names)
    body = template(f"engines/numba_{'few_' if few else ''}density.py", density_pass=tag)
    module = load_module(tag, _joined(precision, [sources.text(), "", "", solved], body))
    return module, getattr(module, tag)


@functools.cache
def lists_pass() -> Callable:
    """The entry function of the generated module that lists neighbours."""
    text = "\n".join([*header("float64"), template("engines/numba_lists.py")])
    return load_module("neighbour_lists", text).neighbour_lists


def _joined(precision: str, functions: list[str], body: str) -> str:
    return "\n".join([*header(precision), *functions, body])
