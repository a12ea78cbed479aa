"""Composite polytropes: a core of one index inside an envelope of another, with a jump of mean molecular weight.

Pressure, temperature and enclosed mass are continuous at the interface, so that the density falls there by the ratio
of the mean molecular weights, envelope over core. Each zone is integrated in its own t, density ~ t^(4 n), from the
centre to the surface; nothing is matched, and only the place of the interface is searched for where it is not given by
its pressure.

Sources: Milne 1930, MNRAS 91, 4; Chandrasekhar 1939, An Introduction to the Study of Stellar Structure, ch. IV;
Rappaport, Verbunt & Joss 1983, ApJ 275, 713; Beech 1988, Ap&SS 147, 219. Tests:
tests/unit/bodies/test_composite_polytrope.py.
"""

import math
from dataclasses import dataclass

import numpy as np

from astroinertia.bodies.apsidal import (
    CORE_START,
    DEGREES,
    ROUND_OFF,
    Zone,
    core_zone,
    integrate_zone,
    love_from_complement,
)
from astroinertia.bodies.polytrope import central_series, hermite
from astroinertia.errors import NumericalError
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

_NODES = 513  # in each zone, for the profiles
_SCAN = 33  # places of the interface tried before one is refined
_TOP = 1e-3  # smallest t of an interface that is searched for: pressures down to 1e-12 of the central one
_TOP_OF_HALO = 0.05  # the same for cores without a surface of their own: 3e5 units of length out where n = 5
_CONDENSED = 4.0  # index of a core from which on the solution has such a halo
_EDGE = 1e-3  # of the angle pi/2 that these places leave out at the centre
_ROUGH = 1e-7  # relative tolerance of the search before it is refined
_PLACE = 1e-15  # relative tolerance of t at the interface


