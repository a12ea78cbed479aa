"""Characteristic numbers of a scene, as plain data: what the sizes of effects are made of (sizes.py).

scene/characteristic.py works them out. All quantities are in one system of units, SI or code units, with the G given;
None is what a scene does not tell. Tests: tests/unit/effects/test_sizes.py.
"""

import math
from dataclasses import dataclass

from astroinertia.effects.one_zone import Zone

Vector = tuple[float, float, float]
# What the body as one zone is made of, and what messages call it.
OF_ZONE = {
    "second_moment": "moment of inertia",
    "gravitational": "gravitational energy",
    "triple_pressure": "pressure",
    "rotational": "rotation",
}


@dataclass(frozen=True)
class Neighbour:
    """Another body: its mass, the mean and the least distance in the run, its orbit's eccentricity, rate and normal."""

    name: str
    mass: float
    distance: float
    nearest: float
    eccentricity: float = 0.0
    rate: float = 0.0
    normal: Vector = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Pair:
    """Two bodies of a scene on an orbit: masses and distance."""

    masses: tuple[float, float]
    distance: float


@dataclass(frozen=True)
class Characteristic:
    """A body, its run and its surroundings.

    moments: principal moments, ascending. spin: the rate of rotation, about spin_axis; wobble: sine of the angle
    between it and the axis of the largest moment. momentum_axis: the direction of L, where it is known, and
    momentum_wobble: its angle from that axis. second_moment: trace of Q. gravitational: |W|. rotational: T, of all
    motion that neither swells nor shrinks the body; shear: size of the rate of strain of that motion. triple_pressure:
    3 times the volume integral of the pressure; further_pressure: that of what effects add to it at the start;
    added_weight: what effects add to |W| over it. expansion: rate at which the size grows. fallen: share of the mass
    that would be in the centre at the end if nothing held it up. deforms: the model lets the body change its size;
    held: the pressure keeps its volume, whatever happens; homologous: it falls without one part passing another.
    position: of its centre. stars: mass of each sink that there is from the start, and its distance from there.
    bodies: how many; touching: materials meet in it, or bodies can.
    weighs, presses: whether gravity and pressure act, as far as that is settled.
    """

    end: float
    gravitational_constant: float
    speed_of_light: float | None = None
    deforms: bool = True
    held: bool = False
    bodies: int = 1
    touching: bool = False
    weighs: bool = True
    presses: bool = True
    rate_needs_gravity: bool = False
    mass: float | None = None
    radius: float | None = None
    moments: Vector | None = None
    second_moment: float | None = None
    gravitational: float | None = None
    triple_pressure: float | None = None
    further_pressure: float = 0.0
    added_weight: float = 0.0
    position: Vector = (0.0, 0.0, 0.0)
    stars: tuple[tuple[float, float], ...] = ()
    gamma: float = 5.0 / 3.0
    thermal_energy: float | None = None
    rotational: float | None = None
    shear: float = 0.0
    expansion: float = 0.0
    spin: float | None = None
    spin_axis: Vector = (0.0, 0.0, 1.0)
    wobble: float = 0.0
    momentum_axis: Vector | None = None
    momentum_wobble: float = 0.0
    central_density: float | None = None
    fallen: float = 0.0
    homologous: bool = False
    neighbours: tuple[Neighbour, ...] | None = ()
    pair: Pair | None = None

    @property
    def dynamical_time(self) -> float | None:
        """(R^3/(G M))^(1/2)."""
        if self.mass is None or self.radius is None:
            return None
        return math.sqrt(self.radius**3 / (self.gravitational_constant * self.mass))

    @property
    def run_length(self) -> float | None:
        """The run in dynamical times."""
        return None if self.dynamical_time is None else self.end / self.dynamical_time

    @property
    def turns(self) -> float | None:
        """The run in turns of the body."""
        return self.end * self.spin / (2.0 * math.pi) if self.spin else None

    @property
    def free_fall_time(self) -> float | None:
        """(3 pi/(32 G rho))^(1/2) of the mean density of the sphere of this radius."""
        return None if self.dynamical_time is None else math.pi / math.sqrt(8.0) * self.dynamical_time

    @property
    def compactness(self) -> float | None:
        """G M/(R c^2)."""
        if self.mass is None or self.radius is None or self.speed_of_light is None:
            return None
        return self.gravitational_constant * self.mass / (self.radius * self.speed_of_light**2)

    @property
    def thermal_to_gravitational(self) -> float | None:
        """U/|W|."""
        return _ratio(self.thermal_energy, self.gravitational)

    @property
    def rotational_to_gravitational(self) -> float | None:
        """T/|W|."""
        return _ratio(self.rotational, self.gravitational)

    @property
    def rotation_over_break_up(self) -> float | None:
        """Spin over the rate of an orbit at the surface."""
        if self.spin is None or self.dynamical_time is None:
            return None
        return self.spin * self.dynamical_time

    @property
    def mach_number(self) -> float | None:
        """Speed at which the surface moves in or out, over that of sound in the mean, (gamma Pi/M)^(1/2)."""
        if self.triple_pressure is None or self.mass is None or self.radius is None:
            return None
        speed = abs(self.expansion) * self.radius
        sound = math.sqrt(self.gamma * self.triple_pressure / (3.0 * self.mass))
        return speed / sound if sound > 0.0 else math.inf if speed > 0.0 else 0.0

    @property
    def falling(self) -> float:
        """The share of the mass that falls to the centre in the run: `fallen`, as far as nothing holds it up."""
        lacking = 0.0 if self.support is None else 1.0 - self.support
        return self.fallen * lacking if lacking > 1e-6 else 0.0

    @property
    def support(self) -> float | None:
        """(3 Pi + 2 T)/|W|, of the forces that act: 1 in equilibrium; None where nothing weighs or is known."""
        zone = self.zone
        if zone is None or zone.weight == 0.0:
            return None
        assert self.second_moment is not None
        further = self.further_pressure / self.second_moment if self.presses else 0.0
        return (zone.pressure + further + zone.turning) / (zone.weight * (1.0 + self.added_weight))

    @property
    def zone(self) -> Zone | None:
        """The body as one zone; None where the scene does not tell what that takes, or numbers do not reach so far."""
        needed = tuple(getattr(self, name) for name in OF_ZONE)
        if any(value is None for value in needed) or not self.second_moment:
            return None
        weight, pressure, turning = (value / self.second_moment for value in needed[1:])
        acting = weight if self.weighs else 0.0, pressure if self.presses else 0.0
        found = *acting, 2.0 * turning, self.expansion
        return Zone(*found[:3], self.gamma, self.expansion) if all(map(math.isfinite, found)) else None


def tidal_parameter(body: Characteristic, mass: float, distance: float) -> float:
    """(M'/M) (R/d)^3: the tide of a mass at a distance over the body's own gravity, at its surface."""
    assert body.mass is not None and body.radius is not None
    return mass / body.mass * (body.radius / distance) ** 3 if distance > 0.0 else math.inf


def _ratio(part: float | None, whole: float | None) -> float | None:
    if part is None or whole is None:
        return None
    return part / whole if whole > 0.0 else math.inf if part > 0.0 else 0.0
