"""What an equation of state of your own is made of.

    from astroinertia.matter import REQUIRED, Dimension, Matter, Option, positive, pytree

Nothing is imported until one of them is asked for. An example: sims/plugin_example/logotrope.py.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from astroinertia.effects.entries import REQUIRED, Option, not_negative, positive
    from astroinertia.engines.pytree import pytree
    from astroinertia.matter.equation import Matter
    from astroinertia.units import Dimension

__all__ = ["REQUIRED", "Dimension", "Matter", "Option", "not_negative", "positive", "pytree"]

_ROOMS = {
    "matter.equation": ("Matter",),
    "effects.entries": ("REQUIRED", "Option", "not_negative", "positive"),
    "engines.pytree": ("pytree",),
    "units": ("Dimension",),
}


def __getattr__(name: str) -> Any:
    for room, names in _ROOMS.items():
        if name in names:
            return getattr(import_module(f"astroinertia.{room}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
