"""The electrons of a scene's matter: effects that take some go by its table, where that is one over electron fractions.

Tests: tests/unit/scene/test_electron_axis.py.
"""

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from astroinertia.errors import SceneError
from astroinertia.scene.schema import Scene
from astroinertia.scene.source import file_of_scene
from astroinertia.units import CodeUnits

if TYPE_CHECKING:
    from astroinertia.matter.electron_axis import ElectronAxis


def in_matter(effect: Any, scene: Scene, units: CodeUnits) -> Any:
    """The effect as it is in the scene's matter; SceneError where several materials have electrons that it takes."""
    fluid: Any = scene.equation_of_state
    fractions = effect.electron_fractions
    if fractions is None or fluid is None or fluid.kind != "materials":
        return effect
    tables = [material for material in fluid.materials if material.electron_fraction is not None]
    if len(tables) > 1:
        raise SceneError(
            f"{scene.where_listed(effect.kind)} follows the electrons of one material, not of {len(tables)}."
        )
    if not tables:
        return effect
    axis = _axis(file_of_scene(scene.origin, str(tables[0].file)), tables[0].reference_density, fractions)
    return effect.on_axis(axis, units)


@lru_cache(maxsize=4)
def _axis(path: Path, reference_density: float, fractions: tuple[float, float]) -> "ElectronAxis":
    from astroinertia.matter.electron_axis import electron_axis  # with scipy, which other scenes do without

    return electron_axis(path, reference_density, fractions)
