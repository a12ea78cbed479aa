"""What fluids do: effects of the matter itself, as the catalogue lists them, and how large each is in a scene."""

import math
from collections.abc import Mapping

from astroinertia.bodies.bar_limits import SECULAR
from astroinertia.effects.characteristic import Characteristic
from astroinertia.effects.entries import FORCE_ERROR, Entry
from astroinertia.effects.measure import ZONE, Found, Measure, Options, within_all
from astroinertia.effects.one_zone import braked, difference
from astroinertia.units import ALL_MODELS, REQUIRED, Option, choice, not_negative, positive

CAPTURES, LEFT = (3e10, 2e16), 0.56  # kg/m3 between which electrons are captured, and what is left of them


def _gravity(body: Characteristic, options: Options) -> Found:
    zone = body.zone
    assert zone is not None
    weight_over_heat = zone.weight / (zone.pressure + zone.turning) if zone.pressure + zone.turning > 0.0 else math.inf
    if body.held:
        return weight_over_heat, within_all(zone.weight * body.end**2)
    return weight_over_heat, difference(zone, body.end, weight=0.0)


def pressure_size(body: Characteristic, options: Options) -> Found:
    """U/|W|, and what a body without pressure would do otherwise."""
    zone = body.zone
    assert zone is not None
    share = body.thermal_to_gravitational
    number = zone.pressure / zone.weight if share is None and zone.weight > 0.0 else share or 0.0
    if body.held:
        return number, 1.0
    if zone.pressure == 0.0:
        return number, 0.0
    return number, max(difference(zone, body.end, pressure=0.0), within_all(body.fallen))


def _viscosity(body: Characteristic, options: Options) -> Found:
    zone = body.zone
    assert zone is not None and body.mass is not None and body.radius is not None
    if zone.pressure == 0.0:
        return 0.0, 0.0
    if body.bodies > 1 or body.touching:
        return math.inf, 1.0
    sound = math.sqrt(body.gamma * zone.pressure / 3.0)
    mach = braked(zone, body.end) / sound if sound > 0.0 else 0.0
    periods = max(1.0, body.end * zone.frequency / (2.0 * math.pi))
    heat = min(1.0, mach) ** 2 * min(1.0, mach * periods)  # waves of Mach number m steepen within 1/m periods
    return mach, max(within_all(heat), 0.0 if body.homologous else body.falling)


def _conduction(body: Characteristic, options: Options) -> Found:
    return (1.0, 1.0) if body.touching else (0.0, 0.0)


def _shear_viscosity(body: Characteristic, options: Options) -> Found:
    assert body.radius is not None
    decay = 5.0 * options["kinematic_viscosity"] * body.end / body.radius**2
    zone = body.zone
    steady = body.shear == 0.0 and body.expansion == 0.0 and zone is not None and body.bodies == 1
    if steady and zone is not None and (body.rotational_to_gravitational or 0.0) < SECULAR:
        return decay, within_all(decay * zone.imbalance)  # rigid rotation has no friction: what moves is what swings
    return decay, within_all(decay)


def _deleptonisation(body: Characteristic, options: Options) -> Found:
    zone, dense = body.zone, body.central_density
    assert zone is not None and dense is not None
    if options["mass_unit"] is not None:
        dense *= options["mass_unit"] / options["length_unit"] ** 3
    elif body.gravitational_constant == 1.0:
        raise KeyError("mass_unit")
    first, last = CAPTURES
    reached = 1.0 if body.falling > 0.0 else min(max(math.log(dense / first) / math.log(last / first), 0.0), 1.0)
    left = 1.0 - (1.0 - LEFT) * reached
    return 1.0 - left, difference(zone, body.end, pressure=zone.pressure * left ** (4.0 / 3.0))


