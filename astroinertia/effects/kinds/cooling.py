"""Cooling and heating: thermal energy that matter radiates, or is given."""

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

from astroinertia.effects import ZONE, Characteristic, Effect, Entry, Found, Measure, Options, pytree
from astroinertia.effects.heat_exchange import changing_time, heat_change
from astroinertia.engines.elementwise import elementwise
from astroinertia.units import Option, choice, not_negative, positive

NO_TIME = 1e-9  # of the time scale at first: one that falls has come to zero there
COLD = 1e-20  # of the reference energy: below it a power law falls no further


def turning(xp, x, v):
    """|x cross v| / x^2: the angular velocity about the origin."""
    square = x[0] ** 2 + x[1] ** 2 + x[2] ** 2
    turned = (x[1] * v[2] - x[2] * v[1]) ** 2 + (x[2] * v[0] - x[0] * v[2]) ** 2 + (x[0] * v[1] - x[1] * v[0]) ** 2
    return (xp.sqrt(turned) / xp.where(square > 0.0, square, 1.0),)


def power_law(xp, density, energy, reference_density, reference_energy, density_exponent, energy_exponent):
    """(rho/rho_0)^a (u/u_0)^(b - 1)."""
    warm = xp.maximum(energy / reference_energy, COLD)
    return (xp.power(density / reference_density, density_exponent) * xp.power(warm, energy_exponent - 1.0),)


def towards(xp, energy, decay, floor):
    """Gain and decay of du/dt = -k (u - floor) above the floor; nothing below it."""
    above = xp.where(energy > floor, decay, 0.0)
    return above * floor, above


def heated(xp, gain, rate):
    """A gain that is larger by a constant rate."""
    return (gain + rate,)


@pytree
@dataclass(frozen=True, eq=False)
class Cooling(Effect):
    """du/dt = -(u - floor)/tau + heating_rate of the thermal energy u, above the floor; below it nothing is radiated.

    law "time_scale": tau = time_scale + t time_scale_change everywhere. At constant density that is dA/dt = -A/tau of
    the entropy function, everywhere alike: a star contracts homologously. With rho ~ R^-3 and P ~ R^-4 in equilibrium
    R ~ A^(1/(3 gamma - 4)), so with time_scale_change -3/(2 (3 gamma - 4)), which is -3/2 for gamma 5/3, tau falls
    as the free-fall time does, and A = A_0 (1 - 3 t/(2 time_scale))^(2/3).
    law "power_law": tau = time_scale (rho/rho_0)^-a (u/u_0)^(1-b), with rho_0 and u_0 the references, so that
    du/dt ~ rho^a u^b: a = 1, b = 1/2 is thermal bremsstrahlung (Rybicki & Lightman 1979, eq. 5.15b).
    law "beta": tau = beta/Omega (Gammie 2001, ApJ 553, 174), Omega that of the matter about the centre of mass of
    fluid and sinks.
    Linear laws are integrated exactly over a step; limit "none" lets steps be longer than tau.
    """

    time_scale: Any = None
    time_scale_change: Any = None
    reference_density: Any = None
    reference_energy: Any = None
    density_exponent: Any = 1.0
    energy_exponent: Any = 0.5
    beta: Any = None
    heating_rate: Any = None
    floor: Any = None
    law: str = field(default="time_scale", metadata={"static": True})
    limit: str = field(default="cooling_time", metadata={"static": True})

    kind: ClassVar[str] = "cooling"
    external: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses a law without its numbers, and numbers of another law."""
        needs = {
            "time_scale": ("time_scale",),
            "power_law": ("time_scale", "reference_density", "reference_energy"),
            "beta": ("beta",),
        }
        law = options["law"]
        missing = [name for name in needs[law] if options[name] is None]
        if missing and not (missing == ["time_scale"] and options["heating_rate"] is not None):
            raise ValueError(f"the law {law} needs {' and '.join(missing)}")
        numbers = {name for names in needs.values() for name in names} | {"time_scale_change"}
        own = {*needs[law], *(("time_scale_change",) if law == "time_scale" else ())}
        foreign = [name for name in sorted(numbers - own) if options[name] is not None]
        if foreign:
            raise ValueError(f"the law {law} has no {foreign[0]}")
        return cls(**options)

    @property
    def inertial(self):
        """Where the time scale is that of the rotation."""
        return 'by the law "beta" follows from the rotation in inertial axes' if self.law == "beta" else ""

    def rate(self, xp, fluid):
        """1/tau, (N,)."""
        none = xp.zeros_like(fluid.density)
        if self.law == "beta":
            whole = fluid.with_points
            about = fluid.position - whole.centre, fluid.velocity - whole.velocity
            return elementwise(xp, turning, *about)[0] / self.beta
        if self.time_scale is None:
            return none
        if self.law == "power_law":
            factor = elementwise(
                xp, power_law, fluid.density, fluid.thermal_energy, self.reference_density, self.reference_energy,
                self.density_exponent, self.energy_exponent,
            )  # fmt: skip
            return factor[0] / self.time_scale
        if self.time_scale_change is None:
            return none + 1.0 / self.time_scale
        return none + 1.0 / xp.maximum(self.time_scale + fluid.time * self.time_scale_change, NO_TIME * self.time_scale)

    def spent(self, xp, time):
        """Whether tau has fallen to zero: nothing is left to radiate, and no step has to follow it."""
        return self.time_scale + time * self.time_scale_change <= NO_TIME * self.time_scale

    def exchange(self, xp, fluid):
        """What is radiated, towards the floor, and what is given."""
        decay = self.rate(xp, fluid)
        gain = xp.zeros_like(decay)
        if self.floor is not None:
            gain, decay = elementwise(xp, towards, fluid.thermal_energy, decay, self.floor)
        if self.heating_rate is not None:
            gain = elementwise(xp, heated, gain, self.heating_rate)[0]
        return gain, decay

    def timestep(self, xp, fluid):
        """u/|du/dt|, and what heating takes to move matter by a smoothing length."""
        if self.limit == "none":
            return None
        gain, decay = self.exchange(xp, fluid)
        limit = elementwise(xp, changing_time, fluid.smoothing_length, fluid.thermal_energy, gain, decay)[0]
        if self.time_scale_change is None:
            return limit
        return xp.where(self.spent(xp, fluid.time), xp.inf, limit)


def _size(body: Characteristic, options: Options) -> Found:
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
    return times, heat_change(body, times)


ENTRY = Entry(
    "cooling and heating of the matter: thermal energy that it radiates, or is given",
    {
        "law": choice(
            "du/dt = -u/tau of the thermal energy u: time_scale has one tau everywhere, so that a star contracts "
            "homologously; power_law has du/dt ~ rho^a u^b; beta has tau = beta/Omega, of the local rotation about the "
            "centre of mass of fluid and sinks",
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
    "particles", "Gammie 2001; Rybicki & Lightman 1979", made=Cooling, rank=16,
    size=Measure(
        "run in cooling times", "2/(3 gamma - 4) of that, times what pressure does",
        "Chandrasekhar 1939, chapter 4", _size, (*ZONE, "thermal_energy"), ("law",),
    ),
)  # fmt: skip
