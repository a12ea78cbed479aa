"""Polhodes: the curves that the angular velocity of a free rigid body runs along on its inertia ellipsoid."""

import numpy as np

_FAMILIES = ((0, 1, 2), (2, 1, 0))  # axis that a family circles, the intermediate one, and the other


def polhode(moments: np.ndarray, share: float, around: int, points: int = 241) -> np.ndarray:
    """The two closed curves of a polhode, (2, points, 3), in the principal axes, on the ellipsoid sum I_k x_k^2 = 1.

    moments (3,), ascending and positive; x = omega / sqrt(2 T). around: 0 or 2, the axis that the curves circle, that
    of the least or of the greatest moment; the other moments must differ from its own. share: from 0, the axis itself,
    to 1, the separatrix through the intermediate axis.
    Along a polhode |I x|^2 = D = L^2 / (2 T) is constant, so that two of the x_k^2 follow from the third: Poinsot
    (1834); Landau & Lifshitz, Mechanics, section 37. Checked by tests/unit/plots/test_inertia.py.
    """
    lone, middle, other = next(family for family in _FAMILIES if family[0] == around)
    lone_moment, middle_moment, other_moment = moments[lone], moments[middle], moments[other]
    turn = np.linspace(0.0, 2.0 * np.pi, points)
    curve = np.zeros((2, points, 3))
    across = share**2 * abs(lone_moment - middle_moment)  # |D - I| for the moment that the curves circle
    curve[..., middle] = np.sqrt(across / (middle_moment * abs(lone_moment - middle_moment))) * np.sin(turn)
    curve[..., other] = np.sqrt(across / (other_moment * abs(lone_moment - other_moment))) * np.cos(turn)
    rest = 1.0 - middle_moment * curve[0, :, middle] ** 2 - other_moment * curve[0, :, other] ** 2
    curve[..., lone] = np.array([[1.0], [-1.0]]) * np.sqrt(np.maximum(rest, 0.0) / lone_moment)
    return curve
