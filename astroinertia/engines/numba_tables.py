"""Tables of sources for the numba engine: one line of memory a particle, and how columns of it are taken apart.

A line is read with a few wide loads. To gather its numbers one by one, as a loop over pairs would, costs several times
as much. The text of this file is copied into every generated module.
"""

from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from astroinertia.engines.numba_vectors import COMPACTED_BITS, INT64, LANES, PART, Lanes


# Copied into generated modules from here on.
@intrinsic
def _vector_fill(typingctx, array, position, value):
    def codegen(context, builder, signature, args):
        build = Lanes(context, builder, signature, args)
        kind = build.scalar_type(0)
        value = args[2]
        if isinstance(kind, ir.IntType):
            value = value if kind.width == value.type.width else builder.trunc(value, kind)
        builder.store(build.spread(value, LANES), build.pointer(0, args[1], LANES), align=4)
        return context.get_dummy_value()

    return types.void(array, types.int64, value), codegen


@intrinsic
def _vector_copy(typingctx, source, position, zero, row, place):
    def codegen(context, builder, signature, args):
        build = Lanes(context, builder, signature, args)
        values = builder.fsub(build.load(0, args[1], LANES), build.spread(args[2], LANES))
        target = build.pointer(3, args[4], LANES)
        values = values if values.type == target.type.pointee else builder.fptrunc(values, target.type.pointee)
        builder.store(values, target, align=4)
        return context.get_dummy_value()

    return types.void(source, types.int64, source.dtype, row, types.int64), codegen


@intrinsic
def _vector_take(typingctx, source, axis, indices, count, zero, row):
    def codegen(context, builder, signature, args):
        build, lanes = Lanes(context, builder, signature, args), 8
        array = context.make_array(signature.args[0])(context, builder, args[0])
        plain = signature.args[0].ndim == 1
        width = ir.Constant(INT64, 1) if plain else builder.extract_value(array.shape, 1)
        data = builder.gep(array.data, [args[1]])
        kind, double = build.scalar_type(5), ir.DoubleType()
        pointers = ir.VectorType(double.as_pointer(), lanes)
        whole, bits = ir.VectorType(double, lanes), ir.VectorType(ir.IntType(1), lanes)
        gather = cgutils.get_or_insert_function(
            builder.module,
            ir.FunctionType(whole, [pointers, ir.IntType(32), bits, whole]),
            "llvm.masked.gather.v8f64.v8p0f64",
        )
        less, everything = build.spread(args[4], lanes), ir.Constant(bits, [1] * lanes)

        def body(k, position, last=False):
            kept = build.up_to(args[3], k, everything) if last else everything
            places = build.load(2, k, lanes)
            places = builder.select(kept, places, ir.Constant(places.type, [0] * lanes)) if last else places
            places = places if places.type.element.width == 64 else builder.sext(places, ir.VectorType(INT64, lanes))
            begin = build.spread(builder.mul(width, ir.Constant(INT64, 8)), lanes)
            address = builder.add(build.spread(builder.ptrtoint(data, INT64), lanes), builder.mul(places, begin))
            address = builder.inttoptr(address, pointers)
            values = builder.call(
                gather, [address, ir.Constant(ir.IntType(32), 8), kept, ir.Constant(whole, [0.0] * lanes)]
            )
            values = builder.fsub(values, less)
            if isinstance(kind, ir.FloatType):
                values = builder.fptrunc(values, ir.VectorType(kind, lanes))
            builder.store(values, build.pointer(5, k, lanes), align=4)
            return kept

        build.loop(ir.Constant(INT64, 0), args[3], lanes, ir.Constant(INT64, 0), body)
        return context.get_dummy_value()

    return types.void(source, types.int64, indices, types.int64, types.float64, row), codegen


def _shuffled(builder, a, b, lanes):
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(ir.IntType(32), len(lanes)), lanes))


def _joined(builder, parts):
    # One vector of several, by halves, which are single instructions.
    while len(parts) > 1:
        width = 2 * parts[0].type.count
        parts = [_shuffled(builder, a, b, list(range(width))) for a, b in zip(parts[::2], parts[1::2], strict=True)]
    return parts[0]