FLUID: Mapping[str, Entry] = {
    "gravity": Entry(
        "self-gravity of the body (particles are softened by their own kernel)",
        {
            "method": choice(
                "how particles attract each other: direct sums over all pairs, exact and N^2; multipole expansions of "
                "far groups, to an error that is asked for; auto is what takes less time",
                "auto", "direct", "multipole", models=("sph",),
            ),
            "force_error": Option(
                "dimensionless", FORCE_ERROR, "of multipole: wanted rms of the relative error of the accelerations",
                minimum=1e-8, maximum=0.03, models=("sph",),
            ),
            "softening": Option(
                "length", None,
                "smoothing length of every particle, kept as it is, where no effect acts between neighbours; without "
                "it, lengths follow the density",
                minimum=0.0, exclusive=True, models=("sph",),
            ),
            "order": choice(
                "order in the smoothing length of the error of the binding energy: fourth takes out what softening "
                "leaves out of it",
                "second", "fourth", models=("sph",),
            ),
        },
        "all pairs", "Price & Monaghan 2007; Dehnen 2014", ALL_MODELS, colour="blue", auto="always",
        size=Measure(
            "|W| over 3 Pi + 2 T",
            "I of one zone by the virial theorem, with |W| and without",
            "Chandrasekhar 1969, section 14", _gravity, ZONE,
        ),
    ),
    "pressure": Entry(
        "pressure gradient of the fluid",
        {
            "order": choice(
                "order in the smoothing length of the error of densities: fourth takes out what smoothing adds to them",
                "second", "fourth", models=("sph",),
            ),
            "gradients": choice(
                "the kernel's own slope, which keeps the entropy of smooth flow exact; or integral, of a matrix that "
                "straightens out how neighbours lie: less noise in subsonic flow, no surface tension at contacts",
                "kernel", "integral", models=("sph",),
            ),
        },
        "neighbours", "Springel & Hernquist 2002", ALL_MODELS, colour="vermillion", auto="always",
        limit_power=1.0 / 3.0,
        size=Measure(
            "U/|W|",
            "I of one zone with 3 Pi and without; mass whose free fall ends",
            "Chandrasekhar 1969, section 14", pressure_size, ZONE,
        ),
        gradients=lambda options: options["order"] == "fourth" or options["gradients"] == "integral",
    ),
    "viscosity": Entry(
        "artificial viscosity, which captures shocks",
        {
            "alpha_max": positive("dimensionless", 1.0, "linear coefficient in a shock"),
            "alpha_min": not_negative(
                "dimensionless", 0.0, "linear coefficient far from shocks, which damps noise; limiters leave it",
            ),
            "beta": not_negative("dimensionless", 4.0, "quadratic coefficient, as a multiple of the linear one"),
            "decay_length": positive("dimensionless", 10.0, "smoothing lengths over which the coefficient decays"),
            "switch": choice(
                "how the coefficient follows the flow: with shocks, or constant at alpha_max", "cullen_dehnen", "none",
            ),
            "limiter": choice(
                "what keeps viscosity out of smooth flow: reconstruction sees only the jump that linear flow on both "
                "sides leaves, guarded_reconstruction more where particles are closer than they should be, balsara "
                "weakens it where the flow turns rather than converges",
                "reconstruction", "guarded_reconstruction", "balsara", "none",
            ),
            "stress": choice(
                "viscous stress of pairs: whole, or trace_free, which does not push sideways where gas is compressed: "
                "converging shocks heat by what they should; for limiters that reconstruct",
                "whole", "trace_free",
            ),
        },
        "neighbours", "Cullen & Dehnen 2010; Monaghan 1997; Balsara 1995", numerical=True, colour="green",
        auto="always", needs=("pressure",), limit_power=1.0 / 3.0,
        size=Measure(
            "Mach number of the braked fall",
            "M^2 of the heat, once waves of that Mach number have steepened; what falls",
            "Landau & Lifshitz 1987, Fluid Mechanics, section 101", _viscosity, ZONE,
        ),
        gradients=lambda options: options["switch"] != "none" or options["limiter"] != "none",
    ),
    "conduction": Entry(
        "artificial conduction, which smooths jumps of thermal energy",
        {
            "coefficient": not_negative("dimensionless", 1.0, "strength of the exchange of thermal energy"),
            "signal": choice(
                "speed of the exchange: relative_velocity leaves a star in equilibrium alone, pressure_jump is for "
                "contact discontinuities without gravity",
                "relative_velocity", "pressure_jump",
            ),
        },
        "neighbours", "Price 2008; Wadsley, Veeravalli & Couchman 2008", numerical=True, colour="orange",
        auto="touching", needs=("pressure",), limit_power=1.0 / 3.0,
        size=Measure(
            "contacts of materials",
            "all where matter of different kinds meets; a device without a size of its own else",
            "Price 2008", _conduction,
        ),
    ),
    "shear_viscosity": Entry(
        "viscosity of the fluid itself, which particles have along their separations: L is kept",
        {"kinematic_viscosity": not_negative("viscosity", REQUIRED, "nu, the same everywhere")},
        "neighbours", "Espanol & Revenga 2003; Cleary & Monaghan 1999; Chandrasekhar 1969, section 37",
        ("sph", "ellipsoid"), colour="green", limit_power=2.0 / 3.0,
        size=Measure(
            "5 nu t/R^2",
            "that, where the flow has shear; times the imbalance of forces in rigid rotation",
            "Lamb 1932, section 355; Chandrasekhar 1969, section 37", _shear_viscosity, ("radius",),
            ("kinematic_viscosity",),
        ),
    ),
    "deleptonisation": Entry(
        "electrons that a collapsing core loses as it becomes denser, with what neutrinos take and push",
        {
            "fit": choice(
                "which electron fraction belongs to a density: that of a star of 15 solar masses in general "
                "relativity (G15), or of 13 in Newton's gravity (N13)",
                "G15", "N13",
            ),
            "electron_fraction": Option(
                "dimensionless", 0.4971,
                "of the matter that the equation of state is of: it has the pressure of 4.897e14 (rho cm3/g)^(4/3) "
                "dyn/cm2 at 0.4971; gamma_1 is then 4/3",
                minimum=0.0, maximum=1.0, exclusive=True,
            ),
            "escape_energy": not_negative("energy", None, "that a neutrino carries off; 10 MeV without it"),
            "trapping_density": positive("density", None, "above which neutrinos stay; 2e12 g/cm3 without it"),
            "mass_unit": positive("mass", None, "of a scene in code units: what 1 is, in kg"),
            "length_unit": positive("length", None, "of a scene in code units: what 1 is, in m"),
        },
        "neighbours", "Liebendoerfer 2005; Shapiro & Teukolsky 1983", needs=("pressure",), presses=True,
        size=Measure(
            "share of electrons captured",
            "I of one zone with the pressure of those left to the power 4/3",
            "Liebendoerfer 2005", _deleptonisation, (*ZONE, "central_density"),
        ),
    ),
}  # fmt: skip
