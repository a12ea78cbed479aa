"""Equations of state given by P(rho, u), kept as a table of isentropes: one material or several.

The energy u on the isentropes du/dx = P/rho, x = ln rho, is a bicubic spline of x and of y = ln(1 + A/scale), where the
entropy function A is the energy that the matter has on its isentrope at the reference density, above the coldest there.
Whatever the table's errors, the fluid is one of exact thermodynamics, for the spline itself is differentiated:

    P = rho du/dx,   c^2 = du/dx + d2u/dx2,   dA/dq = 1/(du/dA)

so that pressure's work is the change of u to round-off. Beyond the isentropes u goes on linearly in A; beyond the
densities by its slope in x below (P in proportion to rho) and by slope and curvature above.
Tests: tests/unit/matter/test_tabulated.py. Tables are made by isentropes.py.
"""

import hashlib
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from astroinertia.engines.elementwise import Table, by_numpy, elementwise
from astroinertia.engines.pytree import pytree

Array = Any
NUMBERS = 6  # of each material: first x, 1/step in x, scale and greatest of A, 1/step in y, floor of c^2
# Of du/dA, which vanishes where isentropes run together (in matter that has come apart just above the energy at which
# it begins to vaporise) and of which a spline may there be of either sign: heat moves A by no more than this allows.
_LEAST_SLOPE = 3e-3
_BISECTIONS = 64
_BEYOND = 1e3  # how far above its greatest entry A is looked for
MOST_LABELS = 257  # of a table: eight halvings find the cell that energy is in
_ROUNDING = 2e-15  # of u and the scale of A
_FLATTEST = 1e-3


def entry(xp, table, index):
    """An entry by its number."""
    return xp.take(table, xp.int64(index))


def within(xp, z, most):
    """z held to 0 <= z <= most; 0 for what is no number."""
    return xp.where(z > 0.0, xp.where(z < most, z, most), 0.0)


def weights(xp, t):
    """The cubic B-splines of uniform knots on a cell, 0 <= t <= 1."""
    s = 1.0 - t
    return s**3 / 6.0, (3.0 * t**3 - 6.0 * t**2 + 4.0) / 6.0, (3.0 * s**3 - 6.0 * s**2 + 4.0) / 6.0, t**3 / 6.0


def slopes(xp, t):
    """Their derivatives."""
    s = 1.0 - t
    return -0.5 * s**2, 1.5 * t**2 - 2.0 * t, 2.0 * s - 1.5 * s**2, 0.5 * t**2


def curvatures(xp, t):
    """Their second derivatives."""
    return 1.0 - t, 3.0 * t - 2.0, 1.0 - 3.0 * t, t


def across(xp, table, index, w):
    """The sum over four entries of a row."""
    one = w[0] * entry(xp, table, index) + w[1] * entry(xp, table, index + 1.0)
    return one + w[2] * entry(xp, table, index + 2.0) + w[3] * entry(xp, table, index + 3.0)


def combined(xp, w, f):
    """The sum over four rows."""
    return w[0] * f[0] + w[1] * f[1] + w[2] * f[2] + w[3] * f[3]


def rows_of(xp, table, index, columns, w):
    """Four rows, each summed over its entries."""
    return (
        across(xp, table, index, w),
        across(xp, table, index + columns, w),
        across(xp, table, index + 2.0 * columns, w),
        across(xp, table, index + 3.0 * columns, w),
    )


def row_of(xp, rho, own, numbers, rows):
    """The cell of x = ln rho and the place in it; by how many steps x is beyond the table, and above it."""
    z = (xp.log(rho) - entry(xp, numbers, own)) * entry(xp, numbers, own + 1.0)
    inside = within(xp, z, rows - 3.0)
    cell = xp.minimum(xp.floor(inside), rows - 4.0)
    return cell, inside - cell, z - inside, xp.where(z > inside, z - inside, 0.0)


