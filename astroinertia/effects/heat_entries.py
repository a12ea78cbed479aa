"""Effects that exchange heat with the surroundings, as the catalogue lists them, and how large each is in a scene."""

import math
from collections.abc import Mapping

from astroinertia.effects.characteristic import Characteristic
from astroinertia.effects.entries import Entry
from astroinertia.effects.fluid_entries import pressure_size
from astroinertia.effects.measure import ZONE, Found, Measure, Options, within_all
from astroinertia.units import Option, choice, not_negative, positive

DENSER = 8.0  # that a body that does not collapse may become, by half its radius


def _cooling(body: Characteristic, options: Options) -> Found:
    assert body.thermal_energy is not None and body.mass is not None
    specific = body.thermal_energy / body.mass
    if specific == 0.0 and not options["heating_rate"]:
        return 0.0, 0.0
    times = 0.0
    if options["law"] == "beta":
        times = (body.spin or 0.0) * body.end / options["beta"]
    elif options["time_scale"] is not None:
        scale = options["time_scale"]
        if options["law"] == "power_law":
            dense = (body.central_density or 0.0) / options["reference_density"]
            warm = specific / options["reference_energy"]
            scale *= dense ** -options["density_exponent"] * warm ** (1.0 - options["energy_exponent"])
        change = options["time_scale_change"] or 0.0
        left = 1.0 + change * body.end / scale
        times = body.end / scale if change == 0.0 else math.log(left) / change if left > 0.0 else math.inf
    if options["floor"] is not None and specific <= options["floor"]:
        times = 0.0
    if options["heating_rate"]:
        times += options["heating_rate"] * body.end / specific if specific > 0.0 else math.inf
    return times, _heat_change(body, times)


def _heat_change(body: Characteristic, share: float) -> float:
    """What a share of the heat means to the size: R ~ A^(1/(3 gamma - 4)) of what is bound; no more than pressure."""
    zone = body.zone
    bound = zone is not None and zone.weight > zone.pressure
    steep = 2.0 / max(3.0 * body.gamma - 4.0, 0.5) if bound or zone is None or zone.imbalance < 0.5 else 2.0
    return within_all(min(1.0, steep * share) * pressure_size(body, {})[1])


def _neutrino_loss(body: Characteristic, options: Options) -> Found:
    assert body.thermal_energy is not None and body.mass is not None and body.central_density is not None
    if options["law"] == "diffusion":
        reached = body.central_density * DENSER > options["density"] or body.falling > 0.0
        share = body.end / options["time_scale"] if reached else 0.0
    else:
        specific = body.thermal_energy / body.mass
        warm = specific / options["thermal_energy"]
        share = options["rate"] * warm**6 * body.end / specific if specific > 0.0 else 0.0
        share = math.inf if body.falling > 0.0 else share
    return share, _heat_change(body, share)


HEAT: Mapping[str, Entry] = {
    "cooling": Entry(
        "cooling and heating of the matter: thermal energy that it radiates, or is given",
        {
            "law": choice(
                "du/dt = -u/tau of the thermal energy u: time_scale has one tau everywhere, so that a star contracts "
                "homologously; power_law has du/dt ~ rho^a u^b; beta has tau = beta/Omega, of the local rotation",
                "time_scale", "power_law", "beta",
            ),
            "time_scale": positive("time", None, "tau at time 0; of power_law, at the reference density and energy"),
            "time_scale_change": Option(
                "dimensionless", None,
                "constant change of tau with time; with -1.5 and gamma 5/3 a star that contracts has always the same "
                "number of free-fall times for it",
                maximum=0.0,
            ),
            "reference_density": positive("density", None, "of power_law: density at which tau is time_scale"),
            "reference_energy": positive("specific_energy", None, "of power_law: thermal energy at which it is"),
            "density_exponent": Option("dimensionless", 1.0, "a of power_law", minimum=-10.0, maximum=10.0),
            "energy_exponent": Option("dimensionless", 0.5, "b of power_law", minimum=-9.0, maximum=10.0),
            "beta": positive("dimensionless", None, "of the law beta: cooling time times angular velocity"),
            "heating_rate": not_negative("specific_power", None, "heat given to all matter alike, per mass and time"),
            "floor": not_negative("specific_energy", None, "thermal energy below which nothing is radiated"),
            "limit": choice("what steps must resolve: the cooling time, or not even that", "cooling_time", "none"),
        },
        "particles", "Gammie 2001; Rybicki & Lightman 1979",
        size=Measure(
            "run in cooling times",
            "2/(3 gamma - 4) of that, times what pressure does",
            "Chandrasekhar 1939, chapter 4", _cooling, (*ZONE, "thermal_energy"), ("law",),
        ),
    ),
    "neutrino_loss": Entry(
        "heat that neutrinos carry off from a collapsed core, parametrised",
        {
            "law": choice(
                "captures: of electrons and positrons by free nucleons, with the sixth power of the temperature, where "
                "neutrinos are not trapped; diffusion: of those that are, over a time scale above a density",
                "captures", "diffusion",
            ),
            "rate": positive(
                "specific_power", None, "of captures: energy lost at thermal_energy; 1.399e16 W/kg at 2 MeV",
            ),
            "thermal_energy": positive(
                "specific_energy", None,
                "of captures: thermal energy at which it is; 2.9e14 J/kg for nucleons at 2 MeV",
            ),
            "trapping_density": positive(
                "density", None, "of captures: at which the optical depth is 1; about 1e11 g/cm3",
            ),
            "time_scale": positive("time", None, "of diffusion: in which heat leaks out, seconds to tens of seconds"),
            "density": positive("density", None, "of diffusion: above which it does"),
        },
        "particles", "Janka 2001; Murphy & Burrows 2008; Roberts & Reddy 2017",
        size=Measure(
            "run in times of loss",
            "2/(3 gamma - 4) times that, of what pressure does",
            "Janka 2001", _neutrino_loss, (*ZONE, "thermal_energy", "central_density"), ("law",),
        ),
    ),
}  # fmt: skip
