"""Vector instructions for the numba engine: what its compiler would not find by itself.

Streams of candidates are compacted ("compressed") with one instruction on processors that have it (AVX-512), or by a
permutation that is looked up (AVX2); elsewhere plain loops do the same, as they do with numba switched off
(NUMBA_DISABLE_JIT=1). The text of this file is copied into the generated modules of shared parts.
"""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import config, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from astroinertia.engines.numba_compiler import EntryCompiler, PartCompiler
from astroinertia.engines.processor import vector_bits

# Boxes are pruned only where they are certainly out of reach, whatever the rounding of pair distances in float32.
SLACK = 1.0 + 2e-5
# Functions that only others call need neither an entry from Python nor machine code of their own, and none needs an
# entry from C: all are long to compile.
INNER: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": PartCompiler}
PART: dict[str, Any] = {"error_model": "numpy", "nogil": True, **INNER}
ENTRY: dict[str, Any] = {
    "cache": True, "error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True, "pipeline_class": EntryCompiler,
}  # fmt: skip
# Arrays are filled up to whole vectors of float32 on the widest machines, and hold one more vector for loose ends.
LANES = 16
# Bits of the vectors that the processor closes up; 0 where it cannot.
COMPACTED_BITS = vector_bits()
INT64 = ir.IntType(64)


@njit(forceinline=True, **INNER)
def padded(count):
    """The next multiple of LANES."""
    return ((count + LANES - 1) // LANES) * LANES


def plain_or_intrinsic(plain: Callable) -> Callable[[Callable], Any]:
    """Decorates what numba builds an instruction by; with numba switched off, `plain` stands in its place."""
    return (lambda _: plain) if config.DISABLE_JIT else intrinsic  # type: ignore[attr-defined]


def _selection(name):
    @plain_or_intrinsic(getattr(np, name))
    def selection(typingctx, a, b):
        if not isinstance(a, types.Float) or a != b:
            return None

        def codegen(context, builder, signature, args):
            kind = args[0].type
            symbol = f"llvm.{name}.{'f64' if isinstance(kind, ir.DoubleType) else 'f32'}"
            function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(kind, [kind, kind]), symbol)
            return builder.call(function, args)

        return a(a, b), codegen

    return selection


# IEEE 754 maximum and minimum: NaN if either is NaN. Loops over them are vectorised.
maximum = _selection("maximum")
minimum = _selection("minimum")


def _claimed(counter, amount=1):
    was = counter[0]
    counter[0] += amount
    return was


@plain_or_intrinsic(_claimed)
def take(typingctx, counter):
    """Add one to counter[0] atomically and return what it was: how threads share out leaves."""
    if counter != types.Array(types.int64, 1, "C"):
        return None

    def codegen(context, builder, signature, args):
        array = context.make_array(signature.args[0])(context, builder, args[0])
        return builder.atomic_rmw("add", array.data, ir.Constant(INT64, 1), "monotonic")

    return types.int64(counter), codegen


@plain_or_intrinsic(_claimed)
def claim(typingctx, counter, amount):
    """Add an amount to counter[0] atomically and return what it was: how threads share out an array."""
    if counter != types.Array(types.int64, 1, "C"):
        return None

    def codegen(context, builder, signature, args):
        array = context.make_array(signature.args[0])(context, builder, args[0])
        return builder.atomic_rmw("add", array.data, args[1], "monotonic")

    return types.int64(counter, types.int64), codegen


@plain_or_intrinsic(lambda: None)
def widest_vectors(typingctx):
    """Let the calling function use the widest vectors that the processor has (compilers prefer narrower ones).

    The function is also kept from being copied into its callers, so that it is compiled once.
    """

    def codegen(context, builder, signature, args):
        builder.function.attributes.add("noinline")
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')  # llvmlite knows no attributes with values
        return context.get_dummy_value()

    return types.void(), codegen


