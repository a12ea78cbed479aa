"""Multipole gravity of the xla engine: its tree, its lists, and its sums against sums over all pairs."""

import jax
import numpy as np
import pytest

from astroinertia.engines.xla import Engine
from astroinertia.gravity import full_leaves, lists_xla, multipole_xla
from astroinertia.gravity.clamped_points import SOFTENED_LESS_POINT
from astroinertia.gravity.direct import DIRECT_GRAVITY

pytestmark = pytest.mark.usefixtures("float64")

KERNEL = "wendland_c2"
ORDER = 3


def halo(count, seed=5):
    """A Plummer sphere and a small dense clump beside it: positions, masses and smoothing lengths."""
    random = np.random.default_rng(seed)
    direction = random.normal(size=(count, 3))
    radius = 1.0 / np.sqrt(random.uniform(0.001, 0.99, size=count) ** (-2.0 / 3.0) - 1.0)
    position = direction / np.linalg.norm(direction, axis=1)[:, None] * radius[:, None]
    position[: count // 4] = [3.0, 1.0, 0.0] + 0.03 * position[: count // 4]
    position[1] = position[0]
    apart = np.linalg.norm(position[:, None] - position[None], axis=2)
    return position, random.uniform(0.5, 1.5, count) / count, 0.5 * np.sort(apart, axis=1)[:, 16]


def made(count, tolerance, order=ORDER, precision="float64", leaf_size=4):
    """Engine, arrangement, lists and {field: array} in the engine's order."""
    position, mass, lengths = halo(count)
    engine = Engine(precision=precision, pairs_in_chunk=1 << 14)
    sort, arrangement = engine.arrange(position, lengths)
    fields = {"mass": mass[sort], "position": position[sort], "smoothing_length": lengths[sort]}
    exact = engine.all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), fields)["gravity"]
    exact = {name: np.asarray(value) for name, value in exact.items()}
    strength = np.linalg.norm(exact["acceleration"], axis=1)
    given = (fields["mass"], fields["position"], fields["smoothing_length"], strength)
    lists = lists_xla.interaction_lists(*given, tolerance, order, leaf_size, engine.chunk)
    return engine, arrangement, lists, fields, exact


def softened(engine, arrangement, lists, fields, virial=False):
    """Points by expansions, and what softening changes about those."""
    sums = multipole_xla.points(engine.precision, lists, *fields.values())
    if virial:
        sums["virial"] = multipole_xla.virial(engine.precision, lists, *fields.values())
    near = engine.neighbour_sums(arrangement, KERNEL, (SOFTENED_LESS_POINT,), fields, virial=virial)["gravity"]
    return {name: value + near[name] for name, value in sums.items()}


def found(engine, arrangement, lists, fields, virial=False):
    return {name: np.asarray(value) for name, value in softened(engine, arrangement, lists, fields, virial).items()}


def listed(chunks, empty):
    target, source = np.asarray(chunks.target), np.asarray(chunks.source)
    target = np.broadcast_to(target[..., None] if source.ndim == 3 else target, source.shape)
    return np.stack([target[source < empty], source[source < empty]], axis=1)


@pytest.mark.full
def test_every_pair_of_particles_is_in_the_lists_once_and_both_ways():
    _, _, lists, _, _ = made(300, 0.05)
    count, leaves, nodes = 300, lists.slots.shape[0], lists.first.shape[0]
    slots, first, last = (np.asarray(array) for array in (lists.slots, lists.first, lists.last))
    assert np.array_equal(np.sort(slots[slots < count]), np.arange(count))
    times = np.zeros((count + 1, count + 1), int)
    local = listed(lists.local, nodes)
    assert len(local) > 50
    for a, b in local:
        targets, sources = slots[first[a] : last[a]].ravel(), slots[first[b] : last[b]].ravel()
        times[np.ix_(targets[targets < count], sources[sources < count])] += 1
    for a, b in listed(lists.near, leaves):
        times[np.ix_(slots[a][slots[a] < count], slots[b][slots[b] < count])] += 1
    assert np.all(times[:count, :count] == 1)
    assert {(a, b) for a, b in local} == {(b, a) for a, b in local}


@pytest.mark.full
def test_leaves_are_full_or_narrow_whatever_the_threads():
    position, _, _ = halo(1000)
    limit = np.where(np.arange(1000) % 2, 0.05, 0.5)
    trees = [full_leaves.tree(position, 16, limit, threads) for threads in (1, 2)]
    for one, other in zip(vars(trees[0]).values(), vars(trees[1]).values(), strict=True):
        assert np.array_equal(one, other)
    sizes = np.diff(trees[0].start)
    assert sizes.min() >= 1 and sizes.max() == 16 and len(set(sizes)) > 2
    wide = np.diff(full_leaves.tree(position, 16, np.full(1000, np.inf)).start)
    assert np.all(wide[:-1] == 16)


