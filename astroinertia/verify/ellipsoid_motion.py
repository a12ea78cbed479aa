"""Ellipsoids that move: points of instability from growth rates, Riemann's figures, and collapse without pressure."""

from astroinertia.bodies import ellipsoid_secular, ellipsoid_stability, jacobi, maclaurin, riemann
from astroinertia.bodies.cold_spheroid import ColdSpheroid, sphere_free_fall_time
from astroinertia.verify.comparison import Quantities

_VISCOSITY = 1e-3  # kinematic, M = R = G = 1: the onset does not depend on it


def onsets() -> Quantities:
    """Where Maclaurin spheroids begin to be unstable, without friction and with viscosity, from their modes."""
    spheroid = maclaurin.from_eccentricity
    return {
        "dynamical_onset": ellipsoid_stability.onset(spheroid, 0.9, 0.98),
        "secular_onset": ellipsoid_secular.secular_onset(spheroid, 0.7, 0.9, kinematic_viscosity=_VISCOSITY),
    }


def riemann_figures() -> Quantities:
    """Dedekind's theorem: the adjoint of a Jacobi ellipsoid has its shape and stands still."""
    spinning, still = jacobi.from_axis_ratio(0.6), riemann.dedekind(0.6)
    return {
        "dedekind_axis": (still.c_over_a, spinning.c_over_a),
        "dedekind_rate": abs(still.angular_velocity),
        "dedekind_internal_rate": (abs(still.internal_angular_velocity), spinning.angular_velocity),
    }


def cold_collapse() -> Quantities:
    """Times in which cold bodies at rest collapse, M = R = G = 1."""
    collapse = ColdSpheroid(equatorial_radius=1.0, polar_radius=0.9).collapse()
    return {
        "free_fall_time": float(sphere_free_fall_time(1.0)),
        "pancake_time": float(collapse.time),
        "pancake_radius": float(collapse.equatorial_radius),
    }


COMPUTATIONS = (onsets, riemann_figures, cold_collapse)
