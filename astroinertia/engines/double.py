"""64 bits by JAX for work that may come to need it, and most often does not: then nothing waits for its import."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from astroinertia.process.imports import once_imported

_within = 0  # how many times it has been entered without JAX
_before: bool | None = None  # whether JAX, imported within, would have done so by itself


@contextmanager
def in_double() -> Iterator[None]:
    """Within it JAX computes in 64 bits; where it has not been imported yet, in all threads, from its import on.

    Tests: tests/unit/engines/test_double.py.
    """
    if (jax := sys.modules.get("jax")) is not None:
        with jax.enable_x64(True):
            yield
        return
    _entered(1)
    try:
        yield
    finally:
        _entered(-1)


def _entered(times: int) -> None:
    global _within
    _within += times
    once_imported("jax", _switch)


def _switch() -> None:
    global _before
    import jax

    if _within and _before is None:
        _before = jax.config.jax_enable_x64  # type: ignore[attr-defined]
        jax.config.update("jax_enable_x64", True)
    elif not _within and _before is not None:
        jax.config.update("jax_enable_x64", _before)
        _before = None
