"""Pulsars and collapse: what catalogues derive from periods, accretion, and the arithmetic of spin-up."""

import numpy as np

from astroinertia.bodies.break_up import shedding_share
from astroinertia.rotation import accretion, pulsars
from astroinertia.rotation.precession import JULIAN_YEAR
from astroinertia.rotation.spin_scaling import spin_up
from astroinertia.units import SOLAR_MASS
from astroinertia.verify.comparison import Quantities

_TIMED = {"crab": (0.0333924123, 4.20972e-13), "vela": (0.089328385, 1.25008e-13)}  # s, s/s: the catalogue of ATNF
_CRAB_FREQUENCY = (29.946923, -3.77535e-10, 1.1147e-20)  # Hz and its derivatives: Lyne et al. 2015
_CRAB_INDEX, _CRAB_AGE = 2.51, 937.0  # between glitches; a from 1054 to the epoch of the period, 1991
_TESLA, _WATT = 1e4, 1e7  # in G, in erg/s


def catalogue() -> Quantities:
    """Loss of energy, age and field of the Crab and of Vela with I = 1e45 g cm^2, R = 10 km."""
    values = {}
    for name, (period, slowing) in _TIMED.items():
        values |= {
            f"{name}_luminosity": float(pulsars.spin_down_luminosity(period, slowing)) * _WATT,
            f"{name}_age": float(pulsars.characteristic_age(period, slowing)) / JULIAN_YEAR / 1e3,
            f"{name}_field": float(pulsars.dipole_field(period, slowing)) * _TESLA,
        }
    return values


def braking() -> Quantities:
    """The Crab's index from its frequency and two derivatives, and the period that it was born with."""
    period, slowing = _TIMED["crab"]
    birth = pulsars.period_at_birth(period, slowing, _CRAB_AGE * JULIAN_YEAR, _CRAB_INDEX)
    return {
        "crab_index": float(pulsars.frequency_braking_index(*_CRAB_FREQUENCY)),
        "crab_birth_period": 1e3 * float(birth),
    }


def accreting() -> Quantities:
    """Where a field stops a disc, and the most that a neutron star accretes."""
    radius = accretion.magnetospheric_radius(1e8, 1e14, mass=SOLAR_MASS, coefficient=1.0)
    rate = accretion.eddington_rate() / SOLAR_MASS * JULIAN_YEAR
    return {"alfven_radius": float(radius) * 100, "eddington_rate": float(rate)}


def collapse() -> Quantities:
    """An iron core that becomes a neutron star at constant angular momentum, and the limits of rotation."""
    core = spin_up(0.1, 1.4 * SOLAR_MASS, 1500e3, 100.0, 0.35, 1.4 * SOLAR_MASS, 12e3)
    return {
        "core_period": float(core.period),
        "core_moment_fall": float(core.moment_fall),
        "core_over_kepler": float(core.period_over_kepler),
        "roche_shedding": float(np.asarray(shedding_share())),
    }


COMPUTATIONS = (catalogue, braking, accreting, collapse)
