"""The parts that every generated module of the numba engine shares; their text is copied into each one.

A generated module holds all of its code, so that its name, a hash of its text, says exactly what is compiled.
"""

import numpy as np
from llvmlite import ir
from llvmlite.binding import get_host_cpu_features
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

# Boxes are pruned only where they are certainly out of reach, whatever the rounding of pair distances in float32.
SLACK = 1.0 + 2e-5
# Functions that only others call need no entry from Python, which is long to compile.
PART = {"error_model": "numpy", "nogil": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
# Arrays are filled up to whole vectors of float32 on the widest machines, and hold one more vector for loose ends.
LANES = 16
COMPRESSES = bool(get_host_cpu_features().get("avx512f"))


@njit(forceinline=True)
def padded(count):
    """The next multiple of LANES."""
    return ((count + LANES - 1) // LANES) * LANES


def _selection(name):
    @intrinsic
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


@intrinsic
def take(typingctx, counter):
    """Add one to counter[0] atomically and return what it was: how threads share out leaves."""
    if counter != types.Array(types.int64, 1, "C"):
        return None

    def codegen(context, builder, signature, args):
        array = context.make_array(signature.args[0])(context, builder, args[0])
        return builder.atomic_rmw("add", array.data, ir.Constant(ir.IntType(64), 1), "monotonic")

    return types.int64(counter), codegen


@intrinsic
def widest_vectors(typingctx):
    """Let the calling function use the widest vectors that the processor has (compilers prefer narrower ones).

    The function is also kept from being copied into its callers, so that it is compiled once.
    """

    def codegen(context, builder, signature, args):
        builder.function.attributes.add("noinline")
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')  # llvmlite knows no attributes with values
        return context.get_dummy_value()

    return types.void(), codegen


@njit(forceinline=True)
def where(condition, a, b):
    """Either value, both of which are at hand."""
    return a if condition else b


@njit(forceinline=True)
def larger_of(a, b):
    """The larger of two numbers; b if either is NaN, so that an unknown b stays so."""
    return a if a > b else b


@njit(forceinline=True, error_model="numpy", fastmath={"contract", "nsz"})
def reciprocal_root(x):
    """1/sqrt(x) of a positive normal float64 to one unit in the last place; several times faster than to divide.

    The first guess halves the exponent (Lomont 2003; error 3.4e-2); each step raises its order by four.
    """
    y = np.int64(np.int64(0x5FE6EB50C7B537A9) - (np.float64(x).view(np.int64) >> 1)).view(np.float64)
    e = 1.0 - x * (y * y)
    y = y + y * (e * (0.5 + e * (0.375 + e * 0.3125)))
    e = 1.0 - x * (y * y)
    return y + y * (e * (0.5 + e * (0.375 + e * 0.3125)))


@intrinsic
def at(typingctx, array, index):
    """array[index] for an index that is known to lie within the array: loops over it become plain vector gathers."""

    def codegen(context, builder, signature, args):
        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        index = args[1] if args[1].type.width == 64 else builder.sext(args[1], ir.IntType(64))
        return builder.load(builder.gep(data, [index]))

    return array.dtype(array, index), codegen


def _compression(of_indices):
    @intrinsic
    def compression(typingctx, values, key, count, out, offset):
        lanes = 512 // key.dtype.bitwidth

        def codegen(context, builder, signature, args):
            def vector_at(k, position, lane_type):
                data = context.make_array(signature.args[k])(context, builder, args[k]).data
                return builder.bitcast(builder.gep(data, [position]), ir.VectorType(lane_type, lanes).as_pointer())

            key_type = context.get_value_type(signature.args[1].dtype)
            out_type = context.get_value_type(signature.args[3].dtype)
            width, index_type = signature.args[3].dtype.bitwidth, ir.IntType(64)
            vector, mask_type = ir.VectorType(out_type, lanes), ir.VectorType(ir.IntType(1), lanes)
            kind = f"v{lanes}{'i' if of_indices else 'f'}{width}"
            compress = cgutils.get_or_insert_function(
                builder.module,
                ir.FunctionType(vector, [vector, mask_type, vector]),
                f"llvm.experimental.vector.compress.{kind}",
            )
            bits = ir.IntType(lanes)
            ones = cgutils.get_or_insert_function(builder.module, ir.FunctionType(bits, [bits]), f"llvm.ctpop.i{lanes}")
            filled = cgutils.alloca_once_value(builder, args[4])
            begin, step = ir.Constant(index_type, 0), ir.Constant(index_type, lanes)
            with cgutils.for_range_slice(builder, begin, args[2], step, intp=index_type) as (k, _):
                keys = builder.load(vector_at(1, k, key_type), align=4)
                kept = builder.fcmp_unordered("<", keys, ir.Constant(keys.type, [0.0] * lanes))
                if of_indices:
                    first = builder.add(args[0], k)
                    first = first if width == 64 else builder.trunc(first, out_type)
                    nothing = ir.Constant(vector, ir.Undefined)
                    zeros = ir.Constant(ir.VectorType(ir.IntType(32), lanes), [0] * lanes)
                    lane = builder.insert_element(nothing, first, ir.Constant(ir.IntType(32), 0))
                    steps = ir.Constant(vector, [ir.Constant(out_type, lane) for lane in range(lanes)])
                    chosen = builder.add(builder.shuffle_vector(lane, nothing, zeros), steps)
                else:
                    chosen = builder.load(vector_at(0, k, out_type), align=4)
                chosen = builder.call(compress, [chosen, kept, ir.Constant(vector, ir.Undefined)])
                position = builder.load(filled)
                builder.store(chosen, vector_at(3, position, out_type), align=4)
                more = builder.zext(builder.call(ones, [builder.bitcast(kept, bits)]), index_type)
                builder.store(builder.add(position, more), filled)
            return builder.load(filled)

        return types.int64(values, key, types.int64, out, types.int64), codegen

    return compression


if COMPRESSES:
    compressed_values = _compression(False)
    compressed_indices = _compression(True)
else:

    @njit(**PART)
    def compressed_values(values, key, count, out, offset):
        for k in range(count):
            out[offset] = values[k]
            offset += 1 - np.int64(key[k] >= 0)
        return offset

    @njit(**PART)
    def compressed_indices(first, key, count, out, offset):
        for k in range(count):
            out[offset] = first + k
            offset += 1 - np.int64(key[k] >= 0)
        return offset


# compressed_values(values, key, count, out, offset): append to out[offset:] those of values[:count] whose key is not
# >= 0, and return how far `out` is filled. compressed_indices(first, ...): likewise for the indices first + k. Elements
# of `key` as wide as those of `out`; `count` a multiple of LANES; `out` with a further LANES of room at its end.


@njit(**PART)
def with_room(array, count, more):
    """An array that begins with array[:count] and has room for `more` and loose ends after it."""
    if count + more + 2 * LANES <= len(array):
        return array
    larger = np.empty(2 * (count + more) + 2 * LANES, array.dtype)
    larger[:count] = array[:count]
    return larger


@njit(forceinline=True)
def filled_up(key, count):
    """Mark the loose end of a key as out of reach; returns its padded length."""
    for k in range(count, padded(count)):
        key[k] = 1
    return padded(count)


@njit(**PART)
def node_excess(lo, hi, node, box, reach):
    """Squared distance of a node from a box, less a squared reach."""
    dx = maximum(maximum(lo[node, 0] - box[1, 0], box[0, 0] - hi[node, 0]), 0.0)
    dy = maximum(maximum(lo[node, 1] - box[1, 1], box[0, 1] - hi[node, 1]), 0.0)
    dz = maximum(maximum(lo[node, 2] - box[1, 2], box[0, 2] - hi[node, 2]), 0.0)
    return dx * dx + dy * dy + dz * dz - reach * reach * SLACK


@njit(**PART)
def reachable_leaves(lo, hi, node_reach, box, target_reach, leaf_rows):
    """Leaves within the larger of two reaches of a box, ascending: their number and leaf_rows (8, ...), maybe a larger one.

    Rows: low and high corners, reach, and the leaf's number.
    """
    leaves = len(node_reach) // 2
    stack = np.empty(128, np.int64)
    stack[0] = 1
    top = 1
    count = 0
    while top > 0:
        top -= 1
        node = stack[top]
        if node_excess(lo, hi, node, box, maximum(target_reach, node_reach[node])) > 0.0:
            continue
        if node < leaves:
            stack[top] = 2 * node + 1
            stack[top + 1] = 2 * node
            top += 2
            continue
        if count + 2 * LANES > leaf_rows.shape[1]:
            larger = np.empty((8, 2 * count + 2 * LANES))
            larger[:, :count] = leaf_rows[:, :count]
            leaf_rows = larger
        for a in range(3):
            leaf_rows[a, count] = lo[node, a]
            leaf_rows[3 + a, count] = hi[node, a]
        leaf_rows[6, count] = node_reach[node]
        leaf_rows[7, count] = node - leaves
        count += 1
    return count, leaf_rows


@njit(**PART)
def leaf_excess(leaf_rows, count, box, target_reach, key):
    """Squared distances of listed leaves from a box, less their squared reaches."""
    widest_vectors()
    x0, y0, z0, x1, y1, z1 = box[0, 0], box[0, 1], box[0, 2], box[1, 0], box[1, 1], box[1, 2]
    for k in range(count):
        dx = larger_of(leaf_rows[0, k] - x1, x0 - leaf_rows[3, k])
        dy = larger_of(leaf_rows[1, k] - y1, y0 - leaf_rows[4, k])
        dz = larger_of(leaf_rows[2, k] - z1, z0 - leaf_rows[5, k])
        dx, dy, dz = larger_of(0.0, dx), larger_of(0.0, dy), larger_of(0.0, dz)
        reach = larger_of(target_reach, leaf_rows[6, k])
        key[k] = dx * dx + dy * dy + dz * dz - reach * reach * SLACK


@njit(**PART)
def particle_excess(x, y, z, source_reach, first, last, box, target_reach, key):
    """Squared distances from a box, less their squared reaches, of the particles first to last - 1."""
    widest_vectors()
    x0, y0, z0, x1, y1, z1 = box[0, 0], box[0, 1], box[0, 2], box[1, 0], box[1, 1], box[1, 2]
    for j in range(first, last):
        dx = larger_of(0.0, larger_of(x0 - x[j], x[j] - x1))
        dy = larger_of(0.0, larger_of(y0 - y[j], y[j] - y1))
        dz = larger_of(0.0, larger_of(z0 - z[j], z[j] - z1))
        reach = larger_of(target_reach, source_reach[j])
        key[j - first] = dx * dx + dy * dy + dz * dz - reach * reach * SLACK


@njit(**PART)
def gather(x, y, z, source_reach, start, leaf_rows, leaf_count, box, target_reach, key, listed, found):
    """Indices of the particles of listed leaves that come within the larger of two reaches of a box, ascending.

    x, y, z, source_reach (N,); box (2, 3); key, listed and found are work space. Returns the number, `found`, which holds
    them, and the work space, each the array that was given or a larger one. NaN is never out of reach.
    """
    key = with_room(key, 0, leaf_count)
    listed = with_room(listed, 0, leaf_count)
    leaf_excess(leaf_rows, leaf_count, box, target_reach, key)
    near = compressed_indices(0, key, filled_up(key, leaf_count), listed, 0)
    count = k = 0
    while k < near:
        leaf = np.int64(leaf_rows[7, listed[k]])
        first, last = start[leaf], start[leaf + 1]
        k += 1
        while k < near and start[np.int64(leaf_rows[7, listed[k]])] == last:
            last = start[np.int64(leaf_rows[7, listed[k]]) + 1]
            k += 1
        found = with_room(found, count, last - first)
        key = with_room(key, 0, last - first)
        particle_excess(x, y, z, source_reach, first, last, box, target_reach, key)
        count = compressed_indices(first, key, filled_up(key, last - first), found, count)
    return count, key, listed, found


@njit(**PART)
def place_of(item, found):
    """Where an item stands in an ascending list that holds it."""
    low, high = 0, len(found) - 1
    while low < high:
        middle = (low + high) // 2
        if found[middle] < item:
            low = middle + 1
        else:
            high = middle
    return low


@njit(**PART)
def divide(x, y, z, source_reach, lo, hi, node_reach, first_of, last_of, level, box, target_reach, near, far, ranges):
    """Split all particles by whether they come within the larger of two reaches of a box.

    The walk ends at `level`, whose nodes hold particles first_of to last_of - 1. Returns the numbers and arrays of:
    `near`, the indices within reach; `far`, the indices out of reach in leaves that are not wholly so; `ranges` (K, 2),
    contiguous runs of particles whose node is wholly out of reach.
    """
    leaves = 1 << level
    stack = np.empty(128, np.int64)
    key = np.empty(256)
    stack[0] = 1
    top = 1
    near_count = far_count = range_count = 0
    while top > 0:
        top -= 1
        node = stack[top]
        first, last = first_of[node], last_of[node]
        if node_excess(lo, hi, node, box, maximum(target_reach, node_reach[node])) > 0.0:
            if range_count > 0 and ranges[range_count - 1, 1] == first:
                ranges[range_count - 1, 1] = last
                continue
            if range_count == len(ranges):
                more = np.empty((2 * range_count, 2), np.int64)
                more[:range_count] = ranges
                ranges = more
            ranges[range_count, 0] = first
            ranges[range_count, 1] = last
            range_count += 1
            continue
        if node < leaves:
            stack[top] = 2 * node + 1
            stack[top + 1] = 2 * node
            top += 2
            continue
        near = with_room(near, near_count, last - first)
        far = with_room(far, far_count, last - first)
        key = with_room(key, 0, last - first)
        particle_excess(x, y, z, source_reach, first, last, box, target_reach, key)
        for k in range(last - first):
            outside = np.int64(key[k] >= 0.0)
            near[near_count] = first + k
            far[far_count] = first + k
            near_count += 1 - outside
            far_count += outside
    return near_count, near, far_count, far, range_count, ranges
