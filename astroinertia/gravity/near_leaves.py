"""Neighbours of the leaves of the fast gravity's tree, for its softening: no second order of particles, no second tree.

Nodes halved in space have boxes that stay compact where particles cluster. The leaves of a task of the tree share the
list of all leaves that are near the task.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_cpu import Arrangement, Lists, Targets
from astroinertia.engines.numba_lists import extent, load_balls
from astroinertia.engines.numba_parts import (
    GROUP,
    MANY,
    box_centre,
    columns_for,
    target_box,
    touched,
    whole_lines,
    with_columns,
    with_room,
)
from astroinertia.engines.numba_vectors import ENTRY, LANES, claim, in_reach, take
from astroinertia.engines.threads import share_out
from astroinertia.engines.tree import Leaves, Nodes
from astroinertia.gravity.tree import Tree

LISTED = 512  # neighbours of a leaf that there is room for at first


def near_leaves(tree: Tree, position: np.ndarray, length: np.ndarray, support: float, threads: int) -> Arrangement:
    """The tree's leaves with the particles that can reach each, as sums over neighbours take them.

    position (N, 3), length (N,): in the tree's order. Tested in tests/unit/gravity/test_multipole.py.
    """
    count = len(length)
    first = np.sort(tree.first[tree.child == 0])
    start = np.append(first, np.full(1 + -len(first) % GROUP, count))  # groups of leaves are whole
    every, columns, boxes = np.arange(count), np.zeros((4, count + LANES)), np.zeros((7, len(first) + LANES))
    columns[:3, :count], columns[3, :count] = position.T, length
    offset, number = np.zeros((2, len(start) - 1), np.int64)
    tasks = np.append(np.searchsorted(first, tree.first[tree.task]), len(first))
    share_out(_boxes, threads, position, length, every, start, tasks, boxes)
    room = LISTED * len(first)
    while True:
        pool, used = np.empty(room, np.int32), np.zeros(1, np.int64)
        share_out(
            _lists, threads, *columns, *boxes, support, position, every, start, tasks, offset, number, pool, used
        )  # fmt: skip
        if used[0] <= room:
            break
        room = int(used[0])
    everyone = Targets(every, start, np.arange((len(start) - 1) // GROUP), np.arange(len(first)))
    lists = Lists(position, length, support, Nodes(columns, boxes), everyone, offset, number, pool)
    return Arrangement(Leaves(start, 0), every[:0], every[:0], everyone, np.inf, {}, lists)


@njit(**ENTRY)
def _boxes(counter, position, h, every, start, tasks, boxes):
    box = np.empty((2, 3))
    while True:
        task = take(counter)
        if task >= len(tasks) - 1:
            break
        for leaf in range(tasks[task], tasks[task + 1]):
            boxes[6, leaf] = target_box(position, h, every, start[leaf], start[leaf + 1], box)
            for a in range(3):
                boxes[a, leaf], boxes[3 + a, leaf] = box[0, a], box[1, a]


@njit(**ENTRY)
def _lists(counter, x, y, z, h, lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, size, support, position, every, start, tasks,
           offset, number, pool, used):  # fmt: skip
    # Of each leaf: the particles that come within the larger of two reaches of its box, ascending.
    leaves = tasks[-1]
    box, near, index = np.empty((2, 3)), np.empty(leaves + LANES, np.int64), np.empty(4096, np.int64)
    listed, some = np.empty(leaves + LANES, np.int64), np.empty((7, leaves + LANES))
    centre, balls = np.empty(3), whole_lines(4, columns_for(64), np.empty(0, np.float32))
    while True:
        task = take(counter)
        if task >= len(tasks) - 1:
            break
        reach = support * target_box(position, h, every, start[tasks[task]], start[tasks[task + 1]], box)
        nears = in_reach(lo_x, lo_y, lo_z, hi_x, hi_y, hi_z, size, 0, leaves, box, support, reach, near, 0)
        kept = 0
        for k in range(nears):  # of a leaf's lengths the longest may be that of a particle far away
            leaf = near[k]
            index = with_room(index, start[leaf + 1] - start[leaf])
            if in_reach(x, y, z, x, y, z, h, start[leaf], start[leaf + 1], box, support, reach, index, 0) > 0:
                near[kept] = leaf
                some[0, kept], some[1, kept], some[2, kept] = lo_x[leaf], lo_y[leaf], lo_z[leaf]
                some[3, kept], some[4, kept], some[5, kept] = hi_x[leaf], hi_y[leaf], hi_z[leaf]
                some[6, kept] = size[leaf]
                kept += 1
        for leaf in range(tasks[task], tasks[task + 1]):
            reach = support * target_box(position, h, every, start[leaf], start[leaf + 1], box)
            nears = in_reach(
                some[0], some[1], some[2], some[3], some[4], some[5], some[6], 0, kept, box, support, reach, listed, 0
            )
            if nears > MANY:  # the box of particles around a dense body holds the body
                box_centre(box, centre)
                unit = 1.0 / extent(box, reach)
                balls = with_columns(balls, start[leaf + 1] - start[leaf])
                load_balls(position, h, support, every, start[leaf], start[leaf + 1], centre, unit, balls)
                nears = touched(
                    some, support, box, balls, start[leaf + 1] - start[leaf], centre, unit, listed, nears
                )  # fmt: skip
            room = 0
            for k in range(nears):
                room += start[near[listed[k]] + 1] - start[near[listed[k]]]
            index = with_room(index, room)
            count = 0
            for k in range(nears):
                other = near[listed[k]]
                count = in_reach(
                    x, y, z, x, y, z, h, start[other], start[other + 1], box, support, reach, index, count
                )  # fmt: skip
            place = claim(used, count)
            offset[leaf], number[leaf] = place, count
            if place + count <= len(pool):  # else the caller comes back with more room
                for k in range(count):
                    pool[place + k] = index[k]
