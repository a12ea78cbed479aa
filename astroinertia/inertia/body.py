"""A rigid body as far as its motion is concerned: mass, centre of mass and inertia tensor, composed by + and -."""

from dataclasses import dataclass
from typing import Any

from astroinertia.engines.pytree import pytree
from astroinertia.inertia.tensor import about_point, moment_about, namespace, point_inertia, rotated
from astroinertia.process.known import is_known
from astroinertia.process.quantities import with_quantities
from astroinertia.process.vectors import require_components

Array = Any

_SMALLEST_SHARE = 4.0  # roundings of its parts that a total mass must exceed to differ from 0


@pytree
@with_quantities(centre="m")
@dataclass(frozen=True)
class Body:
    """Mass, centre of mass and inertia tensor about it; numpy or jax arrays in any consistent units.

    mass (...,), negative for a hole; centre (..., 3); inertia (..., 3, 3) about the centre of mass, in the axes of the
    frame in use. Leading axes are a batch. A JAX pytree. Source: Goldstein, Poole & Safko (2002), Classical Mechanics,
    section 5.3. Checked by tests/unit/inertia/test_body.py and test_identities.py.

    >>> from astroinertia.inertia import shapes
    >>> part = shapes.disc(4.0, 2.0) - shapes.disc(1.0, 1.0)  # a hole is a body of negative mass
    >>> print(float(part.mass), f"{part.moment((0, 0, 1)):.4f}")  # as shapes.annulus(3.0, 2.0, 1.0)
    3.0 7.5000
    """

    mass: Array
    centre: Array
    inertia: Array

    @with_quantities(point="m")
    def about(self, point: Array) -> Array:
        """Inertia tensor about a point (..., 3), by the parallel-axis theorem: (..., 3, 3)."""
        require_components(point=point)
        point = namespace(self.centre, point).asarray(point)
        return about_point(self.inertia, self.mass, self.centre - point)

    @with_quantities(point="m")
    def moment(self, axis: Array, point: Array | None = None) -> Array:
        """Moment of inertia (...,) about the line along axis (..., 3), of any length, through point (..., 3).

        The line passes through the centre of mass where no point is given.
        """
        inertia = self.inertia if point is None else self.about(point)
        return moment_about(inertia, namespace(inertia, axis).asarray(axis))

    @with_quantities(by="m")
    def translated(self, by: Array) -> "Body":
        """The body moved by a vector (..., 3)."""
        require_components(by=by)
        return Body(self.mass, self.centre + namespace(self.centre, by).asarray(by), self.inertia)

    @with_quantities(about="m")
    def rotated(self, matrix: Array, about: Array | None = None) -> "Body":
        """The body turned by a rotation (or mirrored), matrix (..., 3, 3), about a point (..., 3).

        An active rotation: a point x of the body goes to about + matrix (x - about), and I to R I R^T. The point is the
        centre of mass where none is given. A matrix that is not orthogonal is a ValueError.
        """
        xp = namespace(matrix, self.inertia, self.centre, about)
        matrix = xp.asarray(matrix)
        matrix = matrix.astype(xp.result_type(matrix, self.inertia))
        inertia = rotated(self.inertia, matrix)
        if about is None:
            return Body(self.mass, self.centre, inertia)
        require_components(about=about)
        about = xp.asarray(about)
        return Body(self.mass, about + (matrix @ (self.centre - about)[..., None])[..., 0], inertia)

    def __add__(self, other: "Body") -> "Body":
        """Both bodies as one rigid body; a total mass of 0 has no centre and is a ValueError (not seen inside jit)."""
        if not isinstance(other, Body):
            return NotImplemented
        xp = namespace(*vars(self).values(), *vars(other).values())
        mine, theirs = xp.asarray(self.mass), xp.asarray(other.mass)
        total = mine + theirs
        if is_known(total):
            least = _SMALLEST_SHARE * xp.finfo(total.dtype).eps * xp.maximum(abs(mine), abs(theirs))
            if (abs(total) <= least).any():
                raise ValueError("the masses add up to 0, so the sum of the bodies has no centre of mass")
        # With the vector between the centres, and not with each centre's own, nothing is lost far from the origin.
        apart = other.centre - self.centre
        # From the heavier one, which the sum's centre is near to: a light one far away would bring its own roundings.
        from_mine = self.centre + (theirs / total)[..., None] * apart
        from_theirs = other.centre - (mine / total)[..., None] * apart
        return Body(
            total,
            xp.where((abs(mine) >= abs(theirs))[..., None], from_mine, from_theirs),
            self.inertia + other.inertia + point_inertia(mine * (theirs / total), apart),
        )

    def __radd__(self, other: Any) -> "Body":
        """0 + body, with which sum() begins, is the body."""
        return self if isinstance(other, int) and other == 0 else NotImplemented

    def __neg__(self) -> "Body":
        """The hole that this body would leave: negative mass and inertia at the same place."""
        return Body(-self.mass, self.centre, -self.inertia)

    def __sub__(self, other: "Body") -> "Body":
        """This body with the hole that the other would leave."""
        return self + -other if isinstance(other, Body) else NotImplemented
