"""The signals between particles that limit their steps, as the effects pressure and viscosity have them."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from astroinertia.effects.kinds.viscosity import Side, closing, damped

LEAST = 1e-30  # of what something is divided by


def fastest(
    rate: np.ndarray,
    sound: np.ndarray,
    viscosity: Mapping[str, Any] | None,
    alpha: np.ndarray | float = 0.0,
    linear: np.ndarray | float = 0.0,
    trusted: np.ndarray | float = 1.0,
) -> np.ndarray:
    """The signal speed of pairs that part at some rate (negative: approach), and have a mean speed of sound.

    viscosity: its options, None without it; alpha: its strength. linear: the rate that the flow's gradient alone
    accounts for, of which reconstruction takes out as much as is trusted, from 0 to 1.
    """
    signal = sound + np.abs(rate)
    if viscosity is None:
        return signal
    inward = np.minimum(rate, 0.0)
    linear = linear if "reconstruction" in viscosity["limiter"] else 0.0
    side = Side(0.0, 0.5, sound, alpha * sound, alpha * viscosity["beta"])
    return np.maximum(signal, damped(np, inward, closing(np, 1.0, rate, 2.0 * linear, trusted), side, side)[2])
