"""What the closed forms of shapes share: checked sizes in, and a Body out of the mean squares of its coordinates.

A homogeneous body's mean squares <x^2>, <y^2>, <z^2> about its centre of mass say all that its inertia tensor does, and
are simpler: I_xx = m (<y^2> + <z^2>) and so on, with no cancellation for thin bodies.
"""

from typing import Any

import numpy as np

from astroinertia.inertia.body import Body
from astroinertia.inertia.tensor import inertia_from_second_moment, namespace
from astroinertia.process.known import is_known

Array = Any


def checked(mass: Array, can_vanish: tuple[str, ...] = (), **sizes: Array) -> tuple[Any, list[Array]]:
    """The namespace, and mass and sizes as arrays (...,) of one shape and precision, the widest given.

    A mass must be finite and may be negative (a hole); sizes must be finite and positive, or 0 where `can_vanish` names
    them. Else a ValueError says which; values that are not known yet, inside jax.jit or jax.grad, pass unseen.
    Checked by tests/unit/inertia/test_shapes.py.
    """
    xp = namespace(mass, *sizes.values())
    values = [np.asarray(value) if isinstance(value, (list, tuple)) else value for value in (mass, *sizes.values())]
    precision = xp.result_type(*values, 1.0)  # 1.0 makes whole numbers floating, and widens nothing
    arrays = xp.broadcast_arrays(*(xp.asarray(value, dtype=precision) for value in values))
    if is_known(arrays[0]) and not np.isfinite(np.asarray(arrays[0])).all():
        raise ValueError("the mass of a shape must be finite")
    for name, array in zip(sizes, arrays[1:], strict=True):
        if is_known(array):
            value = np.asarray(array)
            wrong = ~(np.isfinite(value) & ((value >= 0) if name in can_vanish else (value > 0)))
            if wrong.any():
                bound = "0 or more" if name in can_vanish else "above 0"
                raise ValueError(
                    f"the {name.replace('_', ' ')} of a shape must be finite and {bound}, not {value[wrong].flat[0]:g}"
                )
    return xp, list(arrays)


def checked_points(mass: Array, points: Array, trailing: tuple[int | None, ...], what: str) -> tuple[Any, Array, Array]:
    """The namespace, mass (...,) and points (..., *trailing) in one precision, the widest given; None stands for any.

    A ValueError where the shape or a known value is not as stated. Checked by tests/unit/inertia/test_shapes.py.
    """
    xp = namespace(mass, points)
    values = [np.asarray(value) if isinstance(value, (list, tuple)) else value for value in (mass, points)]
    precision = xp.result_type(*values, 1.0)  # 1.0 makes whole numbers floating, and widens nothing
    mass, points = (xp.asarray(value, dtype=precision) for value in values)
    shape = points.shape[-len(trailing) :]
    if len(shape) < len(trailing) or any(want not in (None, size) for want, size in zip(trailing, shape, strict=True)):
        dimensions = ", ".join("n" if size is None else str(size) for size in trailing)
        raise ValueError(f"{what} must have shape (..., {dimensions}), not {points.shape}")
    for name, array in (("the mass of a shape", mass), (what, points)):
        if is_known(array) and not np.isfinite(np.asarray(array)).all():
            raise ValueError(f"{name} must be finite")
    return xp, mass, points


def refuse(wrong: Array, complaint: str) -> None:
    """A ValueError with this complaint where any of the truth values (...,) is known to be true."""
    if is_known(wrong) and np.asarray(wrong).any():
        raise ValueError(complaint)


def body_of(xp: Any, mass: Array, x: Array, y: Array, z: Array) -> Body:
    """The Body of mass (...,) centred at the origin, with mean squares x, y, z (...,) along these axes."""
    none = xp.zeros_like(mass)
    rows = [[y + z, none, none], [none, z + x, none], [none, none, x + y]]
    tensor = xp.stack([xp.stack([xp.broadcast_to(element, mass.shape) for element in row], -1) for row in rows], -2)
    return Body(mass, xp.stack([none, none, none], -1), mass[..., None, None] * tensor)


def body_of_simplices(mass: Array, vertices: Array, shares: Array | None = None) -> Body:
    """The homogeneous Body made of simplices: segments, triangles or tetrahedra, with n vertices (..., k, n, 3) each.

    mass (...,) of the whole; shares (..., k), signed, of which only the ratios matter (all equal where none are given).
    About its own centroid a simplex has <x (x) x> = sum over vertices of v (x) v / (n (n + 1)) (Eberly 2002, Polyhedral
    Mass Properties, for n = 4). Checked by tests/unit/inertia/test_shapes.py and test_mesh.py.
    """
    xp = namespace(mass, vertices)
    count = vertices.shape[-2]
    # From one of the corners: nothing is lost far from the origin, where the middle of a simplex would be rounded.
    start = vertices[..., :1, :1, :]
    local = vertices - start
    centres = local.mean(-2)
    offsets = local - centres[..., None, :]
    own = xp.einsum("...nk,...nl->...kl", offsets, offsets) / (count * (count + 1))
    weights = xp.ones_like(centres[..., 0]) if shares is None else xp.asarray(shares)
    weights = weights / weights.sum(-1, keepdims=True)
    centre = xp.einsum("...k,...ki->...i", weights, centres)
    away = centres - centre[..., None, :]
    second = xp.einsum("...k,...kij->...ij", weights, own + away[..., :, None] * away[..., None, :])
    shape = xp.broadcast_shapes(mass.shape, second.shape[:-2])
    mass = xp.broadcast_to(mass, shape)
    return Body(
        mass,
        xp.broadcast_to(start[..., 0, 0, :] + centre, (*shape, 3)),
        mass[..., None, None] * inertia_from_second_moment(xp.broadcast_to(second, (*shape, 3, 3))),
    )