@plain_or_intrinsic(lambda: None)
def estimated_roots(typingctx):
    """Let 1/sqrt of float32 in the calling function be the processor's estimate (processor.mean_estimates)."""

    def codegen(context, builder, signature, args):
        set.add(builder.function.attributes, '"reciprocal-estimates"="vec-sqrtf:0,sqrtf:0"')
        return context.get_dummy_value()

    return types.void(), codegen


@plain_or_intrinsic(lambda: None)
def once(typingctx):
    """Keep the calling function from being copied into its callers, so that each program compiles it once."""

    def codegen(context, builder, signature, args):
        builder.function.attributes.add("noinline")
        return context.get_dummy_value()

    return types.void(), codegen


@plain_or_intrinsic(lambda: None)
def widest_vectors_inlined(typingctx):
    """As `widest_vectors`, for a function that is copied into its callers."""

    def codegen(context, builder, signature, args):
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.void(), codegen


@njit(forceinline=True, **INNER)
def where(condition, a, b):
    """Either value, both of which are at hand."""
    return a if condition else b


@njit(forceinline=True, **INNER)
def larger_of(a, b):
    """The larger of two numbers; b if either is NaN, so that an unknown b stays so."""
    return a if a > b else b


@njit(forceinline=True, fastmath={"contract", "nsz"}, **PART)
def reciprocal_root(x):
    """1/sqrt(x) of a positive normal float64 to one unit in the last place; several times faster than to divide.

    The first guess halves the exponent (Lomont 2003; error 3.4e-2); each step raises its order by four.
    """
    y = np.int64(np.int64(0x5FE6EB50C7B537A9) - (np.float64(x).view(np.int64) >> 1)).view(np.float64)
    e = 1.0 - x * (y * y)
    y = y + y * (e * (0.5 + e * (0.375 + e * 0.3125)))
    e = 1.0 - x * (y * y)
    return y + y * (e * (0.5 + e * (0.375 + e * 0.3125)))


@plain_or_intrinsic(operator.getitem)
def at(typingctx, array, index):
    """array[index] for an index that is known to lie within the array: loops over it become plain vector gathers."""

    def codegen(context, builder, signature, args):
        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        index = args[1] if args[1].type.width == 64 else builder.sext(args[1], INT64)
        return builder.load(builder.gep(data, [index]))

    return array.dtype(array, index), codegen


