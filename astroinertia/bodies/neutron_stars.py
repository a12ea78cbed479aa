"""Neutron stars and white dwarfs of a cold equation of state: one star, the star of a mass, the heaviest, sequences.

Units are geometric, G = c = Msun = 1 (a length of 1 is G Msun/c^2 = 1.476625 km), but for names that end in a unit.
R is the areal (circumferential) radius of the non-rotating star, the radius of every ratio here.

Sources: Hartle 1967, ApJ 150, 1005; Hinderer 2008, ApJ 677, 1216; Yagi & Yunes 2013, PRD 88, 023009 (the bar
quantities). Tests: tests/unit/bodies/test_neutron_stars.py, tests/physics/test_neutron_stars.py.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.optimize import fminbound

from astroinertia.bodies.neutron_star_fits import shedding_frequency
from astroinertia.bodies.slow_rotation import Equations, SlowRotation, enclosed_moment_share, slow_rotation
from astroinertia.bodies.tov import TOLERANCE, Structure, structure
from astroinertia.errors import NumericalError
from astroinertia.matter.compact_stars import SOLAR_LENGTH, Barotrope, geometric_density, geometric_pressure
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between
from astroinertia.units import SOLAR_MASS, with_unit

_SCAN_TOLERANCE = 1e-7
_TURNING_POINT = 1e-7  # in ln eta: the mass is flat there, to a part in 1e13
_SCAN_FROM, _SCAN_TO, _SCAN_PER_DECADE = 1e-8, 30.0, 8  # central eta: from cold gas to far beyond every maximum


@dataclass(frozen=True, eq=False)
class NeutronStar:
    """A star with its answers to slow rotation and to tides."""

    equation_of_state: Barotrope = field(repr=False)
    structure: Structure = field(repr=False)
    rotation: SlowRotation

    @property
    def mass(self) -> float:
        """Gravitational mass M."""
        return self.structure.mass

    @property
    def rest_mass(self) -> float:
        """Rest mass of the baryons."""
        return self.structure.rest_mass

    @property
    def radius(self) -> float:
        """Areal radius R."""
        return self.structure.radius

    @property
    def compactness(self) -> float:
        """G M/(R c^2)."""
        return self.structure.compactness

    @property
    def central_rest_density(self) -> float:
        """Rest-mass density at the centre."""
        return self.structure.central_rest_density

    @property
    def central_pressure(self) -> float:
        """Pressure at the centre."""
        return self.structure.central_pressure

    @property
    def moment_of_inertia(self) -> float:
        """I = J/Omega of slow rigid rotation."""
        return self.moment_ratio * self.mass * self.radius**2

    @property
    def moment_ratio(self) -> float:
        """I/(M R^2)."""
        return self.rotation.moment_ratio

    @property
    def moment_bar(self) -> float:
        """I/M^3 (G = c = 1)."""
        return self.moment_ratio / self.compactness**2

    @property
    def tidal_love_number(self) -> float:
        """k2 of Hinderer 2008: 3/4 for an incompressible Newtonian star, half the fluid Love number."""
        return self.rotation.tidal_love_number

    @property
    def tidal_deformability(self) -> float:
        """Lambda = (2/3) k2/C^5, the Love bar of I-Love-Q."""
        return 2 / 3 * self.tidal_love_number / self.compactness**5

    @property
    def quadrupole(self) -> float:
        """Q/Omega^2: the mass quadrupole of slow rotation, positive for an oblate star."""
        return self.rotation.quadrupole * self.radius**5

    @property
    def quadrupole_bar(self) -> float:
        """Q M/J^2, 1 for a Kerr hole; NaN for a Newtonian star."""
        return self.rotation.quadrupole_bar

    @property
    def redshift(self) -> float:
        """Redshift of light from the surface, 0 for a Newtonian star."""
        return 1 / math.sqrt(1 - 2 * self.compactness) - 1 if self.structure.relativistic else 0.0

    def shedding_frequency(self, source: str = "haensel_2009") -> float:
        """Fastest rigid rotation in Hz by a published estimate, a name of neutron_star_fits.KEPLER_FACTORS."""
        return float(shedding_frequency(self.mass, self.radius_km, source))

    @property
    def causal(self) -> bool:
        """Whether sound is nowhere in the star faster than light."""
        centre = self.structure.central_log_enthalpy
        return self.equation_of_state.causal_up_to(math.expm1(centre) if self.structure.relativistic else centre)

    @property
    def mass_kg(self) -> float:
        """Gravitational mass in kg."""
        return self.mass * SOLAR_MASS

    @property
    def radius_km(self) -> float:
        """Areal radius in km."""
        return self.radius * SOLAR_LENGTH / 1e3

    @property
    def moment_of_inertia_kg_m2(self) -> float:
        """I in kg m2 (1e38 of them are the customary 1e45 g cm2)."""
        return self.moment_of_inertia * SOLAR_MASS * SOLAR_LENGTH**2


def _geometric(name: str, value: Any) -> float:
    """A number in geometric units of the Sun, as is, or what is given with a unit."""
    if not isinstance(value, str) and with_unit(value) is None:
        return float(value)
    return float(geometric_pressure(value) if name.endswith("pressure") else geometric_density(value))


def _central(equation: Barotrope, options: dict[str, float | None]) -> float:
    named = {name: value for name, value in options.items() if value is not None}
    if len(named) != 1:
        raise ValueError(f"give exactly one of {', '.join(options)}, not {len(named)}")
    ((name, value),) = named.items()
    if np.ndim(value):
        raise ValueError(f"{name} is that of one star, not of {np.size(value)}: `sequence` has many")
    if name == "central_enthalpy":
        return float(value)
    return equation.enthalpy_of(name.removeprefix("central_"), _geometric(name, value))


def star(
    equation_of_state: Barotrope,
    *,
    central_rest_density: float | None = None,
    central_energy_density: float | None = None,
    central_pressure: float | None = None,
    central_enthalpy: float | None = None,
    relativistic: bool = True,
    tolerance: float = TOLERANCE,
) -> NeutronStar:
    """Return the star with one given central value; central_enthalpy is (e + P)/rho0 - 1.

    Numbers are in units of G = c = Msun = 1; densities and pressures may be quantities, that of energy as a mass.

    At the default tolerance every property is good to 2e-10 (3e-11 for gamma of 5/3 and above, and for all of Read et
    al.), less for stars of hundreds of scale lengths (gamma near 6/5). ValueError where the equation of state does not
    cover the centre or not exactly one central value is given; NumericalError where there is no surface.

    >>> from astroinertia.matter.compact_stars import geometric_density, read2009
    >>> print(f"{star(read2009('SLy'), central_rest_density=geometric_density(1e18)).mass:.2f}")  # solar masses
    1.56
    """
    enthalpy = _central(
        equation_of_state,
        {
            "central_rest_density": central_rest_density,
            "central_energy_density": central_energy_density,
            "central_pressure": central_pressure,
            "central_enthalpy": central_enthalpy,
        },
    )
    whole = structure(equation_of_state, enthalpy, relativistic, tolerance, Equations())
    return NeutronStar(equation_of_state, whole, slow_rotation(whole))


def crust_moment_share(body: NeutronStar, transition_pressure: float) -> float:
    """The share of I that is in the crust: in matter of less than the pressure at which the core begins.

    transition_pressure is in units of G = c = Msun = 1, or a quantity: 0.2 to 0.65 MeV/fm3 by the equation of state.
    The superfluid that glitches need is part of this share (`rotation.glitches.least_superfluid_share`). ValueError for
    a pressure that is not between 0 and that of the centre.
    Source: Ravenhall & Pethick 1994, ApJ 424, 846; Link, Epstein & Lattimer 1999, PRL 83, 3362.

    >>> from astroinertia.matter.compact_stars import read2009
    >>> print(f"{crust_moment_share(star_of_mass(read2009('SLy'), 1.4), '0.337 MeV/fm3'):.4f}")
    0.0254
    """
    equation, centre = body.equation_of_state, body.structure.central_log_enthalpy
    relativistic = body.structure.relativistic
    pressure = _geometric("transition_pressure", transition_pressure)
    if not 0 < pressure < body.central_pressure:
        raise ValueError(f"a crust ends at a pressure from 0 to below {body.central_pressure:.6g}, that of the centre")
    edge = equation.enthalpy_of("pressure", pressure)
    # A break of the equation of state there is a point of the integration.
    place = int(np.searchsorted(equation.edges, edge))
    cut = replace(
        equation, edges=(*equation.edges[:place], edge, *equation.edges[place:]),
        pieces=(*equation.pieces[:place], equation.pieces[place - 1], *equation.pieces[place:]),
    )  # fmt: skip
    solved = structure(cut, math.expm1(centre) if relativistic else centre, relativistic, perturbation=Equations())
    depth = math.log1p(edge) if relativistic else edge
    inside = enclosed_moment_share(solved)[np.argmin(np.abs(solved.log_enthalpy - depth))]
    return float(1 - inside)


@dataclass(frozen=True)
class StableBranch:
    """Central enthalpies between which the mass rises to the heaviest star.

    turning_point: whether the upper end is a maximum of the mass, not the end of the equation of state or of the scan.
    """

    lowest: float
    highest: float
    turning_point: bool


def _minimum(function: Callable[[float], float], low: float, high: float) -> float:
    minimum = fminbound(lambda x: function(float(x)), low, high, xtol=_TURNING_POINT)
    return np.asarray(minimum).item()


@with_quantities()
@lru_cache(maxsize=64)
def stable_branch(equation_of_state: Barotrope, relativistic: bool = True) -> StableBranch:
    """Return the stretch of rising mass that ends at the heaviest star (stable, by the turning-point theorem).

    The heaviest is sought on a grid of eight stars a decade of central eta. ValueError where the mass does not rise
    with central density (gamma of 4/3 and below).
    Source: Harrison, Thorne, Wakano & Wheeler 1965, Gravitation Theory and Gravitational Collapse, ch. 7.
    """
    end = min(_SCAN_TO, equation_of_state.largest_enthalpy)
    count = max(8, round(_SCAN_PER_DECADE * math.log10(end / _SCAN_FROM))) if end > _SCAN_FROM else 8
    logs = np.linspace(math.log(min(_SCAN_FROM, end / 10)), math.log(end), count + 1)
    logs[-1] = math.log(end) - (0.0 if end == _SCAN_TO else 1e-15)

    def mass(log_enthalpy: float, tolerance: float = TOLERANCE) -> float:
        return structure(equation_of_state, min(math.exp(log_enthalpy), end), relativistic, tolerance).mass

    masses = []
    for x in logs:
        try:
            masses.append(mass(float(x), _SCAN_TOLERANCE))
        except NumericalError:  # soft matter: from some density on the star has no surface
            if not masses:
                raise
            break
    count = len(masses) - 1
    top = int(np.argmax(masses))
    if masses[top] < masses[0] * (1 + 100 * _SCAN_TOLERANCE):
        raise ValueError(
            f"equation of state {equation_of_state.name}: no stable star, its mass does not rise with density"
        )
    bottom = top
    while bottom > 0 and masses[bottom - 1] < masses[bottom]:
        bottom -= 1
    lowest, highest = float(logs[bottom]), float(logs[top])
    if top < count:
        highest = _minimum(lambda x: -mass(x), logs[top - 1], logs[top + 1])
    if bottom > 0:
        lowest = _minimum(mass, logs[bottom - 1], logs[bottom + 1])
    turning = top < count
    return StableBranch(math.exp(lowest), min(math.exp(highest), end), turning)


@with_quantities()
def maximum_mass(equation_of_state: Barotrope, relativistic: bool = True) -> NeutronStar:
    """Return the heaviest star: M to 1e-10, its central enthalpy (and so R) to about 1e-6.

    ValueError where the mass has no maximum within the equation of state.

    >>> from astroinertia.matter.compact_stars import read2009
    >>> print(f"{maximum_mass(read2009('SLy')).mass:.2f}")  # solar masses
    2.05
    """
    branch = stable_branch(equation_of_state, relativistic)
    if not branch.turning_point:
        raise ValueError(
            f"equation of state {equation_of_state.name}: the mass still rises at the largest central enthalpy, "
            f"{branch.highest:.3g}; there is no maximum"
        )
    return star(equation_of_state, central_enthalpy=branch.highest, relativistic=relativistic)


@with_quantities(mass="Msun")
def star_of_mass(equation_of_state: Barotrope, mass: float, relativistic: bool = True) -> NeutronStar:
    """Return the stable star of a given gravitational mass (solar masses), on the branch of the heaviest star.

    ValueError for a mass above the maximum or below the least of that branch.

    >>> from astroinertia.matter.compact_stars import read2009
    >>> print(f"{star_of_mass(read2009('SLy'), 1.4).radius_km:.2f} km")
    11.71 km
    """
    require_positive(mass=mass)
    branch = stable_branch(equation_of_state, relativistic)

    def found(log_enthalpy: float) -> float:
        enthalpy = min(max(math.exp(log_enthalpy), branch.lowest), branch.highest)
        return structure(equation_of_state, enthalpy, relativistic).mass

    ends = math.log(branch.lowest), math.log(branch.highest)
    least, most = map(found, ends)
    if not least <= mass <= most:
        raise ValueError(
            f"equation of state {equation_of_state.name}: stable stars have {least:.6g} to {most:.6g} solar masses, "
            f"not {mass:.6g}"
        )
    root = root_between(lambda log: found(log) / mass - 1, *ends, 1e-14, 1e-14)
    return star(equation_of_state, central_enthalpy=math.exp(root), relativistic=relativistic)


@dataclass(frozen=True, eq=False)
class Sequence:
    """Stars of one equation of state by rising central density, with `stable` for each."""

    stars: tuple[NeutronStar, ...] = field(repr=False)
    stable: np.ndarray

    def column(self, name: str) -> np.ndarray:
        """The property `name` of every star, such as "mass" or "radius_km"."""
        return np.array([getattr(one, name) for one in self.stars])


def sequence(
    equation_of_state: Barotrope,
    central_rest_densities: Iterable[float] | None = None,
    count: int = 40,
    relativistic: bool = True,
) -> Sequence:
    """Return stars of the given central rest densities, or `count` of them over the stable branch.

    Without densities they are spaced evenly in ln eta from a thousandth of the branch's highest eta (or its lowest).
    """
    branch = stable_branch(equation_of_state, relativistic)
    if central_rest_densities is None:
        enthalpies = np.geomspace(max(branch.lowest, 1e-3 * branch.highest), branch.highest, count).tolist()
    else:
        chosen = [_geometric("central_rest_density", value) for value in central_rest_densities]
        enthalpies = [equation_of_state.enthalpy_of("rest_density", value) for value in sorted(chosen)]
    stars = tuple(star(equation_of_state, central_enthalpy=value, relativistic=relativistic) for value in enthalpies)
    slack = 1 + 1e-12
    stable = [branch.lowest <= value * slack and value <= branch.highest * slack for value in enthalpies]
    return Sequence(stars, np.array(stable))
