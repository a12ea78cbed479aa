"""Effects, and what an effect of your own is made of.

    from astroinertia.effects import REQUIRED, Dimension, Effect, Option, positive, pytree

Nothing is imported until one of them is asked for. An example: sims/plugin_example/cubic_drag.py.
"""

from typing import TYPE_CHECKING

from astroinertia.process.lazy import exported

if TYPE_CHECKING:
    from astroinertia.effects.affine_parts import AffineParts
    from astroinertia.effects.by_function import FluidState, RigidState
    from astroinertia.effects.effect import Effect
    from astroinertia.effects.measure import Measure
    from astroinertia.effects.particle_parts import ParticleParts
    from astroinertia.effects.rigid_parts import RigidParts
    from astroinertia.engines.pytree import pytree
    from astroinertia.engines.terms import Output, PairTerm
    from astroinertia.units import REQUIRED, Dimension, Option, not_negative, positive

__all__ = [
    "REQUIRED", "AffineParts", "Dimension", "Effect", "FluidState", "Measure", "Option", "Output", "PairTerm",
    "ParticleParts", "RigidParts", "RigidState", "not_negative", "positive", "pytree",
]  # fmt: skip

_MODULES = {
    "astroinertia.effects.effect": ("Effect",),
    "astroinertia.effects.particle_parts": ("ParticleParts",),
    "astroinertia.effects.affine_parts": ("AffineParts",),
    "astroinertia.effects.by_function": ("FluidState", "RigidState"),
    "astroinertia.effects.rigid_parts": ("RigidParts",),
    "astroinertia.units": ("REQUIRED", "Dimension", "Option", "not_negative", "positive"),
    "astroinertia.effects.measure": ("Measure",),
    "astroinertia.engines.terms": ("Output", "PairTerm"),
    "astroinertia.engines.pytree": ("pytree",),
}
__getattr__ = exported(__name__, _MODULES)
