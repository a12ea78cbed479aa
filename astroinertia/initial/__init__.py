"""What an initial body of your own is made of.

    from astroinertia.initial import REQUIRED, Body, Dimension, Option, positive

Nothing is imported until one of them is asked for. An example: sims/plugin_example/torus.py.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from astroinertia.effects.entries import REQUIRED, Option, not_negative, positive
    from astroinertia.initial.placed import Body
    from astroinertia.units import Dimension

__all__ = ["REQUIRED", "Body", "Dimension", "Option", "not_negative", "positive"]

_ROOMS = {
    "initial.placed": ("Body",),
    "effects.entries": ("REQUIRED", "Option", "not_negative", "positive"),
    "units": ("Dimension",),
}


def __getattr__(name: str) -> Any:
    for room, names in _ROOMS.items():
        if name in names:
            return getattr(import_module(f"astroinertia.{room}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
