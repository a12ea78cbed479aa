"""Free rotation in many digits: mpmath's elliptic functions of the energy and angular momentum, and a Taylor series."""

import mpmath as mp


def angular_velocity(moments, spin, time, digits=60):
    """The angular velocity at a time as three mpf: Landau & Lifshitz, Mechanics, section 37, with mpmath's functions.

    For three different moments and motion that is neither steady nor on the separatrix.
    """
    with mp.workdps(digits):
        sizes, rates, time = [mp.mpf(m) for m in moments], [mp.mpf(w) for w in spin], mp.mpf(time)
        order = sorted(range(3), key=lambda k: sizes[k])
        sign = 1 if [order, order[1:] + order[:1], order[2:] + order[:2]].count([0, 1, 2]) else -1
        i1, i2, i3 = (sizes[k] for k in order)
        w1, w2, w3 = (rates[k] for k in order)
        w2 *= sign  # right-handed
        twice, square = i1 * w1**2 + i2 * w2**2 + i3 * w3**2, (i1 * w1) ** 2 + (i2 * w2) ** 2 + (i3 * w3) ** 2
        reverse = square < twice * i2
        if reverse:
            i1, i3, w1, w3 = i3, i1, w3, w1
        p = mp.sqrt((twice * i3 - square) / (i1 * (i3 - i1)))
        q = mp.sqrt((twice * i3 - square) / (i2 * (i3 - i2)))
        r = mp.sqrt((square - twice * i1) / (i3 * (i3 - i1)))
        rate = mp.sqrt((i3 - i2) * (square - twice * i1) / (i1 * i2 * i3))
        m = (i2 - i1) * (twice * i3 - square) / ((i3 - i2) * (square - twice * i1))
        turn = 1 if w3 >= 0 else -1
        angle = mp.atan2(w2 / q * turn, w1 / p)
        u = rate * time + mp.ellipf(angle, m)
        quarter = mp.ellipk(m)
        u -= 4 * quarter * mp.nint(u / (4 * quarter))
        sn, cn, dn = (mp.ellipfun(name, u, m=m) for name in ("sn", "cn", "dn"))
        found = [p * cn, sign * turn * q * sn, turn * r * dn]
        if reverse:
            found.reverse()
        place = [None] * 3
        for k, value in zip(order, found, strict=True):
            place[k] = value
        return place


def motion(moments, spin, time, digits=30):
    """Angular velocity (3) and rotation R (3x3, columns the body's axes) at a time, R = 1 at 0: a Taylor series."""
    with mp.workdps(digits):
        a, b, c = (mp.mpf(m) for m in moments)

        def rate(_, y):
            p, q, r = y[:3]
            found = [(b - c) / a * q * r, (c - a) / b * r * p, (a - b) / c * p * q]
            for row in range(3):  # dR/dt = R [omega]
                x, y_, z = y[3 + 3 * row : 6 + 3 * row]
                found += [y_ * r - z * q, z * p - x * r, x * q - y_ * p]
            return found

        start = [mp.mpf(w) for w in spin] + [mp.mpf(v) for v in (1, 0, 0, 0, 1, 0, 0, 0, 1)]
        found = mp.odefun(rate, 0, start, tol=mp.mpf(10) ** (3 - digits))(mp.mpf(time))
        return found[:3], mp.matrix([found[3 + 3 * row : 6 + 3 * row] for row in range(3)])
