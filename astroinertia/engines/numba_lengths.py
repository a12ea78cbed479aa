"""How smoothing lengths are solved for, a template: the part of density passes that knows the formulae.

With S(h) = sum_j m_j w(r/h), the condition rho = m (eta/h)^3 reads S(h) = m eta^3. S never falls as h grows, so its
root is unique. Newton steps are taken in log S against log h, in which S is nearly straight, and kept within the
bracket that the signs of earlier steps have proved; a step that leaves it is replaced by bisection.
Omega = -sum m q w'/(3 S) and zeta = sum m (phi + q phi')/(3 rho h) follow from Price & Monaghan (2007, MNRAS 374,
1347, equations 7 and 15) with rho ~ h^-3.
By itself it takes Wendland's C2 kernel and float64.
"""

import functools

import numpy as np
from numba import njit

from astroinertia.engines.numba_float64 import inverse_distance, real
from astroinertia.engines.numba_parts import LOOP_FLAGS
from astroinertia.engines.numba_tables import vector_fill
from astroinertia.engines.numba_vectors import LANES, PART, near_squares, widest_vectors, widest_vectors_inlined
from astroinertia.sph.kernels import KERNELS

SOFTENED, KERNEL = True, KERNELS["wendland_c2"]
kernel_w, kernel_dw, kernel_softening = (functools.partial(f, np) for f in (KERNEL.w, KERNEL.dw, KERNEL.softening))

# Copied into generated modules from here on.


@njit(fastmath=LOOP_FLAGS, forceinline=True, **PART)
def softening_moment(distance, weight, vectors, inverse_h):
    """-sum m (phi + q phi'), or 0 without softening."""
    widest_vectors_inlined()
    total = real(0)
    if SOFTENED:
        for k in range(vectors):
            total -= weight[k] * kernel_softening(distance[k] * inverse_h)
    return total


@njit(fastmath=LOOP_FLAGS, forceinline=True, **PART)
def moments(distance, weight, vectors, inverse_h):
    """S(h) and its slope dS/dlog h."""
    widest_vectors_inlined()
    total = real(0)
    slope = real(0)
    for k in range(vectors):
        q = distance[k] * inverse_h
        total += weight[k] * kernel_w(q)
        slope -= weight[k] * (q * kernel_dw(q))
    return np.float64(total), np.float64(slope)


@njit(fastmath=LOOP_FLAGS, forceinline=True, **PART)
def take_roots(distance, count):
    """Distances from their squares."""
    widest_vectors_inlined()
    for k in range(count):
        distance[k] *= inverse_distance(distance[k])


@njit(**PART)
def step_factor(excess, total, slope):
    """The ratio of the next h to this one: (target/S)^(1/s) with s = dlog S/dlog h, to second order where that does."""
    if slope <= 1e-3 * total:
        return 2.0 if excess > 0.0 else 0.5
    exponent = total / slope
    if abs(excess) < 0.1:
        return 1.0 + exponent * excess * (1.0 + 0.5 * (exponent - 1.0) * excess)
    return min(2.0, max(0.5, (1.0 + excess) ** exponent))


@njit(**PART)
def bisected(low, high, h):
    """Between the ends of the bracket, or beyond the only one."""
    if low > 0.0 and high < np.inf:
        return np.sqrt(low * high)
    return 2.0 * h if low > 0.0 else 0.5 * h


@njit(**PART)
def solve(waiting, number, slots, count, buffer, lists, options, results):
    """Solve for the targets waiting[:number], from the guesses in results[0].

    The buffer holds all neighbours of each up to the h in results[1]; those that outgrow it go on waiting, with where
    they got to, and their number is returned.
    """
    widest_vectors()
    x, y, z, mass, distance, weight = buffer[0], buffer[1], buffer[2], buffer[3], lists[0], lists[1]
    support, margin, eta, tolerance, smallest = options[0], options[1], options[2], options[3], options[4]
    left = 0
    for k in range(number):
        i, s = waiting[k], slots[k]
        x_i, y_i, z_i = x[s], y[s], z[s]
        target = np.float64(mass[s]) * eta * eta * eta
        h, limit, low, high, covered = results[0, i], results[1, i], 0.0, np.inf, 0.0
        n = 0
        new = total = slope = 0.0
        for _ in range(200):
            if h > covered:
                if h > limit:
                    break
                covered = min(margin * h, limit)
                reach = real(support * covered)
                n = near_squares(x, y, z, mass, x_i, y_i, z_i, reach * reach, count, distance, weight)
                # Loops over sums run over four vectors at a time, and one by one over what is left.
                for part in range(4):
                    vector_fill(distance, n + part * LANES, real(0))
                    vector_fill(weight, n + part * LANES, real(0))
                n = 4 * LANES * ((n + 4 * LANES - 1) // (4 * LANES))
                take_roots(distance, n)
            total, slope = moments(distance, weight, n, real(1.0 / h))
            factor = step_factor(target / total - 1.0, total, slope)
            new = h * factor
            if np.isnan(total):
                new = total
                break
            if total < target:
                low = h
            else:
                high = h
            if abs(factor - 1.0) <= tolerance:
                break
            if high - low <= tolerance * h or (h <= smallest and total > target):
                new = h
                break
            h = new if low < new < high else bisected(low, high, h)
        if h > limit:
            results[0, i] = h
            waiting[left] = i
            left += 1
            continue
        density = (total + slope * (new - h) / h) / (new * new * new)
        results[0, i] = new
        results[1, i] = density
        results[2, i] = slope / (3.0 * total)
        results[3, i] = np.float64(softening_moment(distance, weight, n, real(1.0 / h))) / (3.0 * density * new)
    return left
