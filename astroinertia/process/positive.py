"""Numbers of which nothing follows unless they are above zero."""

from typing import Any

import numpy as np


def require_positive(**named: Any) -> None:
    """ValueError names the first argument, a number or an array, that is not positive and finite throughout."""
    for name, value in named.items():
        numbers = np.asarray(value, dtype=float)
        wrong = numbers[~((numbers > 0) & (numbers < np.inf))]
        if wrong.size:
            raise ValueError(f"{name} must be positive and finite, not {wrong.flat[0]:g}")


def refuse_negative(**named: Any) -> None:
    """ValueError names the first argument, a number or an array, of which a part is negative; NaN passes."""
    for name, value in named.items():
        numbers = np.asarray(value, dtype=float)
        if (wrong := numbers[numbers < 0]).size:
            raise ValueError(f"{name} must not be negative, not {wrong.flat[0]:g}")


def positive_period(period: Any, name: str = "period") -> np.ndarray:
    """The period or periods as floats; ValueError names the argument where one of them is not above zero."""
    periods = np.asarray(period, dtype=float)
    if not np.all(periods > 0):
        raise ValueError(f"{name} must be above 0 s, not {periods[~(periods > 0)].flat[0]:g} s")
    return periods
