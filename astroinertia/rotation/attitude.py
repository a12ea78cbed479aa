"""Attitudes of a body: matrices, quaternions, rotation vectors and Euler angles; numpy or jax.

An attitude A (..., 3, 3) has the body's axes as rows, in inertial axes, so that x_body = A x_inertial. A rotation R
(..., 3, 3) turns vectors, x -> R x. The rotation that turned the inertial axes into the body's is R = A^T; quaternions
(..., 4), scalar first, and Euler angles are those of this R. Angles in radians.
Source: Goldstein, Poole & Safko (2002), Classical Mechanics, chapter 4. Checked by
tests/unit/rotation/test_attitude.py.
"""

from functools import cache
from typing import Any

import numpy as np

from astroinertia.inertia.orthogonal import require_orthogonal
from astroinertia.inertia.tensor import namespace
from astroinertia.process.known import is_known
from astroinertia.process.quantities import with_quantities
from astroinertia.process.vectors import of_any_length, require_components

Array = Any

_AXES = "xyz"
# By which a rotation that was written down may be off, as scenes take axes; what follows is off as much.
ROUGHLY_ORTHOGONAL = 1e-6


@with_quantities()
def cross_matrix(vector: Array) -> Array:
    """The antisymmetric matrix (..., 3, 3) with [v] x = v cross x, of vectors (..., 3).

    >>> print(cross_matrix(np.array([0.0, 0.0, 1.0])) @ [1.0, 0.0, 0.0])  # z cross x
    [0. 1. 0.]
    """
    xp = namespace(vector)
    x, y, z = (xp.asarray(vector)[..., k] for k in range(3))
    zero = xp.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return xp.stack([xp.stack(row, axis=-1) for row in rows], axis=-2)


@with_quantities(vector="rad")
def rotation(vector: Array) -> Array:
    """The rotation (..., 3, 3) about a rotation vector (..., 3): its direction is the axis, its length the angle.

    To round-off for any angle, with derivatives at 0. Source: Rodrigues' formula, Goldstein et al. eq. 4.62.

    >>> print((rotation(np.array([0.0, 0.0, np.pi / 2])) @ [1.0, 0.0, 0.0]).round(12))  # a quarter turn about z
    [0. 1. 0.]
    """
    xp = namespace(vector)
    vector = xp.asarray(vector)
    square = (vector**2).sum(-1)[..., None, None]
    turns = square > 0
    half = 0.5 * xp.sqrt(xp.where(turns, square, 1.0))
    # sin t/t and (1 - cos t)/t^2, the latter by half the angle, in which it has no cancellation
    first = xp.where(turns, xp.sin(half) * xp.cos(half) / half, 1.0)
    second = xp.where(turns, 0.5 * (xp.sin(half) / half) ** 2, 0.5)
    turn = cross_matrix(vector)
    return xp.eye(3, dtype=turn.dtype) + first * turn + second * (turn @ turn)


@with_quantities()
def rotation_vector(rotation: Array) -> Array:
    """The rotation vector (..., 3) of a rotation (..., 3, 3), of length 0 to pi; the inverse of `rotation`.

    To round-off for any angle: at pi either of the two directions. ValueError for a matrix that is no rotation.

    >>> print(rotation_vector(rotation(np.array([0.1, 0.2, 0.3]))).round(12))  # the inverse
    [0.1 0.2 0.3]
    """
    xp = namespace(rotation)
    parameters = quaternion(xp.swapaxes(rotation, -1, -2))
    axial = parameters[..., 1:]
    square = (axial**2).sum(-1, keepdims=True)
    turns = square > 0
    sine = xp.sqrt(xp.where(turns, square, 1.0))
    return xp.where(turns, 2.0 * xp.arctan2(sine, parameters[..., :1]) / sine, 2.0) * axial