def _transposed(builder, load, packet, lanes):
    """Rows of `lanes` elements from packets of two or four, load(source) -> packet.

    Each vector joins every `packet`-th source, so that what is left to do stays within blocks of 128 bits.
    """
    blocks = range(lanes // packet)
    mixed = [_joined(builder, [load(packet * block + k) for block in blocks]) for k in range(packet)]

    def woven(a, b, take, size):
        # From each block of 128 bits of a and of b, `size` elements each, in turn.
        order = []
        for block in blocks:
            for k in take:
                order += [packet * block + size * k + n for n in range(size)]
                order += [packet * block + size * k + n + lanes for n in range(size)]
        return _shuffled(builder, a, b, order)

    if packet == 2:
        return [woven(mixed[0], mixed[1], (k,), 1) for k in range(2)]
    pairs = [woven(mixed[k], mixed[k + 1], take, 1) for k in (0, 2) for take in ((0, 1), (2, 3))]
    return [woven(pairs[half], pairs[2 + half], (k,), 2) for half in range(2) for k in range(2)]


def _row_spreader(rows, begin):
    @intrinsic
    def spread(typingctx, table, index, count, out):
        def codegen(context, builder, signature, args):
            dtype = signature.args[0].dtype
            kind, lanes, packet = context.get_value_type(dtype), 512 // dtype.bitwidth, 128 // dtype.bitwidth
            source, where, target = (
                context.make_array(signature.args[k])(context, builder, args[k]) for k in (0, 1, 3)
            )
            width = builder.extract_value(source.shape, 1)
            columns = builder.extract_value(target.shape, 1)
            small, whole = ir.VectorType(kind, packet), ir.VectorType(kind, lanes)
            with cgutils.for_range_slice(
                builder, ir.Constant(INT64, 0), args[2], ir.Constant(INT64, lanes), intp=INT64
            ) as (first, _):
                begins = []
                for lane in range(lanes):
                    place = builder.load(builder.gep(where.data, [builder.add(first, ir.Constant(INT64, lane))]))
                    place = place if place.type.width == 64 else builder.sext(place, INT64)
                    begins.append(builder.gep(source.data, [builder.mul(place, width)]))
                for row in range(0, rows, packet):

                    def load(lane, row=row):
                        pointer = builder.gep(begins[lane], [ir.Constant(INT64, begin + row)])
                        return builder.load(builder.bitcast(pointer, small.as_pointer()), align=4)

                    for k, values in enumerate(_transposed(builder, load, packet, lanes)):
                        position = builder.add(builder.mul(columns, ir.Constant(INT64, row + k)), first)
                        pointer = builder.bitcast(builder.gep(target.data, [position]), whole.as_pointer())
                        builder.store(values, pointer, align=4)
            return context.get_dummy_value()

        return types.void(table, index, types.int64, out), codegen

    return spread


def _row_copier(width):
    @intrinsic
    def copied(typingctx, table, index, count, zero, out):
        def codegen(context, builder, signature, args):
            source, where, base, target = (
                context.make_array(signature.args[k])(context, builder, args[k]) for k in (0, 1, 3, 4)
            )
            kind = context.get_value_type(signature.args[4].dtype)
            sizes = [8] * (width // 8) + [4] * (width % 8 // 4)
            begins = [sum(sizes[:k]) for k in range(len(sizes))]

            def vector(data, begin, size):
                pointer = builder.gep(data, [ir.Constant(INT64, begin)])
                return builder.load(
                    builder.bitcast(pointer, ir.VectorType(ir.DoubleType(), size).as_pointer()), align=4
                )

            zeros = [vector(base.data, begin, size) for begin, size in zip(begins, sizes, strict=True)]
            with cgutils.for_range_slice(
                builder, ir.Constant(INT64, 0), args[2], ir.Constant(INT64, 1), intp=INT64
            ) as (k, _):
                place = builder.load(builder.gep(where.data, [k]))
                place = place if place.type.width == 64 else builder.sext(place, INT64)
                row = builder.gep(source.data, [builder.mul(place, ir.Constant(INT64, width))])
                out = builder.gep(target.data, [builder.mul(k, ir.Constant(INT64, width))])
                for begin, size, less in zip(begins, sizes, zeros, strict=True):
                    values = builder.fsub(vector(row, begin, size), less)
                    if isinstance(kind, ir.FloatType):
                        values = builder.fptrunc(values, ir.VectorType(kind, size))
                    pointer = builder.gep(out, [ir.Constant(INT64, begin)])
                    builder.store(values, builder.bitcast(pointer, values.type.as_pointer()), align=4)
            return context.get_dummy_value()

        return types.void(table, index, types.int64, zero, out), codegen

    return copied


# The functions that are made below:
# row_spreader(rows, begin)(table, index, count, out): out[r, k] = table[index[k], begin + r] for so many rows r; count
# is a multiple of LANES. row_copier(width)(table, index, count, zero, out): out[k] = table[index[k]] - zero, of this
# width. vector_take(source, axis, indices, count, zero, row): row[k] = source[indices[k], axis] - zero; axis 0 of plain
# arrays. vector_fill(array, position, value): LANES elements. vector_copy(source, position, zero, row, place): LANES
# elements of source from a position on, less zero, to those of row; compilers would first ask whether arrays overlap.
if COMPACTED_BITS:
    row_spreader = _row_spreader
    row_copier = _row_copier
    vector_fill = _vector_fill
    vector_copy = _vector_copy
    vector_take = _vector_take
else:

    def _named(function, *constants):
        # Compiled code goes by this name and a number that processes count for themselves: without its constants, a
        # function that one process kept could stand in for that of another.
        function.__qualname__ = "_".join(map(str, (function.__name__, *constants)))
        return njit(**PART)(function)

    def _plain_row_spreader(rows, begin):
        def spread(table, index, count, out):
            for k in range(count):
                for row in range(rows):
                    out[row, k] = table[index[k], begin + row]

        return _named(spread, rows, begin)

    def _plain_row_copier(width):
        def copied(table, index, count, zero, out):
            for k in range(count):
                for row in range(width):
                    out[k, row] = table[index[k], row] - zero[row]

        return _named(copied, width)

    @njit(**PART)
    def _plain_vector_fill(array, position, value):
        for k in range(LANES):
            array[position + k] = value

    @njit(**PART)
    def _plain_vector_copy(source, position, zero, row, place):
        for k in range(LANES):
            row[place + k] = source[position + k] - zero

    @njit(**PART)
    def _plain_vector_take(source, axis, indices, count, zero, row):
        values = source.reshape(-1)
        width = len(values) // len(source)
        for k in range(count):
            row[k] = values[width * indices[k] + axis] - zero

    row_spreader, row_copier = _plain_row_spreader, _plain_row_copier
    vector_fill, vector_copy, vector_take = _plain_vector_fill, _plain_vector_copy, _plain_vector_take
