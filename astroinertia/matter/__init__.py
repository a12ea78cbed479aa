"""What an equation of state of your own is made of.

    from astroinertia.matter import REQUIRED, Dimension, Matter, Option, positive, pytree

Nothing is imported until one of them is asked for. An example: sims/plugin_example/logotrope.py.
"""

from typing import TYPE_CHECKING

from astroinertia.process.lazy import exported

if TYPE_CHECKING:
    from astroinertia.engines.options import REQUIRED, Option, not_negative, positive
    from astroinertia.engines.pytree import pytree
    from astroinertia.matter.equation import Matter
    from astroinertia.units import Dimension

__all__ = ["REQUIRED", "Dimension", "Matter", "Option", "not_negative", "positive", "pytree"]

_MODULES = {
    "matter.equation": ("Matter",),
    "engines.options": ("REQUIRED", "Option", "not_negative", "positive"),
    "engines.pytree": ("pytree",),
    "units": ("Dimension",),
}
__getattr__ = exported(__name__, _MODULES)
