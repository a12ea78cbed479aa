"""When matter that is still apart comes within reach: what a time step must not pass over.

Signal velocities tell of neighbours alone. Two bodies that approach each other far above the speed of sound are not
neighbours yet, and a step that suits each by itself would carry one through the other. Particles in the order of their
leaves are therefore taken in groups, each a ball that moves with some velocity and spreads with another.
"""

from typing import Any

import numpy as np

Array = Any
DEPTH = 0.5  # smoothing lengths that matter may go into other matter in one step
GROUPS = 256  # balls: their pairs cost less than a thousandth of a step of many particles


def root(xp: Any, square: Array) -> Array:
    """The square root, whose gradient is zero at zero."""
    return xp.where(square > 0.0, xp.sqrt(xp.where(square > 0.0, square, 1.0)), 0.0)


def contact_limit(
    xp: Any, position: Array, velocity: Array, smoothing_length: Array, support: float, step: Array
) -> Array:
    """The longest step, a scalar, in which no two groups go deeper into each other than DEPTH smoothing lengths h.

    A pair of groups whose kernels, of `support` smoothing lengths, leave a gap and that close in at the rate w may step
    by (gap + DEPTH h)/w. position, velocity (N, 3), smoothing_length (N,), sorted; step is what all else allows: where
    that takes nothing so deep, numpy looks no further. Test: tests/unit/test_contact.py.
    """
    relative = velocity - velocity.mean(axis=0)
    if xp is np:  # the reach of what follows is a matter of speed alone
        fastest = 2.0 * np.sqrt((relative**2).sum(axis=1).max())
        if step * fastest <= DEPTH * smoothing_length.min():
            return np.float64(np.inf)
    count = len(smoothing_length)
    members = -(-count // min(count, GROUPS))
    rows = np.minimum(np.arange(-(-count // members) * members), count - 1).reshape(-1, members)

    def balls(vector: Array) -> tuple[Array, Array]:
        inside = vector[rows]
        middle = 0.5 * (inside.min(axis=1) + inside.max(axis=1))
        return middle, root(xp, ((inside - middle[:, None]) ** 2).sum(axis=2).max(axis=1))

    centre, radius = balls(position - position.mean(axis=0))
    drift, spread = balls(relative)
    length = smoothing_length[rows].max(axis=1)
    apart = centre[:, None] - centre[None, :]
    moving = drift[:, None] - drift[None, :]
    distance = root(xp, (apart**2).sum(axis=2))
    towards = xp.where(
        distance > 0.0,
        -(apart * moving).sum(axis=2) / xp.where(distance > 0.0, distance, 1.0),
        root(xp, (moving**2).sum(axis=2)),
    )
    closing = towards + spread[:, None] + spread[None, :]
    reach = xp.maximum(length[:, None], length[None, :])
    gap = xp.maximum(distance - radius[:, None] - radius[None, :] - support * reach, 0.0)
    return xp.min(xp.where(closing > 0.0, (gap + DEPTH * reach) / xp.where(closing > 0.0, closing, 1.0), xp.inf))
