"""What numba compiles is written in files that Python runs too: small cases of each, against the plain formula."""

import importlib
import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from numba import config

from astroinertia.engines import numba_cpu, templates
from astroinertia.engines.numba_modules import Pass
from astroinertia.gravity import multipole, tree as trees
from astroinertia.gravity.clamped_points import CLAMP
from astroinertia.gravity.expansions import indices
from astroinertia.sph.kernels import KERNELS

SHARED = ("vectors", "tables", "parts", "float64", "mixed", "elementary")
PASSES = ("lists", "lengths", "density", "neighbours", "all_pairs", "few_density", "few_neighbours", "few_pairs")
GRAVITY = ("gravity.compaction", "gravity.refit", "gravity.walk", "gravity.softening")
MODULES = (*(f"engines.numba_{name}" for name in (*SHARED, *PASSES)), *GRAVITY)

KERNEL, ETA = KERNELS["wendland_c2"], 1.1
random = np.random.default_rng(22)
COUNT = 60
MASS, POSITION, LENGTH = random.random(COUNT) + 0.1, random.normal(size=(COUNT, 3)), 0.1 + 0.1 * random.random(COUNT)


@pytest.fixture(scope="module")
def plain():
    """The templates and what they share as NUMBA_DISABLE_JIT=1 would have them, by the last part of their names."""
    for name in MODULES:
        importlib.import_module(f"astroinertia.{name}")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(config, "DISABLE_JIT", True)
        found = SimpleNamespace()
        for name in MODULES:
            room, _, last = f"astroinertia.{name}".rpartition(".")
            patch.delitem(sys.modules, f"{room}.{last}")
            patch.setattr(sys.modules[room], last, None)
            setattr(found, last, importlib.import_module(f"{room}.{last}"))
        patch.setattr(config, "DISABLE_JIT", False)  # functions that are not theirs are compiled as ever
        yield found


def test_words_and_lists_of_arguments_are_replaced_below_the_mark(tmp_path):
    file = tmp_path / "some.py"
    file.write_text(f"WIDTH = 1\n{templates.MARK}def taken(a, more, b,\n          more):\n    return WIDTH + WIDTHS\n")
    assert templates.template(str(file), WIDTH=4, more=["c", "d"], taken="taken_4") == (
        "def taken_4(a, c, d, b, c, d):\n    return 4 + WIDTHS\n"
    )
    assert templates.template(str(file), more=[]).startswith("def taken(a, b):\n")


@pytest.mark.slow
def test_every_node_has_the_moments_of_its_particles(plain):
    order, nodes = 5, trees.tree(POSITION, leaf_size=6, threads=1)
    x, y, z, m, clamp = np.zeros((5, COUNT + 64))
    where_is, about = np.zeros((nodes.count, 4)), np.zeros((nodes.count, 8))
    raw, kept = np.zeros((nodes.count, len(indices(order - 1)))), np.zeros((nodes.count, plain.walk.MOMENTS))
    strength, columns = random.random(COUNT), (x, y, z, m, clamp)
    strength[:2] = 0.0, np.nan  # in balance, and not known
    weight = 1.0 / np.fmax(strength, multipole.LEAST) ** 2
    plain.refit.upward(
        np.zeros(1, np.int64), nodes.first, nodes.last, nodes.child, nodes.task, nodes.begin, nodes.end, nodes.order,
        POSITION, MASS, LENGTH, strength, np.zeros(3), 1.0, 1.0, *columns, where_is, about, raw, kept,
    )  # fmt: skip
    plain.refit.upward_top(nodes.first, nodes.last, nodes.child, nodes.top, where_is, about, raw, kept)
    assert np.count_nonzero(nodes.child) > 4
    assert np.array_equal(clamp[:COUNT], CLAMP * LENGTH[nodes.order] ** 2)
    for node in range(nodes.count):
        mine = nodes.order[nodes.first[node] : nodes.last[node]]
        centre = MASS[mine] @ POSITION[mine] / MASS[mine].sum()
        apart = centre - POSITION[mine]
        assert np.allclose(where_is[node], [*centre, weight[mine].sum()], rtol=1e-13, atol=1e-14)
        assert np.isclose(about[node, 2], MASS[mine].sum(), rtol=1e-14)
        assert np.isclose(about[node, 3], np.sqrt(weight[mine].mean()), rtol=1e-14)
        assert about[node, 0] >= (1 - 1e-14) * np.linalg.norm(apart, axis=1).max()
        for n, a in enumerate(indices(order - 1)):
            factors = math.prod(map(math.factorial, a))
            moment = MASS[mine] @ np.prod(apart**a, axis=1) / factors if sum(a) != 1 else 0.0
            assert np.isclose(raw[node, n], moment, rtol=1e-12, atol=1e-13), (node, a)


