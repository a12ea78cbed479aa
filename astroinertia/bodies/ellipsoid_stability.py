"""Linear stability of homogeneous incompressible ellipsoids that are steady in a turning frame, to second harmonics.

A body moves as x = R(Omega t) G(t) R(Lambda t) X, where G = diag(a, b, c) is steady. The equations of Riemann and
Dirichlet for G (gravity, frame, tide, a pressure that keeps det G) are linearised exactly, for G = (1 + x)
diag(a, b, c); that the volume stays is tr x = 0. Displacements even in z and odd in z part, and in each, by the
symmetry of a steady figure under y -> -y, t -> -t, the squares of the rates, lambda^2, are the eigenvalues of a 4 by 4
matrix. Known rates of motions that only turn the body or its labels are divided out of its characteristic polynomial,
so that what is left is smooth where modes meet: growth rates vanish like a root there, but points of onset are simple
zeros, found to round-off.

A figure and its adjoint have the same rates (transpose F). Finer motions are another matter: Jacobi ellipsoids are lost
to pears at b/a = 0.432, and most figures with internal flow to short waves (Lebovitz & Lifschitz 1996, ApJ 458, 699).

Source: Chandrasekhar 1969, Ellipsoidal Figures of
Equilibrium, ch. 5 to 8; Riemann 1861, Abh. Koenigl. Ges. Wiss. Goettingen 9, 3; Rossner 1967, ApJ 149, 145 (the
equations for F). Tests: tests/unit/bodies/test_ellipsoid_stability.py, tests/hard/test_riemann_hard.py.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from astroinertia.bodies.ellipsoid_gravity import index_symbols
from astroinertia.bodies.homogeneous_ellipsoid import HomogeneousEllipsoid
from astroinertia.bodies.riemann import TURN, RiemannEllipsoid
from astroinertia.bodies.roche import RocheEllipsoid
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

_SPHERE_ENERGY = -4.0  # W/(M R^2/5) of the sphere for pi G rho = 1
_BALANCED = 1e-9  # share of the forces that may be left over in a figure that counts as steady
_ROUNDING = 1e-14  # of the margin, where modes meet that do not interact


def _unit(i: int, j: int) -> np.ndarray:
    matrix = np.zeros((3, 3))
    matrix[i, j] = 1.0
    return matrix


# Displacement gradients x, by parity in z and then in y: the first half of each keeps its form under y -> -y.
# With three axes a body is long rather than flat: its even ones are across the needle and along it.
EVEN = (np.diag([0.0, 1.0, -1.0]), np.diag([2.0, -1.0, -1.0]), _unit(0, 1), _unit(1, 0))
ODD = (_unit(0, 2), _unit(2, 0), _unit(1, 2), _unit(2, 1))
SYMMETRIC = (np.diag([1.0, 1.0, -2.0]), _unit(1, 0) - _unit(0, 1))  # of a spheroid, instead of EVEN
BAR = (np.diag([1.0, -1.0, 0.0]), _unit(1, 0) + _unit(0, 1))


@dataclass(frozen=True)
class Spectrum:
    """Squared rates lambda^2 (complex, in the squared unit of time of the body) of the second-harmonic modes.

    even, odd: of displacements that are even and odd in z, seen in the frame of the figure, without the motions that
    only turn it. growth_rate: the largest real part of a rate, 0 where stable. margin: positive where stable, negative
    where not, and continuous in between: the least of the conditions for real negative lambda^2, in units of pi G rho.
    """

    even: np.ndarray
    odd: np.ndarray
    growth_rate: float
    margin: float

    @property
    def is_stable(self) -> bool:
        """Whether nothing grows without friction."""
        return self.margin >= -_ROUNDING


class Family(NamedTuple):
    """Modes of one symmetry: their displacement gradients, and the polynomial of their lambda^2."""

    basis: tuple[np.ndarray, ...]
    polynomial: np.ndarray


@dataclass(frozen=True)
class SteadyFrame:
    """A figure with pi G rho = R = M = 1 in a frame in which it is steady, and the equations of motion near it.

    axes (3,), Omega, Lambda, tide (3,); gradient and gyration (9, 9): K and C of d2G/dt2 = K dG + C d(dG)/dt, but for
    the pressure's change; time: the body's own unit of time in that of the frame.
    """

    axes: np.ndarray
    turning: float
    internal: float
    tide: np.ndarray
    gradient: np.ndarray
    gyration: np.ndarray
    spheroid: bool
    time: float

    @property
    def isolated(self) -> bool:
        """Whether there is no tide."""
        return not self.tide.any()


def steady_frame(body: HomogeneousEllipsoid) -> SteadyFrame:
    """Return the frame of a Maclaurin, Jacobi, Riemann or Roche figure; of a spheroid the inertial one.

    ValueError for a figure that is not in balance. Source: Rossner 1967. Test:
    tests/unit/bodies/test_ellipsoid_stability.py.
    """
    axes = body.axes / body.mean_radius
    internal = body.internal_rate if isinstance(body, RiemannEllipsoid) else 0.0
    tide = body.tide * np.array([2.0, -1.0, -1.0]) if isinstance(body, RocheEllipsoid) else np.zeros(3)
    turning = math.sqrt(body.omega2)
    spheroid = body.b_over_a == 1 and not tide.any()
    if spheroid:
        turning, internal = 0.0, turning + internal
    balance = axes * _balance(axes, turning, internal, tide)
    if abs(balance - balance[2]).max() > _BALANCED * np.max(axes**2 * index_symbols(axes)):
        raise ValueError(
            "the stability of an ellipsoid is that of a figure in balance by itself or, as Roche's, in the tide of a "
            "point mass, which this one is not"
        )
    # dG/dt in space is dG/dt + T G with T = Omega J . + Lambda . J, so that 2 T and T T are Coriolis's and the
    # centrifugal force; the pressure, of 2 p_c/rho = balance, pushes along the cofactors of G.
    turn = np.kron(turning * TURN, np.eye(3)) + np.kron(np.eye(3), internal * TURN.T)
    gradient = _gravity_jacobian()(axes) + np.diag(np.repeat(tide, 3)) - turn @ turn
    gradient = gradient + balance[2] * _cofactor_jacobian(axes)
    time = math.sqrt(math.pi * body.gravitational_constant * body.density)
    return SteadyFrame(axes, turning, internal, tide, gradient, -2 * turn, spheroid, time)


def _balance(axes: np.ndarray, turning: float, internal: float, tide: np.ndarray) -> np.ndarray:
    """Gravity, tide and frame along the three axes, (3,): in balance their products with the axes are equal."""
    a, b, _ = axes
    centrifugal = (turning**2 + internal**2) * np.array([a, b, 0.0]) + 2 * turning * internal * np.array([b, a, 0.0])
    return 2 * index_symbols(axes) * axes - tide * axes - centrifugal


@cache
def _gravity_jacobian() -> Callable[[np.ndarray], np.ndarray]:
    """The function diag(axes) -> d(gravity)/dF, (9, 9), compiled once."""
    import jax  # only here: figures themselves need no compiler
    import jax.numpy as jnp

    from astroinertia.bodies.affine import gravity_force
    from astroinertia.engines.brief import brief

    @brief
    def jacobian(axes):
        return jax.jacfwd(lambda deformation: gravity_force(deformation, _SPHERE_ENERGY))(jnp.diag(axes))

    def in_double(axes: np.ndarray) -> np.ndarray:
        with jax.enable_x64(True):
            return np.asarray(jacobian(jnp.asarray(axes, dtype=jnp.float64))).reshape(9, 9)

    return in_double


def stiffness_and_gyration(frame: SteadyFrame, basis) -> tuple[np.ndarray, np.ndarray]:
    """Return K and C of d2x/dt2 = K x + C dx/dt for the coefficients of displacement gradients `basis`, (n, n) each.

    The basis is of trace 0 and closed under the equations. Source: Rossner 1967. Test: as of `spectrum`.
    """
    # The change of pressure pushes along the cofactors, and does no work on a displacement that keeps the volume.
    fields = np.array([(field * frame.axes).ravel() for field in basis]).T
    masses = masses_of(frame, basis)
    parts = (fields.T @ matrix @ fields for matrix in (frame.gradient, frame.gyration))
    stiffness, gyration = (np.linalg.solve(masses, matrix) for matrix in parts)
    return stiffness, gyration


def masses_of(frame: SteadyFrame, basis) -> np.ndarray:
    """Return the matrix (n, n) of twice the kinetic energy of displacement gradients over that of d(F)/dt."""
    return np.einsum("kij,j,lij->kl", np.array(basis), frame.axes**2, np.array(basis))


def _cofactor_jacobian(axes: np.ndarray) -> np.ndarray:
    """d cof(F)/dF, (9, 9), at diag(axes): cof_ii = F_jj F_kk - ..., cof_ij = -F_ji F_kk + ..."""
    slopes = np.zeros((3, 3, 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (1, 0, 2), (2, 1, 0), (0, 2, 1)):
        slopes[i, i, j, j] = axes[k]
        slopes[i, j, j, i] = -axes[k]
    return slopes.reshape(9, 9)


def _squared_polynomial(frame: SteadyFrame, basis) -> np.ndarray:
    """The characteristic polynomial, highest power first, of the matrix whose eigenvalues are lambda^2."""
    stiffness, gyration = stiffness_and_gyration(frame, basis)
    near, far = slice(0, 2), slice(2, 4)  # the parts that keep the form under y -> -y and those that change it
    there, back = gyration[near, far], gyration[far, near]
    first = stiffness[near, near]
    matrix = np.block([[first, there], [back @ first, stiffness[far, far] + back @ there]])
    coefficients, power = [1.0], np.eye(4)
    for order in range(1, 5):  # Faddeev and LeVerrier
        product = matrix @ power
        coefficients.append(-float(np.trace(product)) / order)
        power = product + coefficients[-1] * np.eye(4)
    return np.array(coefficients)


def _divided(polynomial: np.ndarray, root: float) -> np.ndarray:
    """The polynomial without a root that it is known to have."""
    return np.polydiv(polynomial, [1.0, -root])[0]


def _margin(polynomial: np.ndarray) -> float:
    """The least of what has to be positive for all roots to be real and negative, each in units of pi G rho."""
    degree = len(polynomial) - 1
    conditions = [float(np.sign(term) * abs(term) ** (1 / k)) for k, term in enumerate(polynomial[1:], start=1)]
    if degree == 2:
        _, b, c = polynomial
        conditions.append((b * b - 4 * c) / max(1.0, abs(b)))
    if degree == 3:
        _, b, c, d = polynomial
        square = b * b * c * c - 4 * c**3 - 4 * b**3 * d - 27 * d * d + 18 * b * c * d
        conditions.append(square / max(1.0, abs(b)) ** 5)
    return min(conditions)


def bar_equation(frame: SteadyFrame) -> tuple[complex, float]:
    """Return c and k of lambda^2 = c lambda + k for the bar e^(2 i phi) of a spheroid in the inertial frame.

    c = -2 i Omega and k = 2 Omega^2 - 4 pi G rho B_11 come out. Source: Chandrasekhar 1969, section 33.
    Test: tests/unit/bodies/test_ellipsoid_stability.py.
    """
    stiffness, gyration = stiffness_and_gyration(frame, BAR)
    return 1j * float(gyration[0, 1] - gyration[1, 0]) / 2, float(stiffness[0, 0] + stiffness[1, 1]) / 2


def spectrum(body: HomogeneousEllipsoid) -> Spectrum:
    """Return the rates of all second-harmonic modes of a steady figure without friction, and whether any grows.

    The companion of a Roche ellipsoid stays on its orbit. Of a spheroid, bars are seen in the inertial frame.
    ValueError for a figure that is not in balance. Source: Chandrasekhar 1969, sections 33, 41, 49 and 57.
    Test: tests/unit/bodies/test_ellipsoid_stability.py.

    >>> from astroinertia.bodies import maclaurin
    >>> print([spectrum(maclaurin.from_eccentricity(e)).margin > 0 for e in (0.9, 0.96)])  # stable until e = 0.9529
    [True, False]
    """
    frame = steady_frame(body)
    if frame.turning == frame.internal == 0:
        even, odd, margin = _at_rest(frame)
    else:
        kept, tilts = families(frame)
        even, odd = [np.roots(kept.polynomial)], np.roots(tilts.polynomial)
        margin = min(_margin(kept.polynomial), _margin(tilts.polynomial))
        if frame.spheroid:
            gyration, stiffness = bar_equation(frame)
            growth2 = stiffness + (gyration**2).real / 4
            even.append((gyration / 2 + np.emath.sqrt(growth2) * np.array([1, -1])) ** 2)
            margin = min(margin, -growth2)
        even = np.concatenate(even)
    even, odd = (frame.time**2 * np.sort_complex(np.asarray(roots, complex)) for roots in (even, odd))
    if margin >= -_ROUNDING:
        return Spectrum(np.real(even) + 0j, np.real(odd) + 0j, 0.0, float(margin))
    return Spectrum(even, odd, float(np.real(np.sqrt(np.append(even, odd))).max()), float(margin))


def families(frame: SteadyFrame) -> tuple[Family, Family]:
    """Return the modes of a moving figure that are even in z, but for the bars of a spheroid, and the odd ones."""
    tilts = _divided(_squared_polynomial(frame, ODD), -(frame.internal**2))
    if frame.isolated:
        tilts = _divided(tilts, -(frame.turning**2))
    if frame.spheroid:
        stiff, gyre = stiffness_and_gyration(frame, SYMMETRIC)
        kept = Family(SYMMETRIC, np.array([1.0, -stiff[0, 0] - gyre[0, 1] * gyre[1, 0]]))
    else:
        whole = _squared_polynomial(frame, EVEN)
        kept = Family(EVEN, whole[:3] if frame.isolated else whole[:4])  # the roots left out are 0
    return kept, Family(ODD, tilts)


def _at_rest(frame: SteadyFrame) -> tuple[np.ndarray, np.ndarray, float]:
    """Squared rates, even and odd, and margin of a figure without motion, where turning the labels costs nothing."""
    (even, _), (odd, _) = (stiffness_and_gyration(frame, basis) for basis in (EVEN, ODD))
    stretches = np.real(np.linalg.eigvals(even[:2, :2]))
    shears = [float(np.trace(block)) for block in (even[2:, 2:], odd[:2, :2], odd[2:, 2:])]
    return np.append(stretches, shears[0]), np.array(shears[1:]), -float(max(*stretches, *shears))


@with_quantities()
def onset(figure: Callable[[float], HomogeneousEllipsoid], low: float, high: float) -> float:
    """Return the parameter between `low` and `high` at which figure(parameter) begins to be unstable without friction.

    The root of the margin, to round-off. ValueError unless one end is stable and the other not.
    Test: tests/unit/bodies/test_ellipsoid_stability.py.

    >>> from astroinertia.bodies import maclaurin
    >>> print(f"{onset(maclaurin.from_eccentricity, 0.9, 0.99):.6f}")  # bars grow by themselves
    0.952887
    """
    return root_between(lambda parameter: spectrum(figure(parameter)).margin, low, high)
