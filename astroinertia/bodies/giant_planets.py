"""Jupiter and Saturn as composite polytropes that fit mass, equatorial radius, J2 and J4, and predict the rest.

The model is of the piecewise polytropes of Neuenschwander et al. 2021, ApJ 910, 38, with two pieces of one index n: an
envelope P = K rho^(1 + 1/n) and, inside a given share of the mean radius, a core with a K of its own (denser matter).
n and K_core/K are fitted; J6 and higher, C/(M a^2) and the polar radius follow. Rotation is rigid: what winds add to
the measured harmonics is left out, by Militzer & Hubbard 2023, PSJ 4, 95, -0.8 % of Jupiter's J6 and +6 % of Saturn's,
and much of Saturn's J8 and J10 (Iess et al. 2019, Science 364, eaat2965, table 2).

Inputs: data/planets.csv (G M, equatorial radius, rotation) and data/zonal_harmonics.csv.
Tests: tests/physics/test_giant_planets.py.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import root

from astroinertia.bodies import planets
from astroinertia.bodies.figures import RotatingFigure, figure_of_barotropes
from astroinertia.errors import NumericalError, UnlistedError
from astroinertia.matter.barotropes import PolytropicLaw
from astroinertia.process.quantities import with_quantities
from astroinertia.storage.data_tables import data_rows
from astroinertia.units import GRAVITATIONAL_CONSTANT

CORE_FRACTION = 0.15  # of the mean radius: the compact cores of three-layer models (Nettelmann et al. 2012, 2013)
# Of Powell's hybrid method for n and ln(K/K_core): tolerance, square of the difference that slopes are taken by,
# and the first step, of their size: further away there may be no figure at all.
_SEARCH = {"xtol": 1e-10, "eps": 1e-10, "factor": 0.1}
_ROUND_OFF = 1e-12


@with_quantities(zonal_harmonics=None, uncertainties=None)
@dataclass(frozen=True, eq=False)
class MeasuredField:
    """A planet from outside, in SI: J2, J4, ... and their uncertainties (3 sigma) for its equatorial radius."""

    name: str
    gravitational_parameter: float
    equatorial_radius: float
    angular_velocity: float
    zonal_harmonics: np.ndarray
    uncertainties: np.ndarray

    @property
    def rotation_parameter(self) -> float:
        """q = Omega^2 a^3/(G M)."""
        return self.angular_velocity**2 * self.equatorial_radius**3 / self.gravitational_parameter


@dataclass(frozen=True, eq=False)
class GiantPlanet:
    """A fitted model: its figure (SI), index n, K_core/K, the core's shares of radius and mass, what was measured."""

    field: MeasuredField
    figure: RotatingFigure
    index: float
    core_constant_ratio: float
    core_fraction: float
    core_mass_fraction: float


@with_quantities()
def measured_field(name: str) -> MeasuredField:
    """Return the field of "Jupiter" (Durante et al. 2020) or "Saturn" (Iess et al. 2019), harmonics to degree 10.

    UnlistedError for other names.

    >>> print(measured_field("Jupiter").name)
    Jupiter
    """
    body = planets.body(name)
    radius = body.equatorial_radius
    rows = [row for row in data_rows("zonal_harmonics.csv") if row["body"] == name]
    if not rows:
        raise UnlistedError(f"no zonal harmonics of {name} in data/zonal_harmonics.csv")
    scales = [1e-6 * (1e3 * float(row["radius_km"]) / radius) ** int(row["degree"]) for row in rows]
    return MeasuredField(
        name=name,
        gravitational_parameter=body.gravitational_parameter,
        equatorial_radius=radius,
        angular_velocity=body.angular_velocity,
        zonal_harmonics=np.array([float(row["value_e6"]) * scale for row, scale in zip(rows, scales, strict=True)]),
        uncertainties=np.array([float(row["uncertainty_e6"]) * scale for row, scale in zip(rows, scales, strict=True)]),
    )


@with_quantities()
def giant_planet(field: MeasuredField, core_fraction: float = CORE_FRACTION) -> GiantPlanet:
    """Return the composite polytrope with the mass, equatorial radius, rotation, J2 and J4 of `field`.

    core_fraction: the core's share of the mean radius, which the field leaves open. Powell's method for n and
    ln(K/K_core), from the single polytrope that has J2. Raises ValueError for a core outside (0, 1), NumericalError if
    no such model is found. Source: Neuenschwander et al. 2021.

    >>> figure = giant_planet(measured_field("Jupiter")).figure
    >>> print(f"{figure.polar_moment_ratio_equatorial:.4f}")  # published: 0.2639
    0.2639
    """
    if not 0 < core_fraction < 1:
        raise ValueError(f"the core must take a share between 0 and 1 of the radius, not {core_fraction}")
    measured = field.zonal_harmonics[:2]

    def figure(parameters, mass=1.0, mean_radius=1.0, gravitational_constant=1.0) -> RotatingFigure:
        index, softness = parameters
        laws = [PolytropicLaw(index, math.exp(-softness)), PolytropicLaw(index)]
        return figure_of_barotropes(
            [core_fraction, 1.0],
            laws,
            mass=mass,
            mean_radius=mean_radius,
            rotation_parameter=field.rotation_parameter,
            gravitational_constant=gravitational_constant,
            harmonics=12,
        )

    def misfit(parameters):
        return figure(parameters).zonal_harmonics[:2] / measured - 1

    index = root(lambda index: misfit([*index, 0.0])[:1], [1.0], options=_SEARCH).x  # the index alone first
    found = root(misfit, [*index, 0.0], options=_SEARCH)
    if not found.success:
        raise NumericalError(f"no composite polytrope with a core of {core_fraction:g} R fits {field.name}")
    parameters = found.x
    shape = figure(parameters)
    mean_radius = field.equatorial_radius * shape.mean_radius / shape.equatorial_radius
    mass = field.gravitational_parameter / GRAVITATIONAL_CONSTANT
    fitted = figure(parameters, mass, mean_radius, GRAVITATIONAL_CONSTANT)
    core_top = np.searchsorted(fitted.radius, core_fraction * mean_radius * (1 - _ROUND_OFF))
    return GiantPlanet(
        field=field,
        figure=fitted,
        index=float(parameters[0]),
        core_constant_ratio=math.exp(-parameters[1]),
        core_fraction=core_fraction,
        core_mass_fraction=float(fitted.enclosed_mass[core_top]) / mass,
    )
