"""The fast gravity's way up, a template: particles in units of the whole, and what is known of every node, refitted.

Masses, centres, radii, multipoles and clamps of leaves come from their particles, those of other nodes from their two
children; tasks are shared out over threads. By itself it takes float64 and expansions of order 5.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_float64 import real
from astroinertia.engines.numba_vectors import ENTRY, PART, take
from astroinertia.engines.templates import executed
from astroinertia.gravity.clamped_points import CLAMP
from astroinertia.gravity.expansions import expansions

RADIUS_SLACK, SHEET, LEAST = 1.0, real(2.0), 1e-3
EXPANSIONS = executed(expansions(5))
particle_moments, add_moments = EXPANSIONS.particle_moments, EXPANSIONS.add_moments
store_moments = EXPANSIONS.store_moments

# Copied into generated modules from here on.


@njit(**PART)
def fit_leaf(node, first, last, order, position, mass, h, strength, origin, scale, mass_scale,
             x, y, z, m, clamp, where_is, about, raw):  # fmt: skip
    """Of a leaf's particles: their places in units of the whole, and what is known of the leaf.

    strength (N,): |a|; one in balance must not ask for no error at all, nor one that is not known, which is NaN.
    """
    unit = mass_scale / (scale * scale)
    total = sx = sy = sz = squares = 0.0
    largest = 0.0
    for k in range(first, last):
        i = order[k]
        x[k] = (position[i, 0] - origin[0]) * scale
        y[k] = (position[i, 1] - origin[1]) * scale
        z[k] = (position[i, 2] - origin[2]) * scale
        mass_k = mass[i] * mass_scale
        h_k = h[i] * scale
        m[k], clamp[k] = real(mass_k), real(CLAMP * h_k * h_k)
        mass_k = np.float64(m[k])
        total += mass_k
        sx += mass_k * x[k]
        sy += mass_k * y[k]
        sz += mass_k * z[k]
        size = strength[i] * unit
        size = size if size > LEAST else LEAST
        squares += 1.0 / (size * size)
        largest = h_k if h_k > largest else largest
    if not total > 0.0:
        total, sx, sy, sz = 0.0, x[first], y[first], z[first]
    else:
        sx, sy, sz = sx / total, sy / total, sz / total
    radius2 = fourth = 0.0
    for k in range(first, last):
        dx, dy, dz = x[k] - sx, y[k] - sy, z[k] - sz
        r2 = dx * dx + dy * dy + dz * dz
        fourth += m[k] * r2 * r2
        radius2 = r2 if r2 > radius2 else radius2
    particle_moments(first, last, x, y, z, m, sx, sy, sz, raw[node])
    where_is[node, 0], where_is[node, 1], where_is[node, 2] = sx, sy, sz
    finish(node, False, last - first, total, np.sqrt(radius2), fourth, squares, largest, where_is, about)


@njit(**PART)
def finish(node, split, count, total, radius, fourth, squares, largest, where_is, about):
    """Of a node: radius, that of its mass (mean of the fourth power), mass, 1/|a| (rms), share of the clamp, scale of
    moments, number (below 0 of those not split), attraction of a sheet of its column density; where_is: centre of mass,
    sum of 1/|a|^2.
    """
    spread = (fourth / total) ** 0.25 if total > 0.0 else radius
    about[node, 0] = real(radius)
    about[node, 1] = real(spread)
    about[node, 2] = real(total)
    about[node, 3] = real(np.sqrt(squares / count))
    about[node, 4] = real(CLAMP * largest * largest * RADIUS_SLACK)
    about[node, 5] = real(max(radius, largest))
    about[node, 6] = real(count if split else -count)
    about[node, 7] = SHEET * about[node, 2] / (about[node, 5] * about[node, 5])
    where_is[node, 3] = squares


@njit(**PART)
def fit_node(node, left, count, where_is, about, raw):
    """From two children: their moments about the common centre, and the smaller of two bounds of the radius."""
    right = left + 1
    one, other = np.float64(about[left, 2]), np.float64(about[right, 2])
    total = one + other
    share = one / total if total > 0.0 else 0.5
    for a in range(3):
        where_is[node, a] = share * where_is[left, a] + (1.0 - share) * where_is[right, a]
    radius = fourth = clamp = 0.0
    row = raw[node]
    row[:] = 0.0
    for child in (left, right):
        dx = where_is[node, 0] - where_is[child, 0]
        dy = where_is[node, 1] - where_is[child, 1]
        dz = where_is[node, 2] - where_is[child, 2]
        add_moments(dx, dy, dz, raw[child], row)
        apart2 = dx * dx + dy * dy + dz * dz
        radius = max(radius, np.sqrt(apart2) + np.float64(about[child, 0]))
        further = np.sqrt(apart2) + np.float64(about[child, 1])
        fourth += np.float64(about[child, 2]) * further**4
        clamp = max(clamp, np.float64(about[child, 4]))
    squares = where_is[left, 3] + where_is[right, 3]
    finish(node, True, count, total, radius * RADIUS_SLACK, fourth, squares, np.sqrt(clamp / CLAMP), where_is, about)


@njit(**PART)
def fit_any(node, first, last, child, order, position, mass, h, strength, origin, scale, mass_scale,
            x, y, z, m, clamp, where_is, about, raw, moments):  # fmt: skip
    """Of a leaf or of a node above, with the moments that others take of it."""
    if child[node] == 0:
        fit_leaf(node, first[node], last[node], order, position, mass, h, strength, origin, scale,
                 mass_scale, x, y, z, m, clamp, where_is, about, raw)  # fmt: skip
    else:
        fit_node(node, np.int64(child[node]), last[node] - first[node], where_is, about, raw)
    store_moments(np.float64(about[node, 5]), raw[node], moments[node])


@njit(**ENTRY)
def upward(counter, first, last, child, task, begin, end, order, position, mass, h, strength, origin, scale,
           mass_scale, x, y, z, m, clamp, where_is, about, raw, moments):  # fmt: skip
    """Of all nodes below the tasks, leaves first, and of the tasks themselves."""
    while True:
        t = take(counter)
        if t >= len(task):
            break
        for n in range(end[t] - begin[t] + 1):
            node = end[t] - 1 - n if n < end[t] - begin[t] else task[t]
            fit_any(node, first, last, child, order, position, mass, h, strength, origin, scale,
                    mass_scale, x, y, z, m, clamp, where_is, about, raw, moments)  # fmt: skip


@njit(**ENTRY)
def upward_top(first, last, child, top, where_is, about, raw, moments):
    """Of all nodes above the tasks."""
    for k in range(len(top) - 1, -1, -1):
        node = top[k]
        fit_node(node, np.int64(child[node]), last[node] - first[node], where_is, about, raw)
        store_moments(np.float64(about[node, 5]), raw[node], moments[node])
