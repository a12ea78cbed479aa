"""General relativity's stronger gravity as a radial force beside Newton's."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from astroinertia.effects import Characteristic, Effect, Entry, pytree
from astroinertia.effects.measure import ZONE, Found, Measure, Options, lit
from astroinertia.effects.one_zone import difference
from astroinertia.units import LIGHT, positive

HEAVIER = 4.0  # times its compactness a star is heavier for relativity: Gamma, pressure and energy in the mean

CENTRAL = 8.0  # particles in the innermost shell; those further out have more, as their number to the power 1/3
ITERATIONS = 16  # of m and Gamma: each gains a factor of the compactness over their number


def shell_ends(count: int) -> np.ndarray:
    """How many particles lie within the outer edge of each shell, (K,), of `count` in the order of their distance."""
    shells = max(1, int((count / CENTRAL) ** (2.0 / 3.0)))
    return np.unique(np.rint(count * (np.arange(1, shells + 1) / shells) ** 1.5).astype(np.int64))


@pytree
@dataclass(frozen=True, eq=False)
class RelativisticPotential(Effect):
    """What general relativity adds to the mean gravity over spheres: a = -(g_TOV - g_N) r/|r| about the centre of mass.

    With g_N = M/r^2 and

        g_TOV = (m + 4 pi r^3 P/c^2) (1 + (u + P/rho)/c^2)/(r^2 Gamma^2),   Gamma^2 = 1 + v^2/c^2 - 2 m/(r c^2),
        dm = 4 pi r^2 rho (1 + u/c^2) Gamma dr,

    of rho, P, u and the radial velocity v averaged over spheres. It is case A of Marek, Dimmelmeier, Janka, Mueller &
    Buras (2006, A&A 445, 273) without neutrinos: the factor Gamma in m makes up for a Newtonian volume 4 pi r^2 dr.

    Averages are over shells of particles in the order of their distance. What their numbers leave of a net force is
    taken off uniformly, so that momentum is exact; the force is central, and so is angular momentum. It has no
    potential energy, as pressure and motion weigh: its work comes from outside, and the energy that is conserved is the
    Newtonian one less that work. One round body alone: nothing of it is relativistic but the mean weight, and space,
    speeds and time stay Newton's. A horizon, 2 m = r c^2 at rest, leaves no number, which ends the run.
    Tests: tests/unit/effects/kinds/test_relativistic_potential.py.
    """

    speed_of_light: Any

    kind: ClassVar[str] = "relativistic_potential"
    external: ClassVar[bool] = True
    whole_body: ClassVar[bool] = True
    not_finite: ClassVar[str] = "a horizon has formed, 2 G m = r c^2, beyond which this gravity goes no further"

    def weights(self, xp, fluid):
        """(g_TOV - g_N)/r of every particle, (N,)."""
        separation = fluid.position - fluid.centre
        distance = xp.sqrt(xp.sum(separation**2, axis=1))
        order = xp.argsort(distance)
        ends, r = shell_ends(len(distance)), distance[order]
        mass, volume = fluid.mass[order], (fluid.mass / fluid.density)[order]

        def within(values):  # of sorted particles, at the edges of the shells from the centre on, (K + 1,)
            return xp.concatenate([xp.zeros(1), xp.cumsum(values)[ends - 1]])

        def mean(values, by):
            return xp.diff(within(by * values[order])) / xp.diff(within(by))

        light = self.speed_of_light**-2.0
        outward = xp.sum(separation * (fluid.velocity - fluid.centre_velocity), axis=1) / xp.maximum(distance, 1e-100)
        enclosed, speed = within(mass), mean(outward, mass)
        content, push = fluid.internal_energy, fluid.pressure
        if "further_pressure" in fluid.memory:
            content, push = content + fluid.memory["further_energy"], push + fluid.memory["further_pressure"]
        energy, pressure = light * mean(content, mass), light * mean(push, volume)
        enthalpy = 1.0 + energy + pressure * xp.diff(within(volume)) / xp.diff(enclosed)
        # Edges lie between particles, and the last at the outermost; middles halve the volumes.
        edge = xp.concatenate([xp.zeros(1), 0.5 * (r[ends[:-1] - 1] + r[ends[:-1]]), r[-1:]])
        middle = xp.cbrt(0.5 * (edge[1:] ** 3 + edge[:-1] ** 3))
        inside, gamma = 0.5 * (enclosed[1:] + enclosed[:-1]), xp.ones_like(middle)
        for _ in range(ITERATIONS):
            mass_energy = xp.concatenate([xp.zeros(1), xp.cumsum((1.0 + energy) * gamma * xp.diff(enclosed))])
            active = 0.5 * (mass_energy[1:] + mass_energy[:-1])
            square = 1.0 + light * (speed**2 - 2.0 * active / middle)
            gamma = xp.sqrt(xp.where(square > 0.0, square, xp.nan))
        weight = (active + 4.0 * math.pi * middle**3 * pressure) * enthalpy / gamma**2
        last = mass_energy[-1:] / (1.0 + light * (speed[-1:] ** 2 - 2.0 * mass_energy[-1:] / r[-1:]))
        places, weight = xp.concatenate([middle, r[-1:]]), xp.concatenate([weight - inside, last - enclosed[-1:]])
        return xp.interp(distance, places, weight / places**3)

    def acceleration(self, xp, fluid):
        """-w (x - c), less its mean."""
        pull = -self.weights(xp, fluid)[:, None] * (fluid.position - fluid.centre)
        return pull - (fluid.mass @ pull) / xp.sum(fluid.mass)

    def virial(self, xp, fluid):
        """-sum m w (x - c) (x) (x - c)."""
        separation = fluid.position - fluid.centre
        return -((fluid.mass * self.weights(xp, fluid))[:, None] * separation).T @ separation

    def timestep(self, xp, fluid):
        """The time w^(-1/2) in which it alone would pull matter to the centre."""
        return 1.0 / xp.sqrt(xp.max(xp.abs(self.weights(xp, fluid))) + 1e-60)


def _added_weight(body: Characteristic, options: Options) -> float | None:
    compact = lit(body, options).compactness
    return None if compact is None else HEAVIER * compact


def _size(body: Characteristic, options: Options) -> Found:
    zone, compact, added = body.zone, lit(body, options).compactness, _added_weight(body, options)
    assert zone is not None and compact is not None and added is not None
    return compact, difference(zone, body.end, weight=zone.weight * (1.0 + added))


ENTRY = Entry(
    "general relativity's stronger gravity in the mean over spheres, beside Newton's (one round body, until a horizon)",
    {"speed_of_light": positive("velocity", LIGHT, "c; smaller than it is, the body is more compact")},
    "body", "Marek, Dimmelmeier, Janka, Mueller & Buras 2006, case A", colour="sky", needs=("gravity",),
    size=Measure(
        "G M/(R c^2)", "I of one zone by the virial theorem, with a weight larger by four times that",
        "Chandrasekhar 1969, section 14; Marek et al. 2006", _size, ZONE,
    ),
    made=RelativisticPotential, rank=15, added_weight=_added_weight,
)  # fmt: skip
