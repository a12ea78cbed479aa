"""The text of multipole and local expansions in Cartesian coordinates, written out for one order p.

About the centre of mass z of a node of size s, with x its particles and D_a the derivatives of 1/r:

    M_a = sum m (z - x)^a / a!  (|a| < p)      L_b = sum_a M_a D_(a+b)(z_A - z_B)  (|a| + |b| <= p)
    potential = -sum_b L_b (x - z)^b / b!      acceleration = sum_b L_(b+e) (x - z)^b / b!

(Warren & Salmon 1995; Dehnen 2002, JCP 179, 27, eqs. 3 to 15: truncated so, the forces of two nodes on each other are
opposite). D is harmonic, D_zz = -D_xx - D_yy, so that moments and local coefficients with at most one z are all that is
needed (2n + 1 of order n). Dipoles are 0. Between two nodes at distance r all is in units of s and r, so that float32
neither overflows nor underflows; D of unit vectors by McMurchie & Davidson (1978, JCP 26, 218), eq. 4.6.
"""

import math
from functools import cache

Index = tuple[int, int, int]
AXES = "xyz"
UNITS: tuple[Index, Index, Index] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


@cache
def indices(order: int) -> tuple[Index, ...]:
    """All (i, j, k) with i + j + k <= order, by order."""
    return tuple((n - k - j, j, k) for n in range(order + 1) for k in range(n + 1) for j in range(n - k + 1))


@cache
def harmonic(order: int) -> tuple[Index, ...]:
    """Those with k <= 1."""
    return tuple(a for a in indices(order) if a[2] <= 1)


def moments(order: int) -> tuple[Index, ...]:
    """The moments that M2L takes from a source: harmonic, of order 0 and 2 to p - 1."""
    return tuple(a for a in harmonic(order - 1) if sum(a) != 1)


def _name(stem: str, a: Index) -> str:
    return f"{stem}_{a[0]}{a[1]}{a[2]}"


def plus(a: Index, b: Index) -> Index:
    """The index of both derivatives one after the other."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def less(a: Index, axis: int) -> Index:
    """The index with one derivative less along an axis."""
    return a[0] - (axis == 0), a[1] - (axis == 1), a[2] - (axis == 2)


def _indented(lines: list[str], depth: int) -> list[str]:
    return ["    " * depth + line for line in lines]


def _monomials(stem: str, order: int, kind: str) -> list[str]:
    # x^a/a! from x, y, z, each from the one below along the last axis that it has
    lines = [f"{stem}_000 = {kind}(1)"]
    for a in indices(order)[1:]:
        axis = max(k for k in range(3) if a[k])
        below = less(a, axis)
        factor = "" if a[axis] == 1 else f" * {kind}({1.0 / a[axis]!r})"
        lines.append(f"{_name(stem, a)} = {_name(stem, below)} * {AXES[axis]}{factor}")
    return lines


def leaf_moments(p: int) -> list[str]:
    """particle_moments: raw moments (all indices below p) of a leaf's particles about its centre."""
    kept = [a for a in indices(p - 1) if sum(a) != 1]
    lines = [
        "@njit(fastmath=LOOP_FLAGS, **PART)",
        "def particle_moments(first, last, all_x, all_y, all_z, mass, centre_x, centre_y, centre_z, raw):",
        *[f"    {_name('m', a)} = 0.0" for a in kept],
        "    for k in range(first, last):",
        "        x, y, z = centre_x - all_x[k], centre_y - all_y[k], centre_z - all_z[k]",
        "        m = np.float64(mass[k])",
        *_indented(_monomials("t", p - 1, "np.float64"), 2),
        *[f"        {_name('m', a)} += m * {_name('t', a)}" for a in kept],
        *[f"    raw[{n}] = {_name('m', a) if sum(a) != 1 else '0.0'}" for n, a in enumerate(indices(p - 1))],
    ]
    return [*lines, "", ""]


