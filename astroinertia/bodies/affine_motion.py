"""Forces and equations of motion of a body whose matter moves as x = F xi: pure JAX.

With q the second moment of the reference sphere along an axis, the moments are Q = q F F^T, P = q F (dF/dt)^T and
K = q dF/dt (dF/dt)^T. A force is given by G = sum m a (x) xi, (3, 3), so that q d2F/dt2 is the sum over all forces,
V = F G^T is the virial tensor of each, and its power is G : dF/dt. This is the problem of Dirichlet and Riemann where
the density is uniform, and the tensor virial equations of second order for other profiles.

Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 4; Carter & Luminet 1985, MNRAS 212, 23 (affine
stars).
"""

import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

from astroinertia.bodies.affine import cofactor, gravity_force, volume_ratio
from astroinertia.inertia.double_precision import double_precision
from astroinertia.inertia.tensor import axial_vector
from astroinertia.process.quantities import with_quantities

Array = Any
Acceleration = Callable[[Array, Array], Array]
"""d2F/dt2 of F and dF/dt."""


@with_quantities()
@double_precision()
def velocity_gradient(deformation: Array, rate: Array) -> Array:
    """Return L with v = L x, (3, 3), from F and dF/dt (3, 3).

    >>> print(velocity_gradient(2 * np.eye(3), np.eye(3))[0, 0])  # v = x/2
    0.5
    """
    return rate @ cofactor(deformation).T / volume_ratio(deformation)


@with_quantities()
@double_precision()
def circulation(deformation: Array, rate: Array, second_moment: Array) -> Array:
    """Return the antisymmetric part of q F^T dF/dt as a vector (3,): what no force of gravity or pressure changes.

    It is the angular momentum of the adjoint motion F^T (Dedekind), and along an axis q/(pi a b) times the circulation
    in the section across it. Source: Chandrasekhar 1969, section 28.

    >>> turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    >>> print(circulation(np.eye(3), turn, 0.2))  # of a sphere: minus its angular momentum, 2 q Omega
    [ 0.   0.  -0.4]
    """
    return axial_vector(second_moment * deformation.T @ rate)


@with_quantities()
@double_precision()
def pressure_force(deformation: Array, slope: Array) -> Array:
    """Return G of a pressure whose internal energy is U(J), slope = dU/dJ: -(dU/dJ) dJ/dF, with V = -(dU/dJ) J 1.

    >>> print(np.diag(pressure_force(np.eye(3), -1.0)))  # outwards where compression costs energy
    [1. 1. 1.]
    """
    return -slope * cofactor(deformation)


@with_quantities()
@double_precision()
def constraint_slope(
    deformation: Array, rate: Array, force: Array, second_moment: Array, restoring: Array = 0.0, volume: Array = 1.0
) -> Array:
    """Return the slope, as `pressure_force` takes it, that keeps J at `volume`: minus the mean pressure per sphere.

    force (3, 3) is the sum of all others, second_moment is q. With a restoring rate k the volume obeys
    J'' + 2 k J' + k^2 (J - volume) = 0: nothing for an exact solution, and no drift for one in steps. d2J/dt2 is
    cof F : d2F/dt2 + 2 F : cof dF/dt. Source: Chandrasekhar 1969, section 27 (pressure as the multiplier); Baumgarte
    1972, Comput. Methods Appl. Mech. Eng. 1, 1.

    >>> slope = constraint_slope(np.eye(3), np.zeros((3, 3)), gravity_force(np.eye(3), -0.6), 0.2)
    >>> print(f"{-slope:.3f}")  # the mean pressure of a sphere at rest, a third of |W|
    0.200
    """
    cofactors = cofactor(deformation)
    drift = jnp.sum(cofactors * rate)
    growth = 2 * jnp.sum(deformation * cofactor(rate))
    wanted = -restoring * (2 * drift + restoring * (volume_ratio(deformation) - volume))
    return (jnp.sum(cofactors * force) + second_moment * (growth - wanted)) / jnp.sum(cofactors**2)


