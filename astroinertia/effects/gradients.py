"""Gradients of vector fields from sums over neighbours, exact where the field is linear.

grad F = [sum_j m_j dW (F_i - F_j) (x) rhat] [sum_j m_j dW (x_i - x_j) (x) rhat]^-1 (Cullen & Dehnen 2010, appendix B;
Garcia-Senz, Cabezon & Escartin 2012, A&A 538, A9, for the matrix). Indices are (component, direction).
"""

from typing import Any


def gradient(xp: Any, sums: dict[str, Any], name: str) -> Any:
    """The gradient (N, 3, 3) of a field F from the sums of one effect; zero for a particle without neighbours.

    Neighbours in one plane leave the matrix singular; its trace then stands for it, as in the plain estimate.
    """
    moment, sum_of_field = sums["position"], sums[name]
    size = xp.einsum("nii->n", moment) / 3.0
    alone = size > -1e-200
    scale = xp.where(alone, -1.0, size)[:, None, None]
    moment, sum_of_field = moment / scale, sum_of_field / scale
    a, b, c = moment[:, 0], moment[:, 1], moment[:, 2]
    bc, ca, ab = xp.cross(b, c), xp.cross(c, a), xp.cross(a, b)
    determinant = xp.einsum("ni,ni->n", a, bc)
    singular = determinant < 1e-3  # of a matrix whose trace is 3: at least one direction all but unsampled
    inverse = xp.stack([bc, ca, ab], axis=-1) / xp.where(singular, 1.0, determinant)[:, None, None]
    inverse = xp.where(singular[:, None, None], xp.eye(3), inverse)
    return xp.where(alone[:, None, None], 0.0, xp.einsum("nij,njk->nik", sum_of_field, inverse))


def divergence_and_curl(xp: Any, velocity_gradient: Any) -> tuple[Any, Any]:
    """Divergence and size of the curl, each (N,)."""
    difference = velocity_gradient - xp.swapaxes(velocity_gradient, 1, 2)
    squared = 0.5 * xp.einsum("nij,nij->n", difference, difference)
    flowing = squared > 0.0  # a square root has no derivative at 0
    curl = xp.where(flowing, xp.sqrt(xp.where(flowing, squared, 1.0)), 0.0)
    return xp.einsum("nii->n", velocity_gradient), curl


def shear_squared(xp: Any, velocity_gradient: Any) -> Any:
    """S:S of the traceless symmetric part S of grad v, (N,)."""
    symmetric = 0.5 * (velocity_gradient + xp.swapaxes(velocity_gradient, 1, 2))
    divergence = xp.einsum("nii->n", velocity_gradient)
    return xp.einsum("nij,nij->n", symmetric, symmetric) - divergence**2 / 3.0
