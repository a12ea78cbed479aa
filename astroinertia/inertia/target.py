"""A penalty energy for the distance between a body's second moment and a target, and the accelerations it calls for.

It generalises the length constraint of cell-shape models, which penalises lambda (L - L_target)^2 with L from the
largest eigenvalue of a cell's inertia tensor (Zajac, Jones & Glazier 2003, J. Theor. Biol. 222, 247; Merks et al. 2006,
Dev. Biol. 289, 44), to the whole tensor. With Q the second moment about the centre of mass, N the target, both divided
by a trace T, k the stiffness and k_o that of the orientation,

    E = T/2 [k |Q/T - N'|^2 + 2 k_o Q/T : (N' - N)],

N' is N turned to the body's own principal axes, in the order of the moments. The first part is that of size and
elongation and does not know how the body lies; the second is that of orientation and not negative (von Neumann's trace
inequality). T is the target's trace, or the body's own where the size is free. With k_o = k the two make
k T |Q/T - N|^2/2, which is smooth everywhere and convex in Q, so that it has one minimum; otherwise the force jumps
where principal moments are equal, and a sphere takes whatever axes its round-off suggests.

The force on each particle is linear in its place, a = A (x - c), with A = -2 dE/dQ symmetric. So nothing depends on
where the body is, the net force is zero and momentum is conserved. The torque is the axial vector of Q A,
2 k_o times that of Q N: angular momentum is conserved where the orientation is free (k_o = 0), and otherwise exchanged
with whatever holds the target's axes. In the plane normal to a given direction, the same energy is taken of the shadows
of both tensors on that plane (for flat bodies: of their tensors), and nothing acts along the normal.

Tensors are (..., 3, 3) in numpy or jax and any consistent units. Checked by tests/unit/inertia/test_target.py.
"""

from typing import Any

from astroinertia.inertia.principal import principal_frame
from astroinertia.inertia.tensor import namespace
from astroinertia.process.quantities import with_quantities

Array = Any


@with_quantities()
def target_tensor(squares: Array, axes: Array | None = None) -> Array:
    """Tensor (3, 3) with these values (3,) along its axes, the rows of `axes` (3, 3); x, y and z where none are given.

    Values are second moments; squares of semi-axes will do where only their ratios count.

    >>> print(np.diag(target_tensor((3.0, 2.0, 1.0))))
    [3. 2. 1.]
    """
    xp = namespace(squares, axes)
    squares = xp.asarray(squares)
    axes = xp.eye(3, dtype=squares.dtype) if axes is None else axes
    return xp.einsum("k,ki,kj->ij", squares, axes, axes)


@with_quantities(target="kg m2", stiffness="s-2", orientation_stiffness="s-2")
def target_energy(
    second_moment: Array,
    target: Array,
    stiffness: Array,
    orientation_stiffness: Array | None = None,
    free_size: bool = False,
    normal: Array | None = None,
) -> Array:
    """The penalty energy (...,) of a second moment about the centre of mass, in units of second_moment times stiffness.

    target: second moment (..., 3, 3) wanted, of any size where `free_size`; stiffness: 1/time^2; orientation_stiffness:
    the same where it is not given, 0 for a free orientation; normal: of the plane (3,) that alone counts, if any.

    >>> print(target_energy(np.diag([3.0, 2.0, 1.0]), target_tensor((3.0, 2.0, 1.0)), 1.0))  # it has what is wanted
    0.0
    """
    xp = namespace(second_moment, target, normal)
    trace, share, wanted, _ = _shares(xp, second_moment, target, free_size, normal)
    if orientation_stiffness is None:
        return 0.5 * trace * stiffness * _square(share - wanted)
    aligned = _aligned(xp, share, wanted)
    turned = _contracted(share, aligned - wanted)
    return trace * (0.5 * stiffness * _square(share - aligned) + orientation_stiffness * turned)


@with_quantities()
def target_matrix(
    second_moment: Array,
    target: Array,
    stiffness: Array,
    orientation_stiffness: Array | None = None,
    free_size: bool = False,
    normal: Array | None = None,
) -> Array:
    """A = -2 dE/dQ, symmetric (..., 3, 3): particles at x are accelerated by A (x - c). Arguments as for the energy.

    >>> print(np.diag(target_matrix(np.diag([4.0, 1.0, 1.0]), np.eye(3), 1.0)))  # too long along x: inwards
    [-2. -0. -0.]
    """
    xp = namespace(second_moment, target, normal)
    _, share, wanted, plane = _shares(xp, second_moment, target, free_size, normal)
    aligned = wanted if orientation_stiffness is None else _aligned(xp, share, wanted)
    matrix = -2.0 * stiffness * (share - aligned)
    if orientation_stiffness is not None:
        matrix = matrix - 2.0 * orientation_stiffness * (aligned - wanted)
    if free_size:
        # The trace in E follows the body: what |Q|^2/T gains by a smaller T.
        gain = _contracted(share - aligned, share + aligned)
        matrix = matrix + stiffness * gain[..., None, None] * plane
    return matrix


@with_quantities(target="kg m2", stiffness="s-2", orientation_stiffness="s-2")
def target_energy_gradient(mass: Array, position: Array, target: Array, stiffness: Array, **options: Any) -> Array:
    """dE/dx of every particle, (N, 3), exactly: -m A (x - c), for masses (N,) at positions (N, 3).

    Positions (N, 2) of a flat body give (N, 2), with a target of which the block of x and y counts. Options as for
    `target_energy`.

    >>> x = np.concatenate([np.eye(3), -np.eye(3)])
    >>> print(target_energy_gradient(np.ones(6), x, np.eye(3), 1.0)[:3].round(6))  # too large: uphill is outwards
    [[0.666667 0.       0.      ]
     [0.       0.666667 0.      ]
     [0.       0.       0.666667]]
    """
    xp = namespace(position)
    flat = position.shape[-1] == 2
    if flat:
        position = xp.concatenate([position, xp.zeros_like(position[..., :1])], axis=-1)
        options = {**options, "normal": xp.asarray((0.0, 0.0, 1.0))}
    relative = position - (mass @ position) / mass.sum()
    weighted = mass[:, None] * relative
    gradient = -weighted @ target_matrix(weighted.T @ relative, target, stiffness, **options)
    return gradient[..., :2] if flat else gradient


def _shares(
    xp: Any, second_moment: Array, target: Array, free_size: bool, normal: Array | None
) -> tuple[Array, Array, Array, Array]:
    # T, Q/T and N, in the plane where there is one, and the unit tensor there.
    second_moment = xp.asarray(second_moment)
    plane = xp.eye(3, dtype=second_moment.dtype)
    if normal is not None:
        across: Any = xp.asarray(normal)
        plane = plane - xp.outer(across, across) / (across @ across)
        second_moment, target = plane @ second_moment @ plane, plane @ target @ plane
    own = xp.trace(target, axis1=-2, axis2=-1)
    trace = xp.trace(second_moment, axis1=-2, axis2=-1) if free_size else own
    # A body without extent has no shape to be driven.
    divisor = xp.where(trace > 0, trace, 1.0)
    return trace, second_moment / divisor[..., None, None], target / own[..., None, None], plane


def _aligned(xp: Any, share: Array, wanted: Array) -> Array:
    values = principal_frame(wanted)[0]
    axes = principal_frame(share)[1]
    return xp.einsum("...k,...ki,...kj->...ij", values, axes, axes)


def _contracted(one: Array, other: Array) -> Array:
    return (one * other).sum((-2, -1))


def _square(tensor: Array) -> Array:
    return _contracted(tensor, tensor)