class Lanes:
    """Builds the loops below: whole vectors of 64 bytes, of which what is kept is compacted and stored."""

    def __init__(self, context, builder, signature, args):
        self.context, self.builder, self.signature, self.args = context, builder, signature, args

    def scalar_type(self, k):
        """Machine type of argument k, or of what it is an array of."""
        kind = self.signature.args[k]
        return self.context.get_value_type(getattr(kind, "dtype", kind))

    def pointer(self, k, position, count):
        """Where `count` elements of array k stand, from a position on."""
        data = self.context.make_array(self.signature.args[k])(self.context, self.builder, self.args[k]).data
        vector = ir.VectorType(self.scalar_type(k), count)
        return self.builder.bitcast(self.builder.gep(data, [position]), vector.as_pointer())

    def load(self, k, position, count):
        """A vector of array k."""
        return self.builder.load(self.pointer(k, position, count), align=4)

    def spread(self, value, count):
        """A scalar in every lane."""
        nothing = ir.Constant(ir.VectorType(value.type, count), ir.Undefined)
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), count), [0] * count)
        first = self.builder.insert_element(nothing, value, ir.Constant(ir.IntType(32), 0))
        return self.builder.shuffle_vector(first, nothing, zeros)

    def numbers(self, k, first, count):
        """first, first + 1, ... of the type of array k."""
        kind = self.scalar_type(k)
        first = first if kind.width == 64 else self.builder.trunc(first, kind)
        steps = ir.Constant(ir.VectorType(kind, count), [ir.Constant(kind, lane) for lane in range(count)])
        return self.builder.add(self.spread(first, count), steps)

    def store_kept(self, k, position, values, kept):
        """Close up what is kept of a vector and store it in array k, from a position on."""
        builder, count, width = self.builder, values.type.count, self.signature.args[k].dtype.bitwidth
        nothing, lanes = ir.Constant(values.type, ir.Undefined), COMPACTED_BITS // width
        if COMPACTED_BITS == 512:  # of narrow numbers beside wide ones there are fewer than such a vector holds
            letter = "i" if isinstance(self.scalar_type(k), ir.IntType) else "f"
            compress = cgutils.get_or_insert_function(
                builder.module,
                ir.FunctionType(values.type, [values.type, kept.type, values.type]),
                f"llvm.experimental.vector.compress.v{count}{letter}{width}",
            )
            builder.store(builder.call(compress, [values, kept, nothing]), self.pointer(k, position, count), align=4)
            return
        for first in range(0, count, lanes):
            mine = ir.Constant(ir.VectorType(ir.IntType(32), lanes), list(range(first, first + lanes)))
            some = builder.shuffle_vector(kept, ir.Constant(kept.type, ir.Undefined), mine)
            closed = self.permuted(builder.shuffle_vector(values, nothing, mine), some)
            builder.store(closed, self.pointer(k, position, lanes), align=4)
            position = builder.add(position, self.number_of(some))

    def permuted(self, values, kept):
        """A vector of 256 bits whose kept lanes come first, in their order."""
        builder, lanes, words = self.builder, kept.type.count, ir.VectorType(ir.IntType(32), 8)
        name = f"places of what is kept of {lanes}"
        if name not in builder.module.globals:
            size = 8 // lanes  # words of 32 bits a lane
            rows = []
            for mask in range(1 << lanes):
                order = sorted(range(lanes), key=lambda lane, mask=mask: not mask >> lane & 1)
                rows.append(ir.Constant(words, [size * lane + n for lane in order for n in range(size)]))
            cgutils.global_constant(builder.module, name, ir.Constant(ir.ArrayType(words, len(rows)), rows))
        mask = builder.zext(builder.bitcast(kept, ir.IntType(lanes)), INT64)
        row = builder.gep(builder.module.globals[name], [ir.Constant(INT64, 0), mask])
        permute = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(words, [words, words]), "llvm.x86.avx2.permd"
        )
        return builder.bitcast(
            builder.call(permute, [builder.bitcast(values, words), builder.load(row, align=4)]), values.type
        )

    def number_of(self, kept):
        """How many lanes are kept."""
        bits = ir.IntType(kept.type.count)
        ones = cgutils.get_or_insert_function(
            self.builder.module, ir.FunctionType(bits, [bits]), f"llvm.ctpop.i{bits.width}"
        )
        return self.builder.zext(self.builder.call(ones, [self.builder.bitcast(kept, bits)]), INT64)

    def up_to(self, last, position, kept):
        """Of what is kept of the vector at a position, what comes before `last`."""
        count = kept.type.count
        steps = ir.Constant(ir.VectorType(INT64, count), list(range(count)))
        remaining = self.spread(self.builder.sub(last, position), count)
        return self.builder.and_(kept, self.builder.icmp_signed("<", steps, remaining))

    def loop(self, first, last, lanes, filled, body):
        """For every vector from first to last: body(position, filled) -> lanes kept; returns how far arrays are filled.

        The final vector, perhaps empty, is marked as the last.
        """
        builder = self.builder
        filled = cgutils.alloca_once_value(builder, filled)
        whole = builder.and_(builder.sub(last, first), ir.Constant(INT64, -lanes))
        end = builder.add(first, whole)
        with cgutils.for_range_slice(builder, first, end, ir.Constant(INT64, lanes), intp=INT64) as (k, _):
            position = builder.load(filled)
            builder.store(builder.add(position, self.number_of(body(k, position))), filled)
        position = builder.load(filled)
        return builder.add(position, self.number_of(body(end, position, last=True)))


