"""Rotating stars and rings: what follows from a self-consistent field, and the members of their sequences.

Sequences run from the sphere at rest to mass shedding (where the equator turns as fast as an orbit) or to where the
surface is torn into a ring, by the ratio of polar to equatorial radius; a member may be asked for by that ratio or by
any other quantity. Source: Hachisu 1986, ApJS 61, 479. Tests: tests/unit/bodies/test_scf.py,
tests/hard/test_scf_hard.py.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

from astroinertia.bodies.equilibrium_figure import EquilibriumFigure
from astroinertia.bodies.rotation_laws import RIGID, Law
from astroinertia.bodies.scf import Field, Resolution, check_field, solve_field
from astroinertia.bodies.scf_mesh import even_legendre
from astroinertia.errors import NumericalError
from astroinertia.matter.barotropes import ScaledLaw
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

RESOLUTIONS = (Resolution(8, 48, 48), Resolution(24, 96, 96))  # the second where the first does not do
_RAYS, _CELLS = 32, 400  # from the centre to the equatorial radius (to a ring more: some just touch it); their pieces
_STEP = 0.1  # of the axis ratio from member to member of a sequence
_VIRIAL_ERROR = 1e-3  # the largest that is accepted, where matter has kinks or is narrower than the elements
_FLATTEST = 0.05  # axis ratio to which sequences are followed
_CLOSEST = 1e-9  # of the axis ratio, to which mass shedding is found
_BY_TRIAL = 1e-5  # the same for other ends
ROUGHLY = 1e-3  # how closely those are sought where a value lies far beyond
_BEYOND = 1.1  # of what a property gains from rest to the end so found: values up to here are sought by the end itself
_PROPERTIES = {
    "spin": "angular_velocity", "period": "angular_velocity", "breakup_fraction": "keplerian_fraction",
    "t_over_w": "rotational_to_gravitational", "angular_momentum": "angular_momentum",
}  # fmt: skip


@dataclass(frozen=True)
class _Cells:
    """Pieces of rays through a star: the lowest and the highest level in each, its volume and its mass, (K,)."""

    low: np.ndarray
    high: np.ndarray
    volume: np.ndarray
    mass: np.ndarray

    def share_above(self, level: float) -> np.ndarray:
        """The share of each that lies above a level, (K,)."""
        return np.clip((self.high - level) / np.maximum(self.high - self.low, 1e-300), 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class RotatingStar(EquilibriumFigure):
    """A star, or ring, of given mass and equatorial (outer) radius, in units with the given G.

    Radii of the quantities with a radius in their definition are said by their names; `angular_velocity` is that on the
    axis. All numbers are in the units of mass, equatorial_radius and gravitational_constant.
    """

    field: Field = field(repr=False)
    mass: float = 1.0
    equatorial_radius: float = 1.0
    gravitational_constant: float = 1.0

    @property
    def max_density(self) -> float:
        """The largest density: at the centre, unless the rotation law digs a hollow there."""
        return self.mass / (4 * math.pi * self.field.exterior[0] * self.equatorial_radius**3)

    @property
    def max_enthalpy(self) -> float:
        """The largest enthalpy, int dP/rho."""
        return self.field.peak * self.gravitational_constant * self.max_density * self.equatorial_radius**2

    @property
    def max_pressure(self) -> float:
        """The largest pressure."""
        return self.max_density * self.max_enthalpy * float(self.field.matter.pressure(np.array(1.0)))

    @property
    def polar_radius(self) -> float:
        """Radius of the pole; 0 for a ring."""
        return max(self.field.axis_ratio, 0.0) * self.equatorial_radius

    @property
    def inner_radius(self) -> float:
        """Inner radius of a ring; 0 for a star."""
        return max(-self.field.axis_ratio, 0.0) * self.equatorial_radius

    @cached_property
    def mean_radius(self) -> float:
        """Radius of the sphere of the same volume."""
        core = 0.0 if self.inner_radius else self.polar_radius / self.equatorial_radius
        split, field = self.field.mesh.split, self.field
        shell = float(field.mesh.volume_weight[split:] @ field.weight[split:].sum(axis=1))
        return self.equatorial_radius * (core**3 + 3 * shell) ** (1 / 3)

    @property
    def angular_velocity(self) -> float:
        """Omega_0, on the axis (which a ring does not reach)."""
        return math.sqrt(self.field.rate_squared * self.gravitational_constant * self.max_density)

    @property
    def rotation_law(self) -> Law:
        """The law with its scale in the star's unit of length."""
        return self.field.law.scaled(self.equatorial_radius)

    @property
    def rotation_parameter(self) -> float:
        """Omega^2 a^3/(G M) with the angular velocity and radius a of the equator."""
        rate = self.angular_velocity * float(self.field.law.rate(1.0))
        return rate**2 * self.equatorial_radius**3 / (self.gravitational_constant * self.mass)

    @property
    def small_m(self) -> float:
        """Omega^2 R_mean^3/(G M) with the angular velocity of the equator."""
        return self.rotation_parameter * (self.mean_radius / self.equatorial_radius) ** 3

    @property
    def keplerian_fraction(self) -> float:
        """Angular velocity of the equator over that of an orbit there, in the star's own field: 1 at mass shedding.

        W of Rivinius, Carciofi & Martayan 2013, A&ARv 21, 69; not Omega over that of the star that sheds mass.
        """
        spin = self.field.rate_squared * float(self.field.law.rate(1.0)) ** 2
        return math.sqrt(spin / (spin - self.field.equatorial_gravity))

    @cached_property
    def gravitational_energy(self) -> float:
        """W, negative: half the integral of rho phi."""
        field = self.field
        energy = 2 * math.pi * float(field.mesh.volume_weight @ (field.moments * field.phi).sum(axis=1))
        return energy * self._energy_unit

    @cached_property
    def kinetic_energy(self) -> float:
        """T, of the rotation."""
        return 2 * math.pi * self._integral(lambda w, rate: (w * rate) ** 2) * self._energy_unit

    @cached_property
    def pressure_integral(self) -> float:
        """Volume integral of the pressure, (gamma - 1) times the internal energy of a gas."""
        field = self.field
        pressure = (field.weight * field.matter.pressure(field.level)).sum(axis=1)
        return 4 * math.pi * field.peak * float(field.mesh.volume_weight @ pressure) * self._energy_unit

    @property
    def virial_error(self) -> float:
        """|2T + W + 3 int P dV|/|W|: the error of radial and angular quadrature (not of the harmonics left out)."""
        total = 2 * self.kinetic_energy + self.gravitational_energy + 3 * self.pressure_integral
        return abs(total / self.gravitational_energy)

    @cached_property
    def angular_momentum(self) -> float:
        """L, about the axis."""
        value = 4 * math.pi * self._integral(lambda w, rate: w**2 * rate)
        density, radius = self.max_density, self.equatorial_radius
        return value * math.sqrt(self.gravitational_constant * density) * density * radius**5

    @cached_property
    def polar_moment(self) -> float:
        """C, about the axis."""
        return 8 * math.pi / 3 * self._moment(1.0, -1.0)

    @cached_property
    def equatorial_moment(self) -> float:
        """A, about a line in the equator."""
        return 8 * math.pi / 3 * self._moment(1.0, 0.5)

    @property
    def mean_moment(self) -> float:
        """(2A + C)/3."""
        return (2 * self.equatorial_moment + self.polar_moment) / 3

    @property
    def zonal_harmonics(self) -> np.ndarray:
        """J2, J4, ... with the equatorial radius, as many as the field has."""
        return -self.field.exterior[1:] / self.field.exterior[0]

    @with_quantities(w="m", z="m")
    def level(self, w, z) -> np.ndarray:
        """Enthalpy over its maximum at distance w from the axis and height z; negative outside, -1 beyond the equator.

        Interpolated: to about 1e-8.
        """
        field = self.field
        w, z = np.broadcast_arrays(np.asarray(w, dtype=float), np.asarray(z, dtype=float))
        r = np.hypot(w, z).ravel() / self.equatorial_radius
        mu = np.abs(z).ravel() / np.maximum(r * self.equatorial_radius, 1e-300)
        phi = field.mesh.interpolated(field.phi, np.clip(r, field.mesh.edges[0], 1.0))
        table = even_legendre(np.minimum(mu, 1.0), int(field.mesh.degrees[-1]))
        psi = field.law.potential(w.ravel() / self.equatorial_radius)
        level = (field.constant - np.einsum("nl,ln->n", phi, table) + field.rate_squared * psi) / field.peak
        outside = (r > 1) | (r < field.mesh.edges[0])
        return np.where(outside, -1.0, level).reshape(w.shape)

    @with_quantities(w="m", z="m")
    def density(self, w, z) -> np.ndarray:
        """Density at distance w from the axis and height z, zero outside."""
        return self.max_density * self.field.matter.density(self.level(w, z))

    @with_quantities(w="m", z="m")
    def pressure(self, w, z) -> np.ndarray:
        """Pressure at distance w from the axis and height z, zero outside."""
        return self.max_density * self.max_enthalpy * self.field.matter.pressure(self.level(w, z))

    @with_quantities(w="m")
    def rotation_rate(self, w) -> np.ndarray:
        """Omega at distance w from the axis."""
        return self.angular_velocity * self.rotation_law.rate(w)

    def level_enclosing(self, fraction: float) -> float:
        """The enthalpy over its maximum above which a fraction of the mass lies; the radius there to some 1e-5."""
        mass = self._cells.mass

        def beyond(level: float) -> float:
            return float(self._cells.share_above(level) @ mass) - fraction * total

        total = float(self._cells.share_above(0.0) @ mass)
        return root_between(beyond, 0.0, 1.0, 1e-12) if 0 < fraction < 1 else float(fraction <= 0)

    def mean_radius_enclosing(self, fraction: float) -> float:
        """Radius of the sphere as large as what lies above `level_enclosing`; to some 1e-5 (of a ring 1e-4)."""
        size = self._cells.share_above(self.level_enclosing(fraction)) @ self._cells.volume
        return self.equatorial_radius * float(3 * size) ** (1 / 3)

    @cached_property
    def _cells(self) -> "_Cells":
        nodes, weights = np.polynomial.legendre.leggauss(_RAYS if self.polar_radius else 8 * _RAYS)
        cosine, radius = 0.5 + 0.5 * nodes, np.linspace(0.0, 1.0, _CELLS + 1)[:, None]
        level = self.level(radius * self.equatorial_radius * np.sqrt(1 - cosine**2),
                           radius * self.equatorial_radius * cosine)  # fmt: skip
        low, high = np.minimum(level[1:], level[:-1]).ravel(), np.maximum(level[1:], level[:-1]).ravel()
        volume = (0.5 * weights * np.diff(radius**3, axis=0) / 3).ravel()
        density = self.field.matter.density(np.maximum(0.5 * (np.maximum(low, 0.0) + high), 0.0))
        return _Cells(low, high, volume, volume * density)

    @property
    def _energy_unit(self) -> float:
        return self.gravitational_constant * self.max_density**2 * self.equatorial_radius**5

    def _integral(self, of: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> float:
        # Of rho times a function of w and Omega over 0 < mu < 1 and r^2 dr.
        field = self.field
        w = field.mesh.radius[:, None] * np.sqrt(1 - field.cosine**2)
        rate = math.sqrt(field.rate_squared) * field.law.rate(w)
        shells = (field.weight * field.matter.density(field.level) * of(w, rate)).sum(axis=1)
        return float(field.mesh.volume_weight @ shells)

    def _moment(self, radial: float, quadrupole: float) -> float:
        field = self.field
        shells = (radial * field.moments[:, 0] + quadrupole * field.moments[:, 1]) * field.mesh.radius**2
        return float(field.mesh.volume_weight @ shells) * self.max_density * self.equatorial_radius**5


@with_quantities()
def rotating_star(
    matter: ScaledLaw,
    axis_ratio: float,
    law: Law = RIGID,
    mass: float = 1.0,
    equatorial_radius: float = 1.0,
    gravitational_constant: float = 1.0,
    resolution: Resolution | None = None,
) -> RotatingStar:
    """Return the star with polar/equatorial radius axis_ratio in (0, 1], or the ring with -inner/outer radius.

    The scale of the law is in equatorial radii. Matter with a density of its own decides mass and radius itself.
    ValueError on bad arguments; NumericalError where there is no such body, or none that 96 harmonics resolve.
    Source: Hachisu 1986, ApJS 61, 479. Test: tests/unit/bodies/test_scf.py.

    >>> from astroinertia.matter.barotropes import polytropic_matter
    >>> print(f"{rotating_star(polytropic_matter(1.5), 0.8).rotational_to_gravitational:.4f}")
    0.0375
    """
    require_positive(mass=mass, equatorial_radius=equatorial_radius, gravitational_constant=gravitational_constant)
    field = _field(matter, axis_ratio, law, resolution)
    check_field(field)
    if (error := RotatingStar(field).virial_error) > _VIRIAL_ERROR:
        star = f"a {matter.name} with axis ratio {axis_ratio:g} and {law.kind} rotation"
        raise NumericalError(f"{star} is not resolved: its virial theorem is off by {error:.2g}")
    if matter.max_density is None or matter.max_enthalpy is None:
        return RotatingStar(field, mass, equatorial_radius, gravitational_constant)
    radius = math.sqrt(matter.max_enthalpy / (field.peak * gravitational_constant * matter.max_density))
    mass = 4 * math.pi * float(field.exterior[0]) * matter.max_density * radius**3
    return RotatingStar(field, mass, radius, gravitational_constant)


def _field(matter: ScaledLaw, axis_ratio: float, law: Law, resolution: Resolution | None) -> Field:
    field = _sought(matter, axis_ratio, law, resolution)
    if isinstance(field, str):
        raise NumericalError(field)
    return field


@lru_cache(maxsize=64)  # stars of one sequence are sought by way of the same ones, and what is none takes longest
def _sought(matter: ScaledLaw, axis_ratio: float, law: Law, resolution: Resolution | None) -> Field | str:
    """The field, or why there is none."""
    choices = RESOLUTIONS if resolution is None else (resolution,)
    try:
        field = solve_field(matter, axis_ratio, law, choices[0])
        fine = field.resolved and RotatingStar(field).virial_error < _VIRIAL_ERROR / 10
        if fine or field.equatorial_gravity >= 0:  # finer harmonics do not bind what sheds mass
            return field
        return solve_field(matter, axis_ratio, law, choices[-1])
    except NumericalError as error:
        return str(error)


@with_quantities()
def end_of_sequence(
    matter: ScaledLaw, law: Law = RIGID, resolution: Resolution | None = None, within: float = _BY_TRIAL, **scale: float
) -> RotatingStar:
    """Return the flattest star of a sequence: at mass shedding (keplerian_fraction 1 to 1e-8), or before it is torn.

    within: of the axis ratio, how closely an end is sought that only trial finds; mass shedding is always found to
    1e-9. `scale` is mass, equatorial_radius and gravitational_constant. Sequences that become flatter than an axis
    ratio of 1/20, or than 96 harmonics can resolve (a liquid at 0.22), are followed to there.
    Test: tests/hard/test_scf_hard.py.
    """
    return _march(lambda star: -1.0, matter, law, resolution, within, scale)[0]


@with_quantities(value="SI")
def rotating_star_with(
    quantity: str, value: float, matter: ScaledLaw, law: Law = RIGID, resolution: Resolution | None = None,
    **scale: float,
) -> RotatingStar:  # fmt: skip
    """Return the first star, from rest on, of which a property has a value, as ("t_over_w", 0.1) or ("spin", 0.5).

    `quantity` is spin (the angular velocity on the axis), period (of that), breakup_fraction (keplerian_fraction, below
    1), t_over_w, angular_momentum or axis_ratio, or the name of another number of RotatingStar that rotation makes
    larger; in units of mass, equatorial_radius and gravitational_constant (`scale`). ValueError for a value that none
    can have and for another quantity; NumericalError, with the limit, where the sequence ends before.
    Test: tests/unit/bodies/test_scf.py.

    >>> from astroinertia.matter.barotropes import polytropic_matter
    >>> print(f"{rotating_star_with('breakup_fraction', 0.8, polytropic_matter(1.5)).field.axis_ratio:.4f}")
    0.7041
    """
    if quantity == "axis_ratio":
        return rotating_star(matter, value, law, resolution=resolution, **scale)
    at_rest = rotating_star(matter, 1.0, law, resolution=resolution, **scale)
    name = _PROPERTIES.get(quantity, quantity)
    if not isinstance(getattr(at_rest, name, None), float):
        raise ValueError(f"quantity must be one of axis_ratio, {', '.join(_PROPERTIES)}, not {quantity!r}")

    shown = _period if quantity == "period" else float
    wanted = shown(value)

    def excess(star: RotatingStar) -> float:
        return getattr(star, name) - wanted

    if not math.isfinite(wanted) or excess(at_rest) > 1e-12 * max(abs(wanted), 1e-300):
        limit = "positive" if quantity == "period" else f"finite and at least {getattr(at_rest, name):g}"
        raise ValueError(f"{quantity} must be {limit}, not {value}")
    star, bracket, end = _march(excess, matter, law, resolution, ROUGHLY, scale)
    if bracket is None and -excess(at_rest) < _BEYOND * (excess(star) - excess(at_rest)):
        star, bracket, end = _march(excess, matter, law, resolution, _BY_TRIAL, scale)
    if bracket is None:
        most = f"down to axis ratio {star.field.axis_ratio:.5g} it reaches {shown(getattr(star, name)):.6g}"
        message = f"no {matter.name} with {law.kind} rotation was found with a {quantity} of {value:g}: {most}"
        raise NumericalError(f"{message}, and {end}" if end else message)

    def at(ratio: float) -> float:
        return excess(rotating_star(matter, ratio, law, resolution=resolution, **scale))

    root = root_between(at, *bracket, 1e-13, 1e-12)
    return rotating_star(matter, root, law, resolution=resolution, **scale)


def _period(spin: float) -> float:
    """The period of a spin, or the spin of a period."""
    return 2 * math.pi / spin if spin else math.inf


def _march(
    excess: Callable[[RotatingStar], float], matter: ScaledLaw, law: Law, resolution: Resolution | None, within: float,
    units: dict[str, float],
) -> tuple[RotatingStar, tuple[float, float] | None, str]:  # fmt: skip
    """Follow a sequence until `excess` is positive or it ends: the last star, axis ratios about the root, and why."""

    def member(ratio: float) -> RotatingStar:
        return rotating_star(matter, ratio, law, resolution=resolution, **units)

    star = member(1.0)
    while star.field.axis_ratio > _FLATTEST:
        above = star.field.axis_ratio
        below = max(above - _STEP, _FLATTEST)
        try:
            flatter = member(below)
        except NumericalError as error:
            star = member(_end(member, matter, law, resolution, within, above, below))
            return star, (star.field.axis_ratio, above) if excess(star) >= 0 else None, str(error)
        star = flatter
        if excess(star) >= 0:
            return star, (below, above), ""
    return star, None, ""


def _end(member, matter, law, resolution, within: float, good: float, bad: float) -> float:
    """The smallest axis ratio between a good and a bad one that is a body: by its gravity, else by trial."""

    def gravity(ratio: float) -> float:
        return _field(matter, ratio, law, resolution).equatorial_gravity

    sheds = True
    while good - bad > within:
        try:
            if sheds and gravity(good) < 0 < gravity(bad):
                sheds = False  # unless this is how it ends
                root = root_between(gravity, bad, good, _CLOSEST / 10)
                member(root + _CLOSEST)
                return root + _CLOSEST
        except NumericalError:
            pass  # torn before it sheds mass, or not converging beyond
        middle = 0.5 * (good + bad)
        try:
            member(middle)
            good = middle
        except NumericalError:
            bad = middle
    return good
