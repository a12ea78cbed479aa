"""Initial velocity fields: rotation laws with one given measure of the amount of rotation, and linear flows.

The laws are those of bodies/rotation_laws.py, rigid, j_constant and v_constant, and any that answers like them.

All functions take arrays in code units with the centre of mass at the origin. Tests:
tests/unit/sph/test_initial_particles.py.
"""

import math

import numpy as np

from astroinertia.bodies.rotation_laws import Law, RotationLaw

MEASURES = ("rate", "angular_momentum", "t_over_w")


def rotation_velocity(
    mass: np.ndarray,
    position: np.ndarray,
    law: str | Law = "rigid",
    axis=(0.0, 0.0, 1.0),
    scale: float | None = None,
    gravitational_energy: float | None = None,
    edge: float | None = None,
    **measure: float,
) -> np.ndarray:
    """Return velocities (N, 3) that rotate about an axis through the origin.

    Exactly one of `rate` (on the axis), `angular_momentum` (along the axis) and `t_over_w` (which needs
    gravitational_energy) is given; the last two hold for these particles to round-off. `law` is a kind of law, with its
    `scale` A where it is not rigid, or a law itself; beyond `edge` from the axis the specific angular momentum stays
    what it is there.
    ValueError where these contradict.
    """
    if len(measure) != 1 or next(iter(measure)) not in MEASURES:
        raise ValueError(f"rotation needs exactly one of {', '.join(MEASURES)}, not {', '.join(measure) or 'none'}")
    (name, value), axis = next(iter(measure.items())), np.asarray(axis, dtype=float)
    length = float(np.linalg.norm(axis))
    if axis.shape != (3,) or not math.isfinite(length) or length == 0:
        raise ValueError("the rotation axis must be three finite numbers that are not all zero")
    unit = np.cross(axis / length, position)  # velocity for rate 1, rigid
    w = np.linalg.norm(unit, axis=1)
    if edge is None:
        unit = unit * law_of(law, scale).rate(w)[:, None]
    else:
        inside = np.minimum(w, edge)
        unit = unit * (law_of(law, scale).rate(inside) * (inside / np.maximum(w, 1e-300)) ** 2)[:, None]
    return unit * _rate(name, value, mass, position, unit, axis / length, gravitational_energy)


def law_of(law: str | Law, scale: float | None) -> Law:
    """The law itself, of a kind and its scale or as it is."""
    return RotationLaw(law, scale) if isinstance(law, str) else law


def _rate(name, value, mass, position, unit, axis, gravitational_energy) -> float:
    if not math.isfinite(value):
        raise ValueError(f"rotation {name} must be finite, not {value!r}")
    if name == "rate":
        return value
    if name == "angular_momentum":
        return value / float((mass @ np.cross(position, unit)) @ axis)
    if gravitational_energy is None or not -math.inf < gravitational_energy < 0:
        raise ValueError("rotation t_over_w needs a self-gravitating body")
    if not value >= 0:
        raise ValueError(f"rotation t_over_w must not be negative, not {value!r}")
    return math.sqrt(value * -gravitational_energy / (0.5 * float(mass @ (unit**2).sum(axis=1))))


def linear_velocity(position: np.ndarray, gradient) -> np.ndarray:
    """Return v_i = gradient_ij x_j, (N, 3); ValueError unless gradient is a finite 3x3 matrix."""
    matrix = np.asarray(gradient, dtype=float)
    if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
        raise ValueError("velocity_gradient must be a 3x3 matrix of finite numbers")
    return position @ matrix.T
