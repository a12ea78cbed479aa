"""Clairaut's equation: how the level surfaces of a slowly rotating or tidally forced fluid body are flattened.

Level surfaces r(1 + f_l P_l) of a body in hydrostatic equilibrium obey, to first order in f_l and with
D = rho/rho_mean(<r),

    r^2 f_l'' + 6 D (r f_l' + f_l) - l(l + 1) f_l = 0,    eta = r f_l'/f_l,    k_l = (l + 1 - eta)/(l + eta) at r = R.

Sources: Clairaut 1743; Radau 1885; Jeffreys 1976, The Earth, ch. IV; Kopal 1959, Close Binary Systems, ch. II.
Tests: tests/unit/test_clairaut.py.
"""

from typing import Any

Array = Any


def radau_slope(r: Array, eta: Array, density_over_mean: Array, degree: int) -> Array:
    """d eta/dr of Radau's variable eta = d ln f_l/d ln r, r > 0; eta is l - 2 at a regular centre and never jumps.

    density_over_mean: D, the density at r over the mean density inside r. Numbers, numpy or jax arrays of one shape, r
    in any unit. Source: Radau 1885, for any degree l Kopal 1959 (II.1). Checked by tests/unit/test_clairaut.py.
    """
    return (degree * (degree + 1) - 6 * density_over_mean * (eta + 1) - eta * (eta - 1)) / r


def love_number_from_radau(eta: Array, degree: int = 2) -> Array:
    """The fluid Love number k_l = (l + 1 - eta)/(l + eta) from Radau's variable at the surface.

    The apsidal constant of a star is half of it. Source: Kopal 1959 (II.2). Checked by tests/unit/test_clairaut.py.
    """
    return (degree + 1 - eta) / (degree + eta)
