"""Love numbers of layered planets: how far they yield to a tide or to a load on their surface, at any degree from 2 on.

The planet is spherical and hydrostatic, of solid and fluid layers that may be compressible, and yields without inertia
(forcing periods that are long beside its free oscillations, of an hour). Viscoelastic layers have complex moduli, by
the correspondence principle, for a forcing that goes as exp(i omega t): Im k < 0 dissipates. In each solid layer the
six functions y1 to y6 of Takeuchi & Saito, in each fluid one the two of Saito, are polynomials that satisfy the
equations at Gauss's points, and one sparse system joins all layers: nothing is integrated from the centre outwards,
and so nothing grows. The tide itself is left out of y5 and y6, so that what the body adds to it keeps its digits
however small. Units inside: the radius R, the mean density and the surface gravity.

Sources: Takeuchi & Saito 1972, Methods Comput. Phys. 11, 217, eq. 82; Saito 1974, J. Phys. Earth 22, 123, of static
fluids; Kamata et al. 2015, JGR Planets 120, 1528, without infinities where a layer is incompressible.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import schur
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

from astroinertia.bodies.layered import LayeredBody, polynomial_layers
from astroinertia.process.quantities import with_quantities
from astroinertia.storage.data_tables import data_rows
from astroinertia.units import GRAVITATIONAL_CONSTANT

Array = Any

_TOLERANCE = 1e-14  # of the polynomials, from how far the centre, where the equations are singular, is from a layer
_MOST_NODES = 200
_FEWEST_NODES, _NODES_OF_EDGES = 10, 8.0  # and how many more of them one over the root of an edge's thickness asks for


class LoveNumbers(NamedTuple):
    """k of the potential, h and l of the vertical and horizontal displacement; l is NaN of a fluid surface."""

    k: Array
    h: Array
    l: Array  # noqa: E741 (Shida's name)


@dataclass(frozen=True)
class YieldingBody:
    """A layered planet with moduli (Pa) from the centre outwards, made by the functions below.

    rigidity, bulk_modulus: of each layer the coefficients of a polynomial in x = r/R, as those of its density. A layer
    of no rigidity is fluid, one of an infinite bulk modulus incompressible. rheology: of each layer the compliance over
    the elastic one, a function of the frequency (`matter.rheology`), or None of an elastic one.
    """

    layers: LayeredBody
    rigidity: Sequence[Array]
    bulk_modulus: Sequence[Array]
    rheology: Sequence[Callable[[float], complex] | None]


@with_quantities()
def yielding_body(
    layers: LayeredBody,
    rigidity: Sequence[Array],
    bulk_modulus: Sequence[Array] | None = None,
    rheology: Sequence[Callable[[float], complex] | None] | None = None,
) -> YieldingBody:
    """The planet of these layers with a rigidity and a bulk modulus (Pa) of each, numbers or coefficients in x = r/R.

    Without bulk_modulus it is incompressible, without rheology elastic. ValueError where the numbers of layers differ,
    a rigidity is negative or a bulk modulus not positive. Source: as for `love_numbers`.

    >>> from astroinertia.bodies.layered import constant_layers
    >>> earth = constant_layers([6.371e6], [5515.0], 6.674e-11)
    >>> print(f"{love_numbers(yielding_body(earth, [1.5e11])).k:.3f}")  # as rigid as steel: Kelvin's
    0.292
    """
    count = len(layers.outer_radii)
    rows = [np.atleast_1d(np.asarray(row, dtype=float)) for row in rigidity]
    bulk = [np.atleast_1d(np.asarray(row, dtype=float)) for row in bulk_modulus or [math.inf] * count]
    laws = list(rheology or [None] * count)
    if not len(rows) == len(bulk) == len(laws) == count:
        raise ValueError(
            f"a rigidity, a bulk modulus and a rheology are needed of each layer, of which there are {count}"
        )
    x_out = np.asarray(layers.outer_radii) / layers.outer_radii[-1]
    for row, stiff, x_in, x in zip(rows, bulk, [0.0, *x_out[:-1]], x_out, strict=True):
        places = np.linspace(x_in, x, 9)
        if not np.all(_polynomial(row, places) > 0) and np.any(row):
            raise ValueError("the rigidity of a layer is above 0 in all of it, or 0 of a fluid")
        if not np.all(_polynomial(stiff, places) > 0):
            raise ValueError("the bulk modulus of a layer is above 0")
    return YieldingBody(layers, rows, bulk, laws)


@with_quantities()
def seismic_body(
    radii: Array, densities: Sequence[Array], pressure_waves: Sequence[Array], shear_waves: Sequence[Array]
) -> YieldingBody:
    """The planet of a seismic model, mu = rho v_s^2 and K = rho (v_p^2 - 4/3 v_s^2), by layers from the centre.

    radii: outer ones (m); of each layer the coefficients in x = r/R of the density (kg m-3) and of the velocities (m/s)
    of pressure and of shear waves, which are 0 in a fluid.
    ValueError as for `yielding_body` and `polynomial_layers`. Source: Dziewonski & Anderson 1981, PEPI 25, 297.

    >>> moon = seismic_body([1.737e6], [[3344.0]], [[8000.0]], [[4500.0]])
    >>> print(f"{love_numbers(moon).k:.4f}")  # without a core
    0.0218
    """
    multiply = np.polynomial.polynomial.polymul
    rows = [
        [np.atleast_1d(np.asarray(c, dtype=float)) for c in table] for table in (densities, pressure_waves, shear_waves)
    ]
    rigidity = [multiply(rho, multiply(v, v)) for rho, _, v in zip(*rows, strict=True)]
    moduli = [multiply(rho, multiply(v, v)) for rho, v, _ in zip(*rows, strict=True)]
    bulk = [np.polynomial.polynomial.polysub(p, 4 / 3 * s) for p, s in zip(moduli, rigidity, strict=True)]
    return yielding_body(polynomial_layers(radii, rows[0], GRAVITATIONAL_CONSTANT), rigidity, bulk)


@with_quantities()
def interior(name: str) -> YieldingBody:
    """The Moon or Mars by a published seismic model, elastic at seismic frequencies: data/interiors.csv.

    Moon: Weber et al. 2011, Science 331, 309. Mars: Khan et al., Knapmeyer-Endrun et al. and Staehler et al. 2021,
    Science 373, 434, 438 and 443. ValueError for another name.

    >>> print(f"{love_numbers(interior('Moon')).k:.4f}")  # GRAIL, at a month: 0.0241
    0.0234
    """
    every = data_rows("interiors.csv")
    table = np.array([[1e3 * float(row[c]) for c in _COLUMNS] for row in every if row["body"] == name])
    if not len(table):
        raise ValueError(f"there are interiors of {', '.join(sorted({row['body'] for row in every}))}, not of {name}")
    inner, outer = table[:-1], table[1:]
    layers = outer[:, 0] > inner[:, 0]
    inner, outer = inner[layers], outer[layers]
    slope = (outer - inner)[:, 1:] / (outer - inner)[:, :1]
    at_centre = inner[:, 1:] - slope * inner[:, :1]
    lines = np.stack([at_centre, slope * table[-1, 0]], axis=-1)
    return seismic_body(outer[:, 0], *(list(lines[:, k]) for k in range(3)))


_COLUMNS = ("radius_km", "density_g_cm3", "vp_km_s", "vs_km_s")


@with_quantities(frequency="rad/s")
def love_numbers(planet: YieldingBody, degree: int = 2, frequency: Array = math.inf, load: bool = False) -> LoveNumbers:
    """k, h and l of a degree n >= 2 at forcing frequencies (rad/s, any shape), elastic without one.

    They are complex where a layer that yields late is forced. Of a tide of potential (r/R)^n: k is the share that the
    planet adds at its surface, h and l the displacements times its gravity over the potential. load: the load Love
    numbers k', h', l' instead, of a mass on the surface whose own potential is that. A negative frequency gives the
    conjugate. ValueError for a degree below 2, and for a frequency of 0, at which what creeps is fluid: give it no
    rigidity.
    Sources: those of the module.

    >>> from functools import partial
    >>> from astroinertia.bodies.layered import constant_layers
    >>> from astroinertia.matter.rheology import maxwell
    >>> io = constant_layers([1.8216e6], [3528.0], 6.674e-11)
    >>> melting = yielding_body(io, [6e10], rheology=[partial(maxwell, relaxation_time=2e4)])
    >>> print(f"{love_numbers(melting, 2, 4.11e-5).k:.4f}")
    0.0306-0.0355j
    """
    if not degree >= 2 or degree % 1 != 0:
        raise ValueError("the degree of a Love number is a whole number from 2 on")
    rates = np.asarray(frequency, dtype=float)
    if np.any(rates == 0) or np.any(np.isnan(rates)):
        raise ValueError("a forcing frequency is above or below 0; a layer that is fluid at rest has no rigidity")
    solved = [_solved(planet, int(degree), rate, load) for rate in rates.ravel()]
    return LoveNumbers(*(np.reshape(numbers, rates.shape)[()] for numbers in zip(*solved, strict=True)))


class _Layer(NamedTuple):
    """From inner to outer radius: number of functions, nodes, and the moduli and density at radii, over their units.

    stiffness: its rigidity where that is above 1. Displacements and their potential are taken times it, for all
    functions to be of one size: else those of rocks, which hardly yield to their own gravity, are lost in round-off.
    """

    inner: float
    outer: float
    stiffness: float
    solid: bool
    nodes: int
    density: Callable[[Array], Array]
    gravity: Callable[[Array], Array]
    rigidity: Callable[[Array], Array]
    bulk: Callable[[Array], Array]

    @property
    def functions(self) -> int:
        return 6 if self.solid else 2

    @property
    def scale(self) -> Array:
        """What each of the functions is taken times."""
        s = self.stiffness
        return np.array([s, 1, s, 1, s, s]) if self.solid else np.ones(2)

    def tide(self, degree: int) -> Array:
        """The functions of the tide itself in a body that does not yield, over x^(degree - 1): z of `_rates`."""
        return np.array([0.0, 0, 0, 0, 1, 2 * degree + 1]) if self.solid else np.array([1.0, 2 * degree + 1])


def _polynomial(coefficients: Array, x: Array) -> Array:
    return np.polynomial.polynomial.polyval(x, coefficients)


def _layers(planet: YieldingBody, degree: int, frequency: float) -> list[_Layer]:
    body = planet.layers
    x_out = np.asarray(body.outer_radii, dtype=float) / float(body.outer_radii[-1])
    rows = np.asarray(body.coefficients, dtype=float)
    inside = np.array([np.concatenate([np.zeros(3), row / (np.arange(len(row)) + 3)]) for row in rows])
    x_in = np.concatenate([[0.0], x_out[:-1]])
    shells = [_polynomial(row, b) - _polynomial(row, a) for row, a, b in zip(inside, x_in, x_out, strict=True)]
    below, mean = np.cumsum([0.0, *shells]), 3 * sum(shells)
    radius, constant = float(body.outer_radii[-1]), float(body.gravitational_constant)
    stress = 4 / 3 * math.pi * constant * mean**2 * radius**2  # mean density, surface gravity and radius
    if not 0.0 < stress < math.inf:
        raise ValueError(
            f"a body of this density and a radius of {radius:g} has a pressure of {stress:g}, out of reach"
        )
    layers = []
    for k, (a, b) in enumerate(zip(x_in, x_out, strict=True)):
        if b <= a:
            continue
        law = planet.rheology[k]
        soft = 1.0 if law is None or math.isinf(frequency) else law(frequency)
        core = below[k] - _polynomial(inside[k], a)
        if a > 0:
            away = (math.sqrt(b) + math.sqrt(a)) / (math.sqrt(b) - math.sqrt(a))
            nodes = 3 - math.log(_TOLERANCE) / math.log(away) + 0.5 * degree * math.log(b / a)
        else:
            nodes = 0.0
        within = np.linspace(a, b, 9)
        rigidity = np.abs(_polynomial(planet.rigidity[k], within) / (stress * soft))
        slope = np.abs(_polynomial(np.polynomial.polynomial.polyder(rows[k]), within)).max() / mean
        # At edges of a layer its functions fall within 1/n of the radius, and those of a soft solid sooner, where its
        # rigidity has to hold the buoyancy of the density's slope: within (mu/(g R |d rho/dx|))^(1/4)/n^(1/2).
        fall = max(degree, math.sqrt(degree) * (slope / rigidity.min()) ** 0.25) if rigidity.any() else degree
        nodes = max(nodes, _FEWEST_NODES + _NODES_OF_EDGES * math.sqrt(fall * (b - a) / b))
        rigid = rigidity.max()
        layers.append(
            _Layer(
                a, b, max(1.0, float(rigid)), bool(np.any(planet.rigidity[k])), min(_MOST_NODES, math.ceil(nodes)),
                lambda x, k=k: _polynomial(rows[k], x) / mean,
                lambda x, k=k, core=core: 3 * (core + _polynomial(inside[k], x)) / (mean * x**2),
                lambda x, k=k, soft=soft: _polynomial(planet.rigidity[k], x) / (stress * soft),
                lambda x, k=k: _polynomial(planet.bulk_modulus[k], x) / stress,
            )
        )  # fmt: skip
    return layers


def _rates(layer: _Layer, degree: int, x: Array) -> Array:
    """B (nodes, functions, functions) of x dz/dx = B z at radii x above 0.

    z of a solid: y1, x y2, y3, x y4, y5/x, y6 of Takeuchi & Saito 1972; of a fluid: y5/x, y7 of Saito 1974.
    """
    n, rho, g = degree, layer.density(x), layer.gravity(x)
    if not layer.solid:
        q = 3 * rho * x / g
        one = np.ones_like(q)
        return np.stack([np.stack([q - n - 2, one], -1), np.stack([2 * (n - 1) * q, n - 1 - q], -1)], -2)
    mu, bulk, both = layer.rigidity(x), layer.bulk(x), n * (n + 1)
    b = 1 / (bulk + 4 / 3 * mu)  # 1/(lambda + 2 mu): 0 where it is incompressible
    a = 1 - 2 * mu * b  # lambda/(lambda + 2 mu)
    spread = mu * (3 * a + 2 * mu * b)
    weight, potential = rho * g * x, rho * x**2
    matrix = np.zeros((len(x), 6, 6), dtype=np.result_type(mu))
    matrix[:, 0, :3] = np.stack([-2 * a, b, both * a], -1)
    matrix[:, 1] = np.stack(
        [
            4 * spread - 4 * weight,
            2 * a - 1,
            both * (weight - 2 * spread),
            both + 0 * x,
            (n + 1) * potential,
            -potential,
        ],
        -1,
    )
    matrix[:, 2, 0], matrix[:, 2, 2], matrix[:, 2, 3] = -1, 1, 1 / mu
    across = 4 * mu * (a + mu * b)
    matrix[:, 3, :5] = np.stack([weight - 2 * across + 2 * mu, -a, both * across - 2 * mu, -2 + 0 * x, -potential], -1)
    matrix[:, 4, 0], matrix[:, 4, 4], matrix[:, 4, 5] = 3 * rho, -n - 2, 1
    matrix[:, 5, 0], matrix[:, 5, 2], matrix[:, 5, 5] = 3 * rho * (n + 1), -3 * rho * both, n - 1
    return matrix


class _System:
    """Rows of the sparse system, and what stands on their right-hand side."""

    def __init__(self) -> None:
        self.rows: list[tuple[Array, Array, Array]] = []
        self.right: list[float] = []

    def add(self, blocks: list[tuple[int, Array]], right: Sequence[float] | None = None) -> None:
        """Equations: blocks of the matrix (equations, unknowns), each from a column on."""
        count = len(blocks[0][1])
        for column, block in blocks:
            i, j = np.indices(block.shape).reshape(2, -1)
            self.rows.append((i + len(self.right), j + column, block.ravel()))
        self.right.extend(right if right is not None else [0.0] * count)

    def solution(self) -> Array:
        i, j, values = (np.concatenate(parts) for parts in zip(*self.rows, strict=True))
        size = len(self.right)
        return spsolve(coo_array((values, (i, j)), (size, size)).tocsc(), np.array(self.right, dtype=values.dtype))


def _solved(planet: YieldingBody, n: int, frequency: float, load: bool) -> tuple[complex, complex, complex]:
    layers, system, column = _layers(planet, n, frequency), _System(), 0
    below: tuple[_Layer, int, Array] | None = None
    top = layers[-1]
    for layer in layers:
        nodes, _ = np.polynomial.legendre.leggauss(layer.nodes)
        values = np.polynomial.legendre.legvander(nodes, layer.nodes)
        to_slope = np.polynomial.legendre.legder(np.eye(layer.nodes + 1))
        slopes = np.polynomial.legendre.legvander(nodes, layer.nodes - 1) @ to_slope
        half = 0.5 * (layer.outer - layer.inner)
        x = layer.inner + half * (nodes + 1)
        power = 0 if layer.inner > 0 else n - 1  # of x/outer, that the functions of the innermost layer are taken over
        unit = np.eye(layer.functions)
        rates, tide = _rates(layer, n, x), layer.tide(n)
        size = (x if layer.inner > 0 else np.full_like(x, layer.outer)) ** (n - 1)  # of the tide, over that power
        driven = layer.scale * size[:, None] * ((rates - (n - 1) * unit) @ tide)
        matrix = rates * (layer.scale[:, None] / layer.scale) - power * unit
        equations = np.einsum("i,im,vw->ivwm", x / half, slopes, unit) - np.einsum("ivw,im->ivwm", matrix, values)
        system.add([(column, equations.reshape(layer.nodes * layer.functions, -1))], list(driven.ravel()))
        inner = np.kron(unit, (-1.0) ** np.arange(layer.nodes + 1))
        if below is None:
            start = np.full(1, 1e-8 * layer.outer)  # of the rates, which differ from the centre's by x^2 or x
            rates = _rates(layer, n, start)[0] * (layer.scale[:, None] / layer.scale)
            _, irregular, count = schur(rates.T, sort="lhp")  # type: ignore[misc]  # exponents below 0
            singular = irregular[:, :count].T
            # Tide and answer together are regular at the centre; the tide is so by itself in a solid, not in a fluid.
            of_tide = np.zeros(count) if layer.solid else singular @ tide * layer.outer ** (n - 1)
            system.add([(column, singular @ inner)], list(-of_tide))
        else:
            system.add(*_joined(below, (layer, column, inner), n))
        below = (layer, column, np.kron(unit, np.ones(layer.nodes + 1)))
        column += layer.functions * (layer.nodes + 1)
    assert below is not None
    pressed = -(2 * n + 1) / 3 if load else 0.0  # y2 of the load's weight
    _, first, outer = below
    if top.solid:
        system.add([(first, outer[[1, 3, 5]])], [pressed, 0.0, 0.0])
    else:
        system.add([(first, outer[[1]])], [3 * pressed])
    z = outer @ system.solution()[first:] / top.scale
    if top.solid:
        return z[4], z[0], z[2]
    return z[0], z[0] + 1 + pressed / top.density(1.0), math.nan


def _joined(
    below: tuple[_Layer, int, Array], above: tuple[_Layer, int, Array], n: int
) -> tuple[list[tuple[int, Array]], list[float] | None]:
    """What is continuous from a layer to the next, as rows of the values there of all functions of each."""
    (lower, first, outer), (upper, second, inner) = below, above
    if lower.solid == upper.solid:
        return [(first, outer * (upper.scale / lower.scale)[:, None]), (second, -inner)], None
    fluid, solid = (lower, upper) if upper.solid else (upper, lower)
    of_solid, of_fluid = (inner, outer) if upper.solid else (outer, inner)
    at_solid, at_fluid = (second, first) if upper.solid else (first, second)
    x = solid.inner if upper.solid else solid.outer
    rho, g = fluid.density(x), fluid.gravity(x)
    # y4 = 0; y2 = rho (g y1 - y5); y5; y7 = y6 + (4 pi G/g) y2
    rows = np.zeros((4, 6))
    rows[0, 3] = 1
    rows[1, [0, 1, 4]] = -rho * g, 1 / x, rho * x
    rows[2, 4] = 1
    rows[3, [1, 5]] = 3 / (g * x), 1
    fluid_rows = np.zeros((4, 2))
    fluid_rows[2, 0] = fluid_rows[3, 1] = -1
    pushed = [0.0, -rho * x**n, 0.0, 0.0]  # by the tide itself
    return [(at_solid, rows / solid.scale @ of_solid), (at_fluid, fluid_rows @ of_fluid)], pushed