def clamped_points():
    """Acceleration and potential of clamped points, pair by pair."""
    apart = POSITION[:, None] - POSITION[None]
    least = CLAMP * (LENGTH[:, None] ** 2 + LENGTH[None] ** 2)
    inverse = 1.0 / np.sqrt(np.maximum((apart**2).sum(axis=-1), least))
    return -np.einsum("j,ij,ijk->ik", MASS, inverse**3, apart), -inverse @ MASS


@pytest.mark.parametrize(("theta", "limit"), [(0.0, 1e-13), (0.5, 5e-3)])
def test_the_walk_takes_every_pair_once(plain, monkeypatch, theta, limit):
    """Of single pairs alone, and of expansions, whose error is theirs."""
    far, taken = plain.walk.far_field, []
    monkeypatch.setattr(plain.walk, "far_field", lambda *given: (taken.append(given[0]), far(*given)))
    generated = SimpleNamespace(**vars(plain.refit) | vars(plain.walk))
    nodes = trees.tree(POSITION, leaf_size=3, threads=1)
    particles = multipole._Particles(MASS, POSITION, LENGTH, nodes, "float64", 1)
    acceleration, potential = particles.sums(generated, 5, math.inf, theta, None)
    expected, depth = clamped_points()
    assert np.abs(acceleration - expected).max() < limit * np.abs(expected).max()
    assert np.abs(potential / depth - 1.0).max() < limit
    assert (sum(taken) > 0) == (theta > 0.0)


def test_softening_takes_every_pair_within_reach_once(plain, monkeypatch):
    generated = SimpleNamespace(**vars(plain.refit) | vars(plain.walk))
    monkeypatch.setattr(multipole, "_softening", lambda kernel, precision: plain.softening)
    monkeypatch.setattr(multipole, "GROUPED", 8)
    nodes = trees.tree(POSITION, leaf_size=3, threads=1)
    length = 4.0 * LENGTH
    particles = multipole._Particles(MASS, POSITION, length, nodes, "float64", 1)
    acceleration, potential = particles.sums(generated, 5, math.inf, 0.0, None, "wendland_c2")
    apart = POSITION[:, None] - POSITION
    r = np.linalg.norm(apart, axis=2)
    each = [(r / h, h) for h in (length[:, None], length)]
    slope = 0.5 * sum(KERNEL.dphi(np, q) / h**2 for q, h in each) / np.where(r > 0.0, r, 1.0)
    expected = -np.einsum("ij,j,ijk->ik", slope, MASS, apart)
    depth = 0.5 * sum(KERNEL.phi(np, q) / h for q, h in each) @ MASS
    assert np.abs(acceleration - expected).max() < 1e-13 * np.abs(expected).max()
    assert np.abs(potential / depth - 1.0).max() < 1e-13
    assert 0.5 * COUNT**2 > np.count_nonzero(r < 2.0 * np.maximum(length[:, None], length)) > 5 * COUNT


@pytest.fixture(params=["many", "few"])
def engine(plain, monkeypatch, request):
    """An engine whose passes run as Python, particles in its order and their arrangement."""
    neighbours, everything = plain.numba_neighbours, plain.numba_all_pairs
    density = {True: plain.numba_few_density, False: plain.numba_density}
    sums = Pass(neighbours.TOTALS, neighbours.neighbour_pass, neighbours.NEEDS)
    both = Pass(everything, everything.all_pairs_pass, everything.NEEDS)
    if request.param == "many":
        monkeypatch.setattr(numba_cpu, "FEW", 0)  # few particles are not listed leaf by leaf
    monkeypatch.setattr(numba_cpu, "lists_pass", lambda: plain.numba_lists.neighbour_lists)
    monkeypatch.setattr(numba_cpu, "density_pass", lambda *given: (None, density[given[3]].density_pass))
    for name, module, entry, needs in (
        ("few_neighbour_pass", plain.numba_few_neighbours, "neighbour_pass", neighbours.NEEDS),
        ("few_all_pairs_pass", plain.numba_few_pairs, "all_pairs_pass", everything.NEEDS),
    ):
        few = Pass(module, getattr(module, entry), needs)
        monkeypatch.setattr(numba_cpu, name, lambda *_, few=few: few)
    monkeypatch.setattr(numba_cpu, "neighbour_pass", lambda *_: sums)
    monkeypatch.setattr(numba_cpu, "all_pairs_pass", lambda *_: both)
    made = numba_cpu.Engine("float64", threads=1)
    order, arrangement = made.arrange(POSITION, LENGTH)
    fields = {"position": POSITION, "mass": MASS, "smoothing_length": 3.0 * LENGTH, "weight": 1.0 + np.arange(COUNT)}
    apart = np.linalg.norm(POSITION[order, None] - POSITION[None, order], axis=-1)
    return made, arrangement, {name: array[order] for name, array in fields.items()}, apart


