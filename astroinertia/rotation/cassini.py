"""Cassini states: spins that stand still against the node of a precessing orbit, and which of them are stable.

The axis s, the orbit's normal n and the pole k about which the orbit precesses lie in one plane. Free spin (Colombo's
top) has the precession constant alpha; a spin of p times the mean motion, locked, has a triaxial figure held to the
orbit as well. With the obliquity theta, from n to s, positive towards k and beyond, both stand where

    (strength J2 + strength C22) sin(theta) = -node_rate sin(theta - i).

States are numbered as by Peale: 1, 2, 3 are stable and 4 is not; 1 and 4 end together where the node is fast.
Sources: Colombo 1966, AJ 71, 891; Peale 1969, AJ 74, 483; Ward 1975, AJ 80, 64; Henrard & Murigande 1987, Celest. Mech.
40, 345.
"""

import math
from typing import NamedTuple

import numpy as np

from astroinertia.errors import NumericalError
from astroinertia.process.quantities import with_quantities

_MOST_DOUBLINGS = 22  # of the points of an orbit
_OFF_THE_CIRCLE = 1e-6  # by which roots of polynomials are off where two of them are about to merge
_NEWTON_STEPS = 3  # by which they are known to round-off


class CassiniState(NamedTuple):
    """One state: its number by Peale, signed obliquity (rad), stability, and frequency of small circling (rad s-1).

    The obliquity is positive where s leans from n towards k and beyond it; the frequency is NaN where it is unstable.
    """

    number: int
    obliquity: float
    stable: bool
    frequency: float


@with_quantities()
def hansen_coefficient(eccentricity: float, p: float) -> float:
    """H(p, e) = X^(-3,2)_(2p), the strength of the spin-orbit resonance of p turns an orbit; 2p is an integer.

    The mean of (a/r)^3 cos(2 f - 2 p M) over an orbit: H(1) = 1 - 5 e^2/2 + ..., H(3/2) = 7 e/2 - ...; ValueError for
    2p that is no integer and for e outside 0 <= e < 1. Source: Goldreich & Peale 1966, AJ 71, 425; Cayley 1861.

    >>> print(f"{hansen_coefficient(0.2056, 1.5):.4f}")  # 7 e/2 - ..., of Mercury
    0.6542
    """
    order = 2 * p
    if not np.isfinite(order) or order != round(order) or not 0 <= eccentricity < 1:
        raise ValueError("a resonance has 2p, an integer, and an eccentricity from 0 to below 1")
    root, before = np.sqrt(1 - eccentricity**2), np.inf
    fewest = math.ceil(math.log2(4 * abs(order) + 16))  # with fewer, what turns fast looks like what stands still
    for doubling in range(fewest, _MOST_DOUBLINGS):
        # dM = (r/a) du, and the anomaly by its cosine and sine, so that nothing jumps: the sum converges exponentially.
        u = 2 * np.pi * np.arange(2**doubling) / 2**doubling
        distance = 1 - eccentricity * np.cos(u)
        cosine, sine = (np.cos(u) - eccentricity) / distance, root * np.sin(u) / distance
        turn = order * (u - eccentricity * np.sin(u))
        double = (cosine**2 - sine**2) * np.cos(turn) + 2 * cosine * sine * np.sin(turn)
        integral = float(np.mean(double / distance**2))
        if abs(integral - before) < 1e-14 * max(1.0, abs(integral)):
            return integral
        before = integral
    raise NumericalError(f"the strength of the resonance is not found at an eccentricity of {eccentricity}")


@with_quantities(precession_constant="rad/s")
def critical_node_rate(precession_constant: float, inclination: float) -> float:
    """|node rate| above which states 1 and 4 are gone, alpha/(sin^(2/3) i + cos^(2/3) i)^(3/2), rad s-1.

    For free spin. Source: Henrard & Murigande 1987; Ward & Hamilton 2004, AJ 128, 2501, (4).

    >>> print(f"{critical_node_rate(1.0, np.radians(5.0)):.3f}")
    0.766
    """
    return precession_constant / (abs(np.sin(inclination)) ** (2 / 3) + abs(np.cos(inclination)) ** (2 / 3)) ** 1.5


