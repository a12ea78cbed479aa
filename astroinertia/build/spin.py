"""What bodies without particles take from a scene alike: how fast it turns, about which axis, and its moments."""

import math
from typing import Any

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.scene.schema import Scene
from astroinertia.units import CodeUnits


def rotation_axis(scene: Scene) -> np.ndarray:
    """The axis of the rotation, a unit vector (3,); z where the body does not turn."""
    rotation = scene.body.rotation
    along = np.array([0.0, 0.0, 1.0] if rotation is None else rotation.direction, dtype=float)
    return along / np.linalg.norm(along)


def rotation_amount(scene: Scene, units: CodeUnits, weighs: bool) -> dict[str, float]:
    """The one measure of the rotation that a scene gives: rate (also for a period or a share of break-up),
    angular_momentum or t_over_w; nothing for a body at rest.

    weighs: whether the body has self-gravity. SceneError for t_over_w without it.
    """
    spin = scene.body.rotation
    if spin is None:
        return {}
    if spin.period is not None:
        return {"rate": 2 * math.pi / units.to_code(spin.period, "time")}
    if spin.t_over_w is not None:
        if not weighs:
            raise SceneError("[body.rotation] rotation t_over_w needs a self-gravitating body.")
        return {"t_over_w": spin.t_over_w}
    if spin.breakup_fraction is not None:
        return {"rate": breakup_rate(scene, units)}
    if spin.rate is not None:
        return {"rate": units.to_code(spin.rate, "angular_velocity")}
    return {"angular_momentum": units.to_code(spin.angular_momentum, "angular_momentum")}


def breakup_rate(scene: Scene, units: CodeUnits) -> float:
    """The rate of a polytrope that is to turn at a fraction of break-up."""
    from astroinertia.bodies.break_up import polytropic_rate  # brings figures of stars along

    body: Any = scene.body
    mass, radius = units.to_code(body.mass, "mass"), units.to_code(body.radius, "length")
    return polytropic_rate(body.polytropic_index, body.rotation.breakup_fraction) * (mass / radius**3) ** 0.5


def rigid_moments(scene: Scene, units: CodeUnits) -> tuple[np.ndarray, np.ndarray]:
    """Principal moments (3,) of a body of the kind rigid, and its axes at the start, unit vectors as rows (3, 3)."""
    body: Any = scene.body
    if body.moments is not None:
        moments = np.array([units.to_code(moment, "moment_of_inertia") for moment in body.moments])
    else:
        moments = np.array(body.moment_ratios) * units.to_code(body.mass, "mass")
        moments = moments * units.to_code(body.radius, "length") ** 2
    return moments, body.rows_at_start
