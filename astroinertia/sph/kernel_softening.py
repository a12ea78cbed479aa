"""How the potential that a kernel softens changes with the smoothing length: h^2 dphi/dh as a function of q = r/h.

It is -(phi + q dphi) = 4 pi int_q^support w s ds, and so made of the same truncated powers as the kernel, with no
cancellation and no division. The functions are plain, as those of kernels.py.
tests/unit/sph/test_kernels.py holds them to the integral.
"""


def cubic_softening(xp, q):
    """M4 change of the potential with h."""
    a = xp.maximum(0.0, 2.0 - q)
    b = xp.maximum(0.0, 1.0 - q)
    a2 = a * a
    b2 = b * b
    return a2 * a2 * (0.5 - 0.2 * a) - b2 * b2 * (1.0 - 0.8 * b)


def quartic_softening(xp, q):
    """M5 change of the potential with h."""
    a = xp.maximum(0.0, 2.5 - q)
    b = xp.maximum(0.0, 1.5 - q)
    c = xp.maximum(0.0, 0.5 - q)
    a2 = a * a
    b2 = b * b
    c2 = c * c
    outer = a2 * a2 * a * (0.5 - a / 6.0) - 5.0 * (b2 * b2 * b * (0.3 - b / 6.0))
    return 0.2 * (outer + 10.0 * (c2 * c2 * c * (0.1 - c / 6.0)))


def quintic_softening(xp, q):
    """M6 change of the potential with h."""
    a = xp.maximum(0.0, 3.0 - q)
    b = xp.maximum(0.0, 2.0 - q)
    c = xp.maximum(0.0, 1.0 - q)
    a2 = a * a
    b2 = b * b
    c2 = c * c
    outer = a2 * a2 * a2 * (0.5 - a / 7.0) - 6.0 * (b2 * b2 * b2 * (1.0 / 3.0 - b / 7.0))
    return (outer + 15.0 * (c2 * c2 * c2 * (1.0 / 6.0 - c / 7.0))) / 30.0


def wendland_c2_softening(xp, q):
    """Wendland C2 change of the potential with h."""
    t = xp.maximum(0.0, 1.0 - 0.5 * q)
    t2 = t * t
    return t2 * t2 * t * (21.0 + t * (12.0 * t - 31.5))


def wendland_c4_softening(xp, q):
    """Wendland C4 change of the potential with h."""
    t = xp.maximum(0.0, 1.0 - 0.5 * q)
    t2 = t * t
    return t2 * t2 * t2 * t * (82.5 + t * (-185.625 + t * (140.9375 - 36.09375 * t)))


def wendland_c6_softening(xp, q):
    """Wendland C6 change of the potential with h."""
    t = xp.maximum(0.0, 1.0 - 0.5 * q)
    t2 = t * t
    t4 = t2 * t2
    return t4 * t4 * t * (312.8125 + t * (-938.4375 + t * (1066.40625 + t * (105.0 * t - 543.8671875))))