@intrinsic
def _compressed_indices(typingctx, first, key, count, out, offset):
    def codegen(context, builder, signature, args):
        build, lanes = Lanes(context, builder, signature, args), 512 // signature.args[1].dtype.bitwidth

        def body(k, position, last=False):
            keys = build.load(1, k, lanes)
            kept = builder.fcmp_unordered("<", keys, ir.Constant(keys.type, [0.0] * lanes))
            kept = build.up_to(args[2], k, kept) if last else kept
            build.store_kept(3, position, build.numbers(3, builder.add(args[0], k), lanes), kept)
            return kept

        return build.loop(ir.Constant(INT64, 0), args[2], lanes, args[4], body)

    return types.int64(first, key, types.int64, out, types.int64), codegen


def _near(of_indices):
    @intrinsic
    def near(typingctx, x, y, z, other, x_i, y_i, z_i, reach2_i, count, out, masses):
        def codegen(context, builder, signature, args):
            build, lanes = Lanes(context, builder, signature, args), 512 // signature.args[0].dtype.bitwidth
            own = [build.spread(args[k], lanes) for k in (4, 5, 6, 7)]

            def body(k, position, last=False):
                square = None
                for axis in range(3):
                    apart = builder.fsub(own[axis], build.load(axis, k, lanes))
                    term = builder.fmul(apart, apart, flags=("contract",))
                    square = term if square is None else builder.fadd(square, term, flags=("contract",))
                others = build.load(3, k, lanes)
                limit = own[3]
                if of_indices:
                    limit = builder.select(builder.fcmp_ordered(">", own[3], others), own[3], others)
                kept = builder.fcmp_unordered("<", square, limit)
                kept = build.up_to(args[8], k, kept) if last else kept
                if of_indices:
                    build.store_kept(9, position, build.numbers(9, k, lanes), kept)
                else:
                    build.store_kept(9, position, square, kept)
                    build.store_kept(10, position, others, kept)
                return kept

            return build.loop(ir.Constant(INT64, 0), args[8], lanes, ir.Constant(INT64, 0), body)

        return types.int64(x, y, z, other, x_i, y_i, z_i, reach2_i, types.int64, out, masses), codegen

    return near


def _boxes_in_reach(inside):
    @intrinsic
    def boxes_in_reach(
        typingctx, lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, size, first, last, box, factor, target_reach, out, offset
    ):
        def codegen(context, builder, signature, args):
            build, lanes = Lanes(context, builder, signature, args), 8
            zero, slack = (ir.Constant(ir.VectorType(ir.DoubleType(), lanes), [x] * lanes) for x in (0.0, SLACK))
            data = context.make_array(signature.args[9])(context, builder, args[9]).data
            sides = [build.spread(builder.load(builder.gep(data, [ir.Constant(INT64, k)])), lanes) for k in range(6)]
            factor, target_reach = build.spread(args[10], lanes), build.spread(args[11], lanes)

            def larger(a, b):
                return builder.select(builder.fcmp_ordered(">", a, b), a, b)

            def body(k, position, last=False):
                square = None
                for axis in range(3):
                    before = builder.fsub(build.load(axis, k, lanes), sides[3 + axis])
                    apart = larger(before, builder.fsub(sides[axis], build.load(3 + axis, k, lanes)))
                    apart = larger(zero, apart)
                    term = builder.fmul(apart, apart, flags=("contract",))
                    square = term if square is None else builder.fadd(square, term, flags=("contract",))
                reach = larger(target_reach, builder.fmul(factor, build.load(6, k, lanes)))
                reach2 = builder.fmul(builder.fmul(reach, reach), slack)
                kept = builder.fcmp_unordered("<" if inside else ">=", square, reach2)
                if not inside:
                    kept = builder.fcmp_ordered(">=", square, reach2)
                kept = build.up_to(args[8], k, kept) if last else kept
                build.store_kept(12, position, build.numbers(12, k, lanes), kept)
                return kept

            return build.loop(args[7], args[8], lanes, args[13], body)

        arrays = (lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, size)
        rest = (types.int64, types.int64, box, types.float64, types.float64, out, types.int64)
        return types.int64(*arrays, *rest), codegen

    return boxes_in_reach


