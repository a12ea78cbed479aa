"""Sinks: point masses that take the place of matter which collapses beyond what particles resolve."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from astroinertia.effects import Characteristic, Effect, Entry, Found, Measure, Options, pytree, within_all
from astroinertia.effects.characteristic import tidal_parameter
from astroinertia.effects.measure import tidal_change
from astroinertia.effects.one_zone import difference
from astroinertia.effects.passes import falling_time, time_beside
from astroinertia.gravity.point_masses import attraction, potential_energy, reaction, virial
from astroinertia.units import REQUIRED, Option, choice, not_negative, positive

IN_THE_MIDDLE = 2.5  # |W| of a uniform sphere and as much mass in its middle, over that of the sphere: 3/2 over 3/5


@pytree
@dataclass(frozen=True, eq=False)
class Sinks(Effect):
    """a = -sum over sinks of M d/(d^2 + s^2)^(3/2); they feel the same, and move in the same kicks and drifts.

    Between steps (models.sph.accretion) particles above the density become sinks where what is within the radius is
    bound and converges, and sinks accrete what comes within the radius and cannot escape, or keep its distance (Bate,
    Bonnell & Price 1995, MNRAS 277, 362). What the fluid loses so is in the effect's rows as well. Two sinks within the
    radius of each other that are bound become the older one (Bleuler & Teyssier 2014, MNRAS 445, 4015). number: of
    sinks that there ever are, at most, with those of the scene's [[sinks]].
    Checked by tests/physics/test_sinks.py.
    """

    radius: Any
    density: Any = None
    softening: Any = 0.0
    number: Any = 16.0
    merging: str = field(default="bound", metadata={"static": True})

    kind: ClassVar[str] = "sinks"
    external: ClassVar[bool] = True

    def points(self, fluid):
        """Masses (n,), places (n, 3), and the square of the softening."""
        sinks = fluid.points[self.kind]
        return sinks.mass, sinks.position, self.softening**2

    def acceleration(self, xp, fluid):
        """By all sinks."""
        return attraction(xp, fluid.position, *self.points(fluid))

    def reaction(self, xp, fluid, weight):
        """Of all sinks."""
        _, place, softening = self.points(fluid)
        return reaction(xp, weight, fluid.position, place, softening)

    def potential_energy(self, xp, fluid):
        """-sum m M/(d^2 + s^2)^(1/2), with all energy that sinks have by themselves."""
        sinks = fluid.points[self.kind]
        alone = sinks.energy(xp, fluid.point_masses) + sinks.inner_energy
        return alone + potential_energy(xp, fluid.mass, fluid.position, *self.points(fluid))

    def virial(self, xp, fluid):
        """Of the attraction by all sinks."""
        return virial(xp, fluid.mass, fluid.position, fluid.centre, *self.points(fluid))

    def timestep(self, xp, fluid):
        """The time of each particle beside the sinks or in its fall (effects.passes), or an orbit at their radius."""
        sinks = fluid.points[self.kind]
        if not len(sinks.mass):
            return None
        fall = xp.sqrt(self.radius**3 / xp.max(sinks.mass))
        mass, place, softening = self.points(fluid)
        near = fluid, mass, place, sinks.velocity, softening
        times = xp.minimum(xp.minimum(time_beside(xp, *near), falling_time(xp, *near)), fall)
        return xp.minimum(times, sinks.meeting_time(xp, fluid.point_masses, xp.min(fluid.sound_speed)))

    def recorded(self, state):
        """The sinks, a row each by age (NaN before it forms and after it merges), and what they took from the fluid."""
        sinks, most = state.points[self.kind], int(self.number)

        def rows(array):
            padded = np.full((most, *array.shape[1:]), np.nan)
            padded[sinks.identity] = array
            return padded

        return {
            "sink_number": float(len(sinks.mass)),
            "sink_mass": rows(sinks.mass),
            "sink_position": rows(sinks.position),
            "sink_velocity": rows(sinks.velocity),
            "sink_spin": rows(sinks.spin),
            "accreted_mass": float(sinks.removed.mass),
            "accreted_momentum": sinks.removed.momentum,
            "accreted_second_moment": sinks.removed.second_moment,
            "accreted_mixed_moment": sinks.removed.mixed_moment,
            "sink_inner_energy": float(sinks.inner_energy),
        }


def _added_weight(body: Characteristic, options: Options) -> float | None:
    if not body.mass or not body.radius:
        return None
    return IN_THE_MIDDLE * sum(mass for mass, distance in body.stars if distance < body.radius) / body.mass


def _size(body: Characteristic, options: Options) -> Found:
    assert body.mass is not None and body.radius is not None
    forms = options["density"] is not None
    number = (body.central_density or 0.0) / options["density"] if forms else 0.0
    change = 1.0 if number >= 1.0 else within_all(body.falling) if forms else 0.0
    if body.stars:
        number = sum(mass for mass, _ in body.stars) / body.mass
        far = [tidal_parameter(body, *star) for star in body.stars if star[1] >= body.radius]
        change = max(change, _held(body, options), *(tidal_change(body, parameter) for parameter in far))
    return number, change


def _held(body: Characteristic, options: Options) -> float:
    """What the pull of sinks within the body changes."""
    zone, added = body.zone, _added_weight(body, options)
    if not added:
        return 0.0
    if zone is None:
        return 1.0
    assert body.gravitational is not None and body.second_moment is not None
    return difference(zone, body.end, weight=zone.weight + added * body.gravitational / body.second_moment)


ENTRY = Entry(
    "point masses that take the place of collapsing matter, and accrete what falls into them",
    {
        "radius": positive("length", REQUIRED, "within which a sink accretes what is bound to it"),
        "density": positive(
            "density", None, "above which bound, converging matter becomes a sink; none does without it"
        ),
        "softening": not_negative("length", 0.0, "Plummer softening of the sinks"),
        "number": Option("dimensionless", 16.0, "of sinks that there ever are, at most", minimum=1.0, maximum=1000.0),
        "merging": choice(
            "bound: two sinks within the radius of each other that are bound become one; never: all stay",
            "bound", "never",
        ),
    },
    "particles", "Bate, Bonnell & Price 1995; Bleuler & Teyssier 2014", made=Sinks, rank=11,
    size=Measure(
        "mass of the sinks that are there over the body's; of others, central density over theirs",
        "I of one zone by the virial theorem, with the pull of those within; as a tide, of those outside; all once the "
        "density is reached; the mass whose free fall ends before",
        "Chandrasekhar 1969, section 14; Bate, Bonnell & Price 1995", _size, ("mass", "radius"), ("radius",),
    ),
    added_weight=_added_weight,
)  # fmt: skip
