"""The engine's compilers do less than numba's and come to the same."""

import signal

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError
from numba.core.types.functions import BaseFunction
from numba.extending import overload

from astroinertia.engines import numba_cache, numba_compiler
from astroinertia.engines.numba_vectors import ENTRY, PART

UNKEPT = {name: option for name, option in ENTRY.items() if name != "cache"}
PLAIN = {name: option for name, option in UNKEPT.items() if name != "pipeline_class"}


def weighted(weight, x, index):
    return weight[index] * x[index, 0] if weight[index] < 2.0 else x[index, 1] ** 2


def totals(weight, x, out):
    last, parity = 0.0, 0  # names that are given again, within branches and loops
    for k in range(len(weight)):
        if weight[k] > 2.0:
            last = x[k, 0]
        out[parity] += weighted_part(weight, x, k) - 0.5 * x[k, 1] * last
        parity = 1 - parity


weighted_part = njit(**PART)(weighted)


def looked_up(monkeypatch, function, *arguments):
    """How often numba looked through the forms of a function or operator while this was compiled."""
    calls = []
    real = numba_compiler._get_call_type
    monkeypatch.setattr(
        numba_compiler, "_get_call_type", lambda *several: (calls.append(several[0]), real(*several))[1]
    )
    function(*arguments)
    return len(calls)


def test_operators_are_typed_once_and_programs_are_those_of_numba(monkeypatch):
    random = np.random.default_rng(1)
    weight, x = random.uniform(1.0, 3.0, 50), random.normal(size=(50, 2))
    numba_compiler._signatures.clear()
    ours, again, theirs = np.zeros(2), np.zeros(2), np.zeros(2)
    first = looked_up(monkeypatch, njit(**UNKEPT)(totals), weight, x, ours)
    second = looked_up(monkeypatch, njit(**UNKEPT)(totals), weight, x, again)
    njit(**PLAIN)(totals)(weight, x, theirs)
    assert second < first / 2
    np.testing.assert_array_equal(ours, theirs)
    np.testing.assert_array_equal(again, theirs)


def test_numbers_that_are_written_out_need_no_function_of_their_own():
    @njit(**PART)
    def scaled(x, factor):
        return x * factor

    @njit(**UNKEPT)
    def several(x, count):
        return scaled(x, 2) + scaled(x, 3) + scaled(x, count)

    assert several(1.5, 4) == 13.5
    assert len(scaled.overloads) == 1


def test_numba_itself_is_left_as_it_was_also_by_functions_that_cannot_be_compiled():
    before = BaseFunction.get_call_type

    @njit(**UNKEPT)
    def impossible(x):
        return x + "text"

    with pytest.raises(TypingError, match=r"add"):
        impossible(1.0)
    assert BaseFunction.get_call_type is before
    assert before is not numba_compiler._kept_call_type
    with pytest.raises(TypingError, match=r"add"):  # what failed is not kept
        impossible(1.0)


def test_functions_that_others_call_are_no_machine_code_and_programs_are():
    program = njit(**UNKEPT)(totals)
    program(np.ones(2), np.ones((2, 2)), np.zeros(2))
    (signature,) = program.signatures
    assert isinstance(program.overloads[signature].library, numba_compiler.EntryLibrary)
    assert not isinstance(program.overloads[signature].library, numba_compiler.PartLibrary)
    parts = [part.library for part in weighted_part.overloads.values()]
    assert parts and all(isinstance(library, numba_compiler.PartLibrary) for library in parts)


def test_a_signal_that_comes_while_a_function_is_compiled_waits_for_that():
    """An exception that its handler raised within the compiler could leave a lock of LLVM that nothing lets go of."""
    assert numba_cache  # which listens to the compiler
    went_on = []

    def twice(x):
        return 2 * x

    @overload(twice)
    def _(x):
        if not went_on:
            signal.raise_signal(signal.SIGINT)
            went_on.append(True)
        return lambda x: 2 * x

    compiled = njit(lambda x: twice(x) + 1)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background commands ignore it
    try:
        with pytest.raises(KeyboardInterrupt):
            compiled(3)
    finally:
        signal.signal(signal.SIGINT, before)
    assert went_on == [True]
    assert compiled(3) == 7
