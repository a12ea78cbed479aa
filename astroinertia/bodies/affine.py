"""Gravity of a body whose matter moves as x = F xi, from its deformation gradient F: pure JAX, without principal axes.

xi runs over a reference sphere with a density that depends on radius alone, so that surfaces of equal density are the
similar ellipsoids of S = F F^T. With Carlson's R_F of the squared semi-axes, in units of the sphere's radius,

    W = W_sphere R_F(S),    V = sum m x (x) a = W_sphere [gamma S + beta (tr(C) 1 - C) + alpha det(S) 1],

C the cofactors of S. R_F depends on the three invariants of S only, and alpha, beta, gamma are its derivatives: sums of
positive terms, functions of the invariants. Nothing is divided by differences of axes, and derivatives of any order
exist for spheres and spheroids too, where eigenvectors have none.

Source: Carlson 1995, Numer. Algorithms 10, 13; Roberts 1962, ApJ 136, 1108 (similar surfaces); Chandrasekhar 1969,
Ellipsoidal Figures of Equilibrium, sections 18 and 22; Trefethen & Weideman 2014, SIAM Rev. 56, 385 (sums for
integrals).
"""

from typing import Any

import jax.numpy as jnp
import numpy as np

from astroinertia.inertia.double_precision import double_precision
from astroinertia.process.quantities import with_quantities

Array = Any

_LOG_STEP = 0.375  # of ln u: the error of the sum is about 100 exp(-2 pi pi/step) = 1e-21
# From where u is 1e-16 of the smallest squared semi-axis, down to 1e-24, to where u^(-3/2) is beneath round-off.
_NODES = np.exp(_LOG_STEP * np.arange(-248, 67))


@with_quantities()
@double_precision()
def gravitational_energy(deformation: Array, sphere_energy: Array) -> Array:
    """Return W (a number below 0) of the body with deformation gradient (3, 3) whose sphere (F = 1) has sphere_energy.

    Source: Roberts 1962; Chandrasekhar 1969, section 22.

    >>> print(f"{gravitational_energy(2 * np.eye(3), -0.6):.6f}")  # twice the radius, half the energy
    -0.300000
    """
    size, first, second, third = _scaled_invariants(deformation)
    return sphere_energy * first_integral(first, second, third) / size


@with_quantities()
@double_precision()
def gravity_tensor(deformation: Array, sphere_energy: Array) -> Array:
    """Return V = sum m x (x) a, (3, 3) and symmetric, of the body's own gravity; its trace is the energy W.

    deformation (3, 3) is F, sphere_energy the W of the sphere F = 1. Chandrasekhar's potential-energy tensor, along
    the principal axes -2 pi G rho A_i Q_ii where the density is uniform. Source: Chandrasekhar 1969, sections 11, 22.

    >>> tensor = gravity_tensor(np.diag([2.0, 1.0, 0.5]), -0.6)
    >>> print(f"{np.trace(tensor) / gravitational_energy(np.diag([2.0, 1.0, 0.5]), -0.6):.9f}")
    1.000000000
    """
    size, first, second, third = _scaled_invariants(deformation)
    alpha, beta, gamma = symmetric_integrals(first, second, third)
    scaled = deformation / size
    squared, cofactors = scaled @ scaled.T, _squared_cofactors(scaled)
    unit = jnp.eye(3)
    whole = gamma * squared + beta * _complement(cofactors) + alpha * third * unit
    return sphere_energy / size * whole


@with_quantities()
@double_precision()
def gravity_force(deformation: Array, sphere_energy: Array) -> Array:
    """Return sum m a (x) xi = -dW/dF, (3, 3), of the body's own gravity: q d2F/dt2 where nothing else acts.

    V is F times its transpose; here nothing is divided by F, so that a pancake's loses no digits. Arguments as of
    `gravity_tensor`.

    >>> print(np.round(gravity_force(np.eye(3), -0.6), 9) + 0.0)  # a third of W along each axis
    [[-0.2  0.   0. ]
     [ 0.  -0.2  0. ]
     [ 0.   0.  -0.2]]
    """
    size, first, second, third = _scaled_invariants(deformation)
    alpha, beta, gamma = symmetric_integrals(first, second, third)
    scaled = deformation / size
    cofactors = cofactor(scaled)
    rows = [
        jnp.cross(scaled[j], cofactors[k]) + jnp.cross(cofactors[j], scaled[k]) for j, k in ((1, 2), (2, 0), (0, 1))
    ]
    whole = gamma * scaled + beta * jnp.stack(rows) + alpha * volume_ratio(scaled) * cofactors
    return sphere_energy / size**2 * whole


