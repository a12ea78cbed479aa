"""The precession of any body by its companions, from the torques on its flattening: numbers of your own, a Dataset out.

Heavier companions are what the body goes around; lighter ones go around it. A torque of the former turns the spin about
the pole of the orbit, and that of the latter about the poles of their mean orbits (Laplace planes), which lie between
the equator and the body's own orbit and precess with the spin: near moons stay with the equator and add to the
flattening, far ones stay with the orbit and act as the star does (Goldreich 1966, Rev. Geophys. 4, 411; Ward & Hamilton
2004, AJ 128, 2501; Tremaine, Touma & Namouni 2009, AJ 137, 3706). With s, n and k the unit vectors of spin, of a moon's
mean orbit and of the body's orbit in one plane, at angles theta, phi and 0 from k, and the common rate Omega,

    C omega Omega sin(theta) = A_0 cos(theta) sin(theta) + sum A cos(theta - phi) sin(theta - phi),
    L Omega sin(phi) = B cos(phi) sin(phi) - A cos(theta - phi) sin(theta - phi)
                       - sum over other moons of D cos(phi' - phi) sin(phi' - phi)        for each moon,

A = (3/2) (C - A) G m/(a^3 (1 - e^2)^(3/2)), B = (3/4) m a^2 (1 + 3 e^2/2) G M_0/(a_0^3 (1 - e_0^2)^(3/2)),
L = m a^2 n (1 - e^2)^(1/2), and D of two moons as B, of the outer one on the inner, times b_(3/2)^(1)(r)/(3 r) for the
ratio r of their axes, by which two rings in nearly one plane turn each other more strongly than far ones (Murray &
Dermott 1999, Solar System Dynamics, (7.11)).
Averages over orbits, over the nodes of inclined ones and over the pericentres of eccentric moons.
"""

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import xarray as xr

from astroinertia.dataset.variables import variables
from astroinertia.errors import NumericalError, SceneError
from astroinertia.process.roots import root_between
from astroinertia.rotation.precession import geodetic_precession_of_binary, node_nutation
from astroinertia.rotation.secular_orbits import laplace_coefficient
from astroinertia.units import GRAVITATIONAL_CONSTANT, quantity, shown, with_unit, written_quantity

_ROUNDS, _SETTLED = 1000, 1e-13
_HELD = {"as": 1.0, "3/2 times as": 1.5}  # turns an orbit of the spins that orbits are known to hold
_IN_STEP = 1e-3  # of a rate: no farther from such a spin, which is given to a few digits, a body is held
_MOST_OBLATE = 0.5  # (C - A)/C, as A + B is at least C, that of a flat disc
_UPRIGHT = 1e-6  # rad: a smaller obliquity has the rate of this one
_KEYS = ("name", "mass", "semi_major_axis", "period", "eccentricity", "inclination", "node_period")


class _Orbit(NamedTuple):
    name: str
    mass: float
    semi_major_axis: float
    eccentricity: float
    inclination: float
    node_period: float

    @property
    def kept(self) -> float:
        """What the inclination to the mean plane leaves of a torque on or by the orbit as the node turns."""
        return 1.0 - 1.5 * math.sin(self.inclination) ** 2

    @property
    def tide(self) -> float:
        """G m/(a^3 (1 - e^2)^(3/2)), and what is kept of it."""
        whole = GRAVITATIONAL_CONSTANT * self.mass / self.semi_major_axis**3 / (1 - self.eccentricity**2) ** 1.5
        return whole * self.kept

    @property
    def spread(self) -> float:
        """m a^2 (1 + 3 e^2/2): m r^2 averaged over the orbit, on which others act; and what is kept of it."""
        return self.mass * self.semi_major_axis**2 * (1.0 + 1.5 * self.eccentricity**2) * self.kept


