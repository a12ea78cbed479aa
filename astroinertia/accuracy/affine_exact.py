"""Exact motions of fluids whose velocity is linear in position: x = F xi over the unit sphere, by F alone.

Dyson's isentropic gas (free, or in a quadratic field: a toy star), uniform ellipsoids without pressure, with the
parabolic pressure of Riemann's family, or incompressible. d2F/dt2 is integrated by scipy's DOP853 from forces by
index symbols along the principal axes; nothing is shared with the model `ellipsoid`, whose forces are Carlson integrals
of F F^T under JAX and whose integrator is diffrax's. A figure in equilibrium is a closed form, without any integration.

Sources: Dyson 1968, J. Math. Mech. 18, 91; Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 4; Lynden-Bell
1964, ApJ 139, 1195. Tests: tests/unit/accuracy/test_exact.py.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from astroinertia.bodies.ellipsoid_gravity import index_symbols
from astroinertia.bodies.riemann import TURN, rotation_about_z
from astroinertia.inertia.spin import angular_velocity
from astroinertia.inertia.tensor import axial_vector, inertia_from_second_moment

Array = Any
Acceleration = Callable[[Array, Array], Array]
_RELATIVE, _ABSOLUTE = 1e-13, 1e-15  # error allowed in a step; the absolute one over the size of what is integrated
INTEGRATED = 1e-12  # what is left of them at the end of a motion of some dynamical times
_STEADY = 1e-9  # of the forces: what may be left of them in a figure that counts as one of equilibrium


def gravity(mass: float) -> Acceleration:
    """Of the uniform ellipsoid itself: -(3/2) M/(abc) A_i along each principal axis (G = 1)."""

    def acceleration(at: Array, _: Array) -> Array:
        left, axes, right = np.linalg.svd(at)
        return -1.5 * mass / np.prod(axes) * left @ np.diag(index_symbols(axes) * axes) @ right

    return acceleration


def gas_pressure(enthalpy: float, volume: float, gamma: float) -> Acceleration:
    """Of P/rho falling as 1 - s^2 in such a way that a = 2 h (J_0/J)^(gamma - 1) F^-T, h (enthalpy) at J_0 (volume)."""

    def acceleration(at: Array, _: Array) -> Array:
        return 2.0 * enthalpy * (volume / np.linalg.det(at)) ** (gamma - 1.0) * np.linalg.inv(at).T

    return acceleration


def field(matrix: Array) -> Acceleration:
    """Of an outer potential x.A.x/2."""
    return lambda at, _: -np.asarray(matrix) @ at


def total(parts: list[Acceleration]) -> Acceleration:
    """Their sum."""
    return lambda at, moving: sum((part(at, moving) for part in parts), np.zeros((3, 3)))


def incompressible(others: Acceleration) -> Acceleration:
    """With the pressure that keeps the volume: the share of F^-T by which d2 ln J/dt2 = 0 (Dirichlet's problem)."""

    def acceleration(at: Array, moving: Array) -> Array:
        free, inverse = others(at, moving), np.linalg.inv(at)
        flow = moving @ inverse
        push = (np.trace(flow @ flow) - np.trace(inverse @ free)) / np.trace(inverse @ inverse.T)
        return free + push * inverse.T

    return acceleration


def motion(start: Array, rate: Array, acceleration: Acceleration, until: float) -> tuple[Array, Array]:
    """F and dF/dt (3, 3) at a time; RuntimeError where the body has collapsed before."""
    first = np.concatenate([np.ravel(start), np.ravel(rate)])
    size = float(np.abs(first).max())

    def rates(_: float, state: Array) -> Array:
        at, moving = state.reshape(2, 3, 3)
        return np.concatenate([moving.ravel(), acceleration(at, moving).ravel()])

    solution = solve_ivp(rates, (0.0, until), first, method="DOP853", rtol=_RELATIVE, atol=_ABSOLUTE * size)
    if not solution.success:
        raise RuntimeError(str(solution.message))
    return tuple(solution.y[:, -1].reshape(2, 3, 3))


def steady_rates(start: Array, rate: Array, acceleration: Acceleration) -> tuple[float, float, float] | None:
    """Omega and Lambda of a figure in equilibrium with axes along x, y and z that turns about z; None for others.

    The third number is the share of the forces that is not in balance, by which it departs from equilibrium. The motion
    is then F = R(Omega t) F_0 R(Lambda t) for ever (Riemann's ellipsoids of type S; Lambda = 0 where a = b).
    """
    axes = np.diag(start)
    gradient = rate @ np.linalg.inv(start)
    planar = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    pace = float(np.abs(gradient).max())
    if not np.allclose(start, np.diag(axes), atol=1e-14 * axes.max()) or np.abs(gradient * (1 - planar)).max() > 0.0:
        return None
    a, b = axes[:2]
    if a == b:
        spin, inner = gradient[1, 0], 0.0
        if abs(gradient[0, 1] + spin) > _STEADY * pace:
            return None
    else:
        # G_xy = -Omega - Lambda a/b and G_yx = Omega + Lambda b/a
        inner = (gradient[0, 1] + gradient[1, 0]) / (b / a - a / b)
        spin = gradient[1, 0] - inner * b / a
    turned = spin**2 * TURN @ TURN @ start + 2.0 * spin * inner * TURN @ start @ TURN
    turned = turned + inner**2 * start @ TURN @ TURN
    forces = acceleration(start, rate)
    scale = max(np.abs(turned).max(), np.abs(gravity(1.0)(start, rate)).max())
    left = float(np.abs(forces - turned).max() / scale)
    return (float(spin), float(inner), left) if left <= _STEADY else None


def steady_motion(start: Array, spin: float, inner: float, time: float) -> tuple[Array, Array]:
    """F and dF/dt (3, 3) of a figure in equilibrium at a time."""
    at = rotation_about_z(spin * time) @ start @ rotation_about_z(inner * time)
    return at, spin * TURN @ at + inner * at @ TURN


def observables(at: Array, moving: Array, moment: float) -> dict[str, np.ndarray]:
    """Variables of the dataset from F and dF/dt and the second moment of the unit sphere along an axis (code units)."""
    second, mixed = moment * at @ at.T, moment * at @ moving.T
    inertia = np.asarray(inertia_from_second_moment(second))
    momentum = np.asarray(axial_vector(mixed))
    return {
        "second_moment": second,
        "inertia_tensor": inertia,
        "angular_momentum": momentum,
        "angular_velocity": np.asarray(angular_velocity(inertia, momentum)),
    }


def central_enthalpy(entropy: float, mass: float, volume: float, gamma: float) -> float:
    """Enthalpy A gamma/(gamma - 1) rho_c^(gamma - 1) at the centre of Dyson's gas, semi-axes of product `volume`."""
    n = 1.0 / (gamma - 1.0)
    density = math.exp(math.lgamma(n + 2.5) - math.lgamma(n + 1.0)) / math.pi**1.5 * mass / volume
    return entropy * gamma / (gamma - 1.0) * density ** (gamma - 1.0)
