"""Electrons that a collapsing core loses to neutrinos, parametrised by the density."""

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from astroinertia.effects import ZONE, Characteristic, Effect, Entry, Found, Measure, Options, Output, PairTerm, pytree
from astroinertia.effects.one_zone import difference
from astroinertia.engines.elementwise import elementwise, totals
from astroinertia.inertia.tensor import namespace
from astroinertia.sph.fourth_order import weights
from astroinertia.units import (
    DIMENSIONLESS,
    GRAVITATIONAL_CONSTANT,
    SPEED_OF_LIGHT,
    Option,
    choice,
    not_negative,
    positive,
)

CAPTURES, LEFT = (3e10, 2e16), 0.56  # kg/m3 between which electrons are captured, and what is left of them

if TYPE_CHECKING:
    from astroinertia.matter.electron_axis import ElectronAxis

# Liebendoerfer 2005: rho_1, rho_2 (kg/m^3), Y_1, Y_2, Y_c.
FITS = {"G15": (3e10, 2e16, 0.5, 0.278, 0.035), "N13": (2e10, 2e16, 0.5, 0.285, 0.035)}
TRAPPING, ESCAPE = 2e15, 10.0  # kg/m^3 and MeV: Liebendoerfer 2005
# Shapiro & Teukolsky 1983, section 2.6, in units of m_u c^2: surface, n less H, symmetry and Coulomb terms of nuclei.
B2, B3, B4, B5 = 0.01911, 0.000840, 0.10175, 0.000763
NUCLEUS = 1.5 * (2.0 * B5 * B2**2) ** (1.0 / 3.0)  # surface and Coulomb energy of the best size, over Y^(2/3)
MEV, ATOMIC_MASS, PLANCK = 1.602176634e-13, 1.66053906660e-27, 6.62607015e-34  # J, kg, J s
_HC = PLANCK * SPEED_OF_LIGHT
ELECTRONS = 0.125 * (3.0 / math.pi) ** (1.0 / 3.0) * _HC / ATOMIC_MASS ** (4.0 / 3.0)  # P over (rho Y)^(4/3), SI
NEUTRINOS = math.pi / 3.0 * (ATOMIC_MASS / _HC) ** 3 * ATOMIC_MASS  # P over the fourth power of mu/m_u, SI


class Lepton(NamedTuple):
    """What a particle of a pair brings with it."""

    dW: Any
    d2W: Any
    lepton_slope: Any
    lepton_curvature: Any


def lepton_pair(xp, r, i: Lepton, j: Lepton):
    """The two sides of the gradient."""
    mine = i.lepton_slope * i.dW + i.lepton_curvature * r * i.d2W
    return (mine + j.lepton_slope * j.dW + j.lepton_curvature * r * j.d2W,)


LEPTONS = PairTerm("deleptonisation", lepton_pair, (Output("acceleration", "central"),))


def fitted(xp, density, middle, half, thin, dense, bulge):
    """Y(rho) of Liebendoerfer 2005; middle and half: of the interval of ln rho."""
    x = xp.minimum(xp.maximum((xp.log(density) - middle) / half, -1.0), 1.0)
    size = xp.abs(x)
    curved = 1.0 - size + 4.0 * size * (size - 0.5) * (size - 1.0)
    return 0.5 * (dense + thin) + 0.5 * x * (dense - thin) + bulge * curved


def energy(xp, density, fraction, electrons, rest):
    """u(rho, Y) of electrons and of what nuclei have by their composition."""
    cubic = xp.power(fraction, 1.0 / 3.0)
    nuclei = rest * (B4 * (0.5 - fraction) ** 2 + NUCLEUS * cubic**2 - B3 * fraction)
    return 3.0 * electrons * xp.power(density, 1.0 / 3.0) * fraction * cubic + nuclei


def chemical_potential(xp, density, fraction, electrons, rest):
    """du/dY = (mu_e + mu_p - mu_n)/m_u."""
    cubic = xp.power(fraction, 1.0 / 3.0)
    nuclei = rest * (2.0 * B4 * (fraction - 0.5) + 2.0 / 3.0 * NUCLEUS / cubic - B3)
    return 4.0 * electrons * xp.power(density, 1.0 / 3.0) * cubic + nuclei


