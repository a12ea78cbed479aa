"""Compaction of what is kept of an array, a whole vector at a time; the text is copied into the generated modules.

`kept(values, key, k, count, out, filled)` appends to out[filled:] those of values[k : k + width] whose key is not >= 0,
and returns how far `out` is filled. width(key): how many at once. Nothing from `count` on is kept; arrays must be
readable, and `out` writable, for one vector more. NaN is kept.
"""

# pyright: reportCallIssue=false
# (numba itself gives intrinsics their first argument)

from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from astroinertia.engines.numba_vectors import COMPACTED_BITS, PART, Lanes

# Copied into generated modules from here on.


@intrinsic
def _kept_vector(typingctx, values, key, k, count, out, filled):
    def codegen(context, builder, signature, args):
        build, lanes = Lanes(context, builder, signature, args), 512 // signature.args[1].dtype.bitwidth
        keys = build.load(1, args[2], lanes)
        chosen = builder.fcmp_unordered("<", keys, ir.Constant(keys.type, [0.0] * lanes))
        chosen = build.up_to(args[3], args[2], chosen)
        build.store_kept(4, args[5], build.load(0, args[2], lanes), chosen)
        return builder.add(args[5], build.number_of(chosen))

    return types.int64(values, key, types.int64, types.int64, out, types.int64), codegen


@njit(**PART)
def _kept_one_by_one(values, key, k, count, out, filled):
    for n in range(k, min(k + 64 // key.itemsize, count)):
        out[filled] = values[n]
        filled += 0 if key[n] >= 0 else 1
    return filled


kept = _kept_vector if COMPACTED_BITS else _kept_one_by_one


@njit(**PART)
def compacted(values, key, count, out, filled):
    """Append to out[filled:] those of values[:count] whose key is not >= 0; returns how far `out` is filled."""
    for k in range(0, count, 64 // key.itemsize):
        filled = kept(values, key, k, count, out, filled)
    return filled
