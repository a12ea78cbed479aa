"""Free rotation in many digits: mpmath's elliptic functions of the energy and angular momentum, and a Taylor series."""

from typing import NamedTuple

import mpmath as mp


class Motion(NamedTuple):
    """Angular velocity in body axes (3) and rotation (3x3), whose columns are the body's axes, equal to 1 at time 0."""

    angular_velocity: list
    rotation: mp.matrix


def motion(moments, spin, time, digits=60):
    """The motion at a time: Landau & Lifshitz, Mechanics, section 37, with mpmath's functions and integrals.

    For three different moments and motion that is neither steady nor on the separatrix.
    """
    with mp.workdps(digits):
        sizes, rates, time = [mp.mpf(m) for m in moments], [mp.mpf(w) for w in spin], mp.mpf(time)
        order = sorted(range(3), key=lambda k: sizes[k])
        i1, i2, i3 = (sizes[k] for k in order)
        w1, w2, w3 = (rates[k] for k in order)
        twice, square = i1 * w1**2 + i2 * w2**2 + i3 * w3**2, (i1 * w1) ** 2 + (i2 * w2) ** 2 + (i3 * w3) ** 2
        if square < twice * i2:
            order, (i1, i3), (w1, w3) = order[::-1], (i3, i1), (w3, w1)
        frame = mp.matrix(3, 3)
        for row, k in enumerate(order):
            frame[row, k] = 1
        if mp.det(frame) < 0:
            frame[1, order[1]], w2 = -1, -w2
        p = mp.sqrt((twice * i3 - square) / (i1 * (i3 - i1)))
        q = mp.sqrt((twice * i3 - square) / (i2 * (i3 - i2)))
        r = mp.sqrt((square - twice * i1) / (i3 * (i3 - i1))) * mp.sign(w3)
        q *= mp.sign(i3 - i1) * mp.sign(w3)
        rate = mp.sqrt((i3 - i2) * (square - twice * i1) / (i1 * i2 * i3))
        m = (i2 - i1) * (twice * i3 - square) / ((i3 - i2) * (square - twice * i1))
        n = i3 * (i1 - i2) / (i1 * (i3 - i2))
        size, quarter, complete = mp.sqrt(square), mp.ellipk(m), mp.ellippi(n, m)
        start = mp.ellipf(mp.atan2(w2 / q, w1 / p), m)

        def at(u):
            halves = mp.nint(u / (2 * quarter))
            u_rest = u - 2 * halves * quarter
            sn, cn, dn = (mp.ellipfun(name, u_rest, m=m) for name in ("sn", "cn", "dn"))
            third = mp.ellippi(n, mp.atan2(sn, cn), m) + 2 * halves * complete
            sign = -1 if halves % 2 else 1
            omega = mp.matrix([p * cn * sign, q * sn * sign, r * dn])
            a, b, c = i1 * omega[0] / size, i2 * omega[1] / size, i3 * omega[2] / size
            across = mp.sqrt(a * a + b * b)
            basis = mp.matrix([[c * a / across, -b / across, a], [c * b / across, a / across, b], [-across, 0, c]])
            return omega, basis, size * (i3 - i1) / (i1 * i3 * rate) * third

        (_, first, first_phase), (omega, basis, phase) = at(start), at(start + rate * time)
        turn = size / i3 * time + phase - first_phase
        about = mp.matrix([[mp.cos(turn), -mp.sin(turn), 0], [mp.sin(turn), mp.cos(turn), 0], [0, 0, 1]])
        return Motion(list(frame.T * omega), frame.T * (first * about * basis.T) * frame)


def taylor_motion(moments, spin, time, digits=30):
    """The same from the equations of motion, of any moments, at a positive time."""
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
        return Motion(found[:3], mp.matrix([found[3 + 3 * row : 6 + 3 * row] for row in range(3)]))


def floats(exact):
    """Angular velocity [3] and attitude [3][3], rows the body's axes, of a motion, as floats."""
    return [float(w) for w in exact.angular_velocity], [
        [float(exact.rotation[i, k]) for i in range(3)] for k in range(3)
    ]


def heavy_motion(transverse, axial, torque, angles, rates, time, digits=25):
    """The motion of a symmetric top in gravity at a positive time, a Taylor series of Euler's equations.

    angles: Euler's, zxz, at time 0; rates about the line of nodes, across it and about the axis.
    """
    with mp.workdps(digits):
        a, c, most = (mp.mpf(x) for x in (transverse, axial, torque))
        phi, theta, psi = (mp.mpf(x) for x in angles)
        nodal, across, spin = (mp.mpf(x) for x in rates)

        def about_axis(x):
            return mp.matrix([[mp.cos(x), -mp.sin(x), 0], [mp.sin(x), mp.cos(x), 0], [0, 0, 1]])

        tilted = mp.matrix([[1, 0, 0], [0, mp.cos(theta), -mp.sin(theta)], [0, mp.sin(theta), mp.cos(theta)]])
        attitude = about_axis(phi) * tilted * about_axis(psi)
        start = list(about_axis(-psi) * mp.matrix([nodal, across, spin])) + list(attitude)

        def rate(_, y):
            p, q, r = y[:3]
            up = y[9:12]  # the vertical in the body: gravity's torque is M up_b, -M up_a
            found = [((a - c) * q * r + most * up[1]) / a, ((c - a) * r * p - most * up[0]) / a, mp.mpf(0)]
            for row in range(3):
                x, y_, z = y[3 + 3 * row : 6 + 3 * row]
                found += [y_ * r - z * q, z * p - x * r, x * q - y_ * p]
            return found

        found = mp.odefun(rate, 0, start)(mp.mpf(time))
        return Motion(found[:3], mp.matrix([found[3 + 3 * row : 6 + 3 * row] for row in range(3)]))
