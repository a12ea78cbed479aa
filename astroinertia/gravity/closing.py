"""Closing up what is kept of an array, a whole vector at a time; the text is copied into the generated modules.

`kept(values, key, k, count, out, filled)` appends to out[filled:] those of values[k : k + width] whose key is not >= 0,
and returns how far `out` is filled. width(key): how many at once. Nothing from `count` on is kept; arrays must be
readable, and `out` writable, for one vector more. NaN is kept.
"""

# pyright: reportCallIssue=false
# (numba itself gives intrinsics their first argument)

from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from astroinertia.engines.numba_vectors import COMPRESSES, INT64, PART


@intrinsic
def _kept_vector(typingctx, values, key, k, count, out, filled):
    def codegen(context, builder, signature, args):
        width = 512 // signature.args[1].dtype.bitwidth

        def vector(number, at):
            data = context.make_array(signature.args[number])(context, builder, args[number]).data
            kind = ir.VectorType(context.get_value_type(signature.args[number].dtype), width)
            return builder.bitcast(builder.gep(data, [at]), kind.as_pointer()), kind

        def spread(value):
            empty = ir.Constant(ir.VectorType(INT64, width), ir.Undefined)
            zeros = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
            return builder.shuffle_vector(
                builder.insert_element(empty, value, ir.Constant(ir.IntType(32), 0)), empty, zeros
            )

        pointer, kind = vector(1, args[2])
        keys = builder.load(pointer, align=4)
        chosen = builder.fcmp_unordered("<", keys, ir.Constant(kind, [0.0] * width))
        steps = ir.Constant(ir.VectorType(INT64, width), list(range(width)))
        chosen = builder.and_(chosen, builder.icmp_signed("<", steps, spread(builder.sub(args[3], args[2]))))
        pointer, kind = vector(0, args[2])
        letter = "i" if isinstance(kind.element, ir.IntType) else "f"
        compress = cgutils.get_or_insert_function(
            builder.module,
            ir.FunctionType(kind, [kind, chosen.type, kind]),
            f"llvm.experimental.vector.compress.v{width}{letter}{signature.args[0].dtype.bitwidth}",
        )
        closed = builder.call(compress, [builder.load(pointer, align=4), chosen, ir.Constant(kind, ir.Undefined)])
        builder.store(closed, vector(4, args[5])[0], align=4)
        bits = ir.IntType(width)
        ones = cgutils.get_or_insert_function(builder.module, ir.FunctionType(bits, [bits]), f"llvm.ctpop.i{width}")
        number = builder.zext(builder.call(ones, [builder.bitcast(chosen, bits)]), INT64)
        return builder.add(args[5], number)

    return types.int64(values, key, types.int64, types.int64, out, types.int64), codegen


@njit(**PART)
def _kept_one_by_one(values, key, k, count, out, filled):
    for n in range(k, min(k + 64 // key.itemsize, count)):
        out[filled] = values[n]
        filled += 0 if key[n] >= 0 else 1
    return filled


kept = _kept_vector if COMPRESSES else _kept_one_by_one


@njit(**PART)
def closed_up(values, key, count, out, filled):
    """Append to out[filled:] those of values[:count] whose key is not >= 0; returns how far `out` is filled."""
    for k in range(0, count, 64 // key.itemsize):
        filled = kept(values, key, k, count, out, filled)
    return filled
