"""exp, log and power in plain arithmetic, so that loops over them become vector instructions.

The text of this file is copied into generated modules. Errors against correctly rounded values, in units of the last
place: exp and log below 1, power below 1 + |y log x| (tests/unit/engines/test_elementwise.py). Results below the
smallest normal number are 0.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_compiler import PartCompiler

# Copied into generated modules from here on.
ELEMENTARY = {
    "forceinline": True, "error_model": "numpy", "fastmath": {"contract", "nsz"},
    "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": PartCompiler,
}  # fmt: skip
# Added to a number below 2^51 and taken away again, it leaves the nearest whole number, whose bits are the last ones.
ROUNDING = 6755399441055744.0
INVERSE_LN2 = 1.4426950408889634
# log 2 in two parts (Cody & Waite): multiples of the first by whole numbers below 2^20 are exact.
LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10


@njit(**ELEMENTARY)
def exp(x):
    """2^n times Taylor's series of what is left, |f| <= (log 2)/2."""
    shifted = x * INVERSE_LN2 + ROUNDING
    whole = shifted - ROUNDING
    f = (x - whole * LN2_HIGH) - whole * LN2_LOW
    s = 1.0 / 6227020800.0
    s = s * f + 1.0 / 479001600.0
    s = s * f + 1.0 / 39916800.0
    s = s * f + 1.0 / 3628800.0
    s = s * f + 1.0 / 362880.0
    s = s * f + 1.0 / 40320.0
    s = s * f + 1.0 / 5040.0
    s = s * f + 1.0 / 720.0
    s = s * f + 1.0 / 120.0
    s = s * f + 1.0 / 24.0
    s = s * f + 1.0 / 6.0
    s = s * f + 0.5
    grown = 1.0 + (f + f * f * s)
    scale = np.int64((np.float64(shifted).view(np.int64) + 1023) << 52).view(np.float64)
    value = grown * scale
    value = 0.0 if x < -708.0 else value
    value = np.inf if x > 709.0 else value
    return x if x != x else value


@njit(**ELEMENTARY)
def log(x):
    """k log 2 + log(1 + f) with 1 + f between the roots of 1/2 and 2, by the odd series in f/(2 + f)."""
    bits = np.float64(x).view(np.int64)
    power_of_two = (bits - np.int64(0x3FE6A09E667F3BCD)) >> 52
    f = np.int64(bits - (power_of_two << 52)).view(np.float64) - 1.0
    k = np.int64(power_of_two + np.int64(0x4338000000000000)).view(np.float64) - ROUNDING
    s = f / (2.0 + f)
    z = s * s
    # Minimax coefficients of the series (Sun Microsystems' fdlibm, e_log.c; error below 2^-58.45).
    r = 1.479819860511658591e-01
    r = r * z + 1.531383769920937332e-01
    r = r * z + 1.818357216161805012e-01
    r = r * z + 2.222219843214978396e-01
    r = r * z + 2.857142874366239149e-01
    r = r * z + 3.999999999940941908e-01
    r = r * z + 6.666666666666735130e-01
    half = 0.5 * f * f
    value = k * LN2_HIGH - ((half - (s * (half + r * z) + k * LN2_LOW)) - f)
    value = -np.inf if x < 2.2250738585072014e-308 else value
    value = np.nan if x < 0.0 else value
    return x if x == np.inf or x != x else value


@njit(**ELEMENTARY)
def power(x, y):
    """x^y of x >= 0."""
    value = exp(y * log(x))
    return 1.0 if y == 0.0 else value
