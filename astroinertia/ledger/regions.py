"""The ledger of a part of a body: what acts on its matter, and what crosses its edge.

The matter of a region is followed as that of the whole body is, kick by kick and drift by drift, about its own centre
of mass. Where membership changes, what enters and leaves is recorded by itself: with positions x and velocities v of
those particles relative to the centre before, and s = +1 for one that enters and -1 for one that leaves,

    dQ = sum s m x (x) x - M' d (x) d    dP = sum s m x (x) v - M' d (x) u    dK = sum s m v (x) v - M' u (x) u,

where M' is the mass afterwards, d = sum s m x / M' how far the centre is then from where it was, and u the change of
its velocity.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from astroinertia.engines.elementwise import totals
from astroinertia.engines.pytree import pytree
from astroinertia.ledger.moments import (
    Ledger,
    Whole,
    after_drift,
    after_kick,
    after_rounding,
    inertia_size,
    moments,
    open_ledger,
    weighted_outer,
)

Array = Any


@pytree
@dataclass(frozen=True)
class Flux:
    """What crossing the edge has changed since the start: mass, and Q, P and K (3, 3) about the region's own centre."""

    mass: Array
    second_moment: Array
    mixed_moment: Array
    kinetic_tensor: Array

    def add(self, more: "Flux") -> "Flux":
        """Both together."""
        return Flux(*(getattr(self, name) + getattr(more, name) for name in self.__dataclass_fields__))


@pytree
@dataclass(frozen=True)
class RegionLedger:
    """The ledger of a region's matter, the mass and centre that it refers to, and what has crossed the edge."""

    ledger: Ledger
    whole: Whole
    flux: Flux

    def drifted(self, xp: Any, dt: Array) -> "RegionLedger":
        """The ledger after free motion over dt."""
        mass, centre, velocity = self.whole
        return replace(
            self, ledger=after_drift(xp, self.ledger, dt), whole=Whole(mass, centre + dt * velocity, velocity)
        )

    def kicked(
        self, xp: Any, weight: Array, position: Array, before: Array, after: Array,
        increments: Sequence[Array | None], dt: Array | float = 1.0, complete: bool = True,
    ) -> "RegionLedger":  # fmt: skip
        """The ledger after a kick, as moments.after_kick; weight (n,) is the mass of members, zero of the others."""
        mass, centre, velocity = self.whole
        safe = Whole(xp.where(mass > 0.0, mass, 1.0), centre, velocity)  # an empty region has nothing that is kicked
        ledger = after_kick(xp, self.ledger, weight, position, before, after, increments, dt, safe, complete)
        gained = totals(xp, push, weight, before, after)[0][0] / safe.mass
        return replace(self, ledger=ledger, whole=Whole(mass, centre, velocity + gained))

    def rounded(
        self, xp: Any, weight: Array, before: Array, after: Array, velocity: Array, dt: Array
    ) -> "RegionLedger":
        """The ledger, drifted by dt, with what rounding did to places, as moments.after_rounding; weight as above."""
        mass, centre, pace = self.whole
        safe = Whole(xp.where(mass > 0.0, mass, 1.0), centre, pace)
        return replace(self, ledger=after_rounding(xp, self.ledger, weight, before, after, velocity, dt, safe))

    def exchanged(self, mass: Array, position: Array, velocity: Array, old: Array, new: Array) -> "RegionLedger":
        """The ledger after membership changed from `old` to `new` (N,), 1 for members, 0 for the others (numpy)."""
        flux = crossing(self.whole, mass, position, velocity, new - old)
        second = self.ledger.second_moment.add(flux.second_moment)
        size = inertia_size(np, second.total)
        ledger = replace(
            self.ledger,
            second_moment=second,
            mixed_moment=self.ledger.mixed_moment.add(flux.mixed_moment),
            kinetic_tensor=self.ledger.kinetic_tensor.add(flux.kinetic_tensor),
            largest_inertia=np.maximum(self.ledger.largest_inertia, size),
        )
        return RegionLedger(ledger, whole_of(mass * new, position, velocity, self.whole), self.flux.add(flux))


def push(xp, mass, before, after):
    """m (after - before)."""
    return ((mass * (after[0] - before[0]), mass * (after[1] - before[1]), mass * (after[2] - before[2])),)


def crossing(whole: Whole, mass: Array, position: Array, velocity: Array, sign: Array) -> Flux:
    """What particles change that enter (sign +1) a region of mass and centre `whole`, or leave it (-1); 0 stays."""
    moved = np.flatnonzero(sign)
    m = (np.asarray(sign) * np.asarray(mass))[moved]
    x, v = np.asarray(position)[moved] - whole.centre, np.asarray(velocity)[moved] - whole.velocity
    total = whole.mass + m.sum()
    scale = 1.0 / total if total > 0.0 else 0.0
    d, u = scale * (m @ x), scale * (m @ v)
    return Flux(
        np.asarray(m.sum()),
        weighted_outer(m, x, x) - total * np.outer(d, d),
        weighted_outer(m, x, v) - total * np.outer(d, u),
        weighted_outer(m, v, v) - total * np.outer(u, u),
    )


def whole_of(weight: Array, position: Array, velocity: Array, otherwise: Whole) -> Whole:
    """Mass, centre and velocity of members of mass `weight` (N,); an empty region stays where `otherwise` is."""
    total = np.asarray(weight).sum()
    if not total > 0.0:
        return Whole(np.zeros(()), np.asarray(otherwise.centre), np.asarray(otherwise.velocity))
    return Whole(total, (weight @ position) / total, (weight @ velocity) / total)


def open_region_ledger(mass: Array, position: Array, velocity: Array, member: Array, effects: int) -> RegionLedger:
    """The ledger of a region at the start (numpy); an empty one stands where the body's centre of mass is."""
    everything = whole_of(mass, position, velocity, Whole(0.0, np.zeros(3), np.zeros(3)))
    chosen = np.flatnonzero(member)
    whole = whole_of((mass * member)[chosen], position[chosen], velocity[chosen], everything)
    if len(chosen):
        ledger = open_ledger(np, mass[chosen], position[chosen], velocity[chosen], effects)
    else:
        ledger = open_ledger(np, np.ones(1), np.zeros((1, 3)), np.zeros((1, 3)), effects)
    nothing = np.zeros((3, 3))
    return RegionLedger(ledger, whole, Flux(np.zeros(()), nothing, nothing, nothing))


def region_moments(mass: Array, position: Array, velocity: Array, member: Array) -> tuple[Array, Array, Array]:
    """Q, P and K of a region's matter about its own centre, each (3, 3); zero of an empty one."""
    chosen = np.flatnonzero(member)
    if not len(chosen):
        return np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    return moments(mass[chosen], position[chosen], velocity[chosen])
