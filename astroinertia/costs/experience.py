"""What was done on this machine before and need not be done again: compiled loops, bodies placed and settled.

Marks in the user's cache, beside what they tell of. They save a prediction from importing an engine to find out.
"""

import os
from importlib.metadata import version
from typing import Any

import numpy as np

from astroinertia.process.kept_programs import processor
from astroinertia.scene.plan import gravity_method
from astroinertia.scene.schema import Scene
from astroinertia.storage import cache

_VERSION = 1  # part of the keys: raise it when what they depend on changes


def compiled(scene: Scene) -> bool:
    """Whether loops for these effects, kernel and precision have been compiled.

    By this version, for this processor, and where numba looks for them now: others are of no use.
    """
    return cache.load("compiled", _loops(scene)) is not None


def placed(scene: Scene) -> bool:
    """Whether these bodies have been placed, and settled where they are to be."""
    return cache.load("placed", _bodies(scene)) is not None


def note(scene: Scene) -> None:
    """Particles have been run: their loops are compiled now, and their bodies kept."""
    if scene.model == "sph":
        cache.save("compiled", _loops(scene), {"done": np.ones(1)})
        cache.save("placed", _bodies(scene), {"done": np.ones(1)})


def _loops(scene: Scene) -> str:
    numerics = scene.numerics
    choices = {
        kind: sorted(
            (name, value) for name, value in options.items() if isinstance(value, str | bool) and name != "method"
        )
        for kind, options in scene.effects.items()
    }
    fluid: Any = scene.equation_of_state
    attraction = ""
    if "gravity" in scene.effects and scene.particles is not None:
        attraction = gravity_method(scene, scene.particles)
    return cache.content_key(
        effects=sorted(choices.items()), attraction=attraction, kernel=numerics.kernel, precision=scene.precision,
        timesteps=numerics.timesteps, box=scene.box is not None, matter=fluid.kind, engine=numerics.engine,
        versions=[version(package) for package in ("astroinertia", "numba", "numpy")], processor=processor(),
        place=os.environ.get("NUMBA_CACHE_DIR", ""), marks=_VERSION,
    )  # fmt: skip


def _bodies(scene: Scene) -> str:
    numerics: Any = scene.numerics
    settling = {kind: sorted(scene.effects[kind].items()) for kind in ("gravity", "pressure") if kind in scene.effects}
    return cache.content_key(
        bodies=[repr(alone.body) for alone in scene.alone()], matter=repr(scene.equation_of_state),
        settling=repr(settling),
        numerics=[numerics.kernel, numerics.eta, numerics.neighbours, numerics.smoothing_tolerance], marks=_VERSION,
    )  # fmt: skip
