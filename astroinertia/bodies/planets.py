"""The solar system as published: `data/planets.csv` in SI, with uncertainty, status and source of each number.

What nobody has measured is absent or has the status "model". A moment ratio always carries the radius that it was
normalised with, and is only ever compared after `moment_ratios.convert_moment_ratio`.
"""

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from astroinertia.bodies import moment_ratios
from astroinertia.errors import UnlistedError
from astroinertia.process.quantities import with_quantities
from astroinertia.storage.data_tables import data_rows
from astroinertia.units import GRAVITATIONAL_CONSTANT

OWN = "own"  # status of a number that is not of the table
_RATIOS = ("polar_moment_ratio", "mean_moment_ratio")
_FIELD = ("j2", "c22")
_ERROR = "_uncertainty"
_SYNCHRONOUS = "synchronous"  # the note of such a rate of rotation
_SMALLEST_REFERENCE = 1e-3  # of the mean radius, that J2 is ever stated for
_TURN_PER_DAY = 2.0 * math.pi / 86400.0


@dataclass(frozen=True)
class Published:
    """One published number in SI: its standard deviation (NaN where none is published), status and source.

    adopted: whether it is the one that the package takes, where there are several. radius: in metres, that a moment
    ratio or a gravity coefficient is normalised with; NaN for other quantities.
    """

    value: float
    uncertainty: float
    unit: str
    status: str
    adopted: bool
    radius: float
    source: str
    note: str


@dataclass(frozen=True)
class MomentRatio:
    """I/(M R^2) of one kind ("mean" or "polar") for the radius R (m), with standard deviation, status and source."""

    value: float
    uncertainty: float
    kind: str
    radius: float
    status: str
    source: str


