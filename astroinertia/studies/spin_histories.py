"""Spins along time in one call: a pulsar that brakes, a planet or young star that contracts, a cloud that makes a disc.

Quantities are given as text with a unit ("33 ms") or as numbers in SI; datasets are in SI.
"""

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from astroinertia.bodies.neutron_star_fits import kepler_period, roche_shedding_period
from astroinertia.bodies.polytrope import Polytrope, lane_emden
from astroinertia.dataset.variables import variables
from astroinertia.errors import SceneError
from astroinertia.process.quantities import with_quantities
from astroinertia.rotation import pulsars
from astroinertia.rotation.braking import Braking
from astroinertia.rotation.collapsing_shells import shells_of
from astroinertia.rotation.contraction import contracted_period, radius_at_luminosity, radius_at_temperature
from astroinertia.units import GRAVITATIONAL_CONSTANT, quantity

Quantity = str | float

_TIMES = 200
_RADII = 200


@with_quantities(end="s")
def pulsar_history(
    period: Quantity = "33.3924123 ms",
    period_derivative: float = 4.20972e-13,
    end: Quantity = "10000 yr",
    braking_index: float = 3.0,
    torques: Sequence[tuple[float, float]] | None = None,
    moment_of_inertia: Quantity = pulsars.CANONICAL_MOMENT,
    radius: Quantity = pulsars.CANONICAL_RADIUS,
) -> xr.Dataset:
    """Return a pulsar's spin along time from now on, with what an observer would make of it at each time.

    torques: pairs (braking index, share of the present spin-down) instead of one index; the measured index then drifts.
    magnetic_field is that at the equator of an orthogonal dipole in vacuum, characteristic_age P/(2 P'), true_age the
    age of a star of the measured index that was born infinitely fast. SceneError for bad quantities.

    >>> print((1e3 * pulsar_history().period.values[[0, -1]]).round(1))  # the Crab pulsar, now and in 10,000 years
    [33.4 99.9]
    """
    first, last = in_si(period, "time"), in_si(end, "time")
    moment, size = in_si(moment_of_inertia, "moment_of_inertia"), in_si(radius, "length")
    if not period_derivative > 0:
        raise SceneError(f"a pulsar that brakes has a positive period_derivative, not {period_derivative!r}")
    rate = 2 * math.pi / first
    mixture = [(braking_index, 1.0)] if torques is None else list(torques)
    indices, shares = zip(*mixture, strict=True)
    try:
        star = Braking(rate, -rate * period_derivative / first, tuple(indices), tuple(shares))
    except ValueError as error:
        raise SceneError(f"the torques are wrong: {error}.") from None
    times = np.concatenate([[0.0], np.geomspace(last / 1e4, last, _TIMES - 1)])
    spin = star.history(times)
    turn, slowing = 2 * math.pi / spin, -2 * math.pi * star.rate(spin) / spin**2
    index = star.index(spin)
    columns = {
        "period": (turn, "s", "period"),
        "period_derivative": (slowing, "1", "period derivative"),
        "angular_velocity": (spin, "rad s-1", "angular velocity"),
        "braking_index": (index, "1", "braking index that is measured"),
        "rotational_energy": (pulsars.rotational_energy(turn, moment), "J", "energy of the rotation"),
        "spin_down_luminosity": (pulsars.spin_down_luminosity(turn, slowing, moment), "W", "spin-down luminosity"),
        "magnetic_field": (pulsars.dipole_field(turn, slowing, moment, size), "T", "dipole field at the equator"),
        "characteristic_age": (pulsars.characteristic_age(turn, slowing), "s", "P/(2 P')"),
        "true_age": (pulsars.characteristic_age(turn, slowing, index), "s", "P/((n - 1) P')"),
    }
    return _along("time", times, "s", "time from now on", columns, "a pulsar that brakes")


