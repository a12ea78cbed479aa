"""How the fluid of a scene moves at first: its rotation and its linear flow, in code units."""

from typing import Any

import numpy as np

from astroinertia.build.spheres import Sphere, Star
from astroinertia.build.spin import rotation_amount
from astroinertia.errors import SceneError
from astroinertia.scene.schema import Scene
from astroinertia.sph import profiles
from astroinertia.sph.progenitor import Progenitor
from astroinertia.sph.rotation import linear_velocity, rotation_velocity
from astroinertia.units import CodeUnits


def initial_velocity(
    scene: Scene, units: CodeUnits, initial: Sphere | Star | None, mass: np.ndarray, position: np.ndarray
) -> np.ndarray:
    """Velocities (N, 3) of the scene's rotation and linear flow at positions (N, 3), not settled."""
    return linear_flow(scene, units, position) + rotation_flow(scene, units, initial, mass, position)


def own_expansion(scene: Scene, units: CodeUnits) -> float:
    """The rate v/r of a body's own flow, negative where it collapses; nothing for most."""
    body: Any = scene.body
    if not body.homologous:
        return 0.0
    return body.expansion(units.to_code(body.mass, "mass"), units.to_code(body.radius, "length"))


def linear_flow(scene: Scene, units: CodeUnits, position: np.ndarray) -> np.ndarray:
    """Velocities (N, 3) of the scene's velocity_gradient, and of a collapse, at positions (N, 3)."""
    own, gradient = own_expansion(scene, units) * position, scene.body.velocity_gradient
    if gradient is None:
        return own
    return own + linear_velocity(position, units.to_code(np.array(gradient), "velocity_gradient"))


def rotation_flow(
    scene: Scene, units: CodeUnits, initial: Sphere | Star | None, mass: np.ndarray, position: np.ndarray
) -> np.ndarray:
    """Velocities (N, 3) of the scene's rotation at positions (N, 3)."""
    body: Any = scene.body
    spin, binding = body.rotation, None
    if spin is None:
        return np.zeros_like(position)
    if isinstance(initial, Sphere) and "gravity" in scene.effects:
        semi_axes = initial.radius * np.asarray(body.axes)
        binding = profiles.ellipsoid_gravitational_energy(initial.profile, initial.mass, semi_axes)
    scale = None if spin.scale is None else units.to_code(spin.scale, "length")
    amount = rotation_amount(scene, units, binding is not None)
    try:
        return rotation_velocity(mass, position, spin.law, spin.direction, scale, binding, **amount)
    except ValueError as error:
        raise SceneError(f"[body.rotation] {error}.") from None


def flow_of_shells(
    scene: Scene, units: CodeUnits, initial: Sphere, mass: np.ndarray, position: np.ndarray, where: np.ndarray
) -> np.ndarray:
    """Velocities (N, 3) of the scene's rotation or, where it gives none, of shells that have one; `where`: r/R (N,)."""
    body: Any = scene.body
    if initial.shells is not None and body.rotation is None:
        return _shellular_rotation(initial.shells, where, position, body.rotation_factor, units)
    return rotation_flow(scene, units, initial, mass, position)


def _shellular_rotation(
    shells: Progenitor, where: np.ndarray, position: np.ndarray, factor: float, units: CodeUnits
) -> np.ndarray:
    """Velocities (N, 3) of shells that each turn rigidly about z, at r/R `where` (N,); at rest where none is given."""
    if shells.angular_velocity is None:
        return np.zeros_like(position)
    rate = factor * shells.at(units.to_code(shells.angular_velocity, "angular_velocity"), where)
    return rate[:, None] * np.cross([0.0, 0.0, 1.0], position)