def relativistic(xp, density, fraction, electrons, rest):
    """The same: u, P of the electrons and mu = du/dY."""
    pressure = electrons * xp.power(density * fraction, 4.0 / 3.0)
    potential = chemical_potential(xp, density, fraction, electrons, rest)
    return energy(xp, density, fraction, electrons, rest), pressure, potential


def trapped_pressure(xp, density, potential, neutrinos, trapping, outside):
    """P of trapped neutrinos, less what they have where they are free."""
    held = neutrinos * xp.maximum(potential, 0.0) ** 4
    return xp.where(density > trapping, xp.maximum(held - outside, 0.0), 0.0)


def plain_weights(xp, pressure, density, grad_h):
    """Weights of dW/dr and of r d2W/dr^2."""
    return pressure / (grad_h * density**2), 0.0 * pressure


def of_neutrinos(xp, density, potential, neutrinos, trapping, outside):
    """The same by itself."""
    return (trapped_pressure(xp, density, potential, neutrinos, trapping, outside),)


def captured(
    xp, density, density_before, lost, freed, potential_before, potential, taken, owed, rate, interval, settling,
    escape, neutrinos, trapping, outside,
):  # fmt: skip
    """The neutrinos' energy, the heat that is owed and the rate that it is given at, after `interval`.

    lost: electrons, of which `freed` is the energy; *_before: at its beginning. Half a step each is given at its
    beginning, by the rate of the step before, and at its end. With rates of single steps that adds up however steps
    differ in length, but for what the rates change meanwhile, which is settled at the rate `settling`.
    """
    heat = xp.where(density < trapping, xp.maximum(freed - escape * lost, 0.0), 0.0)
    push = trapped_pressure(xp, density_before, potential_before, neutrinos, trapping, outside)
    push = push + trapped_pressure(xp, density, potential, neutrinos, trapping, outside)
    squeezed = 0.5 * push * (1.0 / density_before - 1.0 / density)
    owed = owed - 0.5 * rate * interval
    now = heat / xp.where(interval > 0.0, interval, 1.0) + settling * owed
    rate = xp.where(interval > 0.0, xp.maximum(now, 0.0), rate)
    return taken + freed - heat + squeezed, owed + heat - 0.5 * rate * interval, rate


def held(xp, mass, further, taken, owed):
    """What a particle's energy has more than with the initial electrons, and what neutrinos have of it."""
    return mass * (further + owed + taken), mass * taken


