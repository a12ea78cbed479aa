"""How the engine's functions are compiled: as by numba, without what takes time and does nothing for them.

Functions that only others call are compiled not by themselves, but once in each program that calls them. Numba would
turn each into machine code of its own, which is never run from Python, and again within every caller. The two may
round differently (fast-math), both stand under one name, and the first that a process meets is used: results would
depend on whether a program was just compiled or found compiled.
Measured on a first run of sims/pulsar_collapse.toml (375 functions): operators typed once take a sixth off compiling,
passes left out a sixteenth, functions optimised only within their programs a sixteenth, no garbage collected meanwhile
an eighth; on multipoles of order 7 no static single assignment takes a tenth off the rest.
Tests: tests/unit/engines/test_numba_compiler.py, tests/unit/process/test_kept_programs.py, tests/crash/test_kills.py.
"""

import contextlib
from collections.abc import Iterator
from typing import Any

from numba import _dynfunc  # type: ignore[attr-defined]
from numba.core import typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.types import Array, IntegerLiteral, Number, unliteral
from numba.core.types.functions import BaseFunction, Dispatcher

from astroinertia.process.uncollected import uncollected

# Passes for closures, with, raise, functions to be inlined before types are known, loops over literals, and expressions
# of whole arrays: the engine's functions have none of these. And the static single assignment of numba, for names whose
# type changes on the way: ours do not change it, and LLVM does the same in far less time.
NEEDLESS = {
    untyped_passes.WithLifting, untyped_passes.InlineClosureLikes, untyped_passes.RewriteDynamicRaises,
    untyped_passes.MakeFunctionToJitFunction, untyped_passes.InlineInlinables, untyped_passes.FindLiterallyCalls,
    untyped_passes.LiteralUnroll, untyped_passes.LiteralPropagationSubPipelinePass, untyped_passes.ReconstructSSA,
    typed_passes.InlineOverloads, typed_passes.PreLowerStripPhis,
    typed_passes.NopythonRewrites, typed_passes.DumpParforDiagnostics,
}  # fmt: skip

_signatures: dict[tuple, Any] = {}
_get_call_type, _get_dispatched_type = BaseFunction.get_call_type, Dispatcher.get_call_type


def _kept_call_type(function: Any, context: Any, args: tuple, kws: dict) -> Any:
    # Only of operators that numba builds in: what others resolve to may be compiled under other flags.
    if args and isinstance(args[0], (Array, Number)):  # what numbers written out are does not matter here
        args = tuple(unliteral(arg) if isinstance(arg, IntegerLiteral) else arg for arg in args)
    key = (function, context, args)
    if kws or key not in _signatures:
        signature = _get_call_type(function, context, args, kws)
        if kws or function.get_impl_key(signature) is not function.typing_key:
            return signature
        _signatures[key] = signature
    return _signatures[key]


def _plain_call_type(function: Any, context: Any, args: tuple, kws: dict) -> Any:
    if issubclass(function.dispatcher._compiler.pipeline_class, EntryCompiler):
        args, kws = tuple(map(unliteral, args)), {name: unliteral(value) for name, value in kws.items()}
    return _get_dispatched_type(function, context, args, kws)


@contextlib.contextmanager
def _typed_once() -> Iterator[None]:
    """Within, what an operator does to types is looked up once, not for every use: numba tries dozens of forms each.

    And a function of the engine is compiled once for all numbers that are written out where it is called, not for each.
    Compiling holds numba's lock, so that no other thread compiles meanwhile.
    """
    before = BaseFunction.get_call_type, Dispatcher.get_call_type
    BaseFunction.get_call_type = _kept_call_type  # type: ignore[method-assign]
    Dispatcher.get_call_type = _plain_call_type  # type: ignore[method-assign]
    try:
        yield
    finally:
        BaseFunction.get_call_type, Dispatcher.get_call_type = before


class EntryLibrary(JITCodeLibrary):
    """A program: its functions are optimised when all are together, not each before."""

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout


class EntryCompiler(Compiler):
    """Compiles what Python calls."""

    def compile_extra(self, func: Any) -> Any:
        """Numba's result."""
        self.state.library = EntryLibrary(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        with uncollected(), _typed_once():
            return super().compile_extra(func)

    def define_pipelines(self) -> list:
        """Numba's, without needless passes."""
        pipelines = super().define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [step for step in pipeline.passes if step[0] not in NEEDLESS]
        return pipelines


class PartLibrary(EntryLibrary):
    """A function and what it calls as they are lowered, for others to link; its callers optimise it with themselves."""

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


class PartCompiler(EntryCompiler):
    """Compiles what only other compiled functions call, and makes no machine code."""

    def compile_extra(self, func: Any) -> Any:
        """Numba's result, whose entry from Python has no code behind it (as that of all that have no wrapper)."""
        self.state.library = PartLibrary(self.state.targetctx.codegen(), func.__qualname__)
        with _typed_once():
            result = Compiler.compile_extra(self, func)
        nothing = _dynfunc.make_function(
            result.fndesc.lookup_module(), func.__name__, "", 0, result.environment, (result.library,)
        )
        self.state.targetctx.insert_user_function(nothing, result.fndesc, [result.library])
        return result._replace(entry_point=nothing)

    def define_pipelines(self) -> list:
        """Numba's, which stop before machine code."""
        self.state.flags.no_compile = True
        return super().define_pipelines()
