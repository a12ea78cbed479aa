"""Softened attraction as polynomials without branches, for loops in which every pair is computed alike.

A kernel is a sum of pieces, each a polynomial w on [0, k h) and 0 beyond. With b = 1/(k h), c = min(1/r, b) and
x = min(r b, 1) a piece attracts by c^3 P(x) r and has the potential -c Q(x), where

    P(x) = 4 pi k^3 x^-3 int_0^x w s^2 ds,      Q(x) = x^2 P(x) + 4 pi k^3 int_x^1 w s ds,

within and beyond its reach alike. The polynomials are written about x = 1/2, where their terms do not cancel.
The test in tests/unit/test_multipole.py holds them to sph.kernels.
"""

import math

from numpy.polynomial import Polynomial

X = Polynomial([0.0, 1.0])


def pieces(kernel: str) -> list[tuple[float, Polynomial]]:
    """(k, w as a polynomial of x = q/k) of every piece (Schoenberg splines; Dehnen & Aly 2012, table 1)."""
    if kernel.startswith("wendland"):
        exponent, factor, norm = {
            "wendland_c2": (4, 1.0 + 4.0 * X, 21.0 / 16.0),
            "wendland_c4": (6, 1.0 + 6.0 * X + 35.0 / 3.0 * X**2, 495.0 / 256.0),
            "wendland_c6": (8, 1.0 + 8.0 * X + 25.0 * X**2 + 32.0 * X**3, 1365.0 / 512.0),
        }[kernel]
        return [(2.0, norm / math.pi * (1.0 - X) ** exponent * factor)]
    exponent, norm, knots = {
        "cubic": (3, 1.0 / 4.0, {2.0: 1.0, 1.0: -4.0}),
        "quartic": (4, 1.0 / 20.0, {2.5: 1.0, 1.5: -5.0, 0.5: 10.0}),
        "quintic": (5, 1.0 / 120.0, {3.0: 1.0, 2.0: -6.0, 1.0: 15.0}),
    }[kernel]
    return [(k, norm / math.pi * weight * k**exponent * (1.0 - X) ** exponent) for k, weight in knots.items()]


def attraction(k: float, w: Polynomial) -> tuple[Polynomial, Polynomial]:
    """P and Q of a piece, as polynomials of x - 1/2."""
    strength = 4.0 * math.pi * k**3
    p = Polynomial([c / (j + 3) for j, c in enumerate(w.coef)]) * strength
    below = Polynomial([0.0, 0.0] + [c / (j + 2) for j, c in enumerate(w.coef)]) * strength
    q = X**2 * p + below(1.0) - below
    return p(X + 0.5), q(X + 0.5)


def _horner(polynomial: Polynomial) -> str:
    first, *rest = reversed([float(c) for c in polynomial.coef])
    text = f"real({first!r})"
    for coefficient in rest:
        text = f"real({coefficient!r}) + y * ({text})"
    return text


def softened(kernel: str, support: float) -> list[str]:
    """softened_pair(r, inverse, b): slope of the attraction over r, and minus the potential, at b = 1/reach."""
    lines = [
        '@njit(forceinline=True, error_model="numpy", fastmath=LOOP_FLAGS)',
        "def softened_pair(r, inverse, b):",
    ]
    slope, depth = [], []
    for n, (k, w) in enumerate(pieces(kernel)):
        p, q = attraction(k, w)
        lines += [
            f"    b_{n} = b * real({support / k!r})" if k != support else f"    b_{n} = b",
            f"    c = where(inverse < b_{n}, inverse, b_{n})",
            f"    x = r * b_{n}",
            "    y = where(x < real(1), x, real(1)) - real(0.5)",
            f"    slope_{n} = c * c * c * ({_horner(p)})",
            f"    depth_{n} = c * ({_horner(q)})",
        ]
        slope.append(f"slope_{n}")
        depth.append(f"depth_{n}")
    return [*lines, f"    return {' + '.join(slope)}, {' + '.join(depth)}", "", ""]
