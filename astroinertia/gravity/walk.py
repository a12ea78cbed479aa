"""The fast gravity's way down, a template: targets with their lists of sources, after nodes are refitted upwards.

A pair of nodes is split, taken by expansions or taken particle by particle by rules that are the same from both sides,
and either side's sums are written by itself: no sum is shared, so results have the same bits for any number of threads,
and forces are opposite to rounding. Each target looks through its candidates a vector at a time and passes on to its
children those that are no larger than itself. By itself it takes float64 and expansions of order 5.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_float64 import inverse_distance, real
from astroinertia.engines.numba_parts import LOOP_FLAGS, with_columns
from astroinertia.engines.numba_tables import row_spreader, vector_copy
from astroinertia.engines.numba_vectors import (
    ENTRY,
    LANES,
    PART,
    larger_of,
    once,
    padded,
    take,
    where,
    widest_vectors,
)
from astroinertia.engines.templates import executed
from astroinertia.gravity.compaction import compacted
from astroinertia.gravity.expansions import expansions, padded_moments

TEST_FLAGS = {"contract", "nsz", "arcp", "afn"}
roots_of_pairs, OF_FORCE, OF_POTENTIAL = once, real(1), real(1)
ALIKE, MOMENTS, EXPANSIONS = real(3.0), padded_moments(5), executed(expansions(5))
times_power, far_field = EXPANSIONS.times_power, EXPANSIONS.far_field
shift_local, field_of_local = EXPANSIONS.shift_local, EXPANSIONS.field_of_local

# Copied into generated modules from here on.
spread_places = row_spreader(4, 0)
spread_about = row_spreader(8, 0)
spread_moments = row_spreader(MOMENTS, 0)


@njit(**PART)
def gathered(listed, count, where_is, about, centre, places, apart, features):
    """The nodes listed, as columns, in whole vectors: places (4, n), those about a centre, apart (3, n), and features.

    Loops over these hold no float64 besides, which would halve the width of their vectors.
    """
    spread_places(where_is, listed, padded(count), places)
    spread_about(about, listed, padded(count), features)
    for k in range(0, count, LANES):
        for a in range(3):
            vector_copy(places[a], k, centre[a], apart[a], k)


@njit(fastmath=TEST_FLAGS, **PART)
def sort_candidates(node, listed, count, apart, features, about, bucket, theta, tolerance, far, part, hand, near):
    """Keys below 0: taken by expansions; split; deferred to the target's children; taken particle by particle.

    apart, features: of the candidates listed, as `gathered`. Whole vectors, all of them rounded alike.
    """
    widest_vectors()
    r_a, s_a, m_a, g_a, clamp_a, sheet_a = (
        about[node, 0], about[node, 1], about[node, 2], about[node, 3], about[node, 4], about[node, 7]
    )  # fmt: skip
    number_a = np.int32(node)
    single_a, bucket_a = about[node, 6] < real(0), abs(about[node, 6]) <= bucket
    all_x, all_y, all_z = apart[0], apart[1], apart[2]
    radius, spread, mass, need = features[0], features[1], features[2], features[3]
    clamp, number, sheet = features[4], features[6], features[7]
    for k in range(padded(count)):
        x, y, z = all_x[k], all_y[k], all_z[k]
        r_b, s_b, m_b, g_b, clamp_b, sheet_b = radius[k], spread[k], mass[k], need[k], clamp[k], sheet[k]
        r2 = x * x + y * y + z * z
        inverse = inverse_distance(r2)
        r = r2 * inverse
        both = r_a + r_b
        on_a, on_b = (r_a + s_b) * inverse, (r_b + s_a) * inverse
        error = larger_of(times_power(m_b * g_a, on_a), times_power(m_a * g_b, on_b)) * (inverse * inverse)
        # All sources in one direction err alike for a target: those like this one, at most all the mass there is.
        on_a, on_b, all_mass = r_a * inverse, r_b * inverse, inverse * inverse
        pull_a, pull_b = where(sheet_b < all_mass, sheet_b, all_mass), where(sheet_a < all_mass, sheet_a, all_mass)
        alike = larger_of(times_power(pull_a * g_a, on_a), times_power(pull_b * g_b, on_b))
        gap = r - both
        precise = (error <= tolerance) & (alike <= ALIKE * tolerance)
        accepted = precise & (both < theta * r) & (gap * gap > clamp_a + clamp_b)
        single_b, bucket_b = number[k] < real(0), abs(number[k]) <= bucket
        larger_b = (r_b > r_a) | ((r_b == r_a) & (listed[k] < number_a))
        by_pairs = (not accepted) & bucket_a & bucket_b
        split = (not accepted) & (not by_pairs) & (not single_b) & (single_a | larger_b)
        far[k] = where(accepted, real(-1), real(1))
        part[k] = where(split, real(-1), real(1))
        near[k] = where(by_pairs, real(-1), real(1))
        hand[k] = where(accepted | split | by_pairs, real(1), real(-1))


@njit(fastmath=LOOP_FLAGS, **PART)
def point_sums(targets, target_count, count, sources, field):
    """As gravity.clamped_points.point_pair; estimates of 1/r are up to 3.7e-4 off, and right on average."""
    widest_vectors()
    roots_of_pairs()
    all_x, all_y, all_z, mass, clamp = sources[0], sources[1], sources[2], sources[3], sources[4]
    for i in range(target_count):
        x_i, y_i, z_i, clamp_i = targets[0, i], targets[1, i], targets[2, i], targets[4, i]
        sum_x = sum_y = sum_z = sum_phi = real(0)
        for j in range(padded(count)):
            x, y, z = all_x[j] - x_i, all_y[j] - y_i, all_z[j] - z_i
            inverse = inverse_distance(larger_of(x * x + y * y + z * z, clamp_i + clamp[j]))
            potential = mass[j] * inverse
            force = potential * (inverse * inverse)
            sum_phi += potential
            sum_x += force * x
            sum_y += force * y
            sum_z += force * z
        field[0, i] += sum_x * OF_FORCE
        field[1, i] += sum_y * OF_FORCE
        field[2, i] += sum_z * OF_FORCE
        field[3, i] -= sum_phi * OF_POTENTIAL


@njit(**PART)
def copied(listed, runs, first, last, x_c, y_c, z_c, x, y, z, m, clamp, buffer):
    """The particles of the nodes listed; whole vectors: what is too much is overwritten by what comes next."""
    widest_vectors()
    row_x, row_y, row_z, row_m, row_c = buffer[0], buffer[1], buffer[2], buffer[3], buffer[4]
    count = 0
    for n in range(runs):
        begin = first[listed[n]]
        size = last[listed[n]] - begin
        for k in range(0, size, LANES):
            vector_copy(x, begin + k, x_c, row_x, count + k)
            vector_copy(y, begin + k, y_c, row_y, count + k)
            vector_copy(z, begin + k, z_c, row_z, count + k)
            vector_copy(m, begin + k, real(0), row_m, count + k)
            vector_copy(clamp, begin + k, real(0), row_c, count + k)
        count += size
    for k in range(count, padded(count)):  # massless sources fill up the last vector
        row_x[k] = row_y[k] = row_z[k] = row_c[k] = real(1)
        row_m[k] = real(0)
    return count


@njit(**PART)
def leaf_sums(node, near, near_count, local, first, last, where_is, about, x, y, z, m, clamp, order, targets, sources,
              field, acceleration, potential, force_unit, potential_unit):  # fmt: skip
    """To a leaf's particles: the field of expansions and the sums over the particles of the nodes `near`."""
    x_c, y_c, z_c = where_is[node, 0], where_is[node, 1], where_is[node, 2]
    begin, end = first[node], last[node]
    count = end - begin
    for k in range(count):
        targets[0, k], targets[1, k], targets[2, k] = (
            real(x[begin + k] - x_c), real(y[begin + k] - y_c), real(z[begin + k] - z_c)
        )  # fmt: skip
        targets[4, k] = clamp[begin + k]
    field_of_local(count, np.float64(about[node, 5]), local, targets[0], targets[1], targets[2], field)
    total = 0
    for k in range(near_count):
        total += last[near[k]] - first[near[k]]
    sources = with_columns(sources, total)
    total = copied(near, near_count, first, last, x_c, y_c, z_c, x, y, z, m, clamp, sources)
    point_sums(targets, count, total, sources, field)
    for k in range(count):
        i = order[begin + k]
        for a in range(3):
            acceleration[i, a] += np.float64(field[a, k]) * force_unit
        potential[i] += np.float64(field[3, k]) * potential_unit
    return sources