def tabulated(xp, rho, A, material, table, numbers, rows, columns):
    """P, c, u, its thermal part and du/dA."""
    own = NUMBERS * material
    cell, t, beyond, above = row_of(xp, rho, own, numbers, rows)
    scale, greatest = entry(xp, numbers, own + 2.0), entry(xp, numbers, own + 3.0)
    held = within(xp, A, greatest)
    y = within(xp, xp.log(1.0 + held / scale) * entry(xp, numbers, own + 4.0), columns - 3.0)
    column = xp.minimum(xp.floor(y), columns - 4.0)
    first = (material * rows + cell) * columns
    f = rows_of(xp, table, first + column, columns, weights(xp, y - column))
    g = rows_of(xp, table, first + column, columns, slopes(xp, y - column))
    w, v, k = weights(xp, t), slopes(xp, t), curvatures(xp, t)
    per_label = entry(xp, numbers, own + 4.0) / (scale + held)
    excess = (A - held) * per_label
    value = combined(xp, w, f) + excess * combined(xp, w, g)
    slope = combined(xp, v, f) + excess * combined(xp, v, g)
    curvature = combined(xp, k, f) + excess * combined(xp, k, g)
    by_label = combined(xp, w, g) + beyond * combined(xp, v, g) + 0.5 * above**2 * combined(xp, k, g)
    cold = rows_of(xp, table, first, columns, weights(xp, 0.0))
    coldest = combined(xp, w, cold) + beyond * combined(xp, v, cold) + 0.5 * above**2 * combined(xp, k, cold)
    per_step = entry(xp, numbers, own + 1.0)
    u = value + beyond * slope + 0.5 * above**2 * curvature
    by_x = (slope + above * curvature) * per_step
    squared = by_x + xp.where(beyond < 0.0, 0.0, curvature) * per_step**2
    speed = xp.sqrt(xp.maximum(squared, entry(xp, numbers, own + 5.0)))
    return rho * by_x, speed, u, u - coldest, by_label * per_label


def down(xp, table, index, columns, w):
    """The sum over four entries of a column."""
    one = w[0] * entry(xp, table, index) + w[1] * entry(xp, table, index + columns)
    return one + w[2] * entry(xp, table, index + 2.0 * columns) + w[3] * entry(xp, table, index + 3.0 * columns)


def columns_of(xp, table, index, columns, w):
    """Four columns, each summed over its entries."""
    return (
        down(xp, table, index, columns, w),
        down(xp, table, index + 1.0, columns, w),
        down(xp, table, index + 2.0, columns, w),
        down(xp, table, index + 3.0, columns, w),
    )


def halved(xp, low, high, u, table, first, columns, w):
    """The half of the cells from low to high that has u between the energies at its ends."""
    middle = xp.floor(0.5 * (low + high))
    index = first + middle
    node = down(xp, table, index, columns, w) + 4.0 * down(xp, table, index + 1.0, columns, w)
    less = (node + down(xp, table, index + 2.0, columns, w)) / 6.0 <= u
    return xp.where(less, middle, low), xp.where(less, high, xp.maximum(middle, low + 1.0))


def halved_four_times(xp, low, high, u, table, first, columns, w):
    """A sixteenth of the cells."""
    low, high = halved(xp, low, high, u, table, first, columns, w)
    low, high = halved(xp, low, high, u, table, first, columns, w)
    low, high = halved(xp, low, high, u, table, first, columns, w)
    return halved(xp, low, high, u, table, first, columns, w)


def nearer(xp, a, b, t, u, f):
    """The part from a to b of a cell with coefficients f that has the energy u, and a better t in it, by Newton."""
    value, slope = combined(xp, weights(xp, t), f), combined(xp, slopes(xp, t), f)
    a, b = xp.where(value <= u, t, a), xp.where(value <= u, b, t)
    better = t - (value - u) / xp.where(slope > 0.0, slope, 1.0)
    return a, b, xp.where(slope > 0.0, xp.minimum(xp.maximum(better, a), b), 0.5 * (a + b))


def much_nearer(xp, a, b, t, u, f):
    """Three steps of Newton's."""
    a, b, t = nearer(xp, a, b, t, u, f)
    a, b, t = nearer(xp, a, b, t, u, f)
    return nearer(xp, a, b, t, u, f)


