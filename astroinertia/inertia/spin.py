"""How a body spins: angular momentum, mean angular velocity, energy, load on its bearings, flow that is no rotation.

Pure functions of arrays, numpy or jax, any consistent units; particles are mass (..., N), position and velocity
(..., N, 3), tensors (..., 3, 3), all in the same inertial axes unless said otherwise. Sections are those of Goldstein,
Poole & Safko (2002), Classical Mechanics. Checked by tests/unit/inertia/test_spin.py.
"""

from typing import Any

from astroinertia.inertia.tensor import (
    axial_vector,
    centre_of_mass,
    inertia_tensor,
    invariants,
    mixed_moment,
    namespace,
)
from astroinertia.process.quantities import with_quantities

Array = Any

_SINGULAR = 1e-14  # share of the largest moment below which the smallest counts as 0


@with_quantities()
def angular_momentum(
    mass: Array, position: Array, velocity: Array, origin: Array | None = None, weights: Array | None = None
) -> Array:
    """L = sum m x cross v, (..., 3), about a point at rest (..., 3).

    Where no origin is given, x and v are relative to the centre of mass and to its velocity. weights (..., N) multiply
    mass. Source: section 1.2.

    >>> x, v = np.array([[1.0, 0, 0], [-1.0, 0, 0]]), np.array([[0, 3.0, 0], [0, -3.0, 0]])
    >>> print(angular_momentum(np.ones(2), x, v))  # sum m x cross v
    [0. 0. 6.]
    """
    at_rest = None if origin is None else namespace(origin).zeros_like(namespace(origin).asarray(origin))
    return axial_vector(mixed_moment(mass, position, velocity, origin, at_rest, weights))


@with_quantities()
def angular_velocity(inertia: Array, angular_momentum: Array) -> Array:
    """The Tisserand mean angular velocity I^-1 L, (..., 3), of inertia and angular momentum about the same point.

    It is the rigid rotation that carries the body's angular momentum; NaN where I has no inverse to double precision,
    as for a rod. Source: Munk & MacDonald (1960), The Rotation of the Earth.

    >>> print(angular_velocity(np.diag([1.0, 2.0, 4.0]), np.array([0.0, 0.0, 8.0])))  # I^-1 L
    [0. 0. 2.]
    """
    return _spin(inertia, angular_momentum)


@with_quantities()
def rotational_energy(
    inertia: Array | None = None, angular_velocity: Array | None = None, angular_momentum: Array | None = None
) -> Array:
    """Energy of a rigid rotation, (...,), from two of I, omega and L: omega.I.omega / 2, omega.L / 2 or L.I^-1.L / 2.

    I (..., 3, 3), omega and L (..., 3), all about the same point, the centre of mass or one at rest. ValueError unless
    two are given. Where I has no inverse, the form without omega is NaN. Source: section 5.3.

    >>> print(rotational_energy(np.diag([1.0, 2.0, 4.0]), np.array([0.0, 0.0, 3.0])))  # I w^2 / 2
    18.0
    """
    if (inertia is None) + (angular_velocity is None) + (angular_momentum is None) != 1:
        raise ValueError("the rotational energy follows from two of inertia, angular_velocity and angular_momentum")
    rate = _spin(inertia, angular_momentum) if angular_velocity is None else angular_velocity
    momentum = _applied(inertia, rate) if angular_momentum is None else angular_momentum
    return 0.5 * (rate * momentum).sum(-1)


@with_quantities()
def bearing_torque(inertia: Array, angular_velocity: Array) -> Array:
    """omega cross (I omega), (..., 3): the torque by which bearings hold a rigid body to a constant angular velocity.

    Both in the same axes, about a point of the shaft, which the torque is about. Zero where the shaft is a principal
    axis; for spin about z only I_xz and I_yz count. Source: Euler's equations with constant omega, section 5.5.

    >>> inertia = np.array([[2.0, 0, 0.1], [0, 2, 0], [0.1, 0, 3]])
    >>> print(bearing_torque(inertia, np.array([0.0, 0.0, 10.0])))  # about z, I_xz and I_yz wobble
    [ 0. 10.  0.]
    """
    return namespace(inertia, angular_velocity).cross(angular_velocity, _applied(inertia, angular_velocity))


@with_quantities()
def residual_flow(mass: Array, position: Array, velocity: Array, weights: Array | None = None) -> Array:
    """Velocities (..., N, 3) left when the motion of the centre of mass and the mean angular velocity are taken out.

    It has neither momentum nor angular momentum; weights (..., N), which multiply mass, say whose mean motion. NaN
    where the mean angular velocity is. Source: Tisserand's mean axes, Munk & MacDonald (1960), The Rotation of the
    Earth.

    >>> x = np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0]])
    >>> flow = np.cross([0.0, 0.0, 2.0], x) + [5.0, 0, 0]  # a rotation and a drift
    >>> print(abs(residual_flow(np.ones(4), x, flow)).max().round(12))  # leave nothing
    0.0
    """
    xp = namespace(mass, position, velocity, weights)
    spin = _spin(
        inertia_tensor(mass, position, weights=weights), angular_momentum(mass, position, velocity, weights=weights)
    )
    x = xp.asarray(position) - centre_of_mass(mass, position, weights)[..., None, :]
    v = xp.asarray(velocity) - centre_of_mass(mass, velocity, weights)[..., None, :]
    return v - xp.cross(spin[..., None, :], x)


def _applied(inertia: Array, vector: Array) -> Array:
    return (inertia @ namespace(inertia, vector).asarray(vector)[..., None])[..., 0]


def _spin(inertia: Array, angular_momentum: Array) -> Array:
    xp = namespace(inertia, angular_momentum)
    inertia = xp.asarray(inertia)
    size = xp.trace(inertia, axis1=-2, axis2=-1)
    # The determinant over the sum of the principal minors is the smallest moment where that is small.
    of_unit = invariants(inertia / xp.where(size > 0, size, 1.0)[..., None, None])
    solvable = (size > 0) & (of_unit[..., 2] > _SINGULAR * of_unit[..., 1])
    safe = xp.where(solvable[..., None, None], inertia, xp.eye(3, dtype=inertia.dtype))
    return xp.where(solvable[..., None], xp.linalg.solve(safe, angular_momentum[..., None])[..., 0], xp.nan)
