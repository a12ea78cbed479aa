"""Homogeneous ellipsoids in equilibrium: the points on their sequences that textbooks print."""

from astroinertia.bodies import jacobi, maclaurin, roche
from astroinertia.verify.comparison import Quantities


def maclaurin_points() -> Quantities:
    """Where Jacobi's ellipsoids branch off, where a bar grows by itself, and the fastest rotation."""
    values = {}
    points = {
        "bifurcation": maclaurin.bifurcation(),
        "bar": maclaurin.dynamical_limit(),
        "fastest": maclaurin.fastest(),
    }
    for name, point in points.items():
        values |= {
            f"{name}_eccentricity": point.eccentricity,
            f"{name}_rate": point.omega2,
            f"{name}_energy_ratio": point.rotational_to_gravitational,
        }
    return values


def pear_point() -> Quantities:
    """Where the pear-shaped figures branch off Jacobi's."""
    pear = jacobi.pear_bifurcation()
    return {"pear_b_over_a": pear.b_over_a, "pear_c_over_a": pear.c_over_a, "pear_rate": pear.omega2}


def roche_limits() -> Quantities:
    """A small satellite at Roche's limit, and Jeans's spheroid that does not turn."""
    satellite, spheroid = roche.limit(0.0), roche.limit(-1.0)
    return {
        "roche_tide": satellite.tide,
        "roche_distance": satellite.scaled_distance,
        "roche_b_over_a": satellite.b_over_a,
        "roche_c_over_a": satellite.c_over_a,
        "jeans_tide": spheroid.tide,
        "jeans_eccentricity": spheroid.eccentricity,
    }


COMPUTATIONS = (maclaurin_points, pear_point, roche_limits)