@njit(**PART)
def set_to(values, row):
    """By number: numba takes seconds to compile the same of slices and rows."""
    for k in range(len(row)):
        row[k] = values[k]


@njit(**PART)
def roomier(array, filled, count):
    """An array with room for `count` more elements after what is kept."""
    if filled + count + 2 * LANES <= len(array):
        return array
    larger = np.empty(2 * (filled + count) + 2 * LANES, array.dtype)
    for k in range(filled):
        larger[k] = array[k]
    return larger


@njit(**PART)
def seek(node, handed, filled, where_is, about, child, bucket, theta, tolerance, lists, keys, places, apart, features):
    """Sorts all candidates of a node: the numbers of those far, near, and deferred."""
    now, later, far, near, hand = lists[0], lists[1], lists[2], lists[3], lists[4]
    count, fars, nears, hands = filled, 0, 0, 0
    for k in range(filled):
        now[k] = handed[k]
    while count > 0:
        for k in range(count, padded(count)):
            now[k] = now[0]
        gathered(now, count, where_is, about, where_is[node], places, apart, features)
        sort_candidates(
            node, now, count, apart, features, about, bucket, theta, tolerance, keys[0], keys[1], keys[2], keys[3]
        )
        fars = compacted(now, keys[0], count, far, fars)
        hands = compacted(now, keys[2], count, hand, hands)
        nears = compacted(now, keys[3], count, near, nears)
        split = compacted(now, keys[1], count, later, 0)
        for k in range(split):
            left = child[later[k]]
            now[2 * k], now[2 * k + 1] = left, left + np.int32(1)
        count = 2 * split
    return fars, nears, hands


