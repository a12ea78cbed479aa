"""Points where an effect is asked for its acceleration."""

from types import SimpleNamespace
from typing import Any

import numpy as np


def at(position: Any, velocity: Any = None, time: float = 0.0, mass: Any = None) -> SimpleNamespace:
    """As much of a fluid as a per-particle effect sees."""
    position = np.asarray(position, dtype=float)
    velocity = np.zeros_like(position) if velocity is None else np.asarray(velocity, dtype=float)
    mass = np.full(len(position), 1.0 / len(position)) if mass is None else mass
    return SimpleNamespace(
        time=time,
        mass=mass,
        position=position,
        velocity=velocity,
        centre=(mass @ position) / mass.sum(),
        centre_velocity=(mass @ velocity) / mass.sum(),
    )