def precession_of(
    mass: Any,
    radius: Any,
    j2: float | None,
    period: Any,
    obliquity: Any,
    companions: Sequence[Mapping[str, Any]],
    moment_ratio: float | None = None,
    polar_moment: Any = None,
    dynamical_ellipticity: float | None = None,
) -> xr.Dataset:
    """Return the rate at which the equator's node goes back on the orbit's plane, and the share of each companion.

    mass, radius (that of J2), period of rotation and obliquity (to the orbit about the heaviest companion) of the body,
    two of J2, H = (C - A)/C, and C/(M R^2) or C. companions: tables of `name`, `mass`, `semi_major_axis` or `period`,
    and maybe `eccentricity`, `inclination` (to the body's orbit of what it goes around; of moons, to their mean planes)
    and `node_period`, in which its node goes back once. Texts with units, astropy Quantities, or numbers in SI and rad.
    Along `companion`: `precession_rate` (rad s-1, positive where the node goes back), `tilt` of its mean orbit to the
    equator (rad), and the amplitudes `nutation_longitude` and `nutation_obliquity` (rad) of the nutation with its node,
    NaN where that does not turn, and in longitude for an obliquity of 0. Then `relativity` of the orbit, `total_rate`
    and `total_period`, and the `dynamical_ellipticity` and `moment_ratio` of the body. SceneError, in a sentence, for
    what is no such number, and for a body that turns in step with a companion's orbit, as the Moon and Mercury do.
    Checked by tests/unit/studies/test_own_precession.py against published rates of Saturn, Mars and the Earth.

    >>> sun = {"name": "Sun", "mass": "1 Msun", "period": "365.25636 d", "eccentricity": 0.0167}
    >>> earth = precession_of("1 Mearth", "6378.1366 km", 1.08263e-3, "86164.1 s", "23.44 deg", [sun], 0.33070)
    >>> print(f"{float(earth.total_rate) * 206264.8 * 3.15576e7:.2f}")  # arcsec a year, without a Moon
    15.93
    """
    m, r = _number("mass", mass, "mass", 0.0), _number("radius", radius, "length", 0.0)
    rate = 2.0 * math.pi / _number("period", period, "time", 0.0)
    theta = _number("obliquity", obliquity, "angle", -1e-300)
    if theta > math.pi:
        raise SceneError("precession_of: obliquity must be at most 180 deg")
    polar, bulge = _moments(m * r**2, j2, dynamical_ellipticity, moment_ratio, polar_moment)
    orbits = [_orbit(number, companion, m) for number, companion in enumerate(companions)]
    _refuse_impossible(orbits, m, r, rate, theta)
    outer = [orbit for orbit in orbits if orbit.mass > m]
    moons = [orbit for orbit in orbits if orbit.mass <= m]
    if outer and moons and bulge < 0.0:
        raise SceneError("precession_of: j2 must not be negative where there are moons")
    # Orbits have no direction to a torque: a body that turns backwards is one that is upside down.
    folded = max(min(theta, math.pi - theta), _UPRIGHT)
    common, tilts = _common_rate(folded, polar * rate, bulge, outer, moons, m)
    angles = {orbit.name: folded for orbit in outer} | tilts
    backwards = -1.0 if theta > 0.5 * math.pi else 1.0
    shares = [
        backwards * bulge * orbit.tide * math.sin(2.0 * angles[orbit.name]) / (2.0 * polar * rate * math.sin(folded))
        for orbit in orbits
    ]
    swings = [
        _nutation(bulge / (1.5 * polar), rate, folded, angles[orbit.name], orbit)
        if math.isfinite(orbit.node_period)
        else (math.nan, math.nan)
        for orbit in orbits
    ]
    relative = _relativity(max(orbits, key=lambda orbit: orbit.mass), m)
    total = backwards * common + relative
    back = "rate at which the equator's node goes back"
    longitudes, obliquities = zip(*swings, strict=True)
    if min(theta, math.pi - theta) < _UPRIGHT:  # there the node of the equator is nowhere
        longitudes, angles = [math.nan] * len(orbits), dict.fromkeys(angles, 0.0)
    swing = "amplitude of the nutation in {} with the node of its orbit"
    of_companions = {
        "precession_rate": (shares, "rad s-1", f"{back}, by each companion"),
        "tilt": ([angles[orbit.name] for orbit in orbits], "rad", "angle between the equator and the mean orbit"),
        "nutation_longitude": (list(longitudes), "rad", swing.format("longitude")),
        "nutation_obliquity": (list(obliquities), "rad", swing.format("obliquity")),
    }
    of_all = {
        "dynamical_ellipticity": (bulge / (1.5 * polar), "1", "(C - A)/C"),
        "moment_ratio": (polar / (m * r**2), "1", "C/(M R^2), R as that of J2"),
        "relativity": (relative, "rad s-1", "geodesic precession (Barker & O'Connell 1975)"),
        "total_rate": (total, "rad s-1", back),
        "total_period": (2.0 * math.pi / abs(total) if total else math.inf, "s", "its period"),
    }
    return xr.Dataset(
        variables("companion", of_companions) | variables((), of_all),
        {"companion": [orbit.name for orbit in orbits]},
        {"title": "precession by the torques on a body's flattening", "source": "Goldreich 1966, Rev. Geophys. 4, 411"},
    )