@pytree
@dataclass(frozen=True, eq=False)
class Deleptonisation(Effect):
    """Electrons are captured as matter becomes denser: Y = min(Y, Y(rho)), Y(rho) a fit to transport.

    Liebendoerfer (2005, ApJ 633, 1042), up to bounce. Electrons are degenerate and relativistic, P = K (rho Y)^(4/3),
    K = (3/pi)^(1/3) hc/(8 m_u^(4/3)) (Shapiro & Teukolsky 1983, section 2.3): what the equation of state has for
    matter of the composition `electron_fraction` changes by

        dP = K rho^(4/3) (Y^(4/3) - Y_0^(4/3)) + P_nu,   P_nu = pi/(3 (hc)^3) (mu^4 - mu_t^4) above trapping_density,

    P_nu that of degenerate neutrinos in equilibrium (his at zero temperature) less what it is at that density, as
    only its gradient within acts. mu = mu_e + mu_p - mu_n follows from the energy, u = 3 K rho^(1/3) Y^(4/3) and that
    of nuclei, of the best size each: b_4 (1/2 - Y)^2 + (3/2) (2 b_5 b_2^2)^(1/3) Y^(2/3) - b_3 Y in units of m_u c^2
    (Shapiro & Teukolsky 1983, section 2.6). With an electron captured mu is free: below trapping_density neutrinos
    carry off escape_energy of it, or all of it where that is less, and matter is heated by the rest; above it they keep
    all, and what compresses them besides. Their energy is counted: total energies have it, and neutrino_energy says how
    much it is. The same electrons are in nuclear matter, whose other pressure is the equation of state's.
    Matter of a table over electron fractions has the P, u and mu of that table in place of those formulas
    (matter.electron_axis). mass_unit, length_unit: what a scene in code units has as its units, in kg and m.
    Tests: tests/unit/effects/kinds/test_deleptonisation.py.
    """

    fit: str = field(default="G15", metadata={"static": True})
    electron_fraction: Any = 0.4971
    escape_energy: Any = None
    trapping_density: Any = None
    mass_unit: Any = None
    length_unit: Any = None
    axis: "ElectronAxis | None" = field(default=None, metadata={"of_problem": True})

    kind: ClassVar[str] = "deleptonisation"

    def in_units(self, units):
        """Refuses units that are given twice, or not at all."""
        own = (self.mass_unit, self.length_unit)
        if units == DIMENSIONLESS:
            if None in own:
                raise ValueError("the scene has no units: mass_unit (kg) and length_unit (m) must say what 1 is.")
            return self
        if own != (None, None):
            raise ValueError("mass_unit and length_unit are for scenes in code units; leave them away.")
        return replace(self, mass_unit=units.mass, length_unit=units.length)

    @property
    def electron_fractions(self):
        """From what is left in the densest matter to what there was."""
        return FITS[self.fit][3], float(self.electron_fraction)

    def on_axis(self, axis, units):
        """The effect with P, u and mu of a table."""
        return replace(self, axis=axis.in_units(units.unit("density"), units.unit("specific_energy")))

    @property
    def neighbour_terms(self):
        """The gradient of the pressure."""
        return (LEPTONS,)

    def law(self, xp):
        """The numbers of fitted."""
        first, last, *fractions = FITS[self.fit]
        half = 0.5 * math.log(last / first)
        return math.log(first) + half - xp.log(self.mass_unit / self.length_unit**3), half, *fractions

    @property
    def electrons(self):
        """K of electrons, and m_u c^2/m_u."""
        square = self.length_unit / (GRAVITATIONAL_CONSTANT * self.mass_unit)
        return ELECTRONS / (GRAVITATIONAL_CONSTANT * self.mass_unit ** (2.0 / 3.0)), SPEED_OF_LIGHT**2 * square

    def worth(self, xp, density, fraction):
        """u, P and mu = du/dY of the electrons, and of what nuclei have by their composition, each (N,)."""
        if self.axis is not None:
            return self.axis.worth(xp, density, fraction)
        return elementwise(xp, relativistic, density, fraction, *self.electrons)

    @property
    def escape(self):
        """Energy that an electron's neutrino carries off, per mass of its baryon."""
        if self.escape_energy is not None:
            return self.escape_energy * (self.mass_unit / ATOMIC_MASS)
        return ESCAPE * MEV / ATOMIC_MASS * self.length_unit / (GRAVITATIONAL_CONSTANT * self.mass_unit)

    def trapped(self, xp):
        """The numbers of trapped_pressure."""
        unit = self.mass_unit / self.length_unit**3
        trapping = TRAPPING / unit if self.trapping_density is None else self.trapping_density
        speed = GRAVITATIONAL_CONSTANT * self.mass_unit / self.length_unit
        neutrinos = NEUTRINOS * speed**3 / unit
        dense = xp.full((1,), trapping)
        there = self.worth(xp, dense, fitted(xp, dense, *self.law(xp)))[2][0]
        return neutrinos, trapping, neutrinos * xp.maximum(there, 0.0) ** 4

    def initial_memory(self, xp, fluid):
        """Y, what neutrinos have and what matter is owed, per mass, the rate that it is given at, and the density.

        Besides, what pressure and energy have more than the equation of state's.
        """
        none = xp.zeros_like(fluid.density)
        (fraction,) = elementwise(xp, least, fluid.density, self.electron_fraction, *self.law(xp))
        further = self.further(xp, fluid.density, fraction, self.trapped(xp))
        return {
            "electron_fraction": fraction, "neutrino_energy": none, "capture_heat": none, "capture_rate": none,
            "capture_density": fluid.density, **further,
        }  # fmt: skip

    def recalled(self, xp, arrays):
        """What a snapshot has of the memory; what neutrinos have, and the heat that is owed, it lacks."""
        if "electron_fraction" not in arrays:
            return {}
        fraction = arrays["electron_fraction"]
        return {"electron_fraction": fraction, **self.further(xp, arrays["density"], fraction, self.trapped(xp))}

    def remember(self, xp, fluid, interval):
        """The same, `interval` later."""
        memory, density = fluid.memory, fluid.density
        before, dense_before = memory["electron_fraction"], memory["capture_density"]
        (after,) = elementwise(xp, least, density, before, *self.law(xp))
        # In the mean of both densities, which with the pressure at both ends of a step leaves no error of first order.
        first, first_left = (self.worth(xp, dense_before, fraction) for fraction in (before, after))
        last, here = (self.worth(xp, density, fraction) for fraction in (before, after))
        freed = 0.5 * (first[0] - first_left[0] + last[0] - here[0])
        trapped = self.trapped(xp)
        names = ("neutrino_energy", "capture_heat", "capture_rate")
        evolved = elementwise(
            xp, captured, density, dense_before, before - after, freed, first[2], here[2],
            *(memory[name] for name in names), interval + xp.zeros_like(density),
            fluid.sound_speed / fluid.smoothing_length, self.escape, *trapped,
        )  # fmt: skip
        return {
            "electron_fraction": after, **dict(zip(names, evolved, strict=True)), "capture_density": density,
            **self.further(xp, density, after, trapped, here),
        }  # fmt: skip

    def further_pressure(self, xp, density):
        """That of matter which has been no denser before."""
        (fraction,) = elementwise(xp, least, density, self.electron_fraction, *self.law(xp))
        return self.further(xp, density, fraction, self.trapped(xp))["further_pressure"]

    def further(self, xp, density, fraction, trapped, here=None):
        """What pressure and specific energy have more than with the initial electrons, each (N,); here: their worth."""
        energy, pressure, potential = self.worth(xp, density, fraction) if here is None else here
        full_energy, full_pressure, _ = self.worth(xp, density, self.electron_fraction)
        (push,) = elementwise(xp, of_neutrinos, density, potential, *trapped)
        return {"further_pressure": pressure - full_pressure + push, "further_energy": energy - full_energy}

    def fields(self, xp, fluid):
        """The weights of its pressure."""
        push = fluid.memory["further_pressure"]
        if fluid.contrast is None:
            slope, curvature = elementwise(xp, plain_weights, push, fluid.density, fluid.grad_h)
        else:  # which only the order of the pressure asks for
            around = fluid.gradients["pressure"]["curvature"]
            slope, curvature = elementwise(xp, weights, push, fluid.density, fluid.contrast, fluid.grad_h, around)
        return {"lepton_slope": slope, "lepton_curvature": curvature}

    def exchange(self, xp, fluid):
        """What captures leave behind."""
        rate = fluid.memory["capture_rate"]
        return rate, xp.zeros_like(rate)

    def energies(self, xp, fluid):
        """What energies have more than with the initial electrons, and what neutrinos have of it."""
        memory = (fluid.memory[name] for name in ("further_energy", "neutrino_energy", "capture_heat"))
        sums = totals(xp, held, fluid.mass, *memory)
        return tuple(each[0] for each in sums)

    def potential_energy(self, xp, fluid):
        """Of electrons and nuclei, less what they began with; with the neutrinos and what matter is still owed."""
        return self.energies(xp, fluid)[0]

    def recorded(self, state):
        """What neutrinos have, and the least Y."""
        fluid = state.rates.fluid
        return {
            "neutrino_energy": float(self.energies(namespace(fluid.mass), fluid)[1]),
            "least_electron_fraction": float(fluid.memory["electron_fraction"].min()),
        }


def least(xp, density, initial, middle, half, thin, dense, bulge):
    """Y of matter that has the initial one or less."""
    return (xp.minimum(initial, fitted(xp, density, middle, half, thin, dense, bulge)),)


def _size(body: Characteristic, options: Options) -> Found:
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


ENTRY = Entry(
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
        "share of electrons captured", "I of one zone with the pressure of those left to the power 4/3",
        "Liebendoerfer 2005", _size, (*ZONE, "central_density"),
    ),
    made=Deleptonisation, rank=6,
)  # fmt: skip
