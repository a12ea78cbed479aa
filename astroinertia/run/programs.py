"""Which programs the sums of a run are made by, in the order in which it comes to them, without any sum being made.

The scene's body is prepared and recorded, and takes a step, all with made-up sums: what is noted is the functions that
would make them, and the types of their arguments. Work on single particles is noted and done by numpy. Bodies are not
settled. Test: tests/unit/run/test_beside.py.
"""

from contextlib import suppress
from contextvars import copy_context
from typing import Any

import numpy as np

from astroinertia.build.assemble import prepare
from astroinertia.engines.double import in_double
from astroinertia.engines.threads import noting
from astroinertia.scene.schema import Scene

Array = Any
Program = tuple[Any, tuple]
"""A function that numba compiles, and the types of its arguments."""


def programs(scene: Scene) -> list[Program]:
    """The programs by which sums of a run are made, in the order in which it would come to them.

    As far as made-up sums lead: what they make impossible ends the list.
    """
    found: dict[Program, None] = {}
    copy_context().run(_rehearse, scene, found)
    return list(found)


def _rehearse(scene: Scene, found: dict[Program, None]) -> None:
    """Prepare, record and step; passes over particles are noted, and sums over pairs made up."""

    def note(function: Any, *arguments: Any) -> None:
        counted = np.zeros(1, np.int64), *arguments
        found[function, tuple(map(function.typeof_pyval, counted))] = None
        named = dict(zip(function.py_func.__code__.co_varnames, counted, strict=False))
        for name, argument in named.items():
            if name.startswith("out"):
                argument.fill(1.0)
        if function.py_func.__name__.startswith("density_pass"):
            _made_up_density(**named)

    noting.set(note)
    with in_double(), np.errstate(all="ignore"), suppress(Exception):
        prepared = prepare(scene.with_bodies(lambda body: {"relax": False}))
        prepared.evolution.record(None)
        prepared.evolution.advance(prepared.outputs.end)


def _made_up_density(h: Array, mass: Array, targets: Array, options: Array, results: Array, **_: Array) -> None:
    """Lengths as they are guessed, densities that go with them, and no gradients."""
    results[0] = h[targets]
    results[1] = mass[targets] * (options[2] / h[targets]) ** 3
    results[2], results[3] = 1.0, 0.0
