"""Values of one parameter of a [sweep]: a list, a range, or a distribution that samples are drawn from.

Tests: tests/unit/scene/test_sweep.py.
"""

import difflib
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.scene.dimensional import described, fraction
from astroinertia.scene.problems import nearest
from astroinertia.scene.text import toml_value
from astroinertia.units import any_quantity, shown

MOST_MEMBERS = 10_000
RANGE = ("start", "stop", "number", "scale")
DISTRIBUTIONS = ("uniform", "log_uniform", "normal", "integers")
SCALES = ("linear", "log")
_DIGITS = 15  # of values between two ends: those that every float64 has
_NUMBER = re.compile(r"(?<![\w.])\d+\.\d+(?:[eE][+-]?\d+)?")
_WITH_UNIT = re.compile(r"\s*([+-]?[0-9.]+(?:[eE][+-]?\d+)?)\s*(\S.*?)?\s*")


def is_rule(value: Any) -> bool:
    """Whether a table is a range or a distribution, perhaps misspelt, rather than a part of a scene's path."""
    keys = (*RANGE, *DISTRIBUTIONS)
    return isinstance(value, dict) and any(difflib.get_close_matches(key, keys, n=1, cutoff=0.75) for key in value)


def is_distribution(value: Any) -> bool:
    """Whether a rule is a distribution."""
    return isinstance(value, dict) and not any(key in RANGE for key in value)


def listed(value: Any) -> list[Any]:
    """The values of a list or a range; SceneError continues a sentence that begins with the parameter."""
    if isinstance(value, dict):
        return _of_range(value)
    if not isinstance(value, list):
        raise SceneError(
            f"must be a list of values, a range (start, stop, number) or, with samples, a distribution "
            f"({', '.join(DISTRIBUTIONS)}), not {described(value)}."
        )
    if not value:
        raise SceneError("must be a list with at least one value.")
    if len(value) > MOST_MEMBERS:
        raise SceneError(f"has {len(value)} values, more than the {MOST_MEMBERS} members that a sweep may have.")
    seen: set[Any] = set()
    for item in value:
        text, number = value_text(item), fraction(item)
        plain = isinstance(number, int | float) and not isinstance(number, bool)
        one = number if plain else (any_quantity(item) if isinstance(item, str) else None) or text
        if one in seen:
            raise SceneError(f"has the value {shown(text)} twice.")
        seen.add(one)
    return value


def short_text(value: Any) -> str:
    """A value as tables and labels show it: what stands in the scene, with its numbers to six digits.

    >>> print(short_text("3.16227766016838 s"), short_text(100.0))
    3.16228 s 100
    """
    return _NUMBER.sub(lambda found: f"{float(found[0]):.6g}", str(value))


def value_text(value: Any) -> str:
    """A value as TOML; SceneError for a date or time, which no scene holds."""
    try:
        return toml_value(value)
    except TypeError:
        raise SceneError("holds a date or time, which no key of a scene takes.") from None


def _of_range(rule: Mapping[str, Any]) -> list[Any]:
    for key in rule:
        if key not in RANGE:
            raise SceneError(f"has '{shown(key)}', which no range has; {nearest(key, RANGE)}")
    missing = [key for key in RANGE[:3] if key not in rule]
    if missing:
        raise SceneError(f"is a range, in which {missing[0]} is missing.")
    number, scale = rule["number"], rule.get("scale", "linear")
    if isinstance(number, bool) or not isinstance(number, int) or not 2 <= number <= MOST_MEMBERS:
        raise SceneError(f"has a number of {described(number)}, but must have a whole one from 2 to {MOST_MEMBERS}.")
    if scale not in SCALES:
        raise SceneError(f"has a scale of {described(scale)}, but must have one of {', '.join(SCALES)}.")
    (start, stop), unit, whole = _ends([rule["start"], rule["stop"]])
    if start == stop:
        raise SceneError("begins where it ends.")
    if scale == "log" and not (start > 0.0 and stop > 0.0):
        raise SceneError("is logarithmic, so its ends must be positive.")
    values = (np.linspace if scale == "linear" else np.geomspace)(start, stop, number)
    return [_written(float(value), unit, whole) for value in values]


