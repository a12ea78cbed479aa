"""Effects, and what an effect is made of, one of your own as one of this package.

    from astroinertia.effects import REQUIRED, Dimension, Effect, Option, positive, pytree

Nothing is imported until one of them is asked for. An example: sims/plugin_example/cubic_drag.py.
"""

from typing import TYPE_CHECKING

from astroinertia.process.lazy import exported

if TYPE_CHECKING:
    from astroinertia.effects.by_function import FluidState, RigidState
    from astroinertia.effects.characteristic import Characteristic
    from astroinertia.effects.effect import Effect
    from astroinertia.effects.entries import Entry
    from astroinertia.effects.measure import TURNS, ZONE, Found, Measure, Options, within_all
    from astroinertia.effects.parts import AffineParts, ParticleParts, RigidParts
    from astroinertia.engines.pytree import pytree
    from astroinertia.engines.terms import Output, PairTerm
    from astroinertia.units import REQUIRED, Dimension, Option, not_negative, positive

__all__ = [
    "REQUIRED", "TURNS", "ZONE", "AffineParts", "Characteristic", "Dimension", "Effect", "Entry", "FluidState", "Found",
    "Measure", "Option", "Options", "Output", "PairTerm", "ParticleParts", "RigidParts", "RigidState", "not_negative",
    "positive", "pytree", "within_all",
]  # fmt: skip

_MODULES = {
    "astroinertia.effects.effect": ("Effect",),
    "astroinertia.effects.entries": ("Entry",),
    "astroinertia.effects.characteristic": ("Characteristic",),
    "astroinertia.effects.parts": ("AffineParts", "ParticleParts", "RigidParts"),
    "astroinertia.effects.by_function": ("FluidState", "RigidState"),
    "astroinertia.units": ("REQUIRED", "Dimension", "Option", "not_negative", "positive"),
    "astroinertia.effects.measure": ("TURNS", "ZONE", "Found", "Measure", "Options", "within_all"),
    "astroinertia.engines.terms": ("Output", "PairTerm"),
    "astroinertia.engines.pytree": ("pytree",),
}
__getattr__ = exported(__name__, _MODULES)
