"""Gradients of vector fields from sums over neighbours, exact where the field is linear.

grad F = [sum_j m_j dW (F_i - F_j) (x) rhat] [sum_j m_j dW (x_i - x_j) (x) rhat]^-1 (Cullen & Dehnen 2010, appendix B;
Garcia-Senz, Cabezon & Escartin 2012, A&A 538, A9, for the matrix). Indices are (component, direction).

Functions of one particle take matrices as three rows (engines/elementwise.py).
"""

from typing import Any, NamedTuple

from astroinertia.engines.terms import COMMON, Output, PairTerm


class Separation(NamedTuple):
    """x_i - x_j."""

    x: Any
    y: Any
    z: Any


class Symmetric(NamedTuple):
    """A symmetric matrix, as pair functions are given it."""

    xx: Any
    yy: Any
    zz: Any
    xy: Any
    xz: Any
    yz: Any


def gradient_pair(xp, dW_i):
    """Weights of the moment matrix and of the velocity gradient."""
    return dW_i, dW_i


# What an effect lists among its gradient_terms if it needs `linear_gradient` of the velocity, from `flow_sums`.
VELOCITY_GRADIENT = PairTerm(
    COMMON, gradient_pair, (Output("position", "outer", of="position"), Output("velocity", "outer", of="velocity"))
)


def flow_sums(fluid: Any) -> tuple[Any, Any]:
    """The two sums (N, 3, 3) of the velocity gradient, made once for all effects that list it."""
    sums = fluid.gradients[COMMON]
    return sums["position"], sums["velocity"]


def inertial_flow_sums(fluid: Any) -> tuple[Any, Any]:
    """The same of velocities in inertial axes, of which all vorticity is: a frame that turns hides some of it."""
    sums = fluid.gradients[COMMON]
    return sums["position"], sums.get("inertial_velocity", sums["velocity"])


def along(xp, ij: Separation, matrix: Symmetric):
    """x . M . x of a separation."""
    x, y, z = ij.x, ij.y, ij.z
    squares = matrix.xx * (x * x) + matrix.yy * (y * y) + matrix.zz * (z * z)
    return squares + matrix.xy * (2.0 * x * y) + matrix.xz * (2.0 * x * z) + matrix.yz * (2.0 * y * z)


def dot(xp, a, b):
    """a . b of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(xp, a, b):
    """a x b of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def linear_gradient(xp, moment, sum_of_field):
    """The gradient of a field of one particle from its two sums; zero for a particle without neighbours.

    Neighbours in one plane leave the matrix singular; its trace then stands for it, as in the plain estimate.
    """
    size = (moment[0][0] + moment[1][1] + moment[2][2]) / 3.0
    alone = size > -1e-200
    scale = 1.0 / xp.where(alone, -1.0, size)
    a, b, c = scaled(xp, scale, moment[0]), scaled(xp, scale, moment[1]), scaled(xp, scale, moment[2])
    bc, ca, ab = cross(xp, b, c), cross(xp, c, a), cross(xp, a, b)
    determinant = dot(xp, a, bc)
    singular = determinant < 1e-3  # of a matrix whose trace is 3: at least one direction all but unsampled
    # The columns of the inverse are the cross products over the determinant, or those of the unit matrix.
    over = xp.where(singular, 0.0, scale / xp.where(singular, 1.0, determinant))
    plain = xp.where(alone, 0.0, xp.where(singular, scale, 0.0))
    over = xp.where(alone, 0.0, over)
    return (
        solved(xp, sum_of_field[0], over, plain, bc, ca, ab),
        solved(xp, sum_of_field[1], over, plain, bc, ca, ab),
        solved(xp, sum_of_field[2], over, plain, bc, ca, ab),
    )


def symmetric_inverse(xp, matrix):
    """xx, yy, zz, xy, xz, yz of the inverse of a symmetric matrix that is not singular."""
    a, b, c = matrix
    bc, ca, ab = cross(xp, b, c), cross(xp, c, a), cross(xp, a, b)
    over = 1.0 / dot(xp, a, bc)
    return over * bc[0], over * ca[1], over * ab[2], over * bc[1], over * bc[2], over * ca[2]


def scaled(xp, factor, a):
    """factor a of a vector."""
    return factor * a[0], factor * a[1], factor * a[2]


def solved(xp, row, over, plain, bc, ca, ab):
    """One row of the sum times the inverse."""
    return (
        over * dot(xp, row, bc) + plain * row[0],
        over * dot(xp, row, ca) + plain * row[1],
        over * dot(xp, row, ab) + plain * row[2],
    )


def trace(xp, matrix):
    """The trace: a divergence, of a gradient."""
    return matrix[0][0] + matrix[1][1] + matrix[2][2]


def trace_of_square(xp, matrix):
    """tr (M M)."""
    x, y, z = matrix
    return x[0] ** 2 + y[1] ** 2 + z[2] ** 2 + 2.0 * (x[1] * y[0] + x[2] * z[0] + y[2] * z[1])


def curl_size(xp, matrix):
    """The size of the curl that a velocity gradient has."""
    x, y, z = matrix
    squared = (z[1] - y[2]) ** 2 + (x[2] - z[0]) ** 2 + (y[0] - x[1]) ** 2
    flowing = squared > 0.0  # a square root has no derivative at 0
    return xp.where(flowing, xp.sqrt(xp.where(flowing, squared, 1.0)), 0.0)


def converging_share(xp, flow, sound_speed, h):
    """d^2/(d^2 + |curl v|^2 + (1e-4 c/h)^2), d = div v: 1 where the flow converges or expands, 0 where it turns."""
    divergence, curl = trace(xp, flow), curl_size(xp, flow)
    noise = 1e-4 * sound_speed / h + 1e-30
    return divergence**2 / (divergence**2 + curl**2 + noise**2)


def strain(xp, matrix):
    """The symmetric part: xx, yy, zz, xy, xz, yz."""
    x, y, z = matrix
    return x[0], y[1], z[2], 0.5 * (x[1] + y[0]), 0.5 * (x[2] + z[0]), 0.5 * (y[2] + z[1])


def shear(xp, matrix):
    """S:S of the traceless symmetric part S."""
    xx, yy, zz, xy, xz, yz = strain(xp, matrix)
    return xx**2 + yy**2 + zz**2 + 2.0 * (xy**2 + xz**2 + yz**2) - trace(xp, matrix) ** 2 / 3.0
