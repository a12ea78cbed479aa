"""Gravity as a sum over all pairs (G = 1)."""

from astroinertia.engines.terms import Output, PairTerm


def direct_pair(xp, dphi_i, dphi_j, phi_i, phi_j):
    """Attraction and potential softened by both kernels."""
    return 0.5 * (dphi_i + dphi_j), 0.5 * (phi_i + phi_j)


def direct_far(xp, r):
    """The same where neither kernel reaches."""
    inverse = 1.0 / r
    return inverse * inverse, -inverse


DIRECT_GRAVITY = PairTerm(
    "gravity", direct_pair, (Output("acceleration", "central"), Output("potential", "sum")), far=direct_far
)
