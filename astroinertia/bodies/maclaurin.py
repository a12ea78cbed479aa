"""Maclaurin spheroids: homogeneous, rigidly rotating, axisymmetric; any flattening from sphere to disc.

    Omega^2/(pi G rho) = 2 (A_1 - (c/a)^2 A_3) = 2 (1 - (c/a)^2) B_13        (a = 1)

The figures are found by the second eccentricity l = sqrt(a^2 - c^2)/c, which resolves both the sphere (l -> 0) and the
disc (l -> infinity), and B_13 is a sum of positive terms: nothing cancels at either end.

Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 5. Tests: tests/unit/bodies/test_ellipsoids.py,
tests/hard/test_ellipsoids_hard.py.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from astroinertia.bodies.ellipsoid_gravity import index_integral, index_symbols
from astroinertia.bodies.homogeneous_ellipsoid import HomogeneousEllipsoid
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

_LOG_LEAST, _LOG_MOST = -300.0, 60.0  # ln l of the roots that are looked for: T/|W| of 1e-261, and 1/2 - 1e-26

_SAME = 1e-15  # difference of Omega^2 from its maximum that is round-off


@dataclass(frozen=True)
class MaclaurinSpheroid(HomogeneousEllipsoid):
    """A Maclaurin spheroid; `second_eccentricity` is sqrt(a^2 - c^2)/c."""

    second_eccentricity: float = 0.0

    @property
    def eccentricity(self) -> float:
        """e = sqrt(1 - c^2/a^2)."""
        return self.second_eccentricity / math.hypot(1.0, self.second_eccentricity)

    @property
    def flattening(self) -> float:
        """1 - c/a."""
        return self.eccentricity**2 / (1 + self.c_over_a)

    @property
    def second_zonal_harmonic(self) -> float:
        """J_2 = e^2/5."""
        return self.eccentricity**2 / 5

    @property
    def bar_mode_frequencies(self) -> tuple[complex, complex]:
        """The two m = 2 modes of second harmonics, Omega +- sqrt(4 pi G rho B_11 - Omega^2), in the inertial frame.

        Complex beyond the dynamical limit (the pair of growing and decaying bars); the second is zero at the
        bifurcation, where in the frame of the spheroid the first one is. Source: Chandrasekhar 1969, section 33.
        """
        unit = math.pi * self.gravitational_constant * self.density
        square = 4 * index_integral(_squares(self.second_eccentricity), (0, 1), 1) - self.omega2
        root = complex(square) ** 0.5 if square >= 0 else 1j * math.sqrt(-square)
        return tuple(math.sqrt(unit) * (math.sqrt(self.omega2) + sign * root) for sign in (1, -1))  # pyright: ignore[reportReturnType]

    @property
    def is_secularly_stable(self) -> bool:
        """Whether it is no flatter than at the bifurcation to the Jacobi ellipsoids, e = 0.812670."""
        return self.second_eccentricity <= bifurcation().second_eccentricity

    @property
    def is_dynamically_stable(self) -> bool:
        """Whether it is no flatter than at the dynamical bar instability, e = 0.952887."""
        return self.second_eccentricity <= dynamical_limit().second_eccentricity


def _squares(l: float) -> tuple[float, float, float]:  # noqa: E741
    return 1.0, 1.0, 1 / (1 + l * l)


@with_quantities()
def from_second_eccentricity(second_eccentricity: float, **scale: float) -> MaclaurinSpheroid:
    """Return the spheroid of given sqrt(a^2 - c^2)/c >= 0; `scale`: mass, mean_radius, gravitational_constant.

    ValueError unless it is finite. Source: Chandrasekhar 1969, ch. 5. Test: tests/unit/bodies/test_ellipsoids.py.

    >>> print(f"{from_second_eccentricity(1.0).eccentricity**2:.6f}")  # a^2 = 2 c^2
    0.500000
    """
    l = float(second_eccentricity)  # noqa: E741
    if not (0 <= l < math.inf):
        raise ValueError(f"a Maclaurin spheroid needs a flattening between the sphere's and the disc's, not l = {l}")
    squares = _squares(l)
    omega2 = 2 * (l * l * squares[2]) * index_integral(squares, (0, 2), 1)
    return MaclaurinSpheroid(1.0, math.sqrt(squares[2]), float(omega2), second_eccentricity=l).rescaled(**scale)


@with_quantities()
def from_eccentricity(eccentricity: float, **scale: float) -> MaclaurinSpheroid:
    """Return the spheroid of given e = sqrt(1 - c^2/a^2), 0 <= e < 1; ValueError outside.

    Source: Chandrasekhar 1969, ch. 5. Test: tests/unit/bodies/test_ellipsoids.py.

    >>> print(f"{from_eccentricity(0.8126700).rotational_to_gravitational:.4f}")  # where Jacobi ellipsoids branch off
    0.1375
    """
    if not (0 <= eccentricity < 1):
        raise ValueError(f"the eccentricity of a spheroid lies in 0 <= e < 1, not {eccentricity}")
    return from_second_eccentricity(eccentricity / math.sqrt((1 - eccentricity) * (1 + eccentricity)), **scale)


@with_quantities()
def from_axis_ratio(c_over_a: float, **scale: float) -> MaclaurinSpheroid:
    """Return the spheroid of given c/a, 0 < c/a <= 1; ValueError outside. Test: tests/unit/bodies/test_ellipsoids.py.

    >>> print(f"{from_axis_ratio(1.0).angular_velocity:.6f}")  # a sphere does not turn
    0.000000
    """
    if not (0 < c_over_a <= 1):
        raise ValueError(f"the axis ratio of a spheroid lies in 0 < c/a <= 1, not {c_over_a}")
    return from_second_eccentricity(math.sqrt((1 - c_over_a) * (1 + c_over_a)) / c_over_a, **scale)


@with_quantities()
def from_angular_velocity(
    angular_velocity: float, branch: Literal["slow", "fast"] = "slow", **scale: float
) -> MaclaurinSpheroid:
    """Return one of the two spheroids of given Omega: `slow` (e < 0.92996) or `fast` (flatter, with more momentum).

    Omega is in the units of `scale`. ValueError beyond Omega^2 = 0.449331 pi G rho, for Omega < 0, and for Omega = 0 on
    the fast branch (the disc of infinite radius). Source: Chandrasekhar 1969, ch. 5.
    Test: tests/unit/bodies/test_ellipsoids.py.

    >>> print(f"{from_angular_velocity(0.1).flattening:.5f}")  # about (5/4) Omega^2 R^3/(G M)
    0.01253
    """
    top = fastest()
    unit = math.pi * top.rescaled(**scale).gravitational_constant * top.rescaled(**scale).density
    target = angular_velocity**2 / unit
    if angular_velocity > 0 and abs(target / top.omega2 - 1) < _SAME:
        return top.rescaled(**scale)
    if branch not in ("slow", "fast"):
        raise ValueError(f"the branches of Maclaurin spheroids are slow and fast, not {branch!r}")
    if not angular_velocity >= 0:
        raise ValueError(f"the angular velocity of a spheroid is a number of 0 or more, not {angular_velocity}")
    if not target <= top.omega2:
        raise ValueError(
            f"no Maclaurin spheroid has Omega^2/(pi G rho) = {target:.9g}: it lies between 0 and {top.omega2:.9g}"
        )
    if target == 0 and branch == "fast":
        raise ValueError("the fast branch without rotation is a disc of infinite radius")
    log_top = math.log(top.second_eccentricity)
    ends = (_LOG_LEAST, log_top) if branch == "slow" else (log_top, _LOG_MOST)
    return _with(lambda body: body.omega2, target, ends, scale)


@with_quantities()
def from_angular_momentum(angular_momentum: float, **scale: float) -> MaclaurinSpheroid:
    """Return the spheroid of given L >= 0 (in the units of `scale`): there is one for each; ValueError for L < 0.

    Source: Chandrasekhar 1969, ch. 5. Test: tests/unit/bodies/test_ellipsoids.py.

    >>> print(f"{from_angular_momentum(0.303751).rotational_to_gravitational:.4f}")  # the bifurcation
    0.1375
    """
    unit = from_second_eccentricity(0.0, **scale)
    target = angular_momentum / math.sqrt(unit.gravitational_constant * unit.mass**3 * unit.mean_radius)
    if not (0 <= target < math.inf):
        raise ValueError(f"the angular momentum has to be finite and zero or more, not {angular_momentum}")
    return _with(lambda body: body.angular_momentum, target, (_LOG_LEAST, _LOG_MOST), scale)


@with_quantities()
def from_energy_ratio(rotational_to_gravitational: float, **scale: float) -> MaclaurinSpheroid:
    """Return the spheroid of given T/|W|, 0 <= T/|W| < 1/2; ValueError outside.

    Source: Chandrasekhar 1969, ch. 5. Test: tests/unit/bodies/test_ellipsoids.py.

    >>> print(f"{from_energy_ratio(0.1).rotational_to_gravitational:.6f}")
    0.100000
    """
    if not (0 <= rotational_to_gravitational < 0.5):
        raise ValueError(f"T/|W| of a Maclaurin spheroid lies in 0 <= T/|W| < 1/2, not {rotational_to_gravitational}")
    ends = (_LOG_LEAST, _LOG_MOST)
    return _with(lambda body: body.rotational_to_gravitational, rotational_to_gravitational, ends, scale)


def _with(quantity: Callable[[MaclaurinSpheroid], float], target: float, ends, scale) -> MaclaurinSpheroid:
    """The spheroid of unit mass, mean radius and G with quantity = target, then scaled."""
    if target == 0:
        return from_second_eccentricity(0.0, **scale)

    def excess(log_l: float) -> float:
        return math.log(quantity(from_second_eccentricity(math.exp(log_l))) / target)

    low, high = (excess(end) for end in ends)
    if low * high > 0:  # beyond the ends by round-off, or so close to zero or to a disc that it is one
        nearest = ends[0] if abs(low) < abs(high) else ends[1]
        if min(abs(low), abs(high)) > 1e-12:
            raise ValueError(f"a Maclaurin spheroid this close to a sphere or a disc is out of range: {target}")
        return from_second_eccentricity(math.exp(nearest), **scale)
    return from_second_eccentricity(math.exp(root_between(excess, *ends)), **scale)


@lru_cache(maxsize=1)
def bifurcation() -> MaclaurinSpheroid:
    """Return the spheroid where the Jacobi ellipsoids branch off (secular limit): a^4 A_11 = c^2 A_3, T/|W| = 0.137528.

    Source: Chandrasekhar 1969, section 39, eq. 4 with b = a. Test: tests/hard/test_ellipsoids_hard.py.

    >>> print(f"{bifurcation().rotational_to_gravitational:.6f}, e = {bifurcation().eccentricity:.6f}")
    0.137528, e = 0.812670
    """

    def difference(l: float) -> float:  # noqa: E741
        squares = _squares(l)
        axes = [1.0, 1.0, math.sqrt(squares[2])]
        return float(index_integral(squares, (0, 1), 0) - squares[2] * index_symbols(axes)[2])

    return from_second_eccentricity(root_between(difference, 1.0, 2.0))


@lru_cache(maxsize=1)
def dynamical_limit() -> MaclaurinSpheroid:
    """Return the spheroid where the bar mode becomes complex: Omega^2 = 4 pi G rho B_11, T/|W| = 0.273823.

    Source: Chandrasekhar 1969, section 33. Test: tests/hard/test_ellipsoids_hard.py.

    >>> print(f"{dynamical_limit().rotational_to_gravitational:.6f}, e = {dynamical_limit().eccentricity:.6f}")
    0.273823, e = 0.952887
    """

    def difference(l: float) -> float:  # noqa: E741
        return from_second_eccentricity(l).omega2 - float(4 * index_integral(_squares(l), (0, 1), 1))

    return from_second_eccentricity(root_between(difference, 2.0, 5.0))


@lru_cache(maxsize=1)
def fastest() -> MaclaurinSpheroid:
    """Return the spheroid of the largest Omega^2/(pi G rho), 0.449331, at e = 0.929956.

    There the slope of Omega^2/(2 pi G rho) = ((3 + l^2) arctan l - 3 l)/l^3 is zero:
    (1 + l^2)(9 + l^2) arctan l = 9 l + 7 l^3.
    Source: Chandrasekhar 1969, ch. 5. Test: tests/unit/bodies/test_ellipsoids.py.

    >>> print(f"{fastest().omega2:.6f}")  # Omega^2/(pi G rho)
    0.449331
    """

    def slope(l: float) -> float:  # noqa: E741
        return (1 + l * l) * (9 + l * l) * math.atan(l) - l * (9 + 7 * l * l)

    return from_second_eccentricity(root_between(slope, 2.0, 3.0))