@pytest.mark.full
def test_bodies_that_are_cut_a_little_differently_share_a_program():
    # Compiling a step takes 20 s: a body under way must not ask for it whenever its lists are made.
    shapes, leaves = set(), set()
    for nudge in range(12):
        position, mass, lengths = halo(400)
        position = position * (1.0 + 0.01 * nudge * np.sin(3.0 * position))
        given = (mass, position, lengths, np.full(len(mass), 1.0 + 0.03 * nudge), 0.05, 2, 4, 1 << 14)
        lists = lists_xla.interaction_lists(*given)
        shapes.add(tuple(array.shape for array in (lists.slots, lists.first, lists.leaf_node, lists.scale)))
        leaves.add(int((np.asarray(lists.slots)[:, 0] < len(mass)).sum()))
    assert len(leaves) > 6 * len(shapes)


@pytest.mark.slow
@pytest.mark.parametrize(("tolerance", "order"), [pytest.param(3e-2, 2, marks=pytest.mark.full), (1e-3, 4)])
def test_errors_are_about_what_is_asked_for(tolerance, order):
    engine, arrangement, lists, fields, exact = made(300, tolerance, order)
    sums = found(engine, arrangement, lists, fields, virial=order == 2)
    size = np.linalg.norm(exact["acceleration"], axis=1)
    error = np.linalg.norm(sums["acceleration"] - exact["acceleration"], axis=1) / size
    rms = np.sqrt(np.mean(error**2))
    assert 0.05 * tolerance < rms < 2.0 * tolerance
    assert np.abs(sums["potential"] / exact["potential"] - 1.0).max() < tolerance
    # Opposite forces between nodes as between particles: the lists and the orders are symmetric.
    mass = fields["mass"]
    assert np.abs(mass @ sums["acceleration"]).max() < 1e-14 * (mass * size).sum()
    if "virial" in sums:
        tensor = (mass[:, None] * fields["position"]).T @ sums["acceleration"]
        assert np.abs(sums["virial"] - tensor).max() < 1e-13 * np.abs(tensor).max()


@pytest.mark.full
@pytest.mark.parametrize("unit", [1.0, 1e-7])
def test_mixed_precision_holds_numbers_of_any_size(unit):
    _, _, _, fields, exact = made(300, 1e-2, 2)
    strength = np.linalg.norm(exact["acceleration"], axis=1) / unit**2
    given = [np.asarray(fields["mass"]), fields["position"] * unit, fields["smoothing_length"] * unit]
    lists = lists_xla.interaction_lists(*given, strength, 1e-2, 2, 4, 1 << 14)
    double, mixed = (
        np.asarray(multipole_xla.points(precision, lists, *given)["acceleration"]) for precision in ("float64", "mixed")
    )
    assert np.all(np.linalg.norm(mixed - double, axis=1) < 3e-5 * strength)
    assert np.abs(given[0] @ mixed).max() < 3e-8 * given[0] @ strength


@pytest.mark.full
def test_gradients_are_those_of_the_direct_sum_within_the_error():
    tolerance = 1e-3
    engine, arrangement, lists, fields, _ = made(300, tolerance, 3)
    assert len(listed(lists.local, lists.first.shape[0])) > 50
    # Smooth weights: what is asked of a body as a whole. A single pair may be as wrong as its nodes are wide.
    push = fields["mass"][:, None] * (fields["position"] + [1.0, 2.0, 3.0])

    def weighed(sums, mass):
        return (push * sums["acceleration"]).sum() + mass @ sums["potential"]

    def fast(mass, position, length):
        given = {"mass": mass, "position": position, "smoothing_length": length}
        return weighed(softened(engine, arrangement, lists, given), mass)

    def direct(mass, position, length):
        given = {"mass": mass, "position": position, "smoothing_length": length}
        return weighed(engine.all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), given)["gravity"], mass)

    at = tuple(fields.values())
    found, expected = (jax.jit(jax.grad(function, (0, 1, 2)))(*at) for function in (fast, direct))
    # A derivative by position costs one order of the expansions.
    for one, other, bar in zip(found, expected, (3e-3, 3e-2, 1e-9), strict=True):
        assert np.linalg.norm(one - other) < bar * np.linalg.norm(other)
    # The exact derivative of what is summed, with the lists as they are.
    along = np.random.default_rng(8).normal(size=(300, 3))
    ahead, behind = (jax.jit(fast)(at[0], at[1] + sign * 1e-6 * along, at[2]) for sign in (1.0, -1.0))
    assert abs((ahead - behind) / 2e-6 / (found[1] * along).sum() - 1.0) < 1e-6
