"""Inertia tensors and what follows from them: pure functions of arrays, numpy or jax, any consistent units.

Tensors have shape (..., 3, 3); leading axes are batches.
"""

import sys
from typing import Any

import numpy as np

Array = Any

_SINGULAR = 1e-14  # share of the largest moment below which the smallest counts as 0


def namespace(*arrays: Array) -> Any:
    """The module that arrays belong to: jax.numpy where one of them does, else numpy, as for lists and numbers."""
    found = (array.__array_namespace__() for array in arrays if hasattr(array, "__array_namespace__"))
    return next((module for module in found if module is not np), np)


def is_known(array: Array) -> bool:
    """Whether an array has values that can be looked at now: not so inside jax.jit, jax.grad or jax.vmap."""
    # A tracer can only have come from a jax that is already imported, and numpy users need not wait for one.
    return "jax" not in sys.modules or not isinstance(array, sys.modules["jax"].core.Tracer)


def inertia_from_second_moment(second_moment: Array) -> Array:
    """I = tr(Q) 1 - Q; linear, so it also turns dQ/dt into dI/dt and d2Q/dt2 into d2I/dt2."""
    xp = namespace(second_moment)
    x, y, z = (second_moment[..., k, k] for k in range(3))
    # I_xx = Q_yy + Q_zz and not tr(Q) - Q_xx, in which a thin rod along x would lose the digits of its thickness.
    diagonal = xp.stack([y + z, z + x, x + y], axis=-1)
    return xp.where(xp.eye(3, dtype=bool), diagonal[..., None, :], -second_moment)


def second_moment_from_inertia(inertia: Array) -> Array:
    """Q = tr(I)/2 1 - I, the inverse of `inertia_from_second_moment`."""
    xp = namespace(inertia)
    return 0.5 * xp.trace(inertia, axis1=-2, axis2=-1)[..., None, None] * xp.eye(3) - inertia


def point_inertia(mass: Array, position: Array) -> Array:
    """m (|x|^2 1 - x (x) x), (..., 3, 3): the inertia tensor about the origin of point masses.

    mass (...,) and position (..., 3) in any consistent units. With the whole mass and a shift it is the term of the
    parallel-axis theorem (Goldstein, Poole & Safko 2002, Classical Mechanics, eq. 5.25).
    Checked by tests/unit/test_tensor.py and test_inertia_identities.py.
    """
    xp = namespace(mass, position)
    x = xp.asarray(position)
    return xp.asarray(mass)[..., None, None] * inertia_from_second_moment(x[..., :, None] * x[..., None, :])


def twice_symmetric(tensor: Array) -> Array:
    """T + T^T: the rate of Q from P, and the share of V_e in d2Q/dt2."""
    return tensor + namespace(tensor).swapaxes(tensor, -1, -2)


def axial_vector(tensor: Array) -> Array:
    """eps_ijk T_jk, (..., 3): the angular momentum in P and the torque in V_e."""
    differences = [tensor[..., 1, 2] - tensor[..., 2, 1], tensor[..., 2, 0] - tensor[..., 0, 2]]
    return namespace(tensor).stack([*differences, tensor[..., 0, 1] - tensor[..., 1, 0]], axis=-1)


def moment_about(inertia: Array, axis: Array) -> Array:
    """n.I.n about the axis n (..., 3), which need not be a unit vector."""
    xp = namespace(inertia)
    return xp.einsum("...i,...ij,...j->...", axis, inertia, axis) / (axis**2).sum(-1)


def angular_velocity(inertia: Array, angular_momentum: Array) -> Array:
    """The Tisserand mean spin I^-1 L, (..., 3); NaN where I has no inverse.

    It is the rigid rotation that carries the body's angular momentum (Munk & MacDonald 1960, Rotation of the Earth).
    """
    xp = namespace(inertia, angular_momentum)
    minors = 0.5 * (xp.trace(inertia, axis1=-2, axis2=-1) ** 2 - (inertia**2).sum((-2, -1)))
    # det(I) over the sum of its principal minors is the smallest moment where that is small.
    smallest = xp.linalg.det(inertia) / xp.where(minors > 0, minors, 1.0)
    solvable = (minors > 0) & (smallest > _SINGULAR * xp.trace(inertia, axis1=-2, axis2=-1))
    safe = xp.where(solvable[..., None, None], inertia, xp.eye(3, dtype=inertia.dtype))
    return xp.where(solvable[..., None], xp.linalg.solve(safe, angular_momentum[..., None])[..., 0], xp.nan)


def equivalent_semi_axes(mass: Array, moments: Array) -> Array:
    """Semi-axes (..., 3) of the homogeneous ellipsoid with this mass and these principal moments, in their order.

    a_k^2 = 5 Q_k / M with Q_k = (I_1 + I_2 + I_3)/2 - I_k.
    """
    xp = namespace(moments)
    second = 0.5 * moments.sum(-1, keepdims=True) - moments
    return xp.sqrt(xp.maximum(5.0 * second, 0.0) / xp.asarray(mass)[..., None])
