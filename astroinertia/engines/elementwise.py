"""Work on each particle by itself: one scalar function, compiled into one threaded, vectorised loop over particles.

A step has much to do between its sums over pairs, and numpy would carry whole arrays through memory for every
operation. Functions are written as pair functions are, on plain scalars over a namespace, with xp.exp, log, power,
floor, int64 and take besides: (N,) comes to them as a scalar, (N, 3) as (x, y, z), (N, 3, 3) as three rows, a plain
number as it is, and a `Table` as the whole of it, whose entries are had by xp.take(table, xp.int64(index)); and they
return such things. With jax.numpy they are called on whole arrays as they stand, and so with numpy where particles are
few: a program takes 0.1 to 0.7 s to compile, and saves some 50 us of a call. With COMPILED, which is numpy otherwise,
programs are taken all the same: few particles of many have theirs already.

Loops go over fixed chunks of particles, and sums add up chunks in their order: the bits do not depend on the threads.
"""

import functools
import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from types import ModuleType, SimpleNamespace
from typing import Any, ClassVar

import numpy as np

from astroinertia.engines.few import FEW
from astroinertia.engines.numba_source import NAMESPACE_CALLS, Sources
from astroinertia.engines.templates import template
from astroinertia.engines.threads import available_threads, carry_out

Array = Any
COMPILED = SimpleNamespace(**vars(np))
REAL = np.dtype(np.float64)
CHUNK = 1024  # particles that are worked on together; sums are added up in parts of as many
ALONE = 16384  # particles a thread must have to be worth starting: loops take some 1 to 10 ns each, to start it 25 us
WIDTHS = {(): 1, (3,): 3, (3, 3): 9}
SHAPES = {width: shape for shape, width in WIDTHS.items()}
WHOLE = "whole"  # the kind of a table
CALLS = NAMESPACE_CALLS | {name: name for name in ("exp", "log", "power")}
CALLS |= {"floor": "np.floor", "int64": "np.int64", "take": "table_entry"}

HEADER = """
class Apart(EntryCompiler):
    # The arrays of a loop do not overlap: without that knowledge loops over many arrays are not vectorised.
    def define_pipelines(self):
        self.state.flags.noalias = True
        return super().define_pipelines()


real = np.float64
PAIR_FLAGS = {'contract', 'nsz'}
LOOP = {**ENTRY, "pipeline_class": Apart}


class PartApart(PartCompiler):
    def define_pipelines(self):
        self.state.flags.noalias = True
        return super().define_pipelines()


CASE = {**PART, "pipeline_class": PartApart}


@njit(forceinline=True, error_model="numpy", **INNER)
def table_entry(table, index):
    return table[index]
"""
LOOP = """
@njit(fastmath={flags}, **LOOP)
def loop(counter, count{arrays}):
    widest_vectors()
    while True:
        chunk = take(counter)
        first = chunk * {chunk}
        if first >= count:
            break
        last = min(first + {chunk}, count)
"""
CASE = """
@njit(fastmath={flags}, **CASE)
def sum_up(case, chunk, first, last, parts{arrays}):
    widest_vectors()
"""


@dataclass(frozen=True)
class Table:
    """An array that every particle looks things up in; functions must ask for no entry that it does not have."""

    entries: Array
    shape: ClassVar[str] = WHOLE  # that of no number and no array


def elementwise(xp: Any, function: Callable, *arguments: Array) -> Any:
    """What function(xp, ...) returns for each particle: an array, or a tuple of arrays where it returns several things.

    arguments: arrays (N,), (N, 3), (N, 3, 3), plain numbers and a Table; the function must be one of a module or a
    class, as it is compiled once. A tuple of several things holds a scalar, (x, y, z) or three rows each; one thing by
    itself is such a tuple too, of one. Raises ValueError for what cannot be compiled.
    Tests: tests/unit/engines/test_elementwise.py.
    """
    count = _count(arguments)
    if not by_numpy(xp):
        return tuple(_joined(xp, value, count) for value in function(xp, *map(_apart, arguments)))
    if not _is_for_numpy(xp, arguments, count):
        flat, kinds = _flat(arguments, count)
        loop, shapes = _each(function, kinds)
        results = [np.empty(count * WIDTHS[shape]) for shape in shapes]
        if carry_out(loop, _workers(count), count, *flat, *results):
            return tuple([r.reshape(count, *shape) if shape else r for r, shape in zip(results, shapes, strict=True)])
    return tuple(_in_rows(parts, count) for parts in _numpy_values(function, arguments, count))