def labels_after(xp, rho, A, heat, least, u, slope, material, table, numbers, rows, columns):
    """A after so much heat per mass, which makes the energy u: by the slope du/dA at A, and by the table.

    Looked for above A where it was heated, else below; neither is less than `least`.
    """
    own, hotter = NUMBERS * material, heat > 0.0
    cell, place, beyond, above = row_of(xp, rho, own, numbers, rows)
    w, v, k = weights(xp, place), slopes(xp, place), curvatures(xp, place)
    half = 0.5 * above**2
    # With those of the rows beyond the table.
    w = (
        w[0] + beyond * v[0] + half * k[0],
        w[1] + beyond * v[1] + half * k[1],
        w[2] + beyond * v[2] + half * k[2],
        w[3] + beyond * v[3] + half * k[3],
    )
    first = (material * rows + cell) * columns
    scale, per_label = entry(xp, numbers, own + 2.0), entry(xp, numbers, own + 4.0)
    greatest = entry(xp, numbers, own + 3.0)
    y = within(xp, xp.log(1.0 + within(xp, A, greatest) / scale) * per_label, columns - 3.0)
    here = xp.minimum(xp.floor(y), columns - 4.0)
    low, high = xp.where(hotter, here, 0.0), xp.where(hotter, columns - 3.0, here + 1.0)
    low, high = halved_four_times(xp, low, high, u, table, first, columns, w)
    low, high = halved_four_times(xp, low, high, u, table, first, columns, w)
    f = columns_of(xp, table, first + low, columns, w)
    # Of the cell that A is in, what is on its other side is not looked at: isentropes that run together may cross.
    a = xp.where(hotter & (low == here), y - here, 0.0)
    b = xp.where(hotter | (low < here), 1.0, y - here)
    a, b, t = much_nearer(xp, a, b, 0.5 * (a + b), u, f)
    a, b, t = much_nearer(xp, a, b, t, u, f)
    end, edge = xp.where(hotter, 1.0, 0.0), xp.where(hotter, greatest, 0.0)
    f = columns_of(xp, table, first + xp.where(hotter, columns - 4.0, 0.0), columns, w)
    there = combined(xp, slopes(xp, end), f) * per_label / (scale + edge)
    beyond = edge + (u - combined(xp, weights(xp, end), f)) / xp.maximum(there, _FLATTEST)
    outside = xp.where(hotter, beyond > greatest, beyond < 0.0)
    after = xp.where(outside, beyond, scale * (xp.exp((low + t) / per_label) - 1.0))
    furthest = xp.abs(heat) / _FLATTEST
    after = xp.minimum(xp.maximum(after, A - furthest), A + furthest)
    return xp.maximum(A + heat / xp.maximum(slope, _FLATTEST), least), xp.maximum(after, least)


def better_label(xp, linear, after, energy_of_linear, energy_of_after, u, scale):
    """The one of two labels whose energy misses u less, and by how much.

    What little heat makes of A is lost in the rounding of u, but not in proportion to the heat.
    """
    missed_linear, missed = energy_of_linear - u, energy_of_after - u
    better = xp.abs(missed_linear) <= xp.maximum(xp.abs(missed), _ROUNDING * (xp.abs(u) + scale))
    chosen = xp.where(better, linear, after)
    return xp.where(u == u, chosen, u), xp.where(better, missed_linear, missed)