# The functions that are made below:
# compressed_indices(first, key, count, out, offset): append to out[offset:] the indices first + k of those of
# key[:count] that are not >= 0, and return how far `out` is filled. Elements of `key` are as wide as those of `out`.
# near_squares(x, y, z, mass, x_i, y_i, z_i, reach2, count, squares, masses): squared distances and masses of the
# sources not beyond the reach; near_indices(x, y, z, reach2, x_i, y_i, z_i, reach2_i, count, indices, indices): indices
# of the sources not beyond the larger of two reaches. Both return how many there are.
# in_reach(lo_x, ..., hi_z, size, first, last, box, factor, target_reach, out, offset): append the numbers of those
# boxes first to last - 1 that come within max(target_reach, factor size) of a box (2, 3), with some slack; a particle
# is a box whose corners are one. out_of_reach(...): the others.
# NaN is always within reach. All may store LANES elements past what they return, and read LANES too many.
if COMPACTED_BITS:
    compressed_indices = _compressed_indices
    near_squares = _near(False)
    near_indices = _near(True)
    in_reach = _boxes_in_reach(True)
    out_of_reach = _boxes_in_reach(False)
else:

    @njit(**PART)
    def _plain_compressed_indices(first, key, count, out, offset):
        for k in range(count):
            out[offset] = first + k
            offset += 1 - np.int64(key[k] >= 0)
        return offset

    @njit(**PART)
    def _plain_near_squares(x, y, z, mass, x_i, y_i, z_i, reach2, count, squares, masses):
        n = 0
        for k in range(count):
            dx, dy, dz = x_i - x[k], y_i - y[k], z_i - z[k]
            squares[n] = dx * dx + dy * dy + dz * dz
            masses[n] = mass[k]
            n += 1 - np.int64(squares[n] >= reach2)
        return n

    @njit(**PART)
    def _plain_near_indices(x, y, z, reach2, x_i, y_i, z_i, reach2_i, count, indices, _):
        n = 0
        for k in range(count):
            dx, dy, dz = x_i - x[k], y_i - y[k], z_i - z[k]
            indices[n] = k
            n += 1 - np.int64(dx * dx + dy * dy + dz * dz >= (reach2_i if reach2_i > reach2[k] else reach2[k]))
        return n

    @njit(**PART)
    def _plain_beyond_reach(lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, size, k, box, factor, target_reach):
        dx = larger_of(0.0, larger_of(lo_x[k] - box[1, 0], box[0, 0] - hi_x[k]))
        dy = larger_of(0.0, larger_of(lo_y[k] - box[1, 1], box[0, 1] - hi_y[k]))
        dz = larger_of(0.0, larger_of(lo_z[k] - box[1, 2], box[0, 2] - hi_z[k]))
        reach = larger_of(target_reach, factor * size[k])
        return np.int64(dx * dx + dy * dy + dz * dz >= reach * reach * SLACK)

    @njit(**PART)
    def _plain_in_reach(lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, size, first, last, box, factor, target_reach, out, n):
        for k in range(first, last):
            out[n] = k
            n += 1 - _plain_beyond_reach(lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, size, k, box, factor, target_reach)
        return n

    @njit(**PART)
    def _plain_out_of_reach(lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, size, first, last, box, factor, target_reach, out, n):
        for k in range(first, last):
            out[n] = k
            n += _plain_beyond_reach(lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, size, k, box, factor, target_reach)
        return n

    compressed_indices = _plain_compressed_indices
    near_squares, near_indices = _plain_near_squares, _plain_near_indices
    in_reach, out_of_reach = _plain_in_reach, _plain_out_of_reach
