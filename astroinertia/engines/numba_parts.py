"""The walk of the tree and the buffers of sources, which every generated module of the numba engine shares.

The text of this file is copied into a generated module that the others take it from: their names, hashes of their
texts, say exactly what is compiled. Functions that are called for every particle take and return no arrays of their own
making, for every new reference to an array is an atomic count.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_tables import vector_fill, vector_take
from astroinertia.engines.numba_vectors import (
    INNER,
    LANES,
    PART,
    SLACK,
    at,
    in_reach,
    larger_of,
    once,
    out_of_reach,
    padded,
    where,
    widest_vectors,
)

# Copied into generated modules from here on.
MOST_AT_ONCE = 256  # nodes whose boxes are looked at without a look at their parents
LINE = 64  # bytes of a line of the cache
MANY = 128  # nodes near a box that are looked at once more, from each particle in it
# In units of the extent of a box and of what it reaches, float32 changes a squared distance by less than SLACK - 1 of
# itself plus so much.
ROUNDING = 1e-8
GROUP = 2  # neighbouring leaves that share a list of sources
PACKED = 1024  # particles that a thread packs at a time
LOOP_FLAGS = {"reassoc", "contract", "nsz", "arcp", "afn"}  # never nnan or ninf: NaN must survive
BELOW = 32  # nodes that are looked at together where their common ancestor is in reach


@njit(**PART)
def extent(box, reach):
    """Of a box and what is around it."""
    square = 0.0
    for a in range(3):
        square += (box[1, a] - box[0, a]) * (box[1, a] - box[0, a])
    return np.sqrt(square) + reach


@njit(**PART)
def load_balls(position, h, support, targets, first, last, centre, unit, balls):
    """Rows: the places of targets[first:last] and the squares of their reaches."""
    for t in range(first, last):
        i = targets[t]
        for a in range(3):
            balls[a, t - first] = unit * (position[i, a] - centre[a])
        balls[3, t - first] = (unit * support * h[i]) * (unit * support * h[i])


@njit(**PART)
def touched(nodes, factor, box, balls, ball_count, centre, unit, listed, count):
    """Keep those nodes listed[:count] whose particles may reach a box, or that a ball in it reaches, and say how many.

    balls (4, ball_count or more): their places from `centre`, times `unit`, and squares of their radii, times its.
    """
    once()
    x, y, z, radius2 = balls[0], balls[1], balls[2], balls[3]
    kept = 0
    for k in range(count):
        node = listed[k]
        square = 0.0
        for a in range(3):
            apart = larger_of(0.0, larger_of(nodes[a, node] - box[1, a], box[0, a] - nodes[3 + a, node]))
            square += apart * apart
        reach = factor * nodes[6, node]
        number = 1.0
        if square >= reach * reach * SLACK:
            number = touches(
                unit * (nodes[0, node] - centre[0]), unit * (nodes[1, node] - centre[1]),
                unit * (nodes[2, node] - centre[2]), unit * (nodes[3, node] - centre[0]),
                unit * (nodes[4, node] - centre[1]), unit * (nodes[5, node] - centre[2]),
                x, y, z, radius2, ball_count,
            )  # fmt: skip
        listed[kept] = node
        kept += np.int64(number > 0)
    return kept


@njit(fastmath={"contract", "reassoc"}, **PART)
def touches(lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, x, y, z, radius2, count):
    """The number of balls that reach a box."""
    widest_vectors()
    kind = x.dtype.type
    zero, one, slack, rounding = kind(0), kind(1), kind(SLACK), kind(ROUNDING)
    lo_x, lo_y, lo_z, hi_x, hi_y, hi_z = kind(lo_x), kind(lo_y), kind(lo_z), kind(hi_x), kind(hi_y), kind(hi_z)
    number = zero
    for t in range(count):
        dx = larger_of(zero, larger_of(lo_x - x[t], x[t] - hi_x))
        dy = larger_of(zero, larger_of(lo_y - y[t], y[t] - hi_y))
        dz = larger_of(zero, larger_of(lo_z - z[t], z[t] - hi_z))
        square = dx * dx + (dy * dy + (dz * dz - rounding))
        number += where(square >= radius2[t] * slack, zero, one)
    return number


@njit(**PART)
def near_nodes(nodes, count, box, factor, target_reach, balls, ball_count, centre, unit, parents, listed):
    """The nodes of one level, count to 2 count - 1, that come within the larger of two reaches of a box, ascending.

    nodes (7, 2L or more): corners and largest h. balls, ball_count, centre, unit: what `touched` then asks of them, if
    there are any balls and more nodes than MANY. Returns how many come near; parents and listed have room for them all.
    """
    once()
    lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, h = nodes[0], nodes[1], nodes[2], nodes[3], nodes[4], nodes[5], nodes[6]
    level = count
    while level > MOST_AT_ONCE:
        level = max(1, level // BELOW)
    n = in_reach(lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, h, level, 2 * level, box, factor, target_reach, listed, 0)
    while True:
        if ball_count > 0 and n > MANY:
            n = touched(nodes, factor, box, balls, ball_count, centre, unit, listed, n)
        if level == count:
            return n
        step = min(BELOW, count // level)
        level *= step
        for k in range(n):
            parents[k] = listed[k]
        filled = 0
        for k in range(n):
            first, last = parents[k] * step, (parents[k] + 1) * step
            filled = in_reach(
                lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, h, first, last, box, factor, target_reach, listed, filled
            )
        n = filled


@njit(**PART)
def gather(
    x, y, z, h, factor, nodes, start, box, target_reach, balls, ball_count, centre, unit, parents, listed, indices
):
    """Indices of the particles that come within the larger of two reaches of a box, ascending.

    Reaches are target_reach and factor h. x, y, z, h (N or more,); start (L+1,) of the leaves; box (2, 3); balls: see
    `near_nodes`, what only they leave out may be left out; parents and listed have room for all leaves. Returns the
    number and the array that holds them: `indices`, or a larger one.
    """
    once()
    leaves = len(start) - 1
    near = near_nodes(nodes, leaves, box, factor, target_reach, balls, ball_count, centre, unit, parents, listed)
    total = 0
    for k in range(near):
        total += start[listed[k] - leaves + 1] - start[listed[k] - leaves]
    indices = with_room(indices, total)
    count = k = 0
    while k < near:
        first, last = start[listed[k] - leaves], start[listed[k] - leaves + 1]
        k += 1
        while k < near and start[listed[k] - leaves] == last:
            last = start[listed[k] - leaves + 1]
            k += 1
        count = in_reach(x, y, z, x, y, z, h, first, last, box, factor, target_reach, indices, count)
    return count, indices


@njit(**PART)
def divide(
    x, y, z, h, factor, nodes, first_of, last_of, targets, box, target_reach, parents, listed, near, far, ranges
):
    """Split all particles by whether they come within the larger of two reaches of a box.

    Nodes targets to 2 targets - 1 hold the particles first_of to last_of - 1. Returns the numbers of `near` (indices
    within reach), `far` (indices out of reach in nodes that are within) and `ranges` (K, 2) (runs of particles whose
    nodes are out of reach), and the arrays near and far, maybe larger ones.
    """
    once()
    n = near_nodes(nodes, targets, box, factor, target_reach, nodes, 0, nodes[0], 0.0, parents, listed)
    total = 0
    for k in range(n):
        total += last_of[listed[k]] - first_of[listed[k]]
    near, far = with_room(near, total), with_room(far, total)
    near_count = far_count = range_count = covered = k = 0
    while k <= n:
        first = first_of[listed[k]] if k < n else last_of[2 * targets - 1]
        if first > covered:
            ranges[range_count, 0], ranges[range_count, 1] = covered, first
            range_count += 1
        if k == n:
            break
        last = last_of[listed[k]]
        k += 1
        while k < n and first_of[listed[k]] == last:
            last = last_of[listed[k]]
            k += 1
        near_count = in_reach(x, y, z, x, y, z, h, first, last, box, factor, target_reach, near, near_count)
        far_count = out_of_reach(x, y, z, x, y, z, h, first, last, box, factor, target_reach, far, far_count)
        covered = last
    return near_count, far_count, range_count, near, far


@njit(**PART)
def with_room(array, count):
    """An array with room for `count` elements and loose ends; what it holds may be lost."""
    once()
    return array if count + 2 * LANES <= len(array) else np.empty(2 * count + 2 * LANES, array.dtype)


@njit(forceinline=True, **INNER)
def columns_for(count):
    """More than `count` columns with loose ends, such that rows do not all fall on the same lines of a cache."""
    return padded(2 * count + 5 * LANES) | LANES


@njit(**PART)
def whole_lines(rows, columns, like):
    """An array (rows, columns) of the type of another that begins on a line of the cache: no vector straddles two."""
    once()
    flat = np.empty(rows * columns + LINE, like.dtype)
    first = (LINE - np.int64(flat.ctypes.data) % LINE) % LINE // flat.itemsize
    return flat[first : first + rows * columns].reshape(rows, columns)


@njit(**PART)
def with_columns(array, count):
    """An array with room for `count` columns and loose ends; what it holds may be lost."""
    once()
    if count + 5 * LANES <= array.shape[1]:
        return array
    return whole_lines(array.shape[0], columns_for(count), array)


@njit(**PART)
def node_box(nodes, node, box, centre):
    """Set a box (2, 3) to that of a node, and its centre (3,)."""
    for a in range(3):
        box[0, a], box[1, a] = nodes[a, node], nodes[3 + a, node]
        middle = 0.5 * (box[0, a] + box[1, a])
        centre[a] = 0.0 if np.isnan(middle) else middle


@njit(**PART)
def target_box(position, h, targets, first, last, box):
    """Set a box (2, 3) to that of targets[first:last] and return their largest h; NaN makes NaN."""
    once()
    for a in range(3):
        box[0, a], box[1, a] = np.inf, -np.inf
    largest = unknown = 0.0
    for t in range(first, last):
        i = targets[t]
        for a in range(3):
            box[0, a], box[1, a] = min(box[0, a], position[i, a]), max(box[1, a], position[i, a])
        largest = max(largest, h[i])
        total = position[i, 0] + position[i, 1] + position[i, 2] + h[i]
        unknown += 0.0 if total == total else np.nan
    for a in range(3):
        box[0, a] += unknown
        box[1, a] += unknown
    return largest + unknown


@njit(**PART)
def box_centre(box, centre):
    """The middle (3,) of a box (2, 3); 0 where that is not known."""
    for a in range(3):
        middle = 0.5 * (box[0, a] + box[1, a])
        centre[a] = 0.0 if np.isnan(middle) else middle


@njit(**PART)
def places(items, first, last, indices, count, out):
    """Where items[first:last] stand among indices[:count]; both ascend."""
    once()
    place = place_of(items[first], indices, count)
    for t in range(first, last):
        while indices[place] < items[t]:
            place += 1
        out[t - first] = place


@njit(**PART)
def close_to(box, factor, largest, position, h, items, count):
    """Keep those of items[:count] within factor max(largest, h) of a box, in their order, and return their number."""
    once()
    kept = 0
    for k in range(count):
        i = items[k]
        square = 0.0
        for a in range(3):
            apart = larger_of(0.0, larger_of(box[0, a] - position[i, a], position[i, a] - box[1, a]))
            square += apart * apart
        reach = factor * larger_of(largest, h[i])
        items[kept] = i
        kept += 1 - np.int64(square >= reach * reach * SLACK)
    return kept


# Rows of a buffer of sources, converted to its precision. A copy of the last source stands at the loose end; the caller
# gives it no mass, so that it adds nothing, and is as finite as the source itself.


@njit(forceinline=True, **INNER)
def fill_row(row, count):
    """Copy the last source to the loose end."""
    vector_fill(row, count, row[count - 1])
    vector_fill(row, count + LANES, row[count - 1])


@njit(**PART)
def load_row(source, indices, count, zero, row):
    """source[indices] - zero."""
    vector_take(source, 0, indices, count, zero, row)
    fill_row(row, count)


@njit(**PART)
def load_component(source, axis, indices, count, zero, row):
    """source[indices, axis] - zero."""
    vector_take(source, axis, indices, count, zero, row)
    fill_row(row, count)


@njit(**PART)
def load_inverse(source, indices, count, row):
    """1/source[indices]."""
    widest_vectors()
    for k in range(count):
        row[k] = 1.0 / at(source, indices[k])
    fill_row(row, count)


@njit(**PART)
def load_square(source, indices, count, factor, row):
    """(factor source[indices])^2."""
    widest_vectors()
    for k in range(count):
        value = factor * at(source, indices[k])
        row[k] = value * value
    fill_row(row, count)


@njit(**PART)
def place_of(item, indices, count):
    """Where an item stands in an ascending list of `count` that holds it."""
    low, high = 0, count - 1
    while low < high:
        middle = (low + high) // 2
        if indices[middle] < item:
            low = middle + 1
        else:
            high = middle
    return low