@with_quantities(precession_constant="rad/s")
def cassini_states(precession_constant: float, node_rate: float, inclination: float) -> tuple[CassiniState, ...]:
    """The two or four Cassini states of a free spin, by their numbers; rates in rad s-1, inclination to k in rad.

    precession_constant: alpha, above 0; node_rate: of the orbit about k, negative where the node regresses. ValueError
    for a node rate or inclination of zero, where s may stand anywhere. Source: Colombo 1966; Ward 1975.
    Checked by tests/unit/rotation/test_cassini.py and by the motion in tests/unit/rotation/test_secular_spin.py.

    >>> print(len(cassini_states(1.0, -0.1, 0.05)), len(cassini_states(1.0, -2.0, 0.05)))  # slow node, fast node
    4 2
    """
    if not (0 < precession_constant < np.inf and 0 < abs(node_rate) < np.inf and 0 < inclination < np.pi / 2):
        raise ValueError("Cassini states need precession_constant above 0, a moving node and 0 < inclination < pi/2")
    # A node that advances has the states of one that regresses, for the opposite spin.
    rate, opposite = -abs(node_rate), node_rate > 0

    states = []
    for theta in _standing(0.5 * precession_constant, 0.0, rate, inclination):
        # Curvatures of the energy -(alpha/2) (s.n)^2 - rate s.k, with its sign turned, in the plane and out of it.
        inside = precession_constant * np.cos(2 * theta) + rate * np.cos(theta - inclination)
        across = rate * np.sin(inclination) / np.sin(theta)
        stable = inside * across > 0
        number = 4 if not stable else 2 if inside < 0 else 1 if np.cos(theta) > 0 else 3
        obliquity = theta - math.copysign(math.pi, theta) * opposite
        states.append(
            CassiniState(number, obliquity, bool(stable), float(np.sqrt(inside * across)) if stable else np.nan)
        )
    return tuple(sorted(states))


@with_quantities()
def resonant_obliquity(
    moment_ratio: float, j2: float, c22: float, mean_motion: float, node_rate: float, inclination: float,
    eccentricity: float = 0.0, p: float = 1.0, primary_share: float = 1.0,
) -> float:  # fmt: skip
    """The obliquity (rad) in the Cassini state of a spin locked at p turns an orbit that tides lead to.

    moment_ratio: C/(M R^2) for the radius of J2 and C22; inclination to the pole of the orbit's precession; node_rate
    negative for a regressing node; primary_share: GM of the primary over n^2 a^3, 0.988 for the Moon. It is state 2
    where there is no state 1, as for the Moon, and state 1 otherwise, as for Mercury. ValueError for what has no such
    state. Source: Peale 1969, (18); Peale 1981, Icarus 48, 143.

    >>> month, node = 27.3217 * 86400, 18.6 * 3.15576e7  # the Moon, locked, in state 2
    >>> rates = 2 * np.pi / month, -2 * np.pi / node
    >>> tilt = resonant_obliquity(0.3929, 2.033e-4, 2.24e-5, *rates, np.radians(5.145), 0.055)
    >>> print(f"{np.degrees(tilt):.1f}")  # 6.7 to its orbit, 1.5 to the ecliptic
    6.7
    """
    _require_locked(moment_ratio, mean_motion, node_rate, inclination, eccentricity)
    scale = mean_motion / (p * moment_ratio)
    level, tilted = (scale * part for part in _locked_strength(j2, c22, eccentricity, p, primary_share))
    angles = _standing(0.5 * tilted, level, node_rate, inclination)
    # State 1 leans from the normal away from the pole, between the normal and its opposite; tides lead to the state of
    # the smallest obliquity.
    prograde = [angle for angle in angles if abs(angle) < np.pi / 2]
    if not prograde:
        raise ValueError("the spin has no Cassini state of an obliquity below 90 degrees")
    return float(min(prograde, key=abs))


