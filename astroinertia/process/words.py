"""How numbers, tables of text and what others say are said."""

import math
from collections.abc import Sequence

_MINUTE, _HOUR, _DAY = 60.0, 3600.0, 86400.0
_MANY = 1e6  # times as many of something, of which nobody asks how many


def duration(seconds: float) -> str:
    """A length of time as it is said.

    >>> print(duration(7200.0), duration(0.0123))
    2 h 12 ms
    """
    if not math.isfinite(seconds):
        return "an unknown time"
    for length, unit in ((_DAY, "d"), (_HOUR, "h"), (_MINUTE, "min"), (1.0, "s")):
        if seconds >= length:
            return _said(seconds / length, unit)
    return _said(1e3 * seconds, "ms")


def size(number: float) -> str:
    """A number of bytes as it is said.

    >>> print(size(2.5e6), size(1.4e11))
    2.5 MB 140 GB
    """
    for scale, unit in ((1e9, "GB"), (1e6, "MB")):
        if number >= scale:
            return _said(number / scale, unit)
    return _said(number / 1e3, "kB")


def times_as_many(wanted: float, had: float = 1.0) -> str:
    """How many times as many are needed, rounded up to two digits.

    >>> print(times_as_many(116.0, 20.0), "and", times_as_many(521_252.0))
    about 6 times as many and about 530000 times as many
    """
    if not wanted < _MANY * had:
        return "many times as many"
    factor = wanted / had
    step = 10 ** max(0, len(str(math.ceil(factor))) - 2)
    return f"about {math.ceil(factor / step) * step} times as many"


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """A line for each row of a table, its columns below each other.

    >>> print("\\n".join(aligned([("body", "radius"), ("Mars", "3389.5 km")])))
    body  radius
    Mars  3389.5 km
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def clause(sentence: str) -> str:
    """What another library says, as the end of a sentence.

    >>> print(f"this is not TOML ({clause('Unclosed array.')})")
    this is not TOML (unclosed array)
    """
    return sentence[:1].lower() + sentence[1:].rstrip(".")


def _said(number: float, unit: str) -> str:
    return f"{number:.2g} {unit}" if number < 99.5 else f"{number:.0f} {unit}"
