"""Kepler's equation: where a body on an ellipse, a parabola or a hyperbola is at a given time.

Functions of NumPy or JAX arrays (xp).
"""

import math
from typing import Any

# Newton's steps from above; the error is round-off for e up to 100 and all times, by test.
ELLIPTIC_STEPS, OPEN_STEPS = 7, 14
LEAST_ECCENTRICITY = 1e-16  # below which a guess needs no curvature
# Of cosh k - 1 and sinh k - k below k = 1, highest powers first: the first left out is below 1e-18.
_SERIES = tuple((1.0 / math.factorial(2 * j + 2), 1.0 / math.factorial(2 * j + 3)) for j in reversed(range(10)))


def eccentric_anomaly(xp: Any, mean_anomaly: Any, eccentricity: Any) -> Any:
    """E in [-pi, pi] of Kepler's equation E - e sin E = M, for any M and 0 <= e < 1, both of one shape.

    Newton's method from the root of (1 - e) E + e E^3/pi^2 = M, which is beyond E as E - sin E >= E^3/pi^2 up to pi.
    Its relative error is round-off, too, for any e and M: 1 - e and E - sin E are never differences of large numbers.

    >>> print(round(eccentric_anomaly(np, 1.0 - 0.5 * np.sin(1.0), 0.5), 12))
    1.0
    """
    reduced = mean_anomaly - 2.0 * math.pi * xp.round(mean_anomaly / (2.0 * math.pi))
    short, bend = 1.0 - eccentricity, 3.0 / math.pi**2 * xp.maximum(eccentricity, LEAST_ECCENTRICITY)
    anomaly = 2.0 * xp.sqrt(short / bend) * xp.sinh(xp.arcsinh(1.5 * xp.sqrt(bend / short) / short * reduced) / 3.0)
    for _ in range(ELLIPTIC_STEPS):
        second, third = _stumpff_sums(xp, anomaly, -1.0)
        anomaly = anomaly - (short * anomaly + eccentricity * third - reduced) / (short + eccentricity * second)
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
    # Upper bounds of the root: of the parabola, c_3 >= 1/6, and k = b^0.5 s of e sinh k = b^1.5 time + k from one of k.
    parabola = 2.0 * (2.0 / e) ** 0.5 * xp.sinh(xp.arcsinh(1.5 * size * (e / 2.0) ** 0.5) / 3.0)
    root = xp.sqrt(xp.where(excess > 0.0, excess, 1.0))
    late = xp.minimum(parabola * root, xp.arcsinh(size * root))
    late = xp.arcsinh((size * root**3 + late) / e) / root
    anomaly = xp.minimum(parabola, xp.where(excess > 0.0, late, parabola))
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
    small = xp.abs(argument) < 1.0
    second, third, near = 0.0, 0.0, xp.where(small, argument, 0.0)
    for of_second, of_third in _SERIES:
        second = second * near + of_second
        third = third * near + of_third
    b = xp.where(small, 1.0, xp.abs(excess))
    root = xp.where(small, 1.0, s * xp.sqrt(b))
    far_second = xp.where(excess < 0.0, 1.0 - xp.cos(root), xp.cosh(root) - 1.0)
    far_third = xp.where(excess < 0.0, root - xp.sin(root), xp.sinh(root) - root)
    return xp.where(small, s * s * second, far_second / b), xp.where(small, s**3 * third, far_third / b**1.5)
