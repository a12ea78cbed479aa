"""How functions that only others call are compiled: not by themselves, but once in each program that calls them.

Numba would turn each into machine code of its own, which is never run from Python, and again within every caller. The
two may round differently (fast-math), both stand under one name, and the first that a process meets is used: results
would depend on whether a program was just compiled or found compiled. It also takes longer.
Tests: tests/unit/process/test_kept_programs.py, tests/crash/test_kills.py.
"""

from typing import Any

from numba import _dynfunc  # type: ignore[attr-defined]
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class PartLibrary(JITCodeLibrary):
    """A function and what it calls as they are lowered, for others to link; its callers optimise it with themselves."""

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


class PartCompiler(Compiler):
    """Numba's compiler, which makes no machine code."""

    def compile_extra(self, func: Any) -> Any:
        """Numba's result, whose entry from Python has no code behind it (as that of all that have no wrapper)."""
        self.state.library = PartLibrary(self.state.targetctx.codegen(), func.__qualname__)
        result = super().compile_extra(func)
        nothing = _dynfunc.make_function(
            result.fndesc.lookup_module(), func.__name__, "", 0, result.environment, (result.library,)
        )
        self.state.targetctx.insert_user_function(nothing, result.fndesc, [result.library])
        return result._replace(entry_point=nothing)

    def define_pipelines(self) -> list:
        """Numba's, which stop before machine code."""
        self.state.flags.no_compile = True
        return super().define_pipelines()
