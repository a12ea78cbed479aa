"""Pytrees know their class: the cache of a compiled function can never take one for another."""

import ast
import subprocess
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import pytest

import astroinertia
from astroinertia.engines.pytree import mapped, named_leaves, pytree, with_fields, with_leaves
from astroinertia.matter.planetary import Murnaghan, Vinet


@pytree
@dataclass(frozen=True)
class Fruit:
    mass: object
    kind: str = field(default="apple", metadata={"static": True})


def test_structures_of_two_classes_differ():
    """jax.tree_util.register_dataclass calls these two equal."""
    assert jax.tree.structure(Vinet(1.0, 2.0, 3.0)) != jax.tree.structure(Murnaghan(1.0, 2.0, 3.0))


def test_values_pass_and_constants_are_part_of_the_structure():
    doubled = jax.jit(lambda fruit: jax.tree.map(lambda leaf: 2 * leaf, fruit))(Fruit(jnp.arange(3.0), "pear"))
    assert isinstance(doubled, Fruit) and doubled.kind == "pear"
    assert doubled.mass.tolist() == [0, 2, 4]
    assert jax.tree.structure(Fruit(1.0, "pear")) == jax.tree.structure(Fruit(2.0, "pear"))
    assert jax.tree.structure(Fruit(1.0, "pear")) != jax.tree.structure(Fruit(1.0, "apple"))
    ((path, _),) = jax.tree_util.tree_leaves_with_path(Fruit(1.0))
    assert jax.tree_util.keystr(path) == ".mass"


def test_fields_are_changed_as_dataclasses_do():
    apple = Fruit([1.0], "pear")
    other = with_fields(apple, mass=2.0)
    assert other == replace(apple, mass=2.0) and apple == Fruit([1.0], "pear")
    assert with_fields(apple, kind="plum").mass is apple.mass
    assert jax.tree.structure(other) == jax.tree.structure(Fruit(2.0, "pear"))
    with pytest.raises(TypeError, match="Fruit has no field colour"):
        with_fields(apple, colour="red")


class Pair(NamedTuple):
    one: object
    other: object


TREE = Fruit({"b": [1.0, None], "a": (Pair(2.0, Fruit(3.0, "plum")),)}, "pear")


def test_leaves_have_the_names_and_the_order_that_jax_gives_them():
    """Checkpoints of older runs hold them under these."""
    found = jax.tree_util.tree_leaves_with_path(TREE)
    assert list(named_leaves(TREE).items()) == [(jax.tree_util.keystr(path), leaf) for path, leaf in found]


def test_trees_are_rebuilt_as_jax_does():
    doubled = mapped(lambda leaf: 2.0 * leaf, TREE)
    assert doubled == jax.tree.map(lambda leaf: 2.0 * leaf, TREE) and jax.tree.structure(doubled) == jax.tree.structure(
        TREE
    )
    assert with_leaves(TREE, named_leaves(doubled)) == doubled
    with pytest.raises(KeyError, match="mass"):
        with_leaves(Fruit(1.0), {})


@pytest.mark.slow
def test_no_class_is_registered_another_way():
    for file in Path(astroinertia.__file__).parent.rglob("*.py"):
        names = {node.attr for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.Attribute)}
        assert "register_dataclass" not in names, file


@pytest.mark.slow
def test_what_is_made_before_jax_is_imported_is_a_pytree_all_the_same():
    program = (
        "import sys; from astroinertia.inertia.shapes import disc; one = disc(4.0, 2.0);"
        "assert 'jax' not in sys.modules;"
        "import jax; print(len(jax.tree.leaves(one)), float(jax.jit(lambda body: body + body)(one).mass))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["3", "8.0"]
