"""Equations of state given by P(rho, u), kept as a table of isentropes: one material or several.

The energy u on the isentropes du/dx = P/rho, x = ln rho, is a bicubic spline of x and of y = ln(1 + A/scale), where the
entropy function A is the energy that the matter has on its isentrope at the reference density, above the coldest there.
Whatever the table's errors, the fluid is one of exact thermodynamics, for the spline itself is differentiated:

    P = rho du/dx,   c^2 = du/dx + d2u/dx2,   dA/dq = 1/(du/dA)

so that pressure's work is the change of u to round-off. Beyond the isentropes u goes on linearly in A; beyond the
densities by its slope in x below (P in proportion to rho) and by slope and curvature above.
Tests: tests/unit/test_tabulated.py. Tables are made by isentropes.py.
"""

import hashlib
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from astroinertia.engines.elementwise import Table, elementwise
from astroinertia.pytree import pytree

Array = Any
NUMBERS = 6  # of each material: first x, 1/step in x, scale and greatest of A, 1/step in y, floor of c^2
# Of du/dA, which vanishes where isentropes run together (in matter that has come apart just above the energy at which
# it begins to vaporise) and of which a spline may there be of either sign: heat moves A by no more than this allows.
_LEAST_SLOPE = 3e-3
_BISECTIONS = 64
_BEYOND = 1e3  # how far above its greatest entry A is looked for


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


def tabulated(xp, rho, A, material, table, numbers, rows, columns):
    """u, du/dx, d2u/dx2, du/dA and the u of the coldest isentrope, with x = ln rho."""
    own = NUMBERS * material
    z = (xp.log(rho) - entry(xp, numbers, own)) * entry(xp, numbers, own + 1.0)
    inside = within(xp, z, rows - 3.0)
    cell = xp.minimum(xp.floor(inside), rows - 4.0)
    beyond, above, t = z - inside, xp.where(z > inside, z - inside, 0.0), inside - cell
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
    return (
        value + beyond * slope + 0.5 * above**2 * curvature,
        (slope + above * curvature) * per_step,
        xp.where(beyond < 0.0, 0.0, curvature) * per_step**2,
        by_label * per_label,
        coldest,
    )


def tabulated_state(xp, rho, A, material, table, numbers, rows, columns):
    """P, c, u, its thermal part and dA/dq."""
    u, slope, curvature, by_label, coldest = tabulated(xp, rho, A, material, table, numbers, rows, columns)
    squared = xp.maximum(slope + curvature, entry(xp, numbers, NUMBERS * material + 5.0))
    return rho * slope, xp.sqrt(squared), u, u - coldest, 1.0 / xp.maximum(by_label, _LEAST_SLOPE)


def tabulated_energy(xp, rho, A, material, table, numbers, rows, columns):
    """u."""
    return (tabulated(xp, rho, A, material, table, numbers, rows, columns)[0],)


@pytree
@dataclass(frozen=True, eq=False, repr=False)
class Tabulated:
    """Materials by their tables of isentropes.

    coefficients: (materials * rows * columns,) of the splines; numbers: (materials * NUMBERS,); material: which of them
    particles are of, (N,) or one for all; condensed: whether some are known to be solids or liquids. Methods are those
    of the module eos, of particles (N,).
    """

    coefficients: Array
    numbers: Array
    names: tuple[str, ...] = field(metadata={"static": True})
    rows: int = field(metadata={"static": True})
    columns: int = field(metadata={"static": True})
    material: Array = 0.0
    condensed: bool = field(default=False, metadata={"static": True})
    thermal: ClassVar[bool] = True

    def __repr__(self) -> str:
        """The names and a digest of the tables: what a cache may go by."""
        digest = hashlib.sha256(np.asarray(self.coefficients).tobytes() + np.asarray(self.numbers).tobytes())
        return f"Tabulated({', '.join(self.names)}; {digest.hexdigest()[:32]})"

    def of(self, material: Array) -> "Tabulated":
        """The equation of state of particles (N,) of the materials of those numbers."""
        return replace(self, material=material)

    def state(self, xp, rho, A):
        """P, c, u, its thermal part and dA/dq, each (N,)."""
        return elementwise(xp, tabulated_state, rho, A, *self._tables())

    def energy(self, xp, rho, A):
        """u, (N,)."""
        return elementwise(xp, tabulated_energy, rho, A, *self._tables())[0]

    internal_energy = energy

    def pressure(self, xp, rho, A):
        """P, (N,)."""
        return self.state(xp, rho, A)[0]

    def sound_speed(self, xp, rho, A):
        """c, (N,); not below its floor."""
        return self.state(xp, rho, A)[1]

    def entropy(self, xp, rho, u):
        """A of matter with specific internal energy u, (N,); matter colder than the coldest isentrope has none."""
        scales, greatest = self.numbers[2::NUMBERS], self.numbers[3::NUMBERS]
        scale = xp.min(scales)
        low = xp.zeros_like(rho)
        high = low + xp.log(1.0 + _BEYOND * xp.max(greatest) / scale)
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            less = self.energy(xp, rho, scale * (xp.exp(middle) - 1.0)) < u
            low, high = xp.where(less, middle, low), xp.where(less, high, middle)
        return scale * (xp.exp(0.5 * (low + high)) - 1.0)

    def entropy_rate(self, xp, rho, q):
        """dA/dt of the coldest matter heated by q per mass and time, (N,)."""
        return q * self.state(xp, rho, xp.zeros_like(rho))[4]

    def _tables(self) -> tuple:
        return self.material, Table(self.coefficients), Table(self.numbers), float(self.rows), float(self.columns)