@with_quantities()
def quaternion(attitude: Array) -> Array:
    """The unit quaternion (..., 4), scalar first and not negative, of an attitude (..., 3, 3).

    Source: Shepperd (1978), Journal of Guidance and Control 1, 223: the largest of the four components is taken from
    the diagonal, so that no digits are lost at any angle. ValueError for a matrix that is no rotation (not seen inside
    jit).

    >>> print(quaternion(rotation(np.array([0.0, 0.0, np.pi / 2])).T).round(6))  # of a body turned about z
    [0.707107 0.       0.       0.707107]
    """
    _require_rotation(attitude)
    xp = namespace(attitude)
    a = xp.asarray(attitude)
    xx, yy, zz = (a[..., k, k] for k in range(3))
    # 4 q (x) q, linear in the matrix; any of its rows is parallel to q
    wx, wy, wz = a[..., 1, 2] - a[..., 2, 1], a[..., 2, 0] - a[..., 0, 2], a[..., 0, 1] - a[..., 1, 0]
    xy, yz, zx = a[..., 0, 1] + a[..., 1, 0], a[..., 1, 2] + a[..., 2, 1], a[..., 2, 0] + a[..., 0, 2]
    rows = [
        [1.0 + xx + yy + zz, wx, wy, wz],
        [wx, 1.0 + xx - yy - zz, xy, zx],
        [wy, xy, 1.0 - xx + yy - zz, yz],
        [wz, zx, yz, 1.0 - xx - yy + zz],
    ]
    products = xp.stack([xp.stack(row, axis=-1) for row in rows], axis=-2)
    best = xp.argmax(xp.stack([rows[k][k] for k in range(4)], axis=-1), axis=-1)[..., None, None]
    row = xp.take_along_axis(products, best, axis=-2)[..., 0, :]
    return xp.where(row[..., :1] < 0, -row, row) / xp.sqrt((row**2).sum(-1, keepdims=True))


@with_quantities()
def attitude_of_quaternion(quaternion: Array) -> Array:
    """The attitude (..., 3, 3) of a quaternion (..., 4), scalar first, of any length but 0.

    Source: Goldstein et al. eq. 4.47'.

    >>> print(np.diag(attitude_of_quaternion(np.array([0.0, 0.0, 0.0, 1.0]))))  # half a turn about z
    [-1. -1.  1.]
    """
    xp = namespace(quaternion)
    q = of_any_length(xp.asarray(quaternion))
    size = (q**2).sum(-1)[..., None, None]
    w, axial = q[..., 0, None, None], q[..., 1:]
    outer = axial[..., :, None] * axial[..., None, :]
    turn = cross_matrix(axial)
    # A = R^T with R = 1 + 2 w [v]/|q|^2 + 2 [v][v]/|q|^2, and [v][v] = v (x) v - v^2
    square = (axial**2).sum(-1)[..., None, None]
    return xp.eye(3, dtype=q.dtype) * (1.0 - 2.0 * square / size) + 2.0 * (outer - w * turn) / size


@with_quantities()
def quaternion_product(left: Array, right: Array) -> Array:
    """The quaternion (..., 4) of the rotation `right` followed by the rotation `left`, both in inertial axes.

    Source: Hamilton's product.

    >>> print(quaternion_product(np.array([0.0, 1, 0, 0]), np.array([0.0, 0, 1, 0])))  # i j = k
    [0. 0. 0. 1.]
    """
    require_components(4, left=left, right=right)
    xp = namespace(left, right)
    left, right = xp.broadcast_arrays(xp.asarray(left), xp.asarray(right))
    w, v, s, u = left[..., :1], left[..., 1:], right[..., :1], right[..., 1:]
    scalar = w * s - (v * u).sum(-1, keepdims=True)
    return xp.concatenate([scalar, w * u + s * v + xp.cross(v, u)], axis=-1)


@with_quantities(angles="rad")
def attitude_of_euler_angles(angles: Array, sequence: str = "zxz") -> Array:
    """The attitude (..., 3, 3) of Euler angles (..., 3), about the axes of the sequence as they have been turned.

    R = R_i(first) R_j(second) R_k(third), each about an axis of the body as it stands then (intrinsic). "zxz" is that
    of mechanics and of astronomy, angles (precession, nutation, spin); "zyx" is yaw, pitch and roll. ValueError for
    another sequence than two or three different axes. Source: Goldstein et al. section 4.4 and appendix A.

    >>> print(attitude_of_euler_angles(np.array([0.0, np.pi / 2, 0.0]))[2].round(12) + 0.0)  # its axis, tilted
    [ 0. -1.  0.]
    """
    axes = _axes(sequence)
    xp = namespace(angles)
    angles = xp.asarray(angles)
    identity = xp.eye(3, dtype=angles.dtype)
    first, second, third = (rotation(angles[..., k, None] * identity[axis]) for k, axis in enumerate(axes))
    return xp.swapaxes(first @ second @ third, -1, -2)