@with_quantities(end="s", effective_temperature="K")
def contraction_history(
    mass: Quantity = "1.898e27 kg",
    radius: Quantity = "140000 km",
    period: Quantity = "39.7 h",
    end: Quantity = "4.5e9 yr",
    luminosity: Quantity | None = None,
    effective_temperature: float | None = None,
    index: float = 1.5,
    disc_until: Quantity | None = None,
) -> xr.Dataset:
    """Return radius, period and limits of a body that shrinks as it radiates, along time.

    Either luminosity (one for ever) or effective_temperature in K (one for ever, as on a Hayashi track); disc_until:
    the radius down to which a disc holds the period. SceneError for bad quantities, or both or none of the two.

    >>> young = contraction_history(luminosity="1e18 W")
    >>> print(f"{float((young.period / young.radius**2)[-1] / (young.period / young.radius**2)[0]):.6f}")  # as R^2
    1.000000
    """
    body, size, turn = in_si(mass, "mass"), in_si(radius, "length"), in_si(period, "time")
    last = in_si(end, "time")
    if (luminosity is None) == (effective_temperature is None):
        raise SceneError("a contraction needs either a luminosity or an effective_temperature")
    times = np.concatenate([[0.0], np.geomspace(last / 1e6, last, _TIMES - 1)])
    if luminosity is not None:
        radii = radius_at_luminosity(times, body, size, in_si(luminosity, "power"), index)
    else:
        assert effective_temperature is not None
        radii = radius_at_temperature(times, body, size, effective_temperature, index)
    held = math.inf if disc_until is None else in_si(disc_until, "length")
    turns = contracted_period(turn, size, radii, held)
    moment = lane_emden(float(index)).moment_ratio * body * radii**2
    orbit, torn = kepler_period(body, radii), roche_shedding_period(body, radii)
    columns = {
        "radius": (radii, "m", "radius"),
        "period": (turns, "s", "period"),
        "moment_of_inertia": (moment, "kg m2", "I"),
        "angular_momentum": (2 * math.pi * moment / turns, "kg m2 s-1", "L, which a disc takes up while it holds"),
        "kepler_period": (orbit, "s", "period of an orbit at the equator"),
        "shedding_period": (torn, "s", "shortest period without loss of mass (Roche)"),
        "beyond_kepler": (turns < orbit, "1", "whether the equator turns faster than an orbit there"),
        "sheds_mass": (turns < torn, "1", "whether it turns faster than it can without losing mass"),
    }
    return _along("time", times, "s", "time", columns, "a body that contracts")


@with_quantities()
def cloud_to_disc(
    mass: Quantity = "1 Msun", radius: Quantity = "0.05 pc", period: Quantity = "2e7 yr", index: float = 0.0
) -> xr.Dataset:
    """Return the thin disc that a rigidly turning polytropic cloud makes, along radius, when all of it has come down.

    Matter keeps its specific angular momentum and goes to the orbit that has it around the whole mass, which is held to
    be at the centre. disc_radius: of the outermost, Omega^2 R^4/(G M). SceneError for bad quantities. Source: Cassen &
    Moosman 1981, Icarus 48, 353.

    >>> disc = cloud_to_disc()
    >>> print(f"{float(disc.mass_inside[-1]) / 1.98841e30:.2f}")  # solar masses: all of it has come down
    1.00
    """
    body, size, turn = in_si(mass, "mass"), in_si(radius, "length"), in_si(period, "time")
    cloud = shells_of(Polytrope(index, body, size, GRAVITATIONAL_CONSTANT), 2 * math.pi / turn, 400)
    outer = float(cloud.centrifugal_radius[-1] * (size / cloud.radius[-1]) ** 4 * cloud.enclosed_mass[-1] / body)
    radii = outer * np.geomspace(1e-4, 1.0, _RADII)
    half = np.sqrt(radii[1] / radii[0])
    walls = np.append(radii / half, radii[-1] * half)
    density = np.diff(cloud.disc_mass_inside(walls)) / (math.pi * np.diff(walls**2))
    density[-1] = 0.0  # where only the equator comes to rest
    columns = {
        "mass_inside": (cloud.disc_mass_inside(radii), "kg", "mass that comes to rest inside"),
        "surface_density": (density, "kg m-2", "surface density"),
        "orbital_period": (kepler_period(body, radii), "s", "period of the orbit"),
    }
    disc = _along("radius", radii, "m", "radius in the disc", columns, "the disc of a cloud")
    disc.attrs |= {"disc_radius": outer, "angular_momentum": cloud.angular_momentum}
    return disc


def _along(name: str, values: np.ndarray, unit: str, text: str, columns: dict, title: str) -> xr.Dataset:
    along = {column: (np.broadcast_to(numbers, values.shape), *said) for column, (numbers, *said) in columns.items()}
    return xr.Dataset(variables(name, along), variables(name, {name: (values, unit, text)}), {"title": title})


def in_si(value: Quantity, dimension: str) -> float:
    """Return a positive quantity in SI, from text with a unit or a number; SceneError for anything else.

    >>> print(f"{in_si('1 h', 'time'):.0f}")
    3600
    """
    if np.ndim(value) > 0:
        raise SceneError(f"a {dimension.replace('_', ' ')} must be one number, not {value!r:.60}")
    number = quantity(value, dimension) if isinstance(value, str) else float(value)
    if not (math.isfinite(number) and number > 0):
        raise SceneError(f"a {dimension.replace('_', ' ')} must be positive and finite, not {value!r}")
    return number
