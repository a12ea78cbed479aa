"""What functions of the user's own did wrong in compiled programs, out of which no error comes as it is.

Tests: tests/unit/effects/test_by_function.py.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from astroinertia.errors import AstroinertiaError

FAILURES: list[AstroinertiaError] = []


@contextmanager
def failures_said() -> Iterator[None]:
    """Raise what a function did wrong in a compiled program in place of the error that came of it."""
    try:
        yield
    except AstroinertiaError:
        raise_failure()
        raise


def raise_failure() -> None:
    """Raise what a function did wrong in a compiled program first, if any did."""
    if FAILURES:
        first = FAILURES[0]
        FAILURES.clear()
        raise first from None