@pytree
@dataclass(frozen=True, eq=False, repr=False)
class Tabulated:
    """Materials by their tables of isentropes.

    coefficients: (materials * rows * columns,) of the splines; numbers: (materials * NUMBERS,); material: which of them
    particles are of, (N,) or one for all; condensed: whether some are known to be solids or liquids; standards:
    (materials,), the densities that materials have at one pressure, where their boundaries are sharp
    (sph.standard_volumes). Methods are those of the module eos, of particles (N,).
    """

    coefficients: Array
    numbers: Array
    names: tuple[str, ...] = field(metadata={"static": True})
    rows: int = field(metadata={"static": True})
    columns: int = field(metadata={"static": True})
    material: Array = 0.0
    condensed: bool = field(default=False, metadata={"static": True})
    standards: Array | None = None
    thermal: ClassVar[bool] = True
    curved: ClassVar[bool] = True

    def __repr__(self) -> str:
        """The names and a digest of the tables: what a cache may go by."""
        digest = hashlib.sha256(np.asarray(self.coefficients).tobytes() + np.asarray(self.numbers).tobytes())
        sharp = "" if self.standards is None else f"; {np.asarray(self.standards).tolist()}"
        return f"Tabulated({', '.join(self.names)}; {digest.hexdigest()[:32]}{sharp})"

    def of(self, material: Array) -> "Tabulated":
        """The equation of state of particles (N,) of the materials of those numbers."""
        return replace(self, material=material)

    def least_density(self, material: int) -> float:
        """The least density of the table of the material of that number."""
        return float(np.exp(self.numbers[NUMBERS * material]))

    def state(self, xp, rho, A):
        """P, c, u, its thermal part and dA/dq, each (N,)."""
        *state, slope = self._splines(xp, tabulated, rho, A)
        return *state, 1.0 / xp.maximum(slope, _LEAST_SLOPE)

    def energy(self, xp, rho, A):
        """u, (N,)."""
        return self._splines(xp, tabulated, rho, A)[2]

    internal_energy = energy

    def pressure(self, xp, rho, A):
        """P, (N,)."""
        return self.state(xp, rho, A)[0]

    def sound_speed(self, xp, rho, A):
        """c, (N,); not below its floor."""
        return self.state(xp, rho, A)[1]

    def entropy(self, xp, rho, u):
        """A of matter with specific internal energy u, (N,); matter colder than the coldest isentrope has none."""
        return self._label(xp, rho, lambda A: self.energy(xp, rho, A) < u)

    def entropy_at_pressure(self, xp, rho, P):
        """A of matter with the pressure P, (N,); none where the coldest isentrope has more."""
        return self._label(xp, rho, lambda A: self.pressure(xp, rho, A) < P)

    def _label(self, xp, rho, colder):
        scales, greatest = self.numbers[2::NUMBERS], self.numbers[3::NUMBERS]
        scale = xp.min(scales)
        low = xp.zeros_like(rho)
        high = low + xp.log(1.0 + _BEYOND * xp.max(greatest) / scale)
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            less = colder(scale * (xp.exp(middle) - 1.0))
            low, high = xp.where(less, middle, low), xp.where(less, high, middle)
        return scale * (xp.exp(0.5 * (low + high)) - 1.0)

    def heated(self, xp, rho, A, heat, least):
        """A (N,) after heat (N,) per mass at fixed density, not below `least`, (N,) or a number; and what u misses.

        u(rho, A') = u(rho, A) + heat to rounding, but where A' is held at `least`, or du/dA is next to nothing beyond
        the table: u is then above that by the second of what is returned, (N,). Without a limit `least` is -inf.
        """
        _, _, before, _, slope = self._splines(xp, tabulated, rho, A)
        u, least = before + heat, xp.broadcast_to(least, rho.shape)
        if by_numpy(xp):
            linear, after = self._splines(xp, labels_after, rho, A, heat, least, u, slope)
        else:  # xla compiles the search in the table for half a minute: Newton's method goes twice by the slope
            linear = xp.maximum(A + heat / xp.maximum(slope, _FLATTEST), least)
            _, _, there, _, slope = self._splines(xp, tabulated, rho, linear)
            after = xp.maximum(linear + (u - there) / xp.maximum(slope, _FLATTEST), least)
        energies = self.energy(xp, rho, linear), self.energy(xp, rho, after)
        scale = xp.broadcast_to(xp.asarray(self.numbers)[NUMBERS * xp.asarray(self.material, dtype=int) + 2], rho.shape)
        return elementwise(xp, better_label, linear, after, *energies, u, scale)

    def entropy_rate(self, xp, rho, q):
        """dA/dt of the coldest matter heated by q per mass and time, (N,)."""
        return q * self.state(xp, rho, xp.zeros_like(rho))[4]

    def _splines(self, xp, function, rho, *arguments):
        # Numbers of materials are always arrays, so that there is one program of each function.
        material = xp.broadcast_to(self.material, rho.shape)
        tables = Table(self.coefficients), Table(self.numbers), float(self.rows), float(self.columns)
        return elementwise(xp, function, rho, *arguments, material, *tables)
