"""What an equation of state of your own is made of.

    from astroinertia.matter import REQUIRED, Dimension, Matter, Option, positive, pytree

Nothing is imported until one of them is asked for. An example: sims/plugin_example/logotrope.py.
"""

from typing import TYPE_CHECKING

from astroinertia.process.lazy import exported

if TYPE_CHECKING:
    from astroinertia.engines.pytree import pytree
    from astroinertia.matter.equation import Matter
    from astroinertia.units import REQUIRED, Dimension, Option, not_negative, positive

__all__ = ["REQUIRED", "Dimension", "Matter", "Option", "not_negative", "positive", "pytree"]

_MODULES = {
    "astroinertia.matter.equation": ("Matter",),
    "astroinertia.units": ("REQUIRED", "Dimension", "Option", "not_negative", "positive"),
    "astroinertia.engines.pytree": ("pytree",),
}
__getattr__ = exported(__name__, _MODULES)
