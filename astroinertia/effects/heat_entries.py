"""Effects that exchange heat with the surroundings, as the catalogue lists them."""

from collections.abc import Mapping

from astroinertia.effects import sizes
from astroinertia.effects.entries import Entry
from astroinertia.units import Option, not_negative, positive

HEAT: Mapping[str, Entry] = {
    "cooling": Entry(
        "astroinertia.effects.cooling",
        "Cooling",
        "cooling and heating of the matter: thermal energy that it radiates, or is given",
        {
            "law": Option(
                "choice",
                "time_scale",
                "du/dt = -u/tau of the thermal energy u: time_scale has one tau everywhere, so that a star contracts "
                "homologously; power_law has du/dt ~ rho^a u^b; beta has tau = beta/Omega, of the local rotation",
                choices=("time_scale", "power_law", "beta"),
            ),
            "time_scale": positive("time", None, "tau at time 0; of power_law, at the reference density and energy"),
            "time_scale_change": Option(
                "dimensionless",
                None,
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
            "limit": Option(
                "choice",
                "cooling_time",
                "what steps must resolve: the cooling time, or not even that",
                choices=("cooling_time", "none"),
            ),
        },
        "particles",
        "Gammie 2001; Rybicki & Lightman 1979",
        size=sizes.COOLING,
    ),
    "neutrino_loss": Entry(
        "astroinertia.effects.neutrino_loss",
        "NeutrinoLoss",
        "heat that neutrinos carry off from a collapsed core, parametrised",
        {
            "law": Option(
                "choice",
                "captures",
                "captures: of electrons and positrons by free nucleons, with the sixth power of the temperature, where "
                "neutrinos are not trapped; diffusion: of those that are, over a time scale above a density",
                choices=("captures", "diffusion"),
            ),
            "rate": positive(
                "specific_power", None, "of captures: energy lost at thermal_energy; 1.399e16 W/kg at 2 MeV"
            ),
            "thermal_energy": positive(
                "specific_energy", None, "of captures: thermal energy at which it is; 2.9e14 J/kg for nucleons at 2 MeV"
            ),
            "trapping_density": positive(
                "density", None, "of captures: at which the optical depth is 1; about 1e11 g/cm3"
            ),
            "time_scale": positive("time", None, "of diffusion: in which heat leaks out, seconds to tens of seconds"),
            "density": positive("density", None, "of diffusion: above which it does"),
        },
        "particles",
        "Janka 2001; Murphy & Burrows 2008; Roberts & Reddy 2017",
        size=sizes.NEUTRINO_LOSS,
    ),
}