@dataclass(frozen=True, eq=False)
class CompositePolytrope:
    """A star or planet of two polytropic zones with a given mass and radius, in units with the given G.

    weight_ratio: mean molecular weight of the envelope over that of the core. Made by `composite_polytrope`.
    """

    core_index: float
    envelope_index: float
    weight_ratio: float
    mass: float
    radius: float
    gravitational_constant: float
    core: Zone
    envelope: Zone

    @property
    def core_radius_fraction(self) -> float:
        """Radius of the interface over that of the surface."""
        return float(self.core.r[-1] / self.envelope.r[-1])

    @property
    def core_mass_fraction(self) -> float:
        """Mass inside the interface over the whole mass."""
        return float(self.core.mass[-1] / self.envelope.mass[-1])

    @property
    def interface_pressure_ratio(self) -> float:
        """Pressure at the interface over that at the centre."""
        return float(self.core.t[-1] ** (4 * (self.core_index + 1)))

    @property
    def central_to_mean(self) -> float:
        """Central density over the mean density."""
        return float(self.envelope.r[-1] ** 3 / (3 * self.envelope.mass[-1]))

    @property
    def moment_ratio(self) -> float:
        """I/(M R^2), R the radius of the surface."""
        return float(2 * self.envelope.moment[-1] / (3 * self.envelope.mass[-1] * self.envelope.r[-1] ** 2))

    @property
    def moment_of_inertia(self) -> float:
        """I about any axis through the centre."""
        return self.moment_ratio * self.mass * self.radius**2

    @property
    def gravitational_energy(self) -> float:
        """W, the integral of -G m dm/r."""
        share = self.envelope.binding[-1] * self.envelope.r[-1] / self.envelope.mass[-1] ** 2
        return float(-share * self._energy_unit)

    @property
    def virial_energy(self) -> float:
        """-3 times the volume integral of the pressure: W by the virial theorem, from another integral."""
        share = 3 * self.envelope.volume_work[-1] * self.envelope.r[-1] / self.envelope.mass[-1] ** 2
        return float(-share * self._energy_unit)

    @property
    def _energy_unit(self) -> float:
        return self.gravitational_constant * self.mass**2 / self.radius

    @property
    def central_density(self) -> float:
        """Density at the centre."""
        return self.central_to_mean * 3 * self.mass / (4 * math.pi * self.radius**3)

    @property
    def central_pressure(self) -> float:
        """Pressure at the centre: 4 pi G rho_c^2 (unit of length)^2/(n + 1)."""
        length = self.radius / self.envelope.r[-1]
        scale = 4 * math.pi * self.gravitational_constant * self.central_density**2 * length**2
        return float(scale / (self.core_index + 1))

    def love_number(self, degree: int = 2) -> float:
        """The fluid Love number k_l, l from 2 to 8; ValueError for another degree."""
        if degree not in DEGREES:
            raise ValueError(f"Love numbers of composite polytropes are known for degrees 2 to 8, not {degree!r}")
        return float(love_from_complement(self.envelope.delta[DEGREES.index(degree), -1], degree))

    def apsidal_constant(self, degree: int = 2) -> float:
        """The apsidal constant k_l/2, l from 2 to 8."""
        return self.love_number(degree) / 2

    @with_quantities(r="m")
    def density(self, r) -> np.ndarray:
        """Density at radius r, that of the envelope at the interface, zero outside; to 1e-9 of the central one."""
        inside, theta, outside, share = self._thetas(r)
        envelope = self.weight_ratio * self.core.t[-1] ** (4 * self.core_index) * share**self.envelope_index
        return self.central_density * np.where(inside, theta**self.core_index, np.where(outside, 0.0, envelope))

    @with_quantities(r="m")
    def pressure(self, r) -> np.ndarray:
        """Pressure at radius r, zero outside; to 1e-9 of the central one."""
        inside, theta, outside, share = self._thetas(r)
        envelope = self.interface_pressure_ratio * share ** (self.envelope_index + 1)
        within = np.where(inside, theta ** (self.core_index + 1), np.where(outside, 0.0, envelope))
        return self.central_pressure * within

    @with_quantities(r="m")
    def enclosed_mass(self, r) -> np.ndarray:
        """Mass inside radius r; to 1e-9 of the whole."""
        at = np.asarray(r, dtype=float) / self.radius * self.envelope.r[-1]
        masses = []
        for zone, scale in ((self.core, 1.0), (self.envelope, self._envelope_density)):
            slopes = scale * zone.t ** (4 * zone.index) * zone.r**2
            masses.append(hermite(zone.r, zone.mass, slopes, np.clip(at, zone.r[0], zone.r[-1])))
        centre = at**3 / 3
        total = self.envelope.mass[-1]
        inner = np.where(at < CORE_START, centre, np.where(at < self.core.r[-1], masses[0], masses[1]))
        return self.mass * inner / total

    @property
    def _envelope_density(self) -> float:
        return float(self.weight_ratio * self.core.t[-1] ** (4 * self.core_index))

    def _thetas(self, r):
        """Inside the core?, theta there, outside the surface?, and the enthalpy of the envelope over its largest."""
        at = np.abs(np.asarray(r, dtype=float)) / self.radius * self.envelope.r[-1]
        top = _envelope_enthalpy(self.core_index, self.envelope_index, self.core.t[-1], self.weight_ratio)
        values = []
        for zone, scale in ((self.core, 1.0), (self.envelope, top)):
            slopes = -zone.mass / zone.r**2 / scale
            values.append(hermite(zone.r, zone.t**4, slopes, np.clip(at, zone.r[0], zone.r[-1])))
        theta = np.where(at < CORE_START, 1 - at**2 / 6, values[0])
        return at < self.core.r[-1], np.clip(theta, 0.0, 1.0), at >= self.envelope.r[-1], np.clip(values[1], 0.0, 1.0)


def _envelope_enthalpy(core_index: float, envelope_index: float, t: float, weight_ratio: float) -> float:
    """(n + 1) P/rho at the bottom of the envelope, in units of the centre's."""
    return (envelope_index + 1) / (core_index + 1) * t**4 / weight_ratio


def _zones(
    indices: tuple[float, float],
    weight_ratio: float,
    t: float,
    nodes: int = 2,
    degrees: tuple[int, ...] = (),
    tolerance: float = ROUND_OFF,
) -> tuple[Zone, Zone]:
    core = core_zone(indices[0], t, nodes, degrees, tolerance)
    density = weight_ratio * t ** (4 * indices[0])
    enthalpy = _envelope_enthalpy(*indices, t, weight_ratio)
    above = np.linspace(1.0, 0.0, nodes)
    return core, integrate_zone(indices[1], density, enthalpy, core.end, above, degrees, tolerance)