def shifted_moments(p: int) -> list[str]:
    """add_moments: to a parent's raw moments those of a child whose centre lies at -(x, y, z) from the parent's."""
    all_of = indices(p - 1)
    lines = [
        "@njit(fastmath=LOOP_FLAGS, **PART)",
        "def add_moments(x, y, z, child, raw):",
        *_indented(_monomials("t", p - 1, "np.float64"), 1),
        *[f"    {_name('m', a)} = child[{n}]" for n, a in enumerate(all_of) if sum(a) != 1],
    ]
    for n, c in enumerate(all_of):
        if sum(c) == 1:
            continue
        terms = []
        for a in all_of:
            if sum(a) != 1 and all(a[k] <= c[k] for k in range(3)):
                rest = (c[0] - a[0], c[1] - a[1], c[2] - a[2])
                terms.append(_name("m", a) + ("" if rest == (0, 0, 0) else f" * {_name('t', rest)}"))
        lines.append(f"    raw[{n}] += {' + '.join(terms)}")
    return [*lines, "", ""]


def stored_moments(p: int) -> list[str]:
    """store_moments: what M2L takes of a node, harmonic and in units of its size."""
    all_of = indices(p - 1)
    lines = ["@njit(**PART)", "def store_moments(size, raw, moments):"]
    lines += [f"    {_name('m', a)} = raw[{n}]" for n, a in enumerate(all_of)]
    for a in sorted(all_of, key=lambda a: -a[2]):
        if a[2] >= 2:
            for into in _without_two_z(a):
                lines.append(f"    {_name('m', into)} -= {_name('m', a)}")
    lines += ["    f0 = 1.0", *[f"    f{n} = f{n - 1} / size" for n in range(1, p)]]
    lines += [f"    moments[{n}] = real({_name('m', a)} * f{sum(a)})" for n, a in enumerate(moments(p))]
    return [*lines, "", ""]


def _derivatives(p: int) -> list[str]:
    # D of the unit vector x, y, z: auxiliary functions R^m_a, those of order 0 constants.
    lines: list[str] = []
    names: dict[tuple[Index, int], str] = {}

    def constant(m: int) -> float:
        return float((-1) ** m * math.prod(range(1, 2 * m, 2)))

    def value(a: Index, m: int) -> str:
        if a == (0, 0, 0):
            return f"real({constant(m)!r})"
        if (a, m) in names:
            return names[a, m]
        odd = [k for k in (2, 1, 0) if a[k] == 1]
        axis = odd[0] if odd else min((k for k in range(3) if a[k]), key=lambda k: a[k])
        below = less(a, axis)
        text = f"{AXES[axis]} * {value(below, m + 1)}"
        if a[axis] > 1:
            second = less(below, axis)
            factor = "" if a[axis] == 2 else f"real({float(a[axis] - 1)!r}) * "
            text += f" + {factor}{value(second, m + 1)}"
        names[a, m] = f"{_name('d', a)}_{m}"
        lines.append(f"{names[a, m]} = {text}")
        return names[a, m]

    for a in harmonic(p):
        lines.append(f"{_name('d', a)} = {value(a, 0)}")
    for a in indices(p):
        if a[2] == 2:
            one, other = _without_two_z(a)
            lines.append(f"{_name('d', a)} = -({_name('d', one)} + {_name('d', other)})")
    return lines


def interactions(p: int) -> list[str]:
    """far_field: to the local coefficients of a target those of sources, whose moments and so on are columns."""
    sources = moments(p)
    targets = harmonic(p)
    lines = [
        "@njit(fastmath=LOOP_FLAGS, **PART)",
        "def far_field(count, size, apart, features, columns, local):",
        "    widest_vectors()",
        "    all_x, all_y, all_z, sizes = apart[0], apart[1], apart[2], features[5]",
        *[f"    all_{_name('m', a)} = columns[{n}]" for n, a in enumerate(sources)],
        *[f"    {_name('s', b)} = real(0)" for b in targets],
        "    for k in range(padded(count)):",
        "        x, y, z = -all_x[k], -all_y[k], -all_z[k]",
        "        inverse = inverse_distance(x * x + y * y + z * z)",
        "        x, y, z = x * inverse, y * inverse, z * inverse",
        "        t1 = sizes[k] * inverse",
        "        u1 = size * inverse",
        "        u0 = where(k < count, inverse, real(0))",
        *[f"        t{n} = t{n - 1} * t1" for n in range(2, p)],
        "        f0 = u0",
        *[f"        f{n} = f{n - 1} * u1" for n in range(1, p + 1)],
    ]
    for a in sources:
        scale = f" * t{sum(a)}" if sum(a) else ""
        lines.append(f"        {_name('m', a)} = all_{_name('m', a)}[k]{scale}")
    lines += _indented(_derivatives(p), 2)
    for b in targets:
        terms = [
            f"{_name('m', a)} * {_name('d', plus(a, b))}" if sum(a) + sum(b) else _name("m", a)
            for a in sources
            if sum(a) + sum(b) <= p
        ]
        lines.append(f"        {_name('s', b)} += f{sum(b)} * ({' + '.join(terms)})")
    lines += ["    g0 = 1.0", *[f"    g{n} = g{n - 1} / np.float64(size)" for n in range(1, p + 1)]]
    lines += [f"    local[{n}] += g{sum(b)} * np.float64({_name('s', b)})" for n, b in enumerate(targets)]
    return [*lines, "", ""]


