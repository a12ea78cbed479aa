"""Effects, and what an effect of your own is made of.

    from astroinertia.effects import REQUIRED, Dimension, Effect, Option, positive, pytree

Nothing is imported until one of them is asked for. An example: sims/plugin_example/cubic_drag.py.
"""

from typing import TYPE_CHECKING

from astroinertia.process.lazy import exported

if TYPE_CHECKING:
    from astroinertia.effects.affine_parts import AffineParts
    from astroinertia.effects.effect import Effect
    from astroinertia.effects.measure import Measure
    from astroinertia.effects.particle_parts import ParticleParts
    from astroinertia.effects.rigid_parts import RigidParts
    from astroinertia.engines.options import REQUIRED, Option, not_negative, positive
    from astroinertia.engines.pytree import pytree
    from astroinertia.engines.terms import Output, PairTerm
    from astroinertia.units import Dimension

__all__ = [
    "REQUIRED", "AffineParts", "Dimension", "Effect", "Measure", "Option", "Output", "PairTerm", "ParticleParts",
    "RigidParts", "not_negative", "positive", "pytree",
]  # fmt: skip

_MODULES = {
    "effects.effect": ("Effect",),
    "effects.particle_parts": ("ParticleParts",),
    "effects.affine_parts": ("AffineParts",),
    "effects.rigid_parts": ("RigidParts",),
    "engines.options": ("REQUIRED", "Option", "not_negative", "positive"),
    "effects.measure": ("Measure",),
    "engines.terms": ("Output", "PairTerm"),
    "engines.pytree": ("pytree",),
    "units": ("Dimension",),
}
__getattr__ = exported(__name__, _MODULES)
