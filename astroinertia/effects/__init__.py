"""Effects, and what an effect of your own is made of.

    from astroinertia.effects import REQUIRED, Dimension, Effect, Option, positive, pytree

Nothing is imported until one of them is asked for. An example: sims/plugin_example/cubic_drag.py.
"""

from typing import TYPE_CHECKING

from astroinertia.process.lazy import exported

if TYPE_CHECKING:
    from astroinertia.effects.effect import Effect
    from astroinertia.effects.entries import REQUIRED, Option, not_negative, positive
    from astroinertia.effects.measure import Measure
    from astroinertia.engines.pytree import pytree
    from astroinertia.engines.terms import Output, PairTerm
    from astroinertia.units import Dimension

__all__ = [
    "REQUIRED", "Dimension", "Effect", "Measure", "Option", "Output", "PairTerm", "not_negative", "positive", "pytree",
]  # fmt: skip

_MODULES = {
    "effects.effect": ("Effect",),
    "effects.entries": ("REQUIRED", "Option", "not_negative", "positive"),
    "effects.measure": ("Measure",),
    "engines.terms": ("Output", "PairTerm"),
    "engines.pytree": ("pytree",),
    "units": ("Dimension",),
}
__getattr__ = exported(__name__, _MODULES)