def totals(xp: Any, function: Callable, *arguments: Array, cases: Sequence[tuple[Array, ...]] = ((),)) -> Any:
    """Sums over particles of what function(xp, ...) returns: a tuple of arrays (E,), (E, 3) and (E, 3, 3).

    The function is called with `arguments` and the further ones of each of the E cases, which are all of one kind.
    Tests: tests/unit/engines/test_elementwise.py.
    """
    if not by_numpy(xp):
        results = [function(xp, *map(_apart, (*arguments, *more))) for more in cases]
        return tuple(map(xp.stack, zip(*_summed(xp, results, _count(arguments)), strict=True)))
    if not _is_for_numpy(xp, arguments, count := _count(arguments)):
        shared, kinds = _flat(arguments, count)
        flat = [_flat(more, count) for more in cases]
        loop, columns, width = _sums(function, kinds, flat[0][1], len(cases))
        parts = np.zeros((len(cases), width, max(1, -(-count // CHUNK))))
        if carry_out(loop, _workers(count), count, *shared, *[a for more, _ in flat for a in more], parts):
            # Along the last axis numpy adds pairwise.
            sums = parts[:, :, 0] if count <= CHUNK else parts.sum(axis=2)
            return tuple([sums[:, column].reshape(shape) for column, shape in columns])
    values = [_numpy_values(function, (*arguments, *more), count) for more in cases]
    return tuple(_summed_up(value, count) for value in zip(*values, strict=True))


def by_numpy(xp: Any) -> bool:
    """Whether that is numpy, whose work on few particles is compiled or not."""
    return xp is np or xp is COMPILED


def added(one: Array | None, other: Array | None) -> Array | None:
    """The sum of two arrays, or of what there is of them."""
    if one is None or other is None:
        return other if one is None else one
    if not isinstance(one, np.ndarray) or one.ndim > 2 or len(one) <= ALONE:
        return one + other  # the same bits
    return elementwise(np, SUMS[one.shape[1:]], one, other)[0]


def sum_of_numbers(xp, a, b):
    """a + b."""
    return (a + b,)


def sum_of_vectors(xp, a, b):
    """a + b."""
    return ((a[0] + b[0], a[1] + b[1], a[2] + b[2]),)


SUMS = {(): sum_of_numbers, (3,): sum_of_vectors}


def _is_for_numpy(xp: Any, arguments: Sequence[Array], count: int) -> bool:
    """Whether numpy is quicker than compiling first: not in a table, where its operations for 500 particles take a
    run of 200 steps as long.
    """
    return count <= (FEW if xp is np else 0) and not any(isinstance(argument, Table) for argument in arguments)


def _numpy_values(function: Callable, arguments: Sequence[Array], count: int) -> list[list[Array]]:
    """What it returns for so many particles: the components of each thing."""
    rows = (_apart(a if isinstance(a, Table) else _rows(a, count)) for a in arguments)
    with np.errstate(all="ignore"):
        return [_parts(value) for value in function(np, *rows)]


def _in_rows(parts: Sequence[Array], count: int) -> Array:
    rows = np.empty((count, len(parts)))
    for k, part in enumerate(parts):
        rows[:, k] = part
    return rows.reshape(count, *SHAPES[len(parts)])


def _summed_up(cases: Sequence[Sequence[Array]], count: int) -> Array:
    terms = np.empty((len(cases), len(cases[0]), count))
    for case, parts in zip(terms, cases, strict=True):
        for row, part in zip(case, parts, strict=True):
            row[:] = part
    return terms.sum(axis=2).reshape(len(cases), *SHAPES[len(cases[0])])


def _parts(value: Any) -> list[Array]:
    return [part for each in value for part in _parts(each)] if isinstance(value, tuple) else [value]


def _count(arguments: Sequence[Array]) -> int:
    for argument in arguments:
        if getattr(argument, "ndim", 0):
            return len(argument)
    return 0


def _rows(argument: Array, count: int) -> Array:
    """The argument, which has a row for each particle or is a plain number."""
    array = np.asarray(argument, dtype=np.float64)
    if array.ndim and (array.shape[1:] not in WIDTHS or array.shape[0] != count):
        raise ValueError(f"cannot work on each particle of an array of shape {array.shape}")
    return array if array.ndim else array[()]


def _workers(count: int) -> int:
    return 1 if count < 2 * ALONE else min(available_threads(), count // ALONE)


Kind = tuple[int, ...] | str | None  # the shape of a row, WHOLE for a table, None for a number


def _flat(arguments: Sequence[Array], count: int) -> tuple[list[Array], tuple[Kind, ...]]:
    """Arrays in one dimension and numbers, and the kind of each."""
    kind_of, flat, kinds = _kinds(count), [], []
    for argument in arguments:
        shape = getattr(argument, "shape", ())
        if shape in kind_of:
            kind = kind_of[shape]
            if kind is None:
                argument = float(argument)
            elif type(argument) is not np.ndarray or argument.dtype != REAL or kind or not argument.flags.c_contiguous:
                argument = np.asarray(argument, dtype=REAL).ravel()
        elif isinstance(argument, Table):
            kind, argument = WHOLE, np.asarray(argument.entries, dtype=np.float64).ravel()
        else:
            raise ValueError(f"cannot work on each particle of an array of shape {shape}")
        flat.append(argument)
        kinds.append(kind)
    return flat, tuple(kinds)


@functools.lru_cache(maxsize=64)
def _kinds(count: int) -> dict[Any, Kind]:
    """The kind of numbers, and of arrays of each shape that there may be."""
    return {(): None, **{(count, *row): row for row in WIDTHS}}


@functools.lru_cache(maxsize=512)
def _each(function: Callable, kinds: tuple) -> tuple[Callable, list[tuple[int, ...]]]:
    shapes = _shapes(function, kinds)
    names, results = [f"a{k}" for k in range(len(kinds))], [f"out{k}" for k in range(len(shapes))]
    sources = Sources(CALLS)
    call = f"{sources.add(function)}({', '.join(map(_element, names, kinds))})"
    lines = _slices(names, kinds) + _slices(results, shapes)
    lines += ["for n in range(last - first):", f"    value = {call}"]
    for k, shape in enumerate(shapes):
        lines += [
            f"    out{k}_here[{_place(shape, component)}] = {value}"
            for component, value in enumerate(_components(f"value[{k}]", shape))
        ]
    return _compiled("particlewise", function, sources, names + results, "{'contract', 'nsz'}", lines), shapes


@functools.lru_cache(maxsize=512)
def _sums(
    function: Callable, kinds: tuple, more: tuple, cases: int
) -> tuple[Callable, list[tuple[slice, tuple[int, ...]]], int]:
    # The loop, the columns of each sum with the shape that it has for all cases, and how many columns there are.
    shapes = _shapes(function, kinds + more)
    names, mine = [f"a{k}" for k in range(len(kinds))], [f"e{k}" for k in range(len(more))]
    sources = Sources(CALLS)
    called = sources.add(function)
    values = [value for k, shape in enumerate(shapes) for value in _components(f"value[{k}]", shape)]
    # All cases are summed up by one function, which is compiled once.
    lines = _slices(names + mine, kinds + more) + [f"s{k} = 0.0" for k in range(len(values))]
    lines += ["for n in range(last - first):"]
    lines += [f"    value = {called}({', '.join(map(_element, names + mine, kinds + more))})"]
    lines += [f"    s{k} += {value}" for k, value in enumerate(values)]
    lines += [f"parts[case, {k}, chunk] = s{k}" for k in range(len(values))]
    flags = "{'reassoc', 'contract', 'nsz'}"
    case = CASE.format(flags=flags, arrays="".join(f", {name}" for name in names + mine))
    before = "\n".join([case, *(f"    {line}" for line in lines)])
    every, calls = list(names), []
    for number in range(cases):
        theirs = [f"e{number}_{k}" for k in range(len(more))]
        every += theirs
        calls.append(f"sum_up({', '.join([str(number), 'chunk', 'first', 'last', 'parts', *names, *theirs])})")
    edges = [0, *accumulate(WIDTHS[shape] for shape in shapes)]
    columns = [(slice(*ends), (cases, *shape)) for ends, shape in zip(pairwise(edges), shapes, strict=True)]
    return _compiled("totals", function, sources, [*every, "parts"], flags, calls, before), columns, edges[-1]


def _compiled(
    kind: str, function: Callable, sources: Sources, arrays: list[str], flags: str, lines: list[str], before: str = ""
) -> Callable:
    from astroinertia.engines.numba_cache import load_module, taken_from  # with numba: only what is run waits for it

    loop = LOOP.format(flags=flags, chunk=CHUNK, arrays="".join(f", {name}" for name in arrays))
    loop += "\n".join(f"        {line}" for line in lines) + "\n"
    text = "\n".join([taken_from(_shared()), sources.text(), "", before, "", loop])
    return load_module(f"{kind}_{getattr(function, '__name__', '')}", text).loop


@functools.cache
def _shared() -> ModuleType:
    # What all loops have in common is compiled once a process.
    from astroinertia.engines import numba_vectors
    from astroinertia.engines.numba_cache import load_module

    elementary = template("engines/numba_elementary.py")
    return load_module("parts_of_loops", "\n".join([inspect.getsource(numba_vectors), elementary, HEADER]))


def _shapes(function: Callable, kinds: tuple) -> list[tuple[int, ...]]:
    """The shape of a row of each result, from a trial."""
    one = np.float64(1.0)  # whose divisions by zero are no errors
    trial = {None: one, (): one, (3,): (one,) * 3, (3, 3): ((one,) * 3,) * 3, WHOLE: _Trial()}
    with np.errstate(all="ignore"):
        return [np.shape(value) for value in function(np, *(trial[kind] for kind in kinds))]


class _Trial:
    """A table whose every entry is one: where a trial looks does not matter."""

    def take(self, *_: Any, **__: Any) -> np.float64:
        return np.float64(1.0)


def _slices(names: Sequence[str], kinds: Sequence[Kind]) -> list[str]:
    # Within a slice an index cannot be negative, which numba would have to ask in every round of the loop.
    return [
        f"{name}_here = {name}[{WIDTHS[kind]} * first:{WIDTHS[kind]} * last]".replace("1 * ", "")
        for name, kind in zip(names, kinds, strict=True)
        if isinstance(kind, tuple)
    ]


def _place(shape: tuple[int, ...], component: int) -> str:
    return "n" if shape == () else f"{WIDTHS[shape]} * n + {component}"


def _element(name: str, kind: Kind) -> str:
    if not isinstance(kind, tuple):
        return name
    at = [f"{name}_here[{_place(kind, component)}]" for component in range(WIDTHS[kind])]
    if kind == (3, 3):
        at = [f"({', '.join(at[3 * row : 3 * row + 3])})" for row in range(3)]
    return at[0] if kind == () else f"({', '.join(at)})"


def _components(value: str, shape: tuple[int, ...]) -> list[str]:
    return [value + "".join(f"[{k}]" for k in index) for index in np.ndindex(shape)]


def _apart(argument: Array) -> Any:
    if isinstance(argument, Table):
        return argument.entries
    shape = getattr(argument, "shape", ())[1:]
    if shape == (3,):
        return tuple(argument[:, k] for k in range(3))
    if shape == (3, 3):
        return tuple(tuple(argument[:, i, j] for j in range(3)) for i in range(3))
    return argument


def _joined(xp: Any, value: Any, count: int) -> Array:
    if isinstance(value, tuple):
        return xp.stack([_joined(xp, part, count) for part in value], axis=1)
    return xp.broadcast_to(value, (count,))


def _summed(xp: Any, results: list[tuple[Any, ...]], count: int) -> list[tuple[Array, ...]]:
    # The same with a sum for each array, those of three or nine of them as arrays too.
    from astroinertia.engines.xla_sums import sums  # only here: numba's engine does without JAX

    found = iter(sums([xp.broadcast_to(array, (count,)) for array in _leaves(results)]))

    def joined(value: Any) -> Array:
        return xp.stack([joined(part) for part in value]) if isinstance(value, tuple) else next(found)

    return [tuple(map(joined, values)) for values in results]


def _leaves(value: Any) -> list[Array]:
    return [leaf for part in value for leaf in _leaves(part)] if isinstance(value, (tuple, list)) else [value]