def drawn(rule: Mapping[str, Any], shares: np.ndarray) -> list[Any]:
    """Values of a distribution at shares (samples,) of its probability, each between 0 and 1.

    uniform, log_uniform: from one end to the other; normal: mean and standard deviation; integers: both ends included.
    SceneError continues a sentence that begins with the parameter.
    """
    (kind, numbers), *more = rule.items()
    if more:
        raise SceneError(f"has both {kind} and {more[0][0]}; keep one.")
    if kind not in DISTRIBUTIONS:
        raise SceneError(f"has '{shown(kind)}', which is no distribution; {nearest(kind, DISTRIBUTIONS)}")
    if not isinstance(numbers, list) or len(numbers) != 2:
        raise SceneError(f"has {kind}, which must be a list of two values.")
    (first, second), unit, whole = _ends(numbers)
    if kind == "normal":
        if not second > 0.0:
            raise SceneError("has a standard deviation (the second value of normal) that is not positive.")
        from scipy.special import ndtri

        values = first + second * ndtri(shares)
    elif not first < second:
        raise SceneError(f"has {kind}, whose first value must be less than its second.")
    elif kind == "integers":
        if not whole:
            raise SceneError("has integers, whose ends must be whole numbers.")
        return [int(first + math.floor(share * (second - first + 1))) for share in shares]
    elif kind == "log_uniform":
        if not first > 0.0:
            raise SceneError("has log_uniform, whose ends must be positive.")
        values = np.exp(math.log(first) + (math.log(second) - math.log(first)) * shares)
    else:
        values = first + (second - first) * shares
    return [_written(float(value), unit, False) for value in values]


def _ends(ends: Sequence[Any]) -> tuple[list[float], str, bool]:
    """Two numbers, their unit (empty for plain ones), and whether both are whole plain numbers."""
    numbers, units = [], []
    for item in ends:
        quantity = _WITH_UNIT.fullmatch(item) if isinstance(item, str) and any_quantity(item) else None
        if quantity is None and (isinstance(item, bool) or not isinstance(item, int | float)):
            raise SceneError(f"must go between two numbers or two quantities, not {described(item)}.")
        try:
            numbers.append(float(item) if quantity is None else float(quantity[1]))
        except OverflowError:
            raise SceneError("must go between finite numbers.") from None
        units.append("" if quantity is None else quantity[2])
    if not all(math.isfinite(number) for number in numbers):
        raise SceneError("must go between finite numbers.")
    if units[0] != units[1]:
        raise SceneError(f"goes from '{shown(str(ends[0]))}' to '{shown(str(ends[1]))}': give both in the same unit.")
    return numbers, units[0], all(isinstance(item, int) for item in ends)


def _written(value: float, unit: str, whole: bool) -> Any:
    rounded = float(f"{value:.{_DIGITS}g}")
    if unit:
        return f"{rounded!r} {unit}"
    return int(rounded) if whole and rounded.is_integer() else rounded


def scaled(value: Any, factor: float) -> Any:
    """A number or a quantity, in the unit it has, times a factor; SceneError continues a sentence of its key.

    >>> print(scaled("3 km", 1.01))
    3.03 km
    """
    number, unit = number_and_unit(value)
    if number == 0.0:
        raise SceneError("is 0, which a relative step does not move.")
    return _written(number * factor, unit, False)


def number_and_unit(value: Any) -> tuple[float, str]:
    """A number or a quantity as it is written; the unit of a number is "". SceneError continues a sentence of its key.

    >>> print(number_and_unit("3 km"))
    (3.0, 'km')
    """
    (number, _), unit, _ = _ends([value, value])
    return number, unit


def coordinate(values: Sequence[Any]) -> tuple[np.ndarray, str | None]:
    """Values of a parameter as an array: in SI with their unit, or as texts (None) where they are no numbers."""
    values = [fraction(item) for item in values]
    if all(isinstance(item, int | float) and not isinstance(item, bool) for item in values):
        return np.array([float(item) for item in values]), "1"
    pairs = [any_quantity(item) if isinstance(item, str) else None for item in values]
    if None not in pairs and len({pair[1] for pair in pairs if pair}) == 1:
        return np.array([pair[0] for pair in pairs if pair]), next(pair[1] for pair in pairs if pair)
    return np.array([item if isinstance(item, str) else toml_value(item) for item in values], dtype=object), None
