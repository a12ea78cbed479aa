"""Softened gravity in two parts (G = 1): clamped points, and what softening changes about those for close pairs.

Points attract by 1/max(r^2, (h_i^2 + h_j^2)/4): cheap, bounded and continuous, and Newton's law where expansions take
over. The rest is a sum over neighbours like any other, for it is nothing beyond the support of both kernels.
"""

from astroinertia.engines.terms import Output, PairTerm

CLAMP = 0.25  # of h^2: a particle's share of the least squared distance


def clamped_inverse(xp, r, h_i, h_j):
    """One over the distance that points attract by."""
    return 1.0 / xp.sqrt(xp.maximum(r * r, CLAMP * (h_i * h_i + h_j * h_j)))


def point_pair(xp, r, h_i, h_j):
    """Attraction and potential of clamped points."""
    inverse = clamped_inverse(xp, r, h_i, h_j)
    return r * (inverse * inverse * inverse), -inverse


def point_far(xp, r):
    """The same where nothing is clamped."""
    inverse = 1.0 / r
    return inverse * inverse, -inverse


def softened_less_point(xp, r, h_i, h_j, dphi_i, dphi_j, phi_i, phi_j):
    """What softening by both kernels changes."""
    inverse = clamped_inverse(xp, r, h_i, h_j)
    return 0.5 * (dphi_i + dphi_j) - r * (inverse * inverse * inverse), 0.5 * (phi_i + phi_j) + inverse


OUTPUTS = (Output("acceleration", "central"), Output("potential", "sum"))
POINTS = PairTerm("gravity", point_pair, OUTPUTS, far=point_far)
SOFTENED_LESS_POINT = PairTerm("gravity", softened_less_point, OUTPUTS)