@dataclass(frozen=True)
class SolarSystemBody:
    """A body of the table; quantities in SI. KeyError for a quantity that nobody has published.

    published: every row of a quantity, the adopted one first.
    """

    name: str
    published: Mapping[str, tuple[Published, ...]]

    def adopted(self, quantity_name: str) -> Published:
        """Return the adopted number of a quantity, such as "core_radius"; KeyError where there is none."""
        if quantity_name not in self.published:
            raise UnlistedError(f"no {quantity_name.replace('_', ' ')} of {self.name} is known")
        return self.published[quantity_name][0]

    def has(self, quantity_name: str) -> bool:
        """Return whether the table has a number of this quantity."""
        return quantity_name in self.published

    def value(self, quantity_name: str) -> float:
        """Return the adopted value of a quantity, NaN where there is none."""
        return self.adopted(quantity_name).value if self.has(quantity_name) else math.nan

    @property
    def gravitational_parameter(self) -> float:
        """GM in m3 s-2, of the body alone."""
        return self.adopted("gm").value

    @property
    def mass(self) -> float:
        """GM over the G of astropy, in kg."""
        return self.gravitational_parameter / GRAVITATIONAL_CONSTANT

    @property
    def mean_radius(self) -> float:
        """The published mean radius in m (IAU: of the sphere of the same volume)."""
        return self.adopted("mean_radius").value

    @property
    def equatorial_radius(self) -> float:
        """The equatorial radius in m, (ab)^(1/2) of a triaxial body."""
        return self.adopted("equatorial_radius").value

    @property
    def flattening(self) -> float:
        """1 - c/a of the published radii, NaN without a polar radius."""
        return 1.0 - self.value("polar_radius") / self.value("equatorial_radius")

    @property
    def mean_density(self) -> float:
        """Mass over the volume of the mean radius, in kg m-3."""
        return 3.0 * self.mass / (4.0 * math.pi * self.mean_radius**3)

    @property
    def angular_velocity(self) -> float:
        """Sidereal spin rate in rad s-1, negative if retrograde."""
        return self.adopted("rotation_rate").value

    @property
    def small_m(self) -> float:
        """Omega^2 R^3/(GM) with the mean radius."""
        return self.angular_velocity**2 * self.mean_radius**3 / self.gravitational_parameter

    @property
    def synchronous(self) -> bool:
        """Whether tides hold it in step with its orbit, and so give it a third axis."""
        return self.has("rotation_rate") and self.adopted("rotation_rate").note == _SYNCHRONOUS

    @property
    def rotation_parameter(self) -> float:
        """Omega^2 a^3/(GM) with the equatorial radius."""
        return self.angular_velocity**2 * self.equatorial_radius**3 / self.gravitational_parameter

    @with_quantities()
    def zonal_harmonic(self, radius: float | None = None) -> float:
        """Return J2 for a reference radius in m, the equatorial one unless given: J2 goes as radius^-2."""
        j2 = self.adopted("j2")
        if radius is not None and not radius > _SMALLEST_REFERENCE * self.mean_radius:
            raise ValueError(f"zonal_harmonic takes the reference radius of J2 in m, not {radius:g}")
        return j2.value * (j2.radius / (self.equatorial_radius if radius is None else radius)) ** 2

    @with_quantities()
    def moment_ratio(self, kind: str = "mean", radius: float | None = None) -> MomentRatio:
        """Return the adopted moment ratio as "mean" or "polar", for a radius in m: the mean radius unless given.

        C - I = (2/3) J2 M a^2 turns one kind into the other, exactly. KeyError for a body without a ratio or without
        the J2 that this takes; ValueError for another kind.
        """
        return self.moment_ratio_rows(kind, radius)[0]

    @with_quantities()
    def moment_ratio_rows(self, kind: str = "mean", radius: float | None = None) -> tuple[MomentRatio, ...]:
        """Return every published moment ratio, normalised like `moment_ratio`; the adopted one first."""
        if kind not in ("mean", "polar"):
            raise ValueError(f'a moment ratio is "mean" or "polar", not {kind!r}')
        radius = self.mean_radius if radius is None else radius
        rows = [(name, row) for name in _RATIOS for row in self.published.get(name, ())]
        if not rows:
            raise UnlistedError(f"no moment ratio of {self.name} is known")
        rows.sort(key=lambda pair: not pair[1].adopted)
        return tuple(self._normalised(name.partition("_")[0], row, kind, radius) for name, row in rows)

    def moment_ratio_row(self, number: int) -> MomentRatio:
        """Return one of `moment_ratio_rows`, of the mean radius; ValueError for a number that none of them has."""
        rows = self.moment_ratio_rows()
        if not 0 <= number < len(rows):
            raise ValueError(f"{self.name} has {len(rows)} moment ratios, numbered from 0, and none of number {number}")
        return rows[number]

    def moment_of_inertia(self, kind: str = "mean") -> float:
        """Return the adopted "mean" or "polar" moment in kg m2; errors as of `moment_ratio`."""
        return self.moment_ratio(kind).value * self.mass * self.mean_radius**2

    def _normalised(self, published_kind: str, row: Published, kind: str, radius: float) -> MomentRatio:
        value = moment_ratios.convert_moment_ratio(row.value, row.radius, radius)
        uncertainty = moment_ratios.convert_moment_ratio(row.uncertainty, row.radius, radius)
        if published_kind != kind:
            turn = moment_ratios.mean_from_polar if kind == "mean" else moment_ratios.polar_from_mean
            value = turn(value, self.zonal_harmonic(radius))
        return MomentRatio(value, uncertainty, kind, radius, row.status, row.source)