@with_quantities()
def composite_polytrope(
    core_index: float,
    envelope_index: float,
    *,
    radius_fraction: float | None = None,
    mass_fraction: float | None = None,
    pressure_ratio: float | None = None,
    weight_ratio: float = 1.0,
    mass: float = 1.0,
    radius: float = 1.0,
    gravitational_constant: float = 1.0,
) -> CompositePolytrope:
    """Return the composite polytrope whose interface lies at the given radius, mass or pressure, one of the three.

    radius_fraction and mass_fraction: core over whole; pressure_ratio: interface over centre; all in (0, 1).
    weight_ratio: mean molecular weight of the envelope over that of the core: the density falls by it. The core's
    index is 0 or more (5 and above, too), the envelope's 0 <= n < 5. Love numbers, W and moments are accurate to 1e-13.
    ValueError for other arguments, for fractions that no interface has, and for fractions that several have (give the
    pressure then: with a heavy core the mass fraction has a maximum, Schoenberg & Chandrasekhar 1942); NumericalError
    where the envelope has no surface. Source: module text.

    >>> print(f"{composite_polytrope(1.5, 1.5, radius_fraction=0.5).moment_ratio:.6f}")  # of one kind: 0.204600
    0.204600
    """
    options = {"radius_fraction": radius_fraction, "mass_fraction": mass_fraction, "pressure_ratio": pressure_ratio}
    chosen = {name: float(value) for name, value in options.items() if value is not None}
    if len(chosen) != 1:
        raise ValueError("the interface needs one of radius_fraction, mass_fraction and pressure_ratio")
    ((name, wanted),) = chosen.items()
    if not 0 < wanted < 1:
        raise ValueError(f"{name} must lie between 0 and 1, not {wanted!r}")
    if not 0 <= core_index < math.inf:
        raise ValueError(f"the core needs a finite index of 0 or more, not {core_index}")
    if not 0 <= envelope_index < 5:
        raise ValueError(f"an envelope of finite radius needs an index 0 <= n < 5, not {envelope_index}")
    require_positive(weight_ratio=weight_ratio)
    indices = (float(core_index), float(envelope_index))
    if name == "pressure_ratio":
        t = wanted ** (0.25 / (core_index + 1))
    else:
        t = _interface(indices, weight_ratio, name, wanted)
    if t >= _innermost(indices[0]):
        raise ValueError(f"the core is smaller than {CORE_START:g} units of length of Lane-Emden's equation")
    core, envelope = _zones(indices, weight_ratio, t, _NODES, DEGREES)
    require_positive(mass=mass, radius=radius, gravitational_constant=gravitational_constant)
    return CompositePolytrope(*indices, weight_ratio, mass, radius, gravitational_constant, core, envelope)


def _innermost(core_index: float) -> float:
    return float(central_series(core_index, CORE_START)[0]) ** 0.25


def _interface(indices: tuple[float, float], weight_ratio: float, name: str, wanted: float) -> float:
    """The t of the interface at which a fraction has the wanted value."""

    def excess(t: float, tolerance: float) -> float:
        core, envelope = _zones(indices, weight_ratio, t, tolerance=tolerance)
        part, whole = (core.r, envelope.r) if name == "radius_fraction" else (core.mass, envelope.mass)
        return float(part[-1] / whole[-1]) - wanted

    # far out in the halo of a condensed core the envelope hangs on differences that only full accuracy can tell
    top = _TOP_OF_HALO if indices[0] >= 5 else _TOP
    tolerance = ROUND_OFF if indices[0] > _CONDENSED else _ROUGH
    places = top + (_innermost(indices[0]) - top) * np.sin(np.linspace(0.0, np.pi / 2 - _EDGE, _SCAN))
    gaps = np.array([excess(t, tolerance) for t in places])
    changes = np.flatnonzero(gaps[:-1] * gaps[1:] <= 0)
    if len(changes) != 1:
        count = "no interface has" if len(changes) == 0 else f"{len(changes)} interfaces have"
        raise ValueError(
            f"{count} {name} = {wanted:g}, with fractions from {wanted + gaps.min():.3g} to {wanted + gaps.max():.3g}"
            + (": give the pressure" if len(changes) else "")
        )
    low, high = map(float, places[changes[0] : changes[0] + 2])
    rough = root_between(lambda t: excess(t, tolerance), low, high, relative=_ROUGH)
    for margin in (100 * _ROUGH, np.inf):
        near = max(low, rough - margin), min(high, rough + margin)
        if excess(near[0], ROUND_OFF) * excess(near[1], ROUND_OFF) <= 0:
            return root_between(lambda t: excess(t, ROUND_OFF), *near, _PLACE, _PLACE)
    raise NumericalError(f"no interface was found with {name} = {wanted:g}")