@with_quantities()
def moment_ratio_from_obliquity(
    obliquity: float, j2: float, c22: float, mean_motion: float, node_rate: float, inclination: float,
    eccentricity: float = 0.0, p: float = 1.0, primary_share: float = 1.0,
) -> float:  # fmt: skip
    """C/(M R^2) of a body that stands in a Cassini state at this signed obliquity (rad), locked at p turns an orbit.

    The inverse of `resonant_obliquity`, with its arguments; the obliquity is positive towards the pole and beyond.
    ValueError where the node does not move or s lies in line with k. Source: Peale 1981; Margot et al. 2012, JGR
    Planets 117, E00L09.

    >>> month, node = 27.3217 * 86400, 18.6 * 3.15576e7
    >>> known = 2.033e-4, 2.24e-5, 2 * np.pi / month, -2 * np.pi / node, np.radians(5.145)
    >>> print(f"{moment_ratio_from_obliquity(resonant_obliquity(0.393, *known), *known):.4f}")  # the inverse
    0.3930
    """
    _require_locked(1.0, mean_motion, node_rate, inclination, eccentricity)
    level, tilted = _locked_strength(j2, c22, eccentricity, p, primary_share)
    torque = mean_motion / p * np.sin(obliquity) * (level + tilted * np.cos(obliquity))
    turning = -node_rate * np.sin(obliquity - inclination)
    if turning == 0 or torque / turning <= 0:
        raise ValueError(
            "no C/(M R^2) lets a body of this figure stand in a Cassini state at this obliquity, which has a sign: "
            "above 0 towards the pole and beyond (the Moon), below 0 on the other side of the normal (Mercury)"
        )
    return float(torque / turning)


def _locked_strength(j2: float, c22: float, eccentricity: float, p: float, primary_share: float) -> tuple[float, float]:
    """The two parts of what sin(theta) is multiplied by: the second goes with cos(theta)."""
    if not (np.isfinite(j2) and np.isfinite(c22) and np.isfinite(primary_share)):
        raise ValueError(f"j2, c22 and primary_share must be finite, not {j2:g}, {c22:g} and {primary_share:g}")
    held = 1.5 * primary_share * c22 * hansen_coefficient(eccentricity, p)
    return held, held + 1.5 * primary_share * j2 / (1 - eccentricity**2) ** 1.5


def _require_locked(ratio: float, motion: float, node_rate: float, inclination: float, eccentricity: float) -> None:
    if not (ratio > 0 and motion > 0 and node_rate != 0 and np.sin(inclination) != 0 and 0 <= eccentricity < 1):
        raise ValueError(
            "a locked Cassini state needs moment_ratio and mean_motion above 0, a moving node, an inclined orbit and "
            "0 <= eccentricity < 1"
        )


def _standing(double: float, single: float, rate: float, inclination: float) -> list[float]:
    """The angles from -pi to pi at which double sin(2 theta) + single sin(theta) + rate sin(theta - i) vanishes.

    A polynomial of degree 4 in exp(i theta), whose roots are on the unit circle or in pairs on both sides of it.
    """
    turned = single + rate * np.exp(-1j * inclination)
    roots = np.roots([double, turned, 0.0, -turned.conjugate(), -double])
    angles = np.angle(roots[np.abs(np.abs(roots) - 1) < _OFF_THE_CIRCLE])
    for _ in range(_NEWTON_STEPS):
        torque = double * np.sin(2 * angles) + single * np.sin(angles) + rate * np.sin(angles - inclination)
        slope = 2 * double * np.cos(2 * angles) + single * np.cos(angles) + rate * np.cos(angles - inclination)
        angles = angles - torque / slope
    apart = np.diff(np.sort(angles))
    if len(angles) not in (2, 4) or apart.min() < _OFF_THE_CIRCLE:
        raise NumericalError(f"{len(angles)} Cassini states were found where there are two or four: two are merging")
    return sorted(map(float, angles))