@pytest.mark.parametrize("engine", ["many"], indirect=True)
def test_lists_hold_what_reaches_or_is_reached_by_a_target(engine):
    made, arrangement, given, apart = engine
    lists = made.listed(arrangement, "wendland_c2", given["position"], given["smoothing_length"]).lists
    reach = KERNEL.support * np.maximum(lists.length[:, None], lists.length[None])
    assert len(lists.targets.leaves) > 1
    for leaf in lists.targets.leaves:
        mine = slice(lists.targets.begin[leaf], lists.targets.begin[leaf + 1])
        listed = lists.pool[lists.offset[leaf] : lists.offset[leaf] + lists.count[leaf]]
        assert listed.tolist() == np.flatnonzero((apart < reach)[mine].any(axis=0)).tolist()
    assert lists.count.max() < COUNT


def test_lengths_and_densities_satisfy_their_condition(engine):
    """From guesses of a fifth, so that some targets outgrow their lists."""
    made, arrangement, given, apart = engine
    first = given["position"], given["mass"], 0.2 * given["smoothing_length"]
    with np.errstate(over="ignore"):  # as it is compiled
        found = made.density(arrangement, "wendland_c2", *first, ETA, 1e-12, True)
    h, mass = found.smoothing_length, given["mass"]
    q = apart / h[:, None]
    density = KERNEL.w(np, q) @ mass / h**3
    assert np.allclose(density, mass * (ETA / h) ** 3, rtol=1e-10)
    assert np.allclose(found.density, density, rtol=1e-10)
    omega = -((q * KERNEL.dw(np, q)) @ mass) / (3.0 * density * h**3)
    zeta = -(KERNEL.softening(np, q) @ mass) / (3.0 * density * h)
    assert np.allclose(found.grad_h, omega, rtol=1e-9) and np.allclose(found.zeta, zeta, rtol=1e-9)


@pytest.mark.parametrize("some", [None, np.array([3, 4])])
def test_sums_over_neighbours_take_each_once(plain, engine, some):
    """From a table of all particles, and where each leaf packs its own."""
    made, arrangement, given, apart = engine
    found = made.neighbour_sums(arrangement, "wendland_c2", (plain.numba_neighbours.TOTAL,), given, targets=some)
    h = given["smoothing_length"]
    near = apart < KERNEL.support * np.maximum(h[:, None], h[None])
    expected = near @ (given["mass"] * given["weight"])
    assert 9 < near.sum(axis=1).max() < COUNT
    assert np.allclose(found["total"]["weight"], expected if some is None else expected[some], rtol=1e-14)


def test_sums_over_all_pairs_take_each_once(plain, engine, monkeypatch):
    made, arrangement, given, _ = engine
    far, taken = plain.numba_all_pairs.far_leaf, []
    monkeypatch.setattr(plain.numba_all_pairs, "far_leaf", lambda *given: (taken.append(given[4]), far(*given)))
    given["smoothing_length"] = 0.1 * given["smoothing_length"]
    monkeypatch.setattr(numba_cpu, "ALL_PAIRS_SIZE", 16)
    found = made.all_pair_sums(arrangement, "wendland_c2", (plain.numba_neighbours.TOTAL,), given)
    assert np.allclose(found["total"]["weight"], given["mass"] @ given["weight"], rtol=1e-14)
    assert (sum(taken) > 0) == (numba_cpu.FEW == 0)
