"""The ripple on an angle whose rate is an elliptic function with a pair of simple poles: phases of theta functions.

Azimuths of tops go at rates like constant/(cos^2 + p sin^2), of the sine and cosine sn and cn of an argument u, whose
integral is elliptic of the third kind: a mean rate and the phase of a theta function of w + ih, w = pi u/2K, where ih
is the place of the pole. The residues of tops are +-i/2, whatever their moments, so that the phase counts once.
As a phase it is known to round-off, also where the pole is next to the real axis and the angle goes in steps.

Source: Whittaker (1937), Analytical Dynamics, section 69; DLMF 20.2 and 20.7(viii). Tests:
tests/unit/rotation/test_free_attitude.py, tests/unit/rotation/test_heavy_top.py.
"""

import math
from decimal import Decimal

import numpy as np

from astroinertia.rotation.elliptic import PI, Modulus, carlson_rf, digits

_NEGLIGIBLE = 45.0  # terms below exp(-45) of the leading one are left out


def phase_ripple(modulus: Modulus, weight: Decimal, quarters: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """exp(i (angle - mean)) (...,) of an angle whose rate is its greatest at sn = 0, as 1/(cn^2 + weight sn^2).

    weight: 1 or more; at u = 4K (quarters/4 + rest), |rest| up to an eighth. The phase is that of the conjugate of
    -i theta_1(w + ih), less w. Test: tests/unit/rotation/test_free_attitude.py.
    """
    with digits():
        if weight <= 1:
            return np.ones_like(rest, dtype=complex)  # the rate is constant
        inverse = 1 / weight  # the pole is where sn^2 is 1/(1 - weight)
        pole = inverse.sqrt() * carlson_rf(1 - inverse, 1 - modulus.complement_square * inverse, Decimal(1))
        over = modulus.complementary_quarter if modulus.complementary else modulus.quarter
        place = float(PI * pole / (2 * over))
    turn = 2.0 * np.pi * rest
    if modulus.complementary:
        near, beyond = _thetas_of_complement(modulus.log_nome, -2.0 * modulus.log_nome * rest, place)
        turn = turn * (1.0 - 2.0 * place / np.pi)
    else:
        near, beyond = _thetas(modulus.log_nome, turn, place)
    theta = np.where(quarters % 2 == 1, beyond, near)
    return np.conj(theta) / abs(theta) * np.exp(-1.0j * turn)


def limit_ripple(weight: Decimal, tanh: np.ndarray) -> np.ndarray:
    """The same for k = 1, where the mean rate is that of both ends, from tanh u (...,).

    Test: tests/unit/rotation/test_free_attitude.py.
    """
    with digits():
        sine, cosine = float((1 / weight).sqrt()), float((1 - 1 / weight).sqrt())
    phase = sine + 1.0j * cosine * tanh
    return phase / abs(phase)


def _thetas(log_nome: float, turn: np.ndarray, place: float) -> tuple[np.ndarray, np.ndarray]:
    """-i theta_1 and theta_2 of turn + i place, over a positive factor; 2 place is at most -log_nome."""
    near, beyond = np.zeros_like(turn, dtype=complex), np.zeros_like(turn, dtype=complex)
    for n in range(8):
        exponent = n * ((n + 1) * log_nome + 2 * place) if n else 0.0
        if exponent < -_NEGLIGIBLE:
            break
        growing = math.exp(exponent)
        sinh = growing * -math.expm1(-2 * (2 * n + 1) * place)
        cosh = 2.0 * growing - sinh
        sine, cosine = np.sin((2 * n + 1) * turn), np.cos((2 * n + 1) * turn)
        near += (-1) ** n * (cosine * sinh - 1.0j * sine * cosh)
        beyond += cosine * cosh - 1.0j * sine * sinh
    return near, beyond


def _thetas_of_complement(log_nome: float, argument: np.ndarray, place: float) -> tuple[np.ndarray, np.ndarray]:
    """The same by the nome of k', as -theta_1 and theta_4 of i argument - place, each over a positive factor."""
    near, beyond = np.zeros_like(argument, dtype=complex), np.ones_like(argument, dtype=complex)
    for n in range(8):
        odd, even = 2 * n + 1, 2 * n
        if n and (n * n - 0.5 * n) * log_nome < -_NEGLIGIBLE:
            break
        if n:
            factor = 2.0 * (-1) ** n * math.exp(n * n * log_nome)
            cosh, sinh = np.cosh(even * argument), np.sinh(even * argument)
            beyond += factor * (cosh * math.cos(even * place) + 1.0j * sinh * math.sin(even * place))
        if n == 0 or (n * (n + 1) - 0.5 * n) * log_nome > -_NEGLIGIBLE:
            factor = (-1) ** n * (math.exp(n * (n + 1) * log_nome) if n else 1.0)
            cosh, sinh = np.cosh(odd * argument), np.sinh(odd * argument)
            near += factor * (cosh * math.sin(odd * place) - 1.0j * sinh * math.cos(odd * place))
    return near, beyond
