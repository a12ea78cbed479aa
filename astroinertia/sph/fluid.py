"""What the effects see: the particles and everything that follows from them at one instant."""

from dataclasses import dataclass, field
from typing import Any

from astroinertia.engines.pytree import pytree
from astroinertia.ledger.moments import Whole

Array = Any


@pytree
@dataclass(frozen=True)
class Fluid:
    """The fluid at one instant, in code units, one row a particle.

    velocity is the one predicted for this instant where a step is under way. grad_h is Omega and zeta the softening
    correction of Price & Monaghan (2007, MNRAS 374, 1347), None where nothing is softened. contrast is that of a
    density of fourth order (sph.fourth_order), None where it is the kernel's; standard_density, that of its material
    where densities are sums of standard volumes (sph.standard_volumes), else None. acceleration is the total of the
    evaluation before. internal_energy is specific, thermal_energy its part above the cold curve. gradients and sums
    hold {effect: {output: array}} of the passes made so far; memory holds what effects evolve for themselves; points
    {effect: point masses} are beside the fluid (gravity.point_masses.PointMasses, rotation.on_orbits.OnOrbits). body is
    the whole body where these are some of its particles, None where they are all.
    """

    time: Array
    mass: Array
    position: Array
    velocity: Array
    entropy: Array
    smoothing_length: Array
    density: Array
    grad_h: Array
    zeta: Array | None
    pressure: Array
    sound_speed: Array
    internal_energy: Array
    thermal_energy: Array
    acceleration: Array
    memory: dict[str, Array]
    kernel: str = field(metadata={"static": True})
    gradients: dict[str, dict[str, Array]] = field(default_factory=dict)
    sums: dict[str, dict[str, Array]] = field(default_factory=dict)
    points: dict[str, Any] = field(default_factory=dict)
    body: Whole | None = None
    contrast: Array | None = None
    standard_density: Array | None = None

    @property
    def point_masses(self) -> list[Any]:
        """Those of the points that have masses; others are what effects know of the whole body."""
        return [group for group in self.points.values() if hasattr(group, "mass")]

    @property
    def with_points(self) -> Whole:
        """The whole body and the point masses that are part of it."""
        mass = self.mass.sum() if self.body is None else self.body.mass
        centre, velocity = self.centre, self.centre_velocity
        for group in self.point_masses:
            if group.of_body:
                total = mass + group.mass.sum()
                centre = (mass * centre + group.mass @ group.position) / total
                velocity = (mass * velocity + group.mass @ group.velocity) / total
                mass = total
        return Whole(mass, centre, velocity)

    @property
    def centre(self) -> Array:
        """Centre of mass of the whole body, (3,)."""
        return (self.mass @ self.position) / self.mass.sum() if self.body is None else self.body.centre

    @property
    def centre_velocity(self) -> Array:
        """Velocity of the centre of mass, (3,)."""
        return (self.mass @ self.velocity) / self.mass.sum() if self.body is None else self.body.velocity