@njit(**PART)
def room_for(levels, nodes, width, leaf_size):
    """What a thread works in.

    Ends of what is deferred, coefficients of the nodes above, lists of nodes, their keys, places, places apart from a
    centre, features and moments, nodes to come and their depths, targets and their fields.
    """
    most = nodes + 2 * LANES
    return (
        np.zeros(levels + 2, np.int64), np.zeros((levels + 2, width)), np.empty((5, most), np.int32),
        np.empty((4, most), real), np.empty((4, most), np.float64), np.empty((3, most), real),
        np.empty((8, most), real),
        np.empty((MOMENTS, most), real), np.empty((2, 2 * levels + 2), np.int64),
        np.zeros((5, leaf_size + 3 * LANES), real), np.empty((4, leaf_size + 3 * LANES), real), np.zeros(width),
    )  # fmt: skip


@njit(**PART)
def descend_from(start, only_top, seeds, seed_local, first, last, child, parent_of, where_is, about, moments, x, y,
                 z, m, clamp, order, theta, tolerance, acceleration, potential, force_unit, potential_unit, leaf_size,
                 saved, saved_end, saved_local, task_of, room, handed, sources):  # fmt: skip
    """From the node `start`, which was given the candidates `seeds` and its parent's coefficients, to the leaves below.

    With only_top, tasks are not entered: what they are given is saved.
    """
    ends, local, lists, keys, places, apart, features, columns, coming, targets, field, nothing = room
    handed = roomier(handed, 0, len(seeds))
    for k in range(len(seeds)):
        handed[k] = seeds[k]
    ends[0] = len(seeds)
    set_to(seed_local, local[0])
    bucket = real(leaf_size)
    stack, depths = coming[0], coming[1]
    stack[0], depths[0], height = start, 1, 1
    saved_count = 0
    while height > 0:
        height -= 1
        node, depth = stack[height], depths[height]
        parent = np.int64(parent_of[node])
        offset = 0 if depth == 1 else ends[depth - 2]
        handed = roomier(handed, ends[depth - 1], 1)
        filled = ends[depth - 1]
        within = parent != node and last[parent] - first[parent] <= leaf_size
        if parent != node and not within:
            sibling = 2 * np.int64(child[parent]) + 1 - node
            handed[filled] = np.int32(sibling)
            filled += 1
        if only_top and task_of[node] >= 0:
            saved = roomier(saved, saved_count, filled - offset)
            for k in range(ends[depth - 1] - offset):
                saved[saved_count + k] = handed[offset + k]
            saved_count += ends[depth - 1] - offset
            saved_end[task_of[node]] = saved_count
            set_to(local[depth - 1], saved_local[task_of[node]])
            continue
        fars, nears, hands = seek(
            node, handed[offset:filled], filled - offset, where_is, about, child, bucket, theta, tolerance, lists, keys,
            places, apart, features
        )  # fmt: skip
        shift_local(
            where_is[node, 0] - where_is[parent, 0], where_is[node, 1] - where_is[parent, 1],
            where_is[node, 2] - where_is[parent, 2], local[depth - 1], local[depth]
        )  # fmt: skip
        for k in range(fars, padded(fars)):
            lists[2, k] = lists[2, 0]
        gathered(lists[2], fars, where_is, about, where_is[node], places, apart, features)
        spread_moments(moments, lists[2], padded(fars), columns)
        far_field(fars, about[node, 5], apart, features, columns, local[depth])
        if last[node] - first[node] <= leaf_size:
            if not within:
                lists[3, nears] = np.int32(node)
                nears += 1
            done = hands == 0
            sources = leaf_sums(
                node, lists[3], nears, local[depth] if done else nothing, first, last, where_is, about, x, y, z, m,
                clamp, order, targets, sources, field, acceleration, potential, force_unit, potential_unit
            )  # fmt: skip
            if done:
                continue
        base = ends[depth - 1]
        handed = roomier(handed, base, hands + 1)
        for k in range(hands):
            handed[base + k] = lists[4, k]
        ends[depth] = base + hands
        stack[height], depths[height] = np.int64(child[node]) + 1, depth + 1
        stack[height + 1], depths[height + 1] = np.int64(child[node]), depth + 1
        height += 2
    return saved, handed, sources


@njit(**ENTRY)
def descend(counter, only_top, task, seeds, seed_begin, seed_end, seed_local, first, last, child, levels, parent_of,
            where_is, about, moments, x, y, z, m, clamp, order, theta, tolerance, acceleration, potential, force_unit,
            potential_unit, leaf_size, saved_end, saved_local, task_of):  # fmt: skip
    """From each of the nodes `task`; what those were given lies in `seeds` one after the other.

    With only_top, returns what tasks below are given.
    """
    room = room_for(levels, len(first), saved_local.shape[1], leaf_size)
    saved, handed, sources = np.empty(1024, np.int32), np.empty(1024, np.int32), np.empty((5, 2048), real)
    while True:
        t = take(counter)
        if t >= len(task):
            break
        saved, handed, sources = descend_from(
            task[t], only_top, seeds[seed_begin[t] : seed_end[t]], seed_local[t], first, last, child, parent_of,
            where_is, about, moments, x, y, z, m, clamp, order, theta, tolerance, acceleration, potential, force_unit,
            potential_unit, leaf_size, saved, saved_end, saved_local, task_of, room, handed, sources
        )  # fmt: skip
    return saved
