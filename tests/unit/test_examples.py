"""Examples in docstrings: every public function of the rooms below has one, and all of them are run."""

import ast
import doctest
import importlib
from pathlib import Path

import numpy as np
import pytest

PACKAGE = Path(__file__).parents[2] / "astroinertia"
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
ROOMS = ["inertia"]
INSIDES = {
    "inertia.eigen",  # what principal axes and their gradients are computed with
    "inertia.ledger",  # integrated beside the particles
    "inertia.mean_squares",  # what shapes are made with
    "inertia.prescribed",  # the curve of [body.change]
    "inertia.regions",  # the books of [regions]
    "inertia.tensor.is_known",
    "inertia.tensor.namespace",  # NumPy or JAX
}


def modules():
    """The modules of the rooms, without those that only the package itself calls."""
    found = []
    for room in ROOMS:
        path = PACKAGE / room
        files = path.rglob("*.py") if path.is_dir() else [path.with_suffix(".py")]
        found += [".".join(each.relative_to(PACKAGE).with_suffix("").parts) for each in files if each.stat().st_size]
    return sorted(set(found) - INSIDES)


def without_example(name):
    """Public functions, and public methods of accessors, that show no example.

    Other classes are what functions return: their examples are those of the functions.
    """
    tree = ast.parse((PACKAGE / f"{name.replace('.', '/')}.py").read_text())
    bodies = [tree.body, *(each.body for each in tree.body if getattr(each, "name", "").endswith("Accessor"))]
    functions = [each for body in bodies for each in body if isinstance(each, ast.FunctionDef)]
    missing = [each.name for each in functions if ">>>" not in (ast.get_docstring(each) or "")]
    return [each for each in missing if not each.startswith("_") and f"{name}.{each}" not in INSIDES]


@pytest.mark.parametrize("name", modules())
def test_examples_print_what_they_say(name):
    module = importlib.import_module(f"astroinertia.{name}")
    found = doctest.testmod(module, extraglobs={"np": np}, optionflags=FLAGS, verbose=False)
    assert found.failed == 0


@pytest.mark.parametrize("name", modules())
def test_every_public_function_has_an_example(name):
    assert without_example(name) == []
