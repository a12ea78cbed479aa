"""What numba compiles is written in files that Python runs too: small cases of each, against the plain formula."""

import importlib
import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from numba import config

from astroinertia.engines import templates
from astroinertia.gravity import multipole, tree as trees
from astroinertia.gravity.clamped_points import CLAMP
from astroinertia.gravity.expansions import indices

SHARED = ("vectors", "tables", "parts", "float64", "mixed", "elementary")
MODULES = (*(f"engines.numba_{name}" for name in SHARED), "gravity.compaction", "gravity.refit", "gravity.walk")

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


def test_every_node_has_the_moments_of_its_particles(plain):
    order, nodes = 5, trees.tree(POSITION, leaf_size=6, threads=1)
    x, y, z, m, clamp = np.zeros((5, COUNT + 64))
    where_is, about = np.zeros((nodes.count, 4)), np.zeros((nodes.count, 8))
    raw, kept = np.zeros((nodes.count, len(indices(order - 1)))), np.zeros((nodes.count, plain.walk.MOMENTS))
    weight, columns = random.random(COUNT), (x, y, z, m, clamp)
    plain.refit.upward(
        np.zeros(1, np.int64), nodes.first, nodes.last, nodes.child, nodes.task, nodes.begin, nodes.order, POSITION,
        MASS, LENGTH, weight, np.zeros(3), 1.0, 1.0, *columns, where_is, about, raw, kept,
    )  # fmt: skip
    plain.refit.upward_top(nodes.first, nodes.last, nodes.child, nodes.begin, where_is, about, raw, kept)
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
    monkeypatch.setattr(multipole, "_module", lambda order, precision: generated)
    nodes = trees.tree(POSITION, leaf_size=3, threads=1)
    particles = multipole._Particles(MASS, POSITION, LENGTH, nodes, "float64", 1)
    acceleration, potential = particles.sums(5, math.inf, theta, None)
    expected, depth = clamped_points()
    assert np.abs(acceleration - expected).max() < limit * np.abs(expected).max()
    assert np.abs(potential / depth - 1.0).max() < limit
    assert (sum(taken) > 0) == (theta > 0.0)
