"""The balanced tree: its shape, its boxes, and that it depends on the positions alone."""

from itertools import pairwise

import numpy as np
import pytest

from astroinertia.engines import tree


def clustered(count, seed=0):
    random = np.random.default_rng(seed)
    return random.normal(size=(count, 3)) * np.where(random.uniform(size=count) < 0.5, 0.02, 1.0)[:, None]


@pytest.mark.parametrize("count", [1, 2, 31, 32, 33, 1000, 4097])
def test_leaves_are_balanced_contiguous_and_hold_every_particle_once(count):
    order, leaves = tree.arrange(clustered(count), 32)
    sizes = np.diff(leaves.start)
    assert np.array_equal(np.sort(order), np.arange(count))
    assert leaves.count == 2**leaves.depth
    assert leaves.start[0] == 0 and leaves.start[-1] == count
    assert sizes.max() - sizes.min() <= 1 and sizes.max() <= 32
    assert leaves.depth == 0 or sizes.max() > 16


@pytest.mark.parametrize("count", [1000, 1100])
def test_every_node_is_split_at_the_median_of_its_longest_side(count):
    position = clustered(count)
    order, leaves = tree.arrange(position, 16)
    for level in range(leaves.depth):
        edges = leaves.start[:: 1 << (leaves.depth - level)]
        middles = leaves.start[:: 1 << (leaves.depth - level - 1)][1::2]
        for first, middle, last in zip(edges[:-1], middles, edges[1:], strict=True):
            node = position[order[first:last]]
            axis = np.argmax(np.ptp(node, axis=0))
            assert node[: middle - first, axis].max() <= node[middle - first :, axis].min()


@pytest.mark.parametrize("count", [777, 1777])
def test_boxes_enclose_tightly_and_follow_moved_particles(count):
    order, leaves = tree.arrange(clustered(count), 16)
    position = clustered(count)[order] + np.random.default_rng(1).normal(size=(count, 3))
    value = np.random.default_rng(2).normal(size=count)
    nodes = tree.fit(leaves, position, value)
    for level in range(leaves.depth + 1):
        edges = leaves.start[:: 1 << (leaves.depth - level)]
        for k, (first, last) in enumerate(pairwise(edges)):
            node = (1 << level) + k
            assert np.array_equal(nodes.rows[:3, node], position[first:last].min(axis=0))
            assert np.array_equal(nodes.rows[3:6, node], position[first:last].max(axis=0))
            assert nodes.rows[6, node] == value[first:last].max()
    lo, hi = tree.boxes(leaves, position)
    rows = nodes.rows[:, : 2 * leaves.count]
    assert np.array_equal(lo, rows[:3].T) and np.array_equal(hi, rows[3:6].T)
    assert np.array_equal(tree.largest(leaves, value), rows[6])
    assert np.array_equal(nodes.columns[:3, :count].T, position) and np.array_equal(nodes.columns[3, :count], value)


def test_few_of_many_have_the_boxes_of_few_with_what_is_unknown_too():
    order, leaves = tree.arrange(clustered(300), 16)
    position, value = clustered(300)[order], np.random.default_rng(2).normal(size=300)
    position[7, 1] = value[250] = np.nan
    alone, of_many = (tree.fit(leaves, position, value, among=among) for among in (0, 5000))
    assert np.array_equal(alone.rows[:, 1 : 2 * leaves.count], of_many.rows[:, 1 : 2 * leaves.count], equal_nan=True)
    assert np.isnan(of_many.rows[:, 1]).tolist() == [False, True, False, False, True, False, True]
    assert np.array_equal(alone.columns, of_many.columns, equal_nan=True)


def test_the_order_does_not_depend_on_the_number_of_threads():
    position = clustered(5000)
    orders = [tree.arrange(position, 32, threads)[0] for threads in (1, 2, 5)]
    assert np.array_equal(orders[0], orders[1]) and np.array_equal(orders[0], orders[2])


@pytest.mark.parametrize("count", [500, 1500])
def test_equal_positions_are_split_all_the_same(count):
    order, leaves = tree.arrange(np.zeros((count, 3)), 16)
    assert np.array_equal(np.sort(order), np.arange(count))
    assert np.diff(leaves.start).max() <= 16


@pytest.mark.parametrize("count", [300, 1300])
def test_an_unknown_position_is_kept_and_spreads_to_the_boxes_that_hold_it(count):
    position = clustered(count)
    position[7] = np.nan
    order, leaves = tree.arrange(position, 16)
    lo, hi = tree.boxes(leaves, position[order])
    leaf = np.searchsorted(leaves.start, np.flatnonzero(order == 7)[0], side="right") - 1
    assert np.array_equal(np.sort(order), np.arange(count))
    assert np.isnan(lo[1]).all() and np.isnan(hi[leaves.count + leaf]).all()
    assert np.isnan(lo[leaves.count :]).any(axis=1).sum() == 1


@pytest.mark.parametrize(("position", "size"), [(np.zeros((0, 3)), 8), (np.zeros((5, 2)), 8), (np.zeros((5, 3)), 0)])
def test_what_cannot_be_arranged_is_refused(position, size):
    with pytest.raises(ValueError, match=r"particles|positions"):
        tree.arrange(position, size)
