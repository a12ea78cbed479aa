"""What an evolving ellipsoid x = F X does: its bar and pattern speed, internal flow, circulation, energies, fission.

All is seen along a fixed axis, by default z. In the plane across it the distortion

    eta = ((Q_xx - Q_yy)^2 + 4 Q_xy^2)^(1/2)/(Q_xx + Q_yy)

is the strength of the bar, (a^2 - b^2)/(a^2 + b^2) where c lies along the axis. The pattern speed is the rate of its
phase, and the internal rate, for motion about the axis, that of the adjoint F^T (Dedekind) with the opposite sign.

Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 4 and 7; Saijo, Shibata, Baumgarte & Shapiro 2001,
ApJ 548, 919 (the distortion).
"""

from typing import NamedTuple

import numpy as np

from astroinertia.inertia.growth import growth
from astroinertia.inertia.tensor import axial_vector, twice_symmetric
from astroinertia.process.quantities import with_quantities
from astroinertia.process.vectors import of_any_length

_ROUND_OFF = 1e-13  # strength below which what is seen of a bar is round-off
_FEWEST = 3  # points that a growth rate is fitted to


class BarHistory(NamedTuple):
    """Arrays of the shape of the times, (...,), and (..., 3) where said; angles in radians, the rest in given units.

    axes (..., 3): semi-axes, the longest first; bar_strength: eta; bar_phase, within pi; pattern_speed: Omega, and
    internal_rate: Lambda, nan without a bar; vorticity_ratio: f = zeta/Omega; angular_momentum and circulation, both
    (..., 3) and kept by gravity and pressure: L, and minus that of the adjoint motion, (M/5)(2 a b Omega + (a^2 +
    b^2) Lambda); kinetic_energy; rotational_to_gravitational: T/|W|, of all motion; past_pear: whether b/a has fallen
    below that of the Jacobi ellipsoid where pear-shaped figures branch off: one in rigid rotation then comes apart.
    """

    axes: np.ndarray
    bar_strength: np.ndarray
    bar_phase: np.ndarray
    pattern_speed: np.ndarray
    internal_rate: np.ndarray
    vorticity_ratio: np.ndarray
    angular_momentum: np.ndarray
    circulation: np.ndarray
    kinetic_energy: np.ndarray
    rotational_to_gravitational: np.ndarray
    past_pear: np.ndarray


@with_quantities()
def bar_history(
    deformation,
    deformation_rate,
    mass: float = 1.0,
    mean_radius: float = 1.0,
    gravitational_constant: float = 1.0,
    axis=(0.0, 0.0, 1.0),
) -> BarHistory:
    """Return what a homogeneous ellipsoid does at each time, from F and dF/dt (..., 3, 3) of its sphere of mean_radius.

    axis (3,): the line of sight, of any length. ValueError for arrays of another shape or that are not finite, and for
    an axis of length 0. Source: Chandrasekhar 1969.

    >>> from astroinertia.bodies.riemann import dedekind
    >>> figure = dedekind(0.6)
    >>> seen = bar_history(figure.deformation(2.0), figure.deformation_rate(2.0))
    >>> print(f"{abs(seen.pattern_speed):.6f} {seen.internal_rate / figure.internal_angular_velocity:.6f}")  # it stands
    0.000000 1.000000
    """
    from astroinertia.bodies import jacobi  # only here: who opens a file has no need of ellipsoids
    from astroinertia.bodies.ellipsoid_gravity import gravitational_energy

    matrix, rate = np.asarray(deformation, float), np.asarray(deformation_rate, float)
    if matrix.shape[-2:] != (3, 3) or rate.shape != matrix.shape:
        raise ValueError(f"F and dF/dt are (..., 3, 3) each, not {matrix.shape} and {rate.shape}")
    if not (np.isfinite(matrix).all() and np.isfinite(rate).all()):
        raise ValueError("F and dF/dt must be finite")
    adjoint, adjoint_rate = np.swapaxes(matrix, -1, -2), np.swapaxes(rate, -1, -2)
    mixed, mixed_adjoint = matrix @ adjoint_rate, adjoint @ rate
    moment = mass * mean_radius**2 / 5
    axes = mean_radius * np.linalg.svd(matrix, compute_uv=False)
    strength, phase, pattern = bar(matrix @ adjoint, mixed, axis)
    internal = -bar(adjoint @ matrix, mixed_adjoint, axis)[2]
    kinetic = 0.5 * moment * (rate**2).sum((-1, -2))
    binding = np.array([gravitational_energy(abc, mass, gravitational_constant) for abc in axes.reshape(-1, 3)])
    # b/a + a/b in the plane of the bar: 2/(1 - eta^2)^(1/2)
    ratio = 2 / np.sqrt((1 - strength) * (1 + strength))
    with np.errstate(divide="ignore", invalid="ignore"):
        vorticity_ratio = ratio * internal / pattern
    return BarHistory(
        axes,
        strength,
        phase,
        pattern,
        internal,
        vorticity_ratio,
        axial_vector(moment * mixed),
        -axial_vector(moment * mixed_adjoint),
        kinetic,
        kinetic / -binding.reshape(kinetic.shape),
        axes[..., 1] / axes[..., 0] < jacobi.pear_bifurcation().b_over_a,
    )


