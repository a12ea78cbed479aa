"""What an initial body of your own is made of.

    from astroinertia.initial import REQUIRED, Body, Dimension, Option, positive

Nothing is imported until one of them is asked for. An example: sims/plugin_example/torus.py.
"""

from typing import TYPE_CHECKING

from astroinertia.process.lazy import exported

if TYPE_CHECKING:
    from astroinertia.sph.placed import Body
    from astroinertia.units import REQUIRED, Dimension, Option, not_negative, positive

__all__ = ["REQUIRED", "Body", "Dimension", "Option", "not_negative", "positive"]

_MODULES = {
    "astroinertia.sph.placed": ("Body",),
    "astroinertia.units": ("REQUIRED", "Dimension", "Option", "not_negative", "positive"),
}
__getattr__ = exported(__name__, _MODULES)
