"""The signals between particles that limit their steps, as effects.pressure and effects.viscosity have them."""

from collections.abc import Mapping
from typing import Any

import numpy as np

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
    approach = np.minimum(rate, 0.0)
    if "reconstruction" in viscosity["limiter"]:
        approach = np.minimum(np.maximum(rate - trusted * linear, rate), 0.0)
    drag = alpha * (sound - viscosity["beta"] * approach)
    return np.maximum(signal, sound - np.minimum(rate, 0.0) + drag)


def agreement(mine: np.ndarray, other: np.ndarray) -> np.ndarray:
    """van Leer's limiter: 1 where both sides see the same gradient, 0 where they see opposite ones."""
    return np.maximum(4.0 * mine * other / ((mine + other) ** 2 + LEAST), 0.0)
