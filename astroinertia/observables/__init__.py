"""What an observable of your own is made of.

    from astroinertia.observables import Dimension, Observable, Option, positive

Nothing is imported until one of them is asked for. An example: sims/plugin_example/quadrupole_phase.py.
"""

from typing import TYPE_CHECKING

from astroinertia.process.lazy import exported

if TYPE_CHECKING:
    from astroinertia.observables.observable import Observable
    from astroinertia.observables.quantities import BodyState
    from astroinertia.units import REQUIRED, Dimension, Option, not_negative, positive

__all__ = ["REQUIRED", "BodyState", "Dimension", "Observable", "Option", "not_negative", "positive"]

_MODULES = {
    "astroinertia.observables.observable": ("Observable",),
    "astroinertia.observables.quantities": ("BodyState",),
    "astroinertia.units": ("REQUIRED", "Dimension", "Option", "not_negative", "positive"),
}
__getattr__ = exported(__name__, _MODULES)
