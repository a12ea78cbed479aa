"""Which programs the sums of a run are made by, in the order in which it comes to them, without any sum being made.

The scene's body is prepared and recorded, and takes a step, all with made-up sums: what is noted is the functions that
would make them, and the types of their arguments. Bodies are not settled. Test: tests/unit/run/test_beside.py.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any
from unittest import mock

import jax
import numpy as np

from astroinertia.build.assemble import prepare
from astroinertia.engines import elementwise, numba_cpu
from astroinertia.models.sph import first_state, relaxation
from astroinertia.scene.schema import Scene

Array = Any
Program = tuple[Any, tuple]
"""A function that numba compiles, and the types of its arguments."""


def programs(scene: Scene) -> list[Program]:
    """The programs by which sums of a run are made, in the order in which it would come to them.

    As far as made-up sums lead: what they make impossible ends the list.
    """
    found: dict[Program, None] = {}
    with jax.enable_x64(True), _noted(found), np.errstate(all="ignore"), suppress(Exception):
        prepared = prepare(scene)
        prepared.evolution.record(None)
        prepared.evolution.advance(prepared.outputs.end)
    return list(found)


@contextmanager
def _noted(found: dict[Program, None]) -> Iterator[None]:
    """Within, sums over pairs and loops over particles are noted, and results made up."""

    def note(function: Any, _: int, *arguments: Any) -> None:
        counted = np.zeros(1, np.int64), *arguments
        found[function, tuple(map(function.typeof_pyval, counted))] = None
        named = dict(zip(function.py_func.__code__.co_varnames, counted, strict=False))
        for name, argument in named.items():
            if name.startswith("out"):
                argument.fill(1.0)
        if function.py_func.__name__.startswith("density_pass"):
            _made_up_density(**named)

    def zeros(_: Callable, *of: Any) -> Any:
        return results(np.zeros, *of)

    results = numba_cpu._results
    with (
        mock.patch.object(numba_cpu, "share_out", note), mock.patch.object(numba_cpu, "_results", zeros),
        mock.patch.object(elementwise, "share_out", note), mock.patch.object(relaxation, "relax", _unsettled),
        mock.patch.object(first_state, "refuse_unsolved"), mock.patch.object(first_state, "_refuse_beyond"),
    ):  # fmt: skip
        yield


def _made_up_density(
    position: Array, h: Array, mass: Array, targets: Array, options: Array, results: Array, **_: Array
) -> None:
    """Lengths as they are guessed, densities that go with them, and no gradients."""
    results[0] = h[targets]
    results[1] = mass[targets] * (options[2] / h[targets]) ** 3
    results[2], results[3] = 1.0, 0.0


def _unsettled(_: Any, __: Any, position: np.ndarray, *___: Any, **____: Any) -> relaxation.Relaxed:
    return relaxation.Relaxed(position, np.zeros_like(position), relaxation.Report(0, 0, 0, 0, 0, 0), cached=True)
