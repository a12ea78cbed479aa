"""Neutrinos that carry off the heat of a collapsed core, parametrised."""

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

from astroinertia.effects import ZONE, Characteristic, Effect, Entry, Found, Measure, Options, pytree
from astroinertia.effects.heat_exchange import changing_time, heat_change
from astroinertia.engines.elementwise import elementwise
from astroinertia.units import choice, positive

DENSER = 8.0  # that a body that does not collapse may become, by half its radius

TEMPERATURE_POWER = 6.0  # of the rate at which free nucleons capture electrons and positrons


def captures(xp, density, energy, rate, thermal_energy, trapping_density):
    """k of du/dt = -rate (T/T_0)^6 e^-tau = -k u, with T ~ u and tau = rho/trapping_density."""
    warm = energy / thermal_energy
    return (rate / thermal_energy * xp.power(warm, TEMPERATURE_POWER - 1.0) * xp.exp(-density / trapping_density),)


def diffusion(xp, density, threshold, time_scale):
    """k = 1/time_scale above the threshold."""
    return (xp.where(density > threshold, 1.0, 0.0) / time_scale,)


@pytree
@dataclass(frozen=True, eq=False)
class NeutrinoLoss(Effect):
    """du/dt of the thermal energy u (its part above the cold curve), which leaves the star.

    law "captures": du/dt = -rate (T/T_0)^6 e^(-rho/trapping_density), T/T_0 = u/thermal_energy. For matter of free
    nucleons the rate is 1.399e20 erg/g/s at 2 MeV (Janka 2001, A&A 368, 527; Murphy & Burrows 2008, ApJ 688, 1159),
    that is 1.399e16 W/kg at u = 3/2 kT/m_u = 2.9e14 J/kg. Neutrinos are trapped from about 1e11 g/cm^3 on, which the
    optical depth rho/trapping_density stands for (Couch 2013, ApJ 775, 35).
    law "diffusion": du/dt = -u/time_scale above `density`: what is trapped leaks out within the diffusion time of a
    protoneutron star, seconds to tens of seconds (Roberts & Reddy 2017, Handbook of Supernovae, 1605).
    Neither heats what lies above, nor changes the composition.
    """

    rate: Any = None
    thermal_energy: Any = None
    trapping_density: Any = None
    time_scale: Any = None
    density: Any = None
    law: str = field(default="captures", metadata={"static": True})

    kind: ClassVar[str] = "neutrino_loss"
    external: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses a law without its numbers, and numbers of the other law."""
        own = {"captures": ("rate", "thermal_energy", "trapping_density"), "diffusion": ("time_scale", "density")}
        law = options["law"]
        missing = [name for name in own[law] if options[name] is None]
        if missing:
            raise ValueError(f"the law {law} needs {', '.join(own[law])}")
        foreign = [name for other in own if other != law for name in own[other] if options[name] is not None]
        if foreign:
            raise ValueError(f"the law {law} has no {foreign[0]}")
        return cls(**options)

    def exchange(self, xp, fluid):
        """Nothing is given."""
        if self.law == "captures":
            arguments = (fluid.density, fluid.thermal_energy, self.rate, self.thermal_energy, self.trapping_density)
            (decay,) = elementwise(xp, captures, *arguments)
        else:
            (decay,) = elementwise(xp, diffusion, fluid.density, self.density, self.time_scale)
        return xp.zeros_like(decay), decay

    def timestep(self, xp, fluid):
        """u/|du/dt|."""
        gain, decay = self.exchange(xp, fluid)
        return elementwise(xp, changing_time, fluid.smoothing_length, fluid.thermal_energy, gain, decay)[0]


def _size(body: Characteristic, options: Options) -> Found:
    assert body.thermal_energy is not None and body.mass is not None and body.central_density is not None
    if options["law"] == "diffusion":
        reached = body.central_density * DENSER > options["density"] or body.falling > 0.0
        share = body.end / options["time_scale"] if reached else 0.0
    else:
        specific = body.thermal_energy / body.mass
        warm = specific / options["thermal_energy"]
        share = options["rate"] * warm**6 * body.end / specific if specific > 0.0 else 0.0
        share = math.inf if body.falling > 0.0 else share
    return share, heat_change(body, share)


ENTRY = Entry(
    "heat that neutrinos carry off from a collapsed core, parametrised",
    {
        "law": choice(
            "captures: of electrons and positrons by free nucleons, with the sixth power of the temperature, where "
            "neutrinos are not trapped; diffusion: of those that are, over a time scale above a density",
            "captures", "diffusion",
        ),
        "rate": positive("specific_power", None, "of captures: energy lost at thermal_energy; 1.399e16 W/kg at 2 MeV"),
        "thermal_energy": positive(
            "specific_energy", None,
            "of captures: thermal energy at which it is; 2.9e14 J/kg for nucleons at 2 MeV",
        ),
        "trapping_density": positive("density", None, "of captures: at which the optical depth is 1; about 1e11 g/cm3"),
        "time_scale": positive("time", None, "of diffusion: in which heat leaks out, seconds to tens of seconds"),
        "density": positive("density", None, "of diffusion: above which it does"),
    },
    "particles", "Janka 2001; Murphy & Burrows 2008; Roberts & Reddy 2017", made=NeutrinoLoss, rank=17,
    size=Measure(
        "run in times of loss", "2/(3 gamma - 4) times that, of what pressure does",
        "Janka 2001", _size, (*ZONE, "thermal_energy", "central_density"), ("law",),
    ),
)  # fmt: skip