@with_quantities()
@double_precision()
def incompressible_acceleration(
    deformation: Array, rate: Array, sphere_energy: Array, second_moment: Array, others: Array = 0.0
) -> Array:
    """Return d2F/dt2, (3, 3), of an incompressible body under its own gravity, and `others` (3, 3) = G of other forces.

    sphere_energy is W and second_moment q of the sphere F = 1. Source: Chandrasekhar 1969, section 27.

    >>> print(np.round(incompressible_acceleration(np.eye(3), np.zeros((3, 3)), -0.6, 0.2), 9) + 0.0)  # at rest
    [[0. 0. 0.]
     [0. 0. 0.]
     [0. 0. 0.]]
    """
    force = gravity_force(deformation, sphere_energy) + others
    slope = constraint_slope(deformation, rate, force, second_moment)
    return (force + pressure_force(deformation, slope)) / second_moment


@with_quantities()
@double_precision()
def shear_tensor(deformation: Array, rate: Array) -> Array:
    """Return the symmetric part of the velocity gradient without its trace, (3, 3).

    >>> print(np.diag(shear_tensor(np.eye(3), np.diag([1.0, 1.0, -2.0]))), shear_tensor(np.eye(3), np.eye(3))[0, 0])
    [ 1.  1. -2.] 0.0
    """
    gradient = velocity_gradient(deformation, rate)
    return 0.5 * (gradient + gradient.T) - jnp.trace(gradient) / 3 * jnp.eye(3)


@with_quantities()
@double_precision()
def shear_force(deformation: Array, rate: Array, strength: Array) -> Array:
    """Return G of a shear viscosity; strength is mass times kinematic viscosity, V = -2 strength times the shear.

    The velocity stays linear in position, as where the boundary layer is thin or the viscosity small. Source:
    Rosenkilde 1967, ApJ 148, 825 (the viscous tensor virial theorem).

    >>> force = shear_force(np.eye(3), np.diag([1.0, 1.0, -2.0]), 0.5)
    >>> print(np.sum(force * np.diag([1.0, 1.0, -2.0])))  # power, -2 strength times the shear squared
    -6.0
    """
    tensor = -2 * strength * shear_tensor(deformation, rate)
    return tensor @ cofactor(deformation) / volume_ratio(deformation)


@with_quantities()
def second_moment_derivatives(
    deformation: Array, rate: Array, second_moment: Array, acceleration: Acceleration
) -> tuple[Array, ...]:
    """Return the first to the fifth time derivative of Q, (3, 3) each, along the motion with that acceleration.

    acceleration(F, dF/dt) is d2F/dt2 of the motion that nothing dissipates: each derivative of it gives F one more, by
    which the next is taken. Source: Griewank & Walther 2008, Evaluating Derivatives, ch. 13.

    >>> swing = second_moment_derivatives(np.eye(3), np.zeros((3, 3)), 1.0, lambda matrix, rate: -matrix)  # cos(t)
    >>> print([round(float(each[0, 0]), 6) + 0.0 for each in swing])  # of Q = cos(t)^2
    [0.0, -2.0, 0.0, 8.0, 0.0]
    """

    @double_precision()
    def derivatives(deformation: Array, rate: Array, second_moment: Array) -> tuple[Array, ...]:
        known, next_one = [jnp.asarray(each, dtype=float) for each in (deformation, rate)], acceleration
        for _ in range(4):
            known.append(next_one(*known))
            next_one = _in_time(next_one)
        return tuple(
            second_moment * sum(math.comb(order, k) * known[k] @ known[order - k].T for k in range(order + 1))
            for order in range(1, 6)
        )

    return derivatives(deformation, rate, second_moment)


def _in_time(function: Callable) -> Callable:
    """The time derivative of a function of something and its derivatives, of which it takes one more."""
    return lambda *known: jax.jvp(function, known[:-1], known[1:])[1]


@with_quantities()
@double_precision()
def radiation_reaction_tensor(fifth_derivative: Array, coupling: Array) -> Array:
    """Return M (3, 3) of the acceleration M x by the waves that a body sends out; coupling is G/c^5.

    M_ij = -(2/5) (G/c^5) d5 (Q_ij - tr(Q)/3)/dt5. Source: Burke & Thorne 1970, in Relativity (Carmeli et al., eds.),
    p. 209; Misner, Thorne & Wheeler 1973, eq. 36.8.

    >>> print(np.diag(radiation_reaction_tensor(np.diag([3.0, 0.0, 0.0]), 1.0)))
    [-0.8  0.4  0.4]
    """
    return -0.4 * coupling * (fifth_derivative - jnp.trace(fifth_derivative) / 3 * jnp.eye(3))