@with_quantities()
def euler_angles(attitude: Array, sequence: str = "zxz") -> Array:
    """The Euler angles (..., 3) of an attitude (..., 3, 3), about the axes of the sequence as they have been turned.

    The inverse of `attitude_of_euler_angles`: first and third from -pi to pi; second from 0 to pi where the sequence
    begins and ends with the same axis, else from -pi/2 to pi/2. The angles give the attitude back to round-off
    everywhere; where the second is at an end of its range only a sum of the others is defined, and derivatives in JAX
    are NaN. ValueError for another sequence than two or three different axes, and for a matrix that is no rotation (not
    seen inside jit).

    >>> print(euler_angles(attitude_of_euler_angles(np.array([0.3, 0.4, 0.5]))).round(12))  # the inverse
    [0.3 0.4 0.5]
    """
    i, j, k = _axes(sequence)
    _require_rotation(attitude)
    rest = 3 - i - j
    xp = namespace(attitude)
    turned = xp.swapaxes(attitude, -1, -2)

    def part(row: int, column: int) -> Array:
        return turned[..., row, column]

    sign = _parity(i, j, rest)
    if i == k:
        first = xp.arctan2(part(j, i), -sign * part(rest, i) + 0.0)  # which of -0.0 is 0.0, and the first angle 0
        second = xp.arctan2(xp.hypot(part(j, i), part(rest, i)), part(i, i))
    else:
        first = xp.arctan2(-sign * part(j, k), part(k, k))
        second = xp.arctan2(sign * part(i, k), xp.hypot(part(k, k), part(j, k)))
    # The third from what the first leaves, so that the two agree where neither is well defined.
    left = xp.cos(first)[..., None] * turned[..., j, :] + sign * xp.sin(first)[..., None] * turned[..., rest, :]
    last = 3 - j - k
    third = xp.arctan2(-_parity(k, j, last) * left[..., last], left[..., j])
    return xp.stack([first, second, third], axis=-1)


@with_quantities()
def nearest_rotation(matrix: Array) -> Array:
    """The rotation nearest to a matrix (..., 3, 3) in the sum of squares; an attitude as much as a rotation.

    NaN where the matrix is not finite. In JAX it has derivatives wherever no other rotation is as near: also at a
    rotation itself. ValueError for another shape.
    Source: Horn, Hilden & Negahdaripour (1988), J. Opt. Soc. Am. A 5, 1127, by singular values.

    >>> print(np.diag(nearest_rotation(1.1 * np.eye(3))).round(12))
    [1. 1. 1.]
    """
    xp = namespace(matrix)
    matrix = xp.asarray(matrix)
    if matrix.shape[-2:] != (3, 3):
        raise ValueError(f"nearest_rotation takes matrices of shape (..., 3, 3), not {matrix.shape}")
    return _nearest(np, matrix) if xp is np else _jax_nearest()(matrix)


def _nearest(xp: Any, matrix: Array) -> Array:
    # Numpy's own solver raises where one matrix is not finite, for the whole series.
    finite = xp.isfinite(matrix).all((-2, -1))[..., None, None]
    left, _, right = xp.linalg.svd(xp.where(finite, matrix, 0.0))
    proper = xp.sign(xp.linalg.det(left) * xp.linalg.det(right))
    one = xp.ones_like(proper)
    return xp.where(finite, (left * xp.stack([one, one, proper], axis=-1)[..., None, :]) @ right, xp.nan)