@with_quantities()
def own_body(
    name: str, mass: float, mean_radius: float, *, synchronous: bool = False, **quantities: float
) -> SolarSystemBody:
    """Return a body that is not in the table, from its mass (kg), mean radius (m) and other quantities of the table.

    quantities: mean_moment_ratio, of that radius, j2 and c22, of the equatorial radius or else of that one,
    rotation_rate, core_density, mantle_density, crust_thickness, crust_density, ... in SI, each with name_uncertainty
    beside it where it has one; densities and crust count as assumed. synchronous: whether tides hold it in step with
    its orbit, so that they shape it, too. ValueError for another name, and for a synchronous body without a
    rotation_rate. studies.core_inversion has its core.

    >>> planet = own_body("mine", 6e24, 6.4e6, mean_moment_ratio=0.33, mean_moment_ratio_uncertainty=0.001)
    >>> print(planet.moment_ratio().value, planet.has("core_density"))
    0.33 False
    """
    if not isinstance(name, str):
        raise ValueError(f"the name of a body must be text, not {name!r:.60}")
    known_names = {quantity_name for body in solar_system().values() for quantity_name in body.published}
    for key in quantities:
        if key.removesuffix(_ERROR) not in known_names:
            near = difflib.get_close_matches(key, sorted(known_names), 1, 0.0)[0]
            raise ValueError(f"{key} is no quantity of the table of bodies; did you mean {near}?")
    for key, value in {"mass": mass, "mean_radius": mean_radius, **quantities}.items():
        known = key.endswith(_ERROR) or (np.ndim(value) == 0 and not isinstance(value, str) and np.isfinite(value))
        if not known or (key in ("mass", "mean_radius") and value <= 0):
            raise ValueError(f"{key} of {name} must be a finite number that a body can have, not {value!r:.60}")
    if synchronous and "rotation_rate" not in quantities:
        raise ValueError(f"the synchronous body {name} needs its rotation_rate, which is that of its orbit")
    values = {"gm": GRAVITATIONAL_CONSTANT * mass, "mean_radius": mean_radius, **quantities}

    of_field = values.get("equatorial_radius", mean_radius)

    def row(key: str) -> Published:
        status = "assumed" if key.startswith(("core_", "mantle_", "crust_")) else OWN
        radius = mean_radius if key in _RATIOS else of_field if key in _FIELD else math.nan
        error = values.get(f"{key}{_ERROR}", math.nan)
        note = _SYNCHRONOUS if synchronous and key == "rotation_rate" else ""
        return Published(values[key], error, "", status, True, radius, name, note)

    rows = {key: (row(key),) for key in values if not key.endswith(_ERROR)}
    return SolarSystemBody(name, MappingProxyType(rows))


@lru_cache(maxsize=1)
def solar_system() -> Mapping[str, SolarSystemBody]:
    """Return every body of the table by name, in the order of the table: Sun, planets with their moons, asteroids.

    >>> print(list(solar_system())[:4])
    ['Sun', 'Mercury', 'Venus', 'Earth']
    """
    bodies: dict[str, dict[str, list[Published]]] = {}
    for row in data_rows("planets.csv"):
        rows = bodies.setdefault(row["body"], {}).setdefault(row["quantity"], [])
        rows.insert(0 if row["use"] == "adopted" else len(rows), _published(row))
    return MappingProxyType(
        {
            name: SolarSystemBody(name, MappingProxyType({key: tuple(rows) for key, rows in quantities.items()}))
            for name, quantities in bodies.items()
        }
    )


@with_quantities()
def body(name: str) -> SolarSystemBody:
    """Return the body of this name, in upper or lower case; KeyError, which lists the names, for one not there.

    >>> print(body("Mars").moment_ratio().value > body("Earth").moment_ratio().value)  # less centrally condensed
    True
    """
    for title, body in solar_system().items():
        if title.lower() == name.lower():
            return body
    near = difflib.get_close_matches(name.title()[:64], solar_system(), 1)
    meant = f" (did you mean {near[0]}?)" if near else ""
    raise UnlistedError(f"there is no body '{name}' in the table{meant}; it has {', '.join(solar_system())}")


def _published(row: dict[str, str]) -> Published:
    scale, unit = _scale(row["unit"])
    return Published(
        value=scale * float(row["value"]),
        uncertainty=scale * float(row["uncertainty"]) / float(row["sigmas"]) if row["uncertainty"] else math.nan,
        unit=unit,
        status=row["status"],
        adopted=row["use"] == "adopted",
        radius=1e3 * float(row["radius_km"]) if row["radius_km"] else math.nan,
        source=row["source"],
        note=row["note"],
    )


@lru_cache(maxsize=32)
def _scale(unit: str) -> tuple[float, str]:
    if unit == "1":
        return 1.0, "1"
    if unit == "deg":
        return math.radians(1.0), "rad"
    if unit == "deg/d":
        return _TURN_PER_DAY / 360.0, "rad s-1"
    if unit == "km3/s2":
        return 1e9, "m3 s-2"
    return {"km": (1e3, "m"), "kg/m3": (1.0, "kg m-3")}[unit]
