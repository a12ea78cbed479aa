"""What was done on this machine before and need not be done again: compiled loops, bodies placed and settled.

Marks in the user's cache, beside what they tell of. They save a prediction from importing an engine to find out.
"""

import os
from importlib.metadata import version
from typing import Any

import numpy as np

from astroinertia.engines.few import FEW
from astroinertia.process.kept_programs import processor
from astroinertia.scene.plan import gravity_method
from astroinertia.scene.schema import Scene
from astroinertia.storage import cache

_VERSION = 3  # part of the keys: raise it when what they depend on changes
_OF_NO_EFFECT = 2.0  # what neighbours, densities and multipoles take to compile, over what an effect takes


def left_to_compile(scene: Scene) -> float:
    """The share of the loops for these effects, kernel and precision that has not been compiled, 0 to 1.

    By this version, for this processor, and where numba looks for them now: others are of no use.
    """
    loops = programs(scene)
    left = sum(weight for key, weight in loops.items() if cache.load("compiled", key) is None)
    return left / sum(loops.values())


def placed(scene: Scene) -> bool:
    """Whether these bodies have been placed, and settled where they are to be."""
    return cache.load("placed", _bodies(scene)) is not None


def note(scene: Scene) -> None:
    """Particles have been run: their loops are compiled now, and their bodies kept."""
    if scene.model == "sph":
        for key in programs(scene):
            cache.save("compiled", key, {"done": np.ones(1)})
        cache.save("placed", _bodies(scene), {"done": np.ones(1)})


def few(scene: Scene) -> bool:
    """Whether a scene's particles are few, which have programs of their own."""
    return scene.particles is not None and scene.particles <= FEW and scene.precision == "float64"


def programs(scene: Scene) -> dict[str, float]:
    """Keys of what is compiled apart, and how much it is: by effect and precision (records are in float64).

    >>> from astroinertia.scene import load
    >>> small, large = (load.load_file("sims/evrard.toml", [f"body.particles={n}"]) for n in (1000, 1001))
    >>> print(programs(small).keys() & programs(large).keys())  # few particles have programs of their own
    set()
    """
    numerics, fluid = scene.numerics, scene.equation_of_state
    common: dict[str, Any] = {
        "kernel": numerics.kernel, "engine": numerics.engine, "box": scene.box is not None, "few": few(scene),
        "processor": processor(),
        "versions": [version(package) for package in ("astroinertia", "numba", "numpy")],
        "place": os.environ.get("NUMBA_CACHE_DIR", ""), "marks": _VERSION,
    }  # fmt: skip
    attraction = ""
    if "gravity" in scene.effects and scene.particles is not None:
        attraction = gravity_method(scene, scene.particles)
    loops = {}
    for precision in {"float64", scene.precision}:
        loops[cache.content_key(attraction=attraction, precision=precision, **common)] = _OF_NO_EFFECT
        for kind, options in scene.effects.items():
            choices = sorted(
                (name, value) for name, value in options.items() if isinstance(value, str | bool) and name != "method"
            )
            loops[cache.content_key(effect=kind, choices=choices, precision=precision, **common)] = 1.0
    matter = None if fluid is None else fluid.kind
    loops[cache.content_key(matter=matter, timesteps=numerics.timesteps, **common)] = 1.0
    return loops


def _bodies(scene: Scene) -> str:
    numerics: Any = scene.numerics
    settling = {kind: sorted(scene.effects[kind].items()) for kind in ("gravity", "pressure") if kind in scene.effects}
    return cache.content_key(
        bodies=[repr(alone.body) for alone in scene.alone()], matter=repr(scene.equation_of_state),
        settling=repr(settling),
        numerics=[numerics.kernel, numerics.eta, numerics.neighbours, numerics.smoothing_tolerance, scene.precision],
        marks=_VERSION,
    )  # fmt: skip
