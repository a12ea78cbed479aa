"""What effects add to the pressure of matter, of a scene that is not yet built."""

from collections.abc import Callable

import numpy as np

from astroinertia.effects import catalogue
from astroinertia.scene.dimensional import options_in_code_units
from astroinertia.scene.electron_axis import in_matter
from astroinertia.scene.scales import code_units
from astroinertia.scene.schema import Scene


def further_pressure(scene: Scene) -> Callable[[np.ndarray], np.ndarray] | None:
    """The sum of what they add at densities (K,), in code units; None where no effect of the scene adds any."""
    units, effects = code_units(scene), []
    for kind, options in scene.effects.items():
        if scene.entries[kind].presses:
            options = options_in_code_units(options, scene.entries[kind].options, units)
            try:
                effects.append(in_matter(catalogue.build(kind, options, scene.entries).in_units(units), scene, units))
            except ValueError:  # units are missing, which the build says
                return None
    return (lambda density: sum(effect.further_pressure(np, density) for effect in effects)) if effects else None  # type: ignore
