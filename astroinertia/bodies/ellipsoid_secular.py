"""Secular instability of homogeneous ellipsoids: what little viscosity or gravitational radiation does to modes.

To first order in the friction a mode lambda^2 x = (K + lambda C) x moves by

    viscosity nu:   q d2F/dt2 gets -2 M nu sym(dF/dt F^-1) F^-T,                      delta lambda ~ nu,
    radiation:      d2F/dt2 gets -(2 G/(5 c^5)) (d^5/dt^5)(Q - tr(Q)/3) F,            delta lambda ~ lambda^5/c^5.

Viscosity asks for a figure that turns rigidly (Maclaurin, Jacobi, Roche), radiation for one whose quadrupole is at rest
in space (Maclaurin, Dedekind): others have no steady state with it. Without friction the circulation is kept; viscosity
gives the mode in which it changes a rate, and that one crosses zero at the Roche limit. With both at once the bars of a
Maclaurin spheroid may be saved from either (Lindblom & Detweiler).

Source: Roberts & Stewartson 1963, ApJ 137, 777; Rosenkilde 1967, ApJ 148, 825 (viscosity); Chandrasekhar 1970, ApJ 161,
561; Lindblom & Detweiler 1977, ApJ 211, 565; Lai & Shapiro 1995, ApJ 442, 259. Test:
tests/unit/bodies/test_ellipsoid_secular.py.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from astroinertia.bodies.ellipsoid_stability import (
    BAR,
    EVEN,
    SYMMETRIC,
    SteadyFrame,
    bar_equation,
    families,
    masses_of,
    steady_frame,
    stiffness_and_gyration,
)
from astroinertia.bodies.homogeneous_ellipsoid import HomogeneousEllipsoid
from astroinertia.bodies.maclaurin import MaclaurinSpheroid
from astroinertia.bodies.riemann import TURN
from astroinertia.errors import NumericalError
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

_MOST_STEPS, _SETTLED, _RUNAWAY = 200, 2e-15, 1e3  # of the iteration for the bars with radiation
_AT_REST = 1e-12  # of the rates, in (pi G rho)^(1/2): below it a figure turns rigidly, or does not turn


class FrictionalModes(NamedTuple):
    """Rates (n,) without friction, in the frame of the figure (of a spheroid the inertial one), and their changes (n,).

    All complex, per unit of time; the real part is growth. Of conjugate pairs one is left out; of the bars
    of a spheroid, exp(2 i phi + lambda t), a rate with negative imaginary part turns with the body.
    """

    rates: np.ndarray
    changes: np.ndarray


@with_quantities()
def viscous_modes(body: HomogeneousEllipsoid, kinematic_viscosity: float) -> FrictionalModes:
    """Return the modes of a rigidly turning figure and how a small kinematic viscosity changes their rates.

    The last one of a figure with three axes is that in which its circulation decays or runs away. Units of the body.
    ValueError for a negative viscosity, or a figure with internal motion. Source: Rosenkilde 1967.

    >>> from astroinertia.bodies import maclaurin
    >>> changes = viscous_modes(maclaurin.from_eccentricity(0.5), 1e-3).changes
    >>> print(changes.real.max() < 1e-12)  # of a nearly round body: friction damps all
    True
    """
    frame = steady_frame(body)
    if not frame.spheroid and abs(frame.internal) > _AT_REST:
        raise ValueError("a figure with internal motion is not steady with viscosity: it has no secular modes")
    if frame.turning == frame.internal == 0 and not frame.spheroid:
        raise ValueError("viscosity only damps a figure that does not turn: see whether its spectrum is stable")
    strength = _viscosity(body, frame, kinematic_viscosity)

    def change(rate: complex, basis, left: np.ndarray, right: np.ndarray) -> complex:
        return strength * complex(left @ _viscous_operator(frame, basis, rate) @ right)

    rates, changes = _first_order(frame, change)
    if not frame.spheroid:
        rates, changes = [*rates, 0.0], [*changes, strength * _circulation_rate(frame)]
    return FrictionalModes(frame.time * np.array(rates, complex), frame.time * np.array(changes, complex))


@with_quantities()
def radiative_modes(body: HomogeneousEllipsoid, speed_of_light: float) -> FrictionalModes:
    """Return the modes of a figure at rest in space and how gravitational radiation reaction changes their rates.

    Units of the body. ValueError for a figure that radiates (three axes, turning), or a tide, or a speed of light of
    zero or less. Source: Chandrasekhar 1970.

    >>> from astroinertia.bodies import riemann
    >>> print(len(radiative_modes(riemann.dedekind(0.8), 10.0).rates))
    4
    """
    frame = steady_frame(body)
    if abs(frame.turning) > _AT_REST or not frame.isolated:
        raise ValueError(
            "an ellipsoid with three axes that turns sends out waves: it is not steady with their reaction"
        )
    strength = _coupling(body, frame, speed_of_light)

    def change(rate: complex, basis, left: np.ndarray, right: np.ndarray) -> complex:
        return strength * rate**5 * complex(left @ _radiative_operator(frame, basis) @ right)

    rates, changes = _first_order(frame, change)
    return FrictionalModes(frame.time * np.array(rates, complex), frame.time * np.array(changes, complex))


@with_quantities()
def bar_rates(
    spheroid: MaclaurinSpheroid, kinematic_viscosity: float = 0.0, speed_of_light: float = math.inf
) -> tuple[complex, complex]:
    """Return the rates of both bars, exp(2 i phi + lambda t) in space, of a spheroid with friction that is not small.

    The one of larger modulus first, which is the faster; growth - i sigma belongs to a pattern that turns at sigma/2.
    Units of the body. They are the quadratic factor, continuous with that without friction, of

        lambda^2 + 2 i Omega lambda + 4 B_11 - 2 Omega^2 + (10 nu/a^2)(lambda + 2 i Omega) + k lambda^5,

    k = 4 G M a^2/(25 c^5), whose other roots, where the last term is as large as the rest, mean nothing. ValueError for
    three axes, NumericalError where radiation is so strong that the factor is not found.
    Source: Roberts & Stewartson 1963; Chandrasekhar 1970.

    >>> from astroinertia.bodies import maclaurin
    >>> rates = bar_rates(maclaurin.from_eccentricity(0.9), kinematic_viscosity=1e-3)
    >>> print(max(rate.real for rate in rates) > 0)  # beyond e = 0.8127 friction lets a bar grow
    True
    """
    frame = steady_frame(spheroid)
    if not frame.spheroid:
        raise ValueError("these are the bars of a spheroid: see viscous_modes and radiative_modes for three axes")
    gyration, stiffness = bar_equation(frame)
    turning = _turning_fields(BAR)[:, 0]
    rest, whole = (complex(turning.conj() @ _viscous_operator(frame, BAR, rate) @ turning) for rate in (0.0, 1.0))
    viscosity = _viscosity(spheroid, frame, kinematic_viscosity)
    radiation = _coupling(spheroid, frame, speed_of_light)
    radiation *= float(np.real(turning.conj() @ _radiative_operator(frame, BAR) @ turning))
    free = np.array([-gyration - viscosity * (whole - rest), -stiffness - viscosity * rest])
    factor, moved, size = free, 0.0, 1.0  # p and q of lambda^2 + p lambda + q
    for _ in range(_MOST_STEPS):
        power = np.array([1.0, 0.0], complex)  # of lambda^n = first lambda + second on the factor's roots
        for _ in range(4):
            power = np.array([power[1] - power[0] * factor[0], -power[0] * factor[1]])
        last, factor = factor, free - radiation * power
        moved, size = abs(factor - last).max(), abs(factor).max()
        if moved <= _SETTLED * size or size > _RUNAWAY:
            break
    if moved > _SETTLED * size:
        raise NumericalError("the bars of a spheroid cannot be followed with so much radiation")
    root = np.emath.sqrt(factor[0] ** 2 / 4 - factor[1])
    fast = max((-factor[0] / 2 + sign * root for sign in (1, -1)), key=abs)
    slow = factor[1] / fast if fast else fast  # not by a difference, in which the bar at rest at the fork would be lost
    return frame.time * complex(fast), frame.time * complex(slow)


@with_quantities()
def secular_growth_rate(
    body: HomogeneousEllipsoid, kinematic_viscosity: float = 0.0, speed_of_light: float = math.inf
) -> float:
    """Return the growth rate, to first order in the friction, of the fastest mode; negative: all of them decay.

    With both frictions at once the figure is a spheroid. ValueError as of `viscous_modes` and `radiative_modes`, and
    where neither is given. Source: Lindblom & Detweiler 1977.

    >>> from astroinertia.bodies import maclaurin
    >>> print(secular_growth_rate(maclaurin.from_eccentricity(0.9), 1e-3) > 0)  # a bar by friction
    True
    """
    parts = []
    if kinematic_viscosity:
        parts.append(viscous_modes(body, kinematic_viscosity))
    if speed_of_light < math.inf:
        parts.append(radiative_modes(body, speed_of_light))
    if not parts:
        raise ValueError("secular growth needs friction: a kinematic viscosity or a finite speed of light")
    return float((parts[0].rates + sum(part.changes for part in parts)).real.max())


@with_quantities()
def secular_onset(
    figure: Callable[[float], HomogeneousEllipsoid],
    low: float,
    high: float,
    kinematic_viscosity: float = 0.0,
    speed_of_light: float = math.inf,
) -> float:
    """Return the parameter between `low` and `high` at which figure(parameter) begins to be secularly unstable.

    ValueError unless the growth rate changes its sign between. Source: Chandrasekhar 1969, section 37.

    >>> from astroinertia.bodies import maclaurin
    >>> print(f"{secular_onset(maclaurin.from_eccentricity, 0.7, 0.9, 1e-3):.6f}")  # where Jacobi ellipsoids branch off
    0.812670
    """

    def growth(parameter: float) -> float:
        rate = secular_growth_rate(figure(parameter), kinematic_viscosity, speed_of_light)
        return math.copysign(abs(rate) ** 0.2, rate)  # radiation grows as the fifth power of the distance to its onset

    return root_between(growth, low, high)


def _viscosity(body: HomogeneousEllipsoid, frame: SteadyFrame, kinematic_viscosity: float) -> float:
    """nu in the units of the frame."""
    if not (0 <= kinematic_viscosity < math.inf):
        raise ValueError(f"the kinematic viscosity is finite and not negative, not {kinematic_viscosity}")
    return kinematic_viscosity / (frame.time * body.mean_radius**2)


def _coupling(body: HomogeneousEllipsoid, frame: SteadyFrame, speed_of_light: float) -> float:
    """2 G M R^2/(25 c^5) in the units of the frame."""
    if not speed_of_light > 0:
        raise ValueError(f"the speed of light is positive, not {speed_of_light}")
    coupling = 2 / 25 * body.gravitational_constant * body.mass * body.mean_radius**2
    return coupling * frame.time**3 / speed_of_light**5


def _first_order(frame: SteadyFrame, change) -> tuple[list[complex], list[complex]]:
    """Rates and changes of modes with a frequency, one of each conjugate pair.

    change(rate, basis, left, right) is the product of left vector, friction and right vector.
    """
    rates: list[complex] = []
    changes: list[complex] = []
    modes: list[tuple[tuple[np.ndarray, ...], list[complex]]] = []
    for family in families(frame):
        roots = [complex(np.emath.sqrt(square)) for square in np.roots(family.polynomial)]
        modes += [(family.basis, [root, -root]) for root in roots]
    if frame.spheroid:
        gyration, stiffness = bar_equation(frame)
        root = complex(np.emath.sqrt(stiffness + (gyration**2).real / 4))
        modes += [(BAR, [gyration / 2 + sign * root]) for sign in (1, -1)]
    for basis, candidates in modes:
        # Of a spheroid each mode is followed in its own dependence on longitude, where it is not degenerate.
        fields = _turning_fields(basis) if frame.spheroid else np.eye(len(basis))
        stiff, gyre = (fields.conj().T @ matrix @ fields for matrix in stiffness_and_gyration(frame, basis))
        unit = np.eye(len(stiff))
        decompositions = [(rate, np.linalg.svd(rate**2 * unit - rate * gyre - stiff)) for rate in candidates]
        rate, (lefts, _, rights) = min(decompositions, key=lambda pair: pair[1][1][-1])
        left, right = lefts[:, -1].conj(), rights[-1].conj()
        slope = complex(left @ (2 * rate * unit - gyre) @ right)
        rates.append(rate)
        changes.append(change(rate, basis, left @ fields.conj().T, fields @ right) / slope)
    return rates, changes


def _turning_fields(basis) -> np.ndarray:
    """Columns: combinations of a basis whose second half is its first turned by a quarter of the period."""
    half = len(basis) // 2
    if basis is SYMMETRIC:
        return np.eye(2)
    return np.vstack([np.eye(half), 1j * np.eye(half)]) / math.sqrt(2)


def _viscous_operator(frame: SteadyFrame, basis, rate: complex) -> np.ndarray:
    """What unit viscosity adds to K + lambda C: -10 times the shear that a displacement gradient makes."""
    shape = np.diag(frame.axes)
    flow = frame.internal * shape @ TURN @ np.linalg.inv(shape)
    shears = np.array([rate * field + field @ flow - flow @ field for field in basis])
    shears = (shears + np.swapaxes(shears, 1, 2)) / 2
    return np.linalg.solve(masses_of(frame, basis), -10 * np.einsum("kij,lij->kl", np.array(basis), shears))


def _radiative_operator(frame: SteadyFrame, basis) -> np.ndarray:
    """What radiation adds to K, over lambda^5 and its coupling: minus the change of the quadrupole, times F."""
    squares = np.diag(frame.axes**2)
    moments = np.array([field @ squares + squares @ field.T for field in basis])
    moments = moments - np.trace(moments, axis1=1, axis2=2)[:, None, None] * np.eye(3) / 3
    forces = -np.einsum("kij,j,lij->kl", np.array(basis), frame.axes**2, moments)
    return np.linalg.solve(masses_of(frame, basis), forces)


def _circulation_rate(frame: SteadyFrame) -> float:
    """Rate, over the viscosity, at which the circulation of a triaxial figure changes while its shape follows."""
    stiffness, gyration = stiffness_and_gyration(frame, EVEN)
    near, far = slice(0, 2), slice(2, 4)
    follow = gyration[far, near] @ np.linalg.solve(stiffness[near, near], gyration[near, far])
    free = stiffness[far, far]  # against turning the figure or its labels: none, but that a tide holds the figure
    if frame.isolated:
        right = left = np.eye(2)
    else:
        values = np.linalg.svd(free)
        right, left = values[2][-1:].T, values[0][:, -1:].T
    inertia = left @ (np.eye(2) + follow) @ right
    friction = left @ np.real(_viscous_operator(frame, EVEN, 1.0))[far, far] @ right
    # without a tide the other rate is 0: the angular momentum is kept
    return float(np.trace(np.linalg.solve(inertia, friction)))
