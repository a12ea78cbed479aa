"""A function of JAX compiled in pieces: each pass over pairs by itself, and what stands between two of them.

XLA takes longer over one large program than over its parts, and a pass that was compiled for a first state serves all
steps. Test: tests/unit/engines/test_xla_pieces.py.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from typing import Any

import jax
from jax.core import Tracer
from jax.extend import core

from astroinertia.engines.threads import available_threads

Array = Any
Compiled = Callable[..., Sequence[Array]]


@cache
def in_pieces(function: Callable[..., Any]) -> Callable[..., Any]:
    """The same function of trees of arrays, compiled for each of their structures and shapes.

    Within jax.jit, jax.grad and the like it is the function as it stands, a part of their one program.
    """
    programs: dict[Any, _Program] = {}

    def called(*arguments: Any) -> Any:
        arrays, structure = jax.tree.flatten(arguments)
        if any(isinstance(array, Tracer) for array in arrays):
            return function(*arguments)
        key = structure, tuple(map(jax.typeof, arrays)), jax.sharding.get_abstract_mesh()
        if key not in programs:
            programs[key] = _program(function, arguments)
        return programs[key](arrays)

    return called


@dataclass(frozen=True)
class _Piece:
    """Compiled equations, and the variables that they read and write."""

    compiled: Compiled
    reads: tuple[Any, ...]
    writes: tuple[Any, ...]


@dataclass(frozen=True)
class _Program:
    """Pieces in their order, the variables that they begin with and those that are returned, with their structure."""

    arguments: tuple[Any, ...]
    constants: dict[Any, Array]
    pieces: tuple[_Piece, ...]
    results: tuple[Any, ...]
    structure: Any

    def __call__(self, arrays: Sequence[Array]) -> Any:
        known = dict(zip(self.arguments, arrays, strict=True)) | self.constants
        for piece in self.pieces:
            known.update(zip(piece.writes, piece.compiled(*_values(known, piece.reads)), strict=True))
        return jax.tree.unflatten(self.structure, _values(known, self.results))


def _program(function: Callable[..., Any], arguments: tuple[Any, ...]) -> _Program:
    traced, shapes = jax.make_jaxpr(function, return_shape=True)(*arguments)
    jaxpr, constants = traced.jaxpr, dict(zip(traced.jaxpr.constvars, traced.consts, strict=True))
    wanted = set(_variables(jaxpr.outvars))
    pieces: list[_Piece] = []
    for group in reversed(list(_groups(jaxpr.eqns))):  # what of a piece is wanted is known after those that follow it
        written = [x for equation in group for x in equation.outvars]
        writes = tuple(x for x in written if x in wanted)
        if not writes:
            continue
        inner = set(written)
        reads = dict.fromkeys(x for equation in group for x in _variables(equation.invars) if x not in inner)
        pieces.append(_pass(group[0]) if _is_pass(group[0]) else _between(jaxpr, group, tuple(reads), writes))
        wanted |= reads.keys()
    _compile(pieces)
    structure = jax.tree.structure(shapes)
    return _Program(tuple(jaxpr.invars), constants, tuple(reversed(pieces)), tuple(jaxpr.outvars), structure)


def _groups(equations: Sequence[Any]) -> Iterator[list[Any]]:
    """Equations in their order: each pass by itself, and all between two of them."""
    between: list[Any] = []
    for equation in equations:
        if _is_pass(equation):
            yield between
            yield [equation]
            between = []
        else:
            between.append(equation)
    yield between


def _is_pass(equation: Any) -> bool:
    """Whether it calls a compiled function with a loop in it."""
    return {"jaxpr", "name"} <= equation.params.keys() and _loops(equation)


def _loops(equation: Any) -> bool:
    if equation.primitive.name in ("while", "scan"):
        return True
    parameters = (x for value in equation.params.values() for x in (value if isinstance(value, tuple) else (value,)))
    inner = (x.jaxpr if isinstance(x, core.ClosedJaxpr) else x for x in parameters)
    return any(_loops(each) for jaxpr in inner if isinstance(jaxpr, core.Jaxpr) for each in jaxpr.eqns)


def _pass(equation: Any) -> _Piece:
    return _Piece(_function(equation.params["jaxpr"]), tuple(equation.invars), tuple(equation.outvars))


@cache
def _function(jaxpr: core.ClosedJaxpr) -> Compiled:
    # JAX has traced a pass once for the same arguments: all programs that it is in have it from here.
    return jax.jit(core.jaxpr_as_fun(jaxpr))


def _between(jaxpr: core.Jaxpr, group: list[Any], reads: tuple[Any, ...], writes: tuple[Any, ...]) -> _Piece:
    part = core.Jaxpr((), reads, writes, group, debug_info=jaxpr.debug_info)
    return _Piece(jax.jit(core.jaxpr_as_fun(core.ClosedJaxpr(part, ()))), reads, writes)


def _compile(pieces: list[_Piece]) -> None:
    """Compile them on all cores, before they are called one after another."""
    if not jax.sharding.get_abstract_mesh().empty:
        return  # where each argument is, on several devices, is known only as it comes
    wide = jax.config.jax_enable_x64  # type: ignore[attr-defined]

    def compiled(piece: _Piece) -> None:
        with jax.enable_x64(wide):
            piece.compiled.lower(*(_shape(variable.aval) for variable in piece.reads)).compile()

    with ThreadPoolExecutor(available_threads()) as pool:
        list(pool.map(compiled, {piece.compiled: piece for piece in pieces}.values()))


def _shape(aval: Any) -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct(aval.shape, aval.dtype, weak_type=aval.weak_type)


def _variables(atoms: Sequence[Any]) -> Iterator[Any]:
    return (x for x in atoms if not isinstance(x, core.Literal))


def _values(known: dict[Any, Array], atoms: Sequence[Any]) -> list[Array]:
    return [x.val if isinstance(x, core.Literal) else known[x] for x in atoms]
