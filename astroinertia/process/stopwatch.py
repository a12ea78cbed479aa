"""How long parts of a run take: functions are watched while somebody wants to know, and are as they were afterwards."""

import functools
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Seconds:
    """A time by the clock on the wall, and the processor time of all threads together."""

    wall: float = 0.0
    processor: float = 0.0

    def __add__(self, other: "Seconds") -> "Seconds":
        return Seconds(self.wall + other.wall, self.processor + other.processor)

    def __mul__(self, factor: float) -> "Seconds":
        return Seconds(self.wall * factor, self.processor * factor)

    __rmul__ = __mul__


def total(times: Iterable[Seconds]) -> Seconds:
    """The sum of times.

    >>> total([Seconds(1.0, 1.5), Seconds(2.0, 3.0)])
    Seconds(wall=3.0, processor=4.5)
    """
    return sum(times, start=Seconds())


def less(whole: Seconds, part: Seconds) -> Seconds:
    """What is left of a time without a part of it; nothing where noise made the part longer.

    >>> less(Seconds(3.0, 4.0), Seconds(1.0, 5.0))
    Seconds(wall=2.0, processor=0.0)
    """
    return Seconds(max(0.0, whole.wall - part.wall), max(0.0, whole.processor - part.processor))


def now() -> tuple[float, float]:
    """The clock on the wall and that of the processor."""
    return time.perf_counter(), time.process_time()


def since(begin: tuple[float, float]) -> Seconds:
    """What has passed on both since `now`."""
    wall, processor = now()
    return Seconds(wall - begin[0], processor - begin[1])


class Stopwatch:
    """Sums up the times of parts by their names, each without what is counted as others meanwhile.

    around: names of parts within which others are counted by themselves; within any other part they are its own.
    """

    def __init__(self, *around: str) -> None:
        self.seconds: dict[str, Seconds] = defaultdict(Seconds)
        self._around, self._part = (None, *around), None

    def timed(self, name: str, action: Callable[[], Any]) -> Any:
        """What the action returns."""
        if self._part not in self._around:
            return action()
        before, begin, counted = self._part, now(), total(self.seconds.values())
        self._part = name
        try:
            return action()
        finally:
            self._part = before
            meanwhile = less(total(self.seconds.values()), counted)
            self.seconds[name] += less(since(begin), meanwhile)


Places = dict[tuple[Any, str], str | Callable[..., str]]
"""What is watched: {(class or module, name of a function): what the part is called, or that by its arguments}."""


@contextmanager
def watched(watch: Stopwatch, places: Places) -> Iterator[None]:
    """Within, calls of functions are timed; an empty name is no part."""
    kept = [(owner, name, vars(owner).get(name)) for owner, name in places]
    for (owner, name), part in places.items():
        setattr(owner, name, _timed(watch, getattr(owner, name), part))
    try:
        yield
    finally:
        for owner, name, before in reversed(kept):
            if before is None:  # its base class has it
                delattr(owner, name)
            else:
                setattr(owner, name, before)


def _timed(watch: Stopwatch, function: Callable, part: str | Callable[..., str]) -> Callable:
    @functools.wraps(function)
    def called(*arguments: Any, **named: Any) -> Any:
        name = part if isinstance(part, str) else part(*arguments, **named)
        action = functools.partial(function, *arguments, **named)
        return watch.timed(name, action) if name else action()

    return called