def _all_local(p: int, source: str) -> list[str]:
    # l_a for all indices, from the harmonic ones
    lines = [f"{_name('l', b)} = {source}[{n}]" for n, b in enumerate(harmonic(p))]
    return lines + _of_more_z("l", p)


def _without_two_z(a: Index) -> tuple[Index, Index]:
    # Laplace's equation: two derivatives along z are those along x and those along y, with the other sign.
    return (a[0] + 2, a[1], a[2] - 2), (a[0], a[1] + 2, a[2] - 2)


def _of_more_z(stem: str, p: int) -> list[str]:
    # Coefficients of two z or more, from those of fewer.
    lines = []
    for a in sorted(indices(p), key=lambda a: a[2]):
        if a[2] >= 2:
            one, other = _without_two_z(a)
            lines.append(f"{_name(stem, a)} = -({_name(stem, one)} + {_name(stem, other)})")
    return lines


def shifted_local(p: int) -> list[str]:
    """shift_local: a parent's local coefficients about a child whose centre lies at (x, y, z) from the parent's."""
    lines = [
        "@njit(fastmath=LOOP_FLAGS, **PART)",
        "def shift_local(x, y, z, parent, local):",
        *_indented(_monomials("t", p, "np.float64") + _all_local(p, "parent"), 1),
    ]
    for n, b in enumerate(harmonic(p)):
        terms = [
            _name("l", plus(b, c)) + ("" if c == (0, 0, 0) else f" * {_name('t', c)}") for c in indices(p - sum(b))
        ]
        lines.append(f"    local[{n}] = {' + '.join(terms)}")
    return [*lines, "", ""]


def at_particles(p: int) -> list[str]:
    """field_of_local: acceleration and potential at a leaf's particles, in units of its size, from its coefficients."""
    lines = [
        "@njit(fastmath=LOOP_FLAGS, **PART)",
        "def field_of_local(count, size, local, all_x, all_y, all_z, field):",
        "    out_x, out_y, out_z, out_phi = field[0], field[1], field[2], field[3]",
        "    f0 = 1.0",
        *[f"    f{n} = f{n - 1} * size" for n in range(1, p + 1)],
        *[f"    c_{b[0]}{b[1]}{b[2]} = real(local[{n}] * f{sum(b)})" for n, b in enumerate(harmonic(p))],
        *_indented(_of_more_z("c", p), 1),
        "    inverse = real(1.0 / size)",
        "    for k in range(padded(count)):",
        "        x, y, z = all_x[k] * inverse, all_y[k] * inverse, all_z[k] * inverse",
        *_indented(_monomials("t", p, "real"), 2),
        "        out_phi[k] = -(" + " + ".join(f"{_name('c', a)} * {_name('t', a)}" for a in indices(p)) + ")",
    ]
    for axis in range(3):
        terms = [f"{_name('c', plus(a, UNITS[axis]))} * {_name('t', a)}" for a in indices(p - 1)]
        lines.append(f"        out_{AXES[axis]}[k] = inverse * ({' + '.join(terms)})")
    return [*lines, "", ""]


def powers(p: int) -> list[str]:
    """times_power: a value times the p-th power of another, multiplied from the left."""
    lines = ["@njit(fastmath=TEST_FLAGS, forceinline=True, **PART)", "def times_power(value, base):"]
    return [*lines, f"    return value{' * base' * p}", "", ""]


def expansions(p: int) -> list[str]:
    """All of the above."""
    parts = (leaf_moments, shifted_moments, stored_moments, interactions, shifted_local, at_particles, powers)
    return [line for part in parts for line in part(p)]


def padded_moments(p: int) -> int:
    """How many moments are kept of a source: whole vectors of four."""
    return -(-len(moments(p)) // 4) * 4