@with_quantities()
def bar(second_moment, mixed_moment, axis=(0.0, 0.0, 1.0)) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return strength eta, phase and pattern speed (...,) of the bar of any body, from its Q and P = sum m x (x) v.

    second_moment and mixed_moment (..., 3, 3), as every dataset has them; axis (3,): the line of sight. The phase is
    within pi of the first direction across the axis (x for z); without a bar, of a strength beyond round-off, the
    pattern speed is nan. ValueError for an axis of length 0. Source: Saijo et al. 2001.

    >>> moved = np.diag([4.0, 1.0, 1.0])  # a bar twice as long as wide, which turns rigidly by 0.3
    >>> strength, phase, pattern = bar(moved, 0.3 * moved @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 0]]))
    >>> print(f"{strength:.1f} {phase:.1f} {pattern:.1f}")
    0.6 0.0 0.3
    """
    plane = _plane(np.asarray(axis, float))
    mixed = np.asarray(mixed_moment, float)
    seen, change = (plane @ matrix @ plane.T for matrix in (np.asarray(second_moment, float), twice_symmetric(mixed)))
    plus, cross = seen[..., 0, 0] - seen[..., 1, 1], 2 * seen[..., 0, 1]
    turning = plus * 2 * change[..., 0, 1] - cross * (change[..., 0, 0] - change[..., 1, 1])
    size2 = plus**2 + cross**2
    spread = seen[..., 0, 0] + seen[..., 1, 1]  # nothing, of a point or of a rod along the axis
    pattern = np.divide(turning, 2 * size2, out=np.full_like(size2, np.nan), where=size2 > (_ROUND_OFF * spread) ** 2)
    strength = np.divide(np.sqrt(size2), spread, out=np.full_like(size2, np.nan), where=spread > 0)
    return strength, np.arctan2(cross, plus) / 2, pattern


@with_quantities()
def growth_rate(times, strength, low: float, high: float) -> float:
    """Return the rate of exponential growth of a bar while its strength (T,) at times (T,) rises from low to high.

    A least-squares line through ln(strength), from the last time that it passes `low` before it first reaches `high`.
    ValueError when fewer than three points lie between, and unless 0 < low < high.

    >>> times = np.linspace(0.0, 10.0, 50)
    >>> print(f"{growth_rate(times, 1e-3 * np.exp(0.5 * times), 0.01, 0.1):.6f}")
    0.500000
    """
    times, strength = np.asarray(times, float), np.asarray(strength, float)
    if not 0 < low < high:
        raise ValueError(f"a bar grows from a low strength above 0 to a higher one, not from {low:g} to {high:g}")
    if times.ndim != 1 or strength.shape != times.shape:
        raise ValueError(f"strengths {strength.shape} do not go with times {times.shape}: both are (T,)")
    reached = np.nonzero(strength >= high)[0]
    end = int(reached[0]) if len(reached) else len(strength)
    below = np.nonzero(strength[:end] < low)[0]
    begin = int(below[-1]) + 1 if len(below) else 0
    if end - begin < _FEWEST:
        raise ValueError(f"{end - begin} points lie between {low:g} and {high:g}: a growth rate needs {_FEWEST}")
    return growth(times[begin:end], strength[begin:end]).slope


def _plane(axis: np.ndarray) -> np.ndarray:
    """Two unit vectors (2, 3) that span the plane across the axis, right-handed with it: x and y for z."""
    if axis.shape != (3,) or not np.isfinite(axis).all() or not axis.any():
        raise ValueError(
            f"the axis along which a bar is seen is a vector of three finite numbers, not {axis.tolist()!r}"
        )
    direction = of_any_length(axis)
    pole = direction / np.linalg.norm(direction)
    aside = np.eye(3)[int(np.argmin(np.abs(pole)))]
    first = np.array([1.0, 0.0, 0.0]) if np.array_equal(pole, [0.0, 0.0, 1.0]) else np.cross(aside, pole)
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(pole, first)])