@with_quantities()
@double_precision()
def cofactor(matrix: Array) -> Array:
    """Return the cofactors det(M) M^-T, (3, 3), of M (3, 3): dJ/dF where M is F, and defined for a singular M too.

    >>> print(np.diag(cofactor(np.diag([1.0, 2.0, 3.0]))))
    [6. 3. 2.]
    """
    return jnp.stack(
        [jnp.cross(matrix[1], matrix[2]), jnp.cross(matrix[2], matrix[0]), jnp.cross(matrix[0], matrix[1])]
    )


@with_quantities()
@double_precision()
def volume_ratio(deformation: Array) -> Array:
    """Return J = det F, the volume over that of the sphere.

    >>> print(volume_ratio(np.diag([1.0, 2.0, 3.0])))
    6.0
    """
    return deformation[0] @ jnp.cross(deformation[1], deformation[2])


@with_quantities()
@double_precision()
def first_integral(first: Array, second: Array, third: Array) -> Array:
    """Return R_F(x, y, z) from x + y + z, xy + yz + zx and xyz, numbers above 0; z is at least 1e-24 of the sum.

    R_F = 1/2 integral du/((x + u)(y + u)(z + u))^(1/2) over u from 0 to infinity; it is of degree -1/2, and so the sum
    of its derivatives. Source: Carlson 1995, eq. 1.1; DLMF 19.18.5 (Euler's relation).

    >>> print(f"{first_integral(3.0, 3.0, 1.0):.5f}")  # R_F(1, 1, 1)
    1.00000
    """
    alpha, beta, gamma = symmetric_integrals(first, second, third)
    return gamma * first + 2 * beta * second + 3 * alpha * third


@with_quantities()
@double_precision()
def symmetric_integrals(first: Array, second: Array, third: Array) -> tuple[Array, Array, Array]:
    """Return alpha, beta, gamma = 1/2 integral of 1, u, u^2 times ((x + u)(y + u)(z + u))^(-3/2) du.

    Arguments as of `first_integral`, of which they are -2 times the derivatives by the third, second and first.
    R_D(x, y, z)/3 = gamma + beta (x + y) + alpha xy. Source: Trefethen & Weideman 2014 (the trapezoidal rule over
    ln u, which converges geometrically).

    >>> alpha, beta, gamma = symmetric_integrals(*jnp.array([3.0, 3.0, 1.0]))
    >>> print(f"{3 * (gamma + 2 * beta + alpha):.4f}")  # R_D(1, 1, 1)
    1.0000
    """
    u = first * _NODES
    product = ((u + first) * u + second) * u + third
    weight = 0.5 * _LOG_STEP * u / (product * jnp.sqrt(product))
    return jnp.sum(weight), jnp.sum(weight * u), jnp.sum(weight * u**2)


def _scaled_invariants(deformation: Array) -> tuple[Array, Array, Array, Array]:
    """The size |F| and the invariants of S/|F|^2, whose trace is 1."""
    size = jnp.sqrt(jnp.sum(deformation**2))
    scaled = deformation / size
    return size, jnp.ones_like(size) * jnp.sum(scaled**2), jnp.sum(cofactor(scaled) ** 2), volume_ratio(scaled) ** 2


def _squared_cofactors(matrix: Array) -> Array:
    cofactors = cofactor(matrix)
    return cofactors @ cofactors.T


def _complement(tensor: Array) -> Array:
    """tr(T) 1 - T, with no difference on the diagonal."""
    x, y, z = tensor[0, 0], tensor[1, 1], tensor[2, 2]
    return jnp.where(jnp.eye(3, dtype=bool), jnp.stack([y + z, z + x, x + y])[None, :], -tensor)