def _refuse_impossible(orbits: Sequence[_Orbit], mass: float, radius: float, spin: float, theta: float) -> None:
    """SceneError for no orbits, for one that comes within the body, and for one that holds its spin."""
    if not orbits:
        raise SceneError("precession_of: give at least one companion")
    if len({orbit.name for orbit in orbits}) < len(orbits):
        raise SceneError("precession_of: two companions have the same name")
    for orbit in orbits:
        if (nearest := orbit.semi_major_axis * (1.0 - orbit.eccentricity)) <= radius:
            raise SceneError(
                f"precession_of: {orbit.name} would come to {nearest:.6g} m from the centre of the body, whose radius "
                f"is {radius:.6g} m"
            )
        motion = math.sqrt(GRAVITATIONAL_CONSTANT * (mass + orbit.mass) / orbit.semi_major_axis**3)
        for often, turns in _HELD.items():
            if theta < 0.5 * math.pi and math.isclose(spin, turns * motion, rel_tol=_IN_STEP):
                raise SceneError(
                    f"precession_of: the body turns {often} fast as {orbit.name} goes around: an orbit that holds a "
                    "spin so takes its axis along, which has no precession of its own (rotation.cassini)"
                )


def _relativity(orbit: _Orbit, mass: float) -> float:
    """Geodesic precession on an orbit, which turns the axis the other way."""
    own, other = GRAVITATIONAL_CONSTANT * mass, GRAVITATIONAL_CONSTANT * orbit.mass
    turn = 2.0 * math.pi * math.sqrt(orbit.semi_major_axis**3 / (own + other))
    return -float(geodetic_precession_of_binary(turn, own, other, orbit.eccentricity))


def _moments(
    size: float, j2: Any, ellipticity: Any, moment_ratio: Any, polar_moment: Any
) -> tuple[float, float]:  # fmt: skip
    """C and (3/2) (C - A), from two of J2, H and C; size: M R^2."""
    polar, difference = _polar_and_difference(size, j2, ellipticity, moment_ratio, polar_moment)
    if difference > _MOST_OBLATE * polar:
        raise SceneError(
            f"precession_of: no body has (C - A)/C = {difference / polar:g}: it is at most 1/2, that of a flat disc"
        )
    return polar, 1.5 * difference


def _polar_and_difference(
    size: float, j2: Any, ellipticity: Any, moment_ratio: Any, polar_moment: Any
) -> tuple[float, float]:
    polar = difference = None
    if moment_ratio is not None:
        polar = _number("moment_ratio", moment_ratio, "dimensionless", 0.0) * size
    elif polar_moment is not None:
        polar = _number("polar_moment", polar_moment, "moment_of_inertia", 0.0)
    if j2 is not None:
        difference = _number("j2", j2, "dimensionless", -math.inf) * size
    twice = moment_ratio is not None and polar_moment is not None
    if twice or [polar, difference, ellipticity].count(None) != 1:
        raise SceneError(
            "precession_of: give two of j2, dynamical_ellipticity, and one of moment_ratio and polar_moment"
        )
    if polar is not None and difference is not None:
        return polar, difference
    share = _number("dynamical_ellipticity", ellipticity, "dimensionless", -math.inf)
    if polar is not None:
        return polar, share * polar
    assert difference is not None
    if share * difference <= 0.0:
        raise SceneError("precession_of: j2 and dynamical_ellipticity must have one sign, and neither be 0")
    return difference / share, difference


def _nutation(ellipticity: float, spin: float, theta: float, tilt: float, orbit: _Orbit) -> tuple[float, float]:
    """Amplitudes in longitude and obliquity of the nutation with the node of an orbit; tilt: of its mean plane."""
    tilt = max(tilt, _UPRIGHT)
    longitude, oblique = node_nutation(
        ellipticity, spin, tilt, GRAVITATIONAL_CONSTANT * orbit.mass, orbit.semi_major_axis, orbit.eccentricity,
        orbit.inclination, -2.0 * math.pi / orbit.node_period,
    )  # fmt: skip
    # Longitude is counted along the body's own orbit, where a mean plane of less tilt goes round a smaller circle.
    return abs(float(longitude)) * math.sin(tilt) / math.sin(theta), abs(float(oblique))


def _common_rate(
    theta: float, spin: float, bulge: float, outer: Sequence[_Orbit], moons: Sequence[_Orbit], mass: float
) -> tuple[float, dict[str, float]]:
    """The rate at which spin and mean orbits of moons go back together, and the tilts of these to the equator."""
    pull = sum(orbit.tide for orbit in outer)
    rate = bulge * pull * math.cos(theta) / spin
    planes = dict.fromkeys((moon.name for moon in moons), theta if pull else 0.0)
    for _ in range(_ROUNDS):
        before = [rate, *planes.values()]
        for moon in moons if pull else ():
            planes[moon.name] = _mean_plane(theta, rate, bulge * moon.tide, pull, moon, moons, planes, mass)
        torque = 0.5 * bulge * pull * math.sin(2.0 * theta)
        torque += sum(0.5 * bulge * moon.tide * math.sin(2.0 * (theta - planes[moon.name])) for moon in moons)
        rate = torque / (spin * math.sin(theta))
        if all(
            math.isclose(new, old, rel_tol=_SETTLED) for new, old in zip([rate, *planes.values()], before, strict=True)
        ):
            break
    return rate, {name: theta - plane for name, plane in planes.items()}


