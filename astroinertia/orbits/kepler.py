"""Kepler's equation: where a body on an ellipse, a parabola or a hyperbola is at a given time.

Functions of NumPy or JAX arrays (xp). Tests: tests/unit/orbits/test_kepler.py.
"""

import math
from typing import Any

# Steps of Halley's method from Danby's guess. Near e = 1 and M = 0 each halves the root's distance, down from 0.85.
ELLIPTIC_STEPS = 24
# Newton steps from above; the error is round-off for e from 1 to 100 and all times, by test.
OPEN_STEPS = 14
# Of cosh k - 1 and sinh k - k below k = 1, highest powers first: the first left out is below 1e-18.
_SERIES = tuple((1.0 / math.factorial(2 * j + 2), 1.0 / math.factorial(2 * j + 3)) for j in reversed(range(10)))


def eccentric_anomaly(xp: Any, mean_anomaly: Any, eccentricity: Any) -> Any:
    """E in [-pi, pi] of Kepler's equation E - e sin E = M, for any M and 0 <= e < 1, both of one shape.

    Danby 1988, Fundamentals of Celestial Mechanics, section 6.6, for the first guess.

    >>> print(round(eccentric_anomaly(np, 1.0 - 0.5 * np.sin(1.0), 0.5), 12))
    1.0
    """
    reduced = mean_anomaly - 2.0 * math.pi * xp.round(mean_anomaly / (2.0 * math.pi))
    anomaly = reduced + xp.where(reduced < 0.0, -0.85, 0.85) * eccentricity
    for _ in range(ELLIPTIC_STEPS):
        # Halley's form of the step: it does not overshoot where the orbit is nearly radial.
        error = anomaly - eccentricity * xp.sin(anomaly) - reduced
        slope = 1.0 - eccentricity * xp.cos(anomaly)
        anomaly = anomaly - error / (slope - 0.5 * error * eccentricity * xp.sin(anomaly) / slope)
    return anomaly


def place_on_open_orbit(xp: Any, time: Any, eccentricity: Any) -> tuple[Any, Any]:
    """Coordinates along the pericentre and across, in units of its distance q, for time in (q^3/M)^(1/2), e >= 1.

    The universal variable s solves time = s + e s^3 c_3(-b s^2), b = e - 1, in which Barker's equation is the case
    b = 0; then x = 1 - s^2 c_2 and y = (1 + e)^(1/2) (s + b s^3 c_3), c_k Stumpff's functions (Danby 1988,
    Fundamentals of Celestial Mechanics, section 6.9).

    >>> x, y = place_on_open_orbit(np, np.float64(4.0 / 3.0 * 2.0**0.5), 1.0)  # a right angle past the pericentre
    >>> print(f"{abs(x):.12f} {y:.12f}")
    0.000000000000 2.000000000000
    """
    e, excess = eccentricity, eccentricity - 1.0
    size = xp.abs(time)
    # Both are upper bounds of the root: of the parabola, c_3 >= 1/6, and of large times, s^3 c_3 >= (sinh k - k)/b^1.5.
    parabola = 2.0 * (2.0 / e) ** 0.5 * xp.sinh(xp.arcsinh(1.5 * size * (e / 2.0) ** 0.5) / 3.0)
    root = xp.sqrt(xp.where(excess > 0.0, excess, 1.0))
    anomaly = xp.minimum(parabola, xp.where(excess > 0.0, xp.arcsinh(size * root) / root, parabola))
    for _ in range(OPEN_STEPS):
        second, third = _stumpff_sums(xp, anomaly, excess)
        anomaly = anomaly - (anomaly + e * third - size) / (1.0 + e * second)
    second, third = _stumpff_sums(xp, anomaly, excess)
    across = (1.0 + e) ** 0.5 * (anomaly + excess * third)
    return 1.0 - second, xp.where(time < 0.0, -across, across)


def time_from_pericentre(xp: Any, distance: Any, eccentricity: Any) -> Any:
    """Time in (q^3/M)^(1/2) between the pericentre and a distance in units of its own, q, on any conic with e > 0.

    Distances that the orbit does not reach count as those of its pericentre and apocentre.

    >>> print(f"{time_from_pericentre(np, np.float64(2.0), 1.0):.12f}")  # Barker's equation at a right angle
    1.885618083164
    """
    e, excess = eccentricity, eccentricity - 1.0
    half = 0.5 * xp.maximum(distance - 1.0, 0.0) / e
    root = xp.sqrt(xp.where(excess == 0.0, 1.0, xp.abs(excess)))
    sine = root * xp.sqrt(half)
    bound, free = xp.arcsin(xp.minimum(sine, 1.0)), xp.arcsinh(sine)
    s = 2.0 * xp.where(excess < 0.0, bound, xp.where(excess > 0.0, free, sine)) / root
    return s + e * _stumpff_sums(xp, s, excess)[1]


def _stumpff_sums(xp: Any, s: Any, excess: Any) -> tuple[Any, Any]:
    """s^2 c_2(-b s^2) and s^3 c_3(-b s^2): (cosh k - 1)/b and (sinh k - k)/b^1.5 with k = b^0.5 s.

    For b < 0 (1 - cos k)/|b| and (k - sin k)/|b|^1.5 with k = |b|^0.5 s.
    """
    argument = excess * s * s
    small, size = xp.abs(argument) < 1.0, xp.abs(argument)
    second, third, near = 0.0, 0.0, xp.where(small, argument, 0.0)
    for of_second, of_third in _SERIES:
        second = second * near + of_second
        third = third * near + of_third
    root, b = xp.sqrt(xp.where(small, 1.0, size)), xp.where(small, 1.0, xp.abs(excess))
    far_second = xp.where(excess < 0.0, 1.0 - xp.cos(root), xp.cosh(root) - 1.0)
    far_third = xp.where(excess < 0.0, root - xp.sin(root), xp.sinh(root) - root)
    return xp.where(small, s * s * second, far_second / b), xp.where(small, s**3 * third, far_third / b**1.5)