@cache
def _jax_nearest() -> Any:
    import jax  # only here: numpy users need not wait for it
    import jax.numpy as jnp

    @jax.custom_jvp
    def nearest(matrix: Array) -> Array:
        return _nearest(jnp, matrix)

    @nearest.defjvp
    def _(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
        # Singular vectors of equal values have no derivative, but R has: M = R S with a symmetric S, so with dR = R [w]
        # R^T dM - dM^T R = [w] S + S [w] = [(tr(S) 1 - S) w].
        rotation = nearest(primals[0])
        # Sums of products and no matrix product, for which an accelerator may use fewer digits.
        stretch, change = ((rotation[..., :, :, None] * one[..., :, None, :]).sum(-3) for one in (*primals, *tangents))
        stretch = 0.5 * (stretch + jnp.swapaxes(stretch, -1, -2))
        change = change - jnp.swapaxes(change, -1, -2)
        turned = jnp.stack([change[..., 2, 1], change[..., 0, 2], change[..., 1, 0]], axis=-1)
        size = jnp.trace(stretch, axis1=-2, axis2=-1)[..., None, None]
        matrix = size * jnp.broadcast_to(jnp.eye(3, dtype=stretch.dtype), stretch.shape) - stretch
        turn = jnp.linalg.solve(matrix, turned[..., None])[..., 0]
        return rotation, jnp.cross(rotation, jnp.broadcast_to(turn[..., None, :], rotation.shape))

    return nearest


@with_quantities()
def angle_between(one: Array, other: Array) -> Array:
    """The angle (...,), 0 to pi, of the rotation between two attitudes (..., 3, 3), to 1e-15 of a radian.

    >>> print(f"{angle_between(np.eye(3), rotation(np.array([0.0, 0.0, 0.25]))):.6f}")
    0.250000
    """
    xp = namespace(one, other)
    one, other = xp.asarray(one), xp.asarray(other)
    # A sum of products and no matrix product, for which an accelerator may use fewer digits.
    between = (one[..., :, :, None] * other[..., :, None, :]).sum(-3)
    square = (rotation_vector(between) ** 2).sum(-1)
    # Of attitudes that are the same the root has no slope: 0 then, with which the square of the angle has its own.
    return xp.where(square == 0, 0.0, xp.sqrt(xp.where(square == 0, 1.0, square)))


@with_quantities(body_angular_velocity="rad/s")
def attitude_rate(attitude: Array, body_angular_velocity: Array) -> Array:
    """dA/dt = -[omega] A, (..., 3, 3), of an attitude and the angular velocity (..., 3) in body axes, in rad per time.

    Source: Goldstein et al. section 4.9.

    >>> print(attitude_rate(np.eye(3), np.array([0.0, 0.0, 2.0]))[0])  # where body axis 1 goes: to +y
    [0. 2. 0.]
    """
    return -cross_matrix(body_angular_velocity) @ attitude


@with_quantities(attitude_rate="s-1")
def body_angular_velocity(attitude: Array, attitude_rate: Array) -> Array:
    """The angular velocity (..., 3) in body axes of an attitude and its rate (..., 3, 3); undoes `attitude_rate`.

    >>> print(body_angular_velocity(np.eye(3), attitude_rate(np.eye(3), np.array([0.0, 0.0, 2.0]))))
    [0. 0. 2.]
    """
    xp = namespace(attitude, attitude_rate)
    turn = attitude @ xp.swapaxes(attitude_rate, -1, -2)
    turn = 0.5 * (turn - xp.swapaxes(turn, -1, -2))
    return xp.stack([turn[..., 2, 1], turn[..., 0, 2], turn[..., 1, 0]], axis=-1)


def _require_rotation(matrix: Array) -> None:
    """ValueError for matrices (..., 3, 3) that are no rotations; one with NaN is not known, nor is what follows."""
    if is_known(matrix):
        matrix = np.asarray(matrix)
        require_orthogonal(matrix[~np.isnan(matrix).any((-2, -1))], ROUGHLY_ORTHOGONAL, may_mirror=False)


def _axes(sequence: str) -> tuple[int, int, int]:
    axes = tuple(_AXES.find(letter) for letter in sequence)
    if len(axes) != 3 or -1 in axes or axes[0] == axes[1] or axes[1] == axes[2]:
        raise ValueError(f"a sequence of Euler angles is like 'zxz' or 'zyx', not {sequence!r}")
    return axes


def _parity(i: int, j: int, k: int) -> int:
    return 1 if (j - i) % 3 == 1 and (k - j) % 3 == 1 else -1