def _mean_plane(
    theta: float, rate: float, bulge: float, pull: float, moon: _Orbit, moons: Sequence[_Orbit],
    planes: Mapping[str, float], mass: float,
) -> float:  # fmt: skip
    """phi: the angle of a moon's mean orbit from the body's own, where those of the others are as they are."""
    parameter = moon.semi_major_axis * (1.0 - moon.eccentricity**2)
    # Along the pole of the mean plane, about which the node turns: against it for a moon that goes backwards.
    momentum = moon.mass * math.sqrt(GRAVITATIONAL_CONSTANT * (mass + moon.mass) * parameter)
    momentum *= math.cos(moon.inclination)
    others = [
        (_ring(*sorted((moon, other), key=lambda orbit: orbit.semi_major_axis)), planes[other.name])
        for other in moons
        if other is not moon
    ]

    def left(phi: float) -> float:
        turned = 0.375 * moon.spread * pull * math.sin(2.0 * phi) - 0.5 * bulge * math.sin(2.0 * (theta - phi))
        turned -= sum(0.5 * strength * math.sin(2.0 * (plane - phi)) for strength, plane in others)
        return turned - momentum * rate * math.sin(phi)

    if left(0.0) == 0.0:  # no bulge, and no other moon that turns it
        return 0.0
    most = theta if left(theta) > 0.0 else theta + 0.25 * math.pi
    if left(0.0) * left(most) >= 0.0:
        raise SceneError(f"precession_of: the mean orbit of {shown(moon.name)} keeps no tilt; is it bound?")
    return root_between(left, 0.0, most, 1e-300, 1e-14)


@lru_cache(maxsize=256)
def _ring(inner: _Orbit, outer: _Orbit) -> float:
    """D: of the torque between two moons, both spread over their orbits."""
    ratio = inner.semi_major_axis / outer.semi_major_axis
    try:
        nearness = float(laplace_coefficient(1.5, 1, ratio)) / (3.0 * ratio)
    except (ValueError, NumericalError):
        raise SceneError(
            f"precession_of: the orbits of {shown(inner.name)} and {shown(outer.name)} are too near each other"
        ) from None
    return 0.75 * inner.spread * outer.tide * nearness


def _orbit(number: int, companion: Mapping[str, Any], mass: float) -> _Orbit:
    if not isinstance(companion, Mapping):
        raise SceneError(f"precession_of: companions must be a list of tables (dicts), not {companion!r:.60}")
    name = str(companion.get("name", number + 1))
    if unknown := [key for key in companion if key not in _KEYS]:
        raise SceneError(
            f"precession_of: companion {shown(name)} has the key {unknown[0]!r}; known: {', '.join(_KEYS)}"
        )
    if "mass" not in companion or ("semi_major_axis" in companion) == ("period" in companion):
        raise SceneError(f"precession_of: companion {shown(name)} needs a mass, and one of semi_major_axis and period")

    def number_of(key: str, dimension: str, above: float, default: Any = 0.0) -> float:
        return _number(f"{key} of {shown(name)}", companion.get(key, default), dimension, above)

    own = number_of("mass", "mass", 0.0)
    if "period" in companion:
        turn = number_of("period", "time", 0.0) / (2.0 * math.pi)
        axis = (GRAVITATIONAL_CONSTANT * (mass + own) * turn**2) ** (1.0 / 3.0)
    else:
        axis = number_of("semi_major_axis", "length", 0.0)
    eccentricity = number_of("eccentricity", "dimensionless", -1e-300)
    if eccentricity >= 1.0:
        raise SceneError(f"precession_of: eccentricity of {shown(name)} must be below 1")
    node = number_of("node_period", "time", 0.0) if "node_period" in companion else math.inf
    inclination = number_of("inclination", "angle", -math.inf)
    if abs(inclination) > math.pi:
        raise SceneError(f"precession_of: inclination of {shown(name)} must be at most 180 deg")
    return _Orbit(name, own, axis, eccentricity, inclination, node)


def _number(name: str, value: Any, dimension: str, above: float) -> float:
    try:
        if isinstance(value, bool):
            raise ValueError(f"must be a number, not {value}")
        own = with_unit(value)
        value = value if own is None else written_quantity(own)
        made = quantity(value, dimension) if isinstance(value, str) and dimension != "dimensionless" else float(value)
    except (SceneError, TypeError, ValueError) as error:
        raise SceneError(f"precession_of: {name}: {error}") from None
    if not (math.isfinite(made) and made > above):
        limit = "" if above == -math.inf else " above 0" if above == 0.0 else " that is not negative"
        raise SceneError(f"precession_of: {name} must be a finite number{limit}, not {made:g}")
    return made
