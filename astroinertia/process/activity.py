"""What a process is busy with for a while, such as compiling a pass: for whoever shows how far its run is.

Tests: tests/unit/process/test_activity.py, tests/unit/run/test_meter.py.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

listeners: list[Callable[[int], None]] = []
"""Called with 1 as something begins, and with -1 as it ends."""
_under_way: list[str] = []  # the outermost first; threads only add and remove


def current() -> str:
    """The outermost of what is being done, in words; empty if nothing is.

    >>> begin("compiling a pass")
    >>> print(current())
    compiling a pass
    >>> end("compiling a pass")
    """
    return next(iter(tuple(_under_way)), "")


def begin(words: str) -> None:
    """It is being done from now on, until `end`."""
    _under_way.append(words)
    for listener in listeners:
        listener(1)


def end(words: str) -> None:
    """It is over."""
    _under_way.remove(words)
    for listener in listeners:
        listener(-1)


@contextmanager
def under_way(words: str) -> Iterator[None]:
    """Meanwhile it is being done.

    >>> with under_way("integrating an orbit"):
    ...     print(current())
    integrating an orbit
    """
    begin(words)
    try:
        yield
    finally:
        end(words)
