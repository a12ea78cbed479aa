"""The parts that every generated module of the numba engine shares; their text is copied into each one.

A generated module holds all of its code, so that its name, a hash of its text, says exactly what is compiled.
"""

import numpy as np
from llvmlite import ir
from numba import njit, prange, types  # noqa: F401
from numba.core import cgutils
from numba.extending import intrinsic

# Boxes are pruned only where they are certainly out of reach, whatever the rounding of pair distances in float32.
SLACK = 1.0 + 2e-5


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


@njit(forceinline=True)
def where(condition, a, b):
    """Either value, both of which are at hand."""
    return a if condition else b


@njit(forceinline=True, error_model="numpy")
def outside(x, low, high):
    """How far x lies outside an interval, 0 inside it; NaN stays NaN."""
    return maximum(maximum(low - x, x - high), 0.0)


@njit(error_model="numpy", nogil=True)
def gather(position, source_reach, lo, hi, node_reach, start, box, target_reach, found):
    """Indices of the particles that come within the larger of two reaches of a box, ascending.

    position (N, 3), source_reach (N,); lo, hi (2L, 3) and node_reach (2L,) of the tree's nodes; box (2, 3).
    Returns their number and the array that holds them: `found`, or a larger one. NaN is never out of reach.
    """
    leaves = len(start) - 1
    stack = np.empty(128, np.int64)
    stack[0] = 1
    top = 1
    count = 0
    x0, y0, z0, x1, y1, z1 = box[0, 0], box[0, 1], box[0, 2], box[1, 0], box[1, 1], box[1, 2]
    while top > 0:
        top -= 1
        node = stack[top]
        reach = maximum(target_reach, node_reach[node])
        dx = maximum(maximum(lo[node, 0] - x1, x0 - hi[node, 0]), 0.0)
        dy = maximum(maximum(lo[node, 1] - y1, y0 - hi[node, 1]), 0.0)
        dz = maximum(maximum(lo[node, 2] - z1, z0 - hi[node, 2]), 0.0)
        if dx * dx + dy * dy + dz * dz > reach * reach * SLACK:
            continue
        if node < leaves:
            stack[top] = 2 * node + 1
            stack[top + 1] = 2 * node
            top += 2
            continue
        first, last = start[node - leaves], start[node - leaves + 1]
        if count + last - first > len(found):
            larger = np.empty(2 * (count + last - first), np.int64)
            larger[:count] = found[:count]
            found = larger
        for j in range(first, last):
            reach = maximum(target_reach, source_reach[j])
            dx = outside(position[j, 0], x0, x1)
            dy = outside(position[j, 1], y0, y1)
            dz = outside(position[j, 2], z0, z1)
            found[count] = j
            count += 1 - np.int64(dx * dx + dy * dy + dz * dz > reach * reach * SLACK)
    return count, found


@njit(error_model="numpy", nogil=True)
def divide(position, source_reach, lo, hi, node_reach, first_of, last_of, level, box, target_reach, near, far, ranges):
    """Split all particles by whether they come within the larger of two reaches of a box.

    The walk ends at `level`, whose nodes hold particles first_of to last_of - 1. Returns the numbers and arrays of:
    `near`, the indices within reach; `far`, the indices out of reach in leaves that are not wholly so; `ranges` (K, 2),
    contiguous runs of particles whose node is wholly out of reach.
    """
    leaves = 1 << level
    stack = np.empty(128, np.int64)
    stack[0] = 1
    top = 1
    near_count = far_count = range_count = 0
    x0, y0, z0, x1, y1, z1 = box[0, 0], box[0, 1], box[0, 2], box[1, 0], box[1, 1], box[1, 2]
    while top > 0:
        top -= 1
        node = stack[top]
        first, last = first_of[node], last_of[node]
        reach = maximum(target_reach, node_reach[node])
        dx = maximum(maximum(lo[node, 0] - x1, x0 - hi[node, 0]), 0.0)
        dy = maximum(maximum(lo[node, 1] - y1, y0 - hi[node, 1]), 0.0)
        dz = maximum(maximum(lo[node, 2] - z1, z0 - hi[node, 2]), 0.0)
        if dx * dx + dy * dy + dz * dz > reach * reach * SLACK:
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
        if near_count + last - first > len(near):
            larger = np.empty(2 * (near_count + last - first), np.int64)
            larger[:near_count] = near[:near_count]
            near = larger
        if far_count + last - first > len(far):
            larger = np.empty(2 * (far_count + last - first), np.int64)
            larger[:far_count] = far[:far_count]
            far = larger
        for j in range(first, last):
            reach = maximum(target_reach, source_reach[j])
            dx = outside(position[j, 0], x0, x1)
            dy = outside(position[j, 1], y0, y1)
            dz = outside(position[j, 2], z0, z1)
            beyond = np.int64(dx * dx + dy * dy + dz * dz > reach * reach * SLACK)
            near[near_count] = j
            far[far_count] = j
            near_count += 1 - beyond
            far_count += beyond
    return near_count, near, far_count, far, range_count, ranges
