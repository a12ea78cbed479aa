"""The reaction of the gravitational waves that a body sends out."""

import math
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from astroinertia.effects import Characteristic, Effect, Entry, pytree
from astroinertia.effects.effect import moments
from astroinertia.effects.measure import Found, Measure, Options, lit, within_all
from astroinertia.units import LIGHT, positive

PERIODS = 2.0  # of the waves, that their frequency is averaged over
UNSEEN = 2.0  # steps before the first third derivative
FASTEST = 2.0  # factor of omega^4 in that time: an inspiral's; what changes faster, as in a collapse, has no frequency


@pytree
@dataclass(frozen=True, eq=False)
class Waves:
    """How fast a body's quadrupole changes: dQ/dt and d2Q/dt2 without trace at the last steps, and running means.

    first (3, 3) is of `time`, second (3, 3) of the middle of the last step, `last` long; first_square and third_square
    (2,) are the running means of |dQ/dt|^2 and |d3Q/dt3|^2, and the running means of these; steps is their number.
    """

    time: Any
    last: Any
    first: Any
    second: Any
    first_square: Any
    third_square: Any
    steps: Any

    def drifted(self, dt, time):
        """Nothing happens between steps."""
        return self

    def kicked(self, dt):
        """Nor in kicks."""
        return self

    def frequency_to_the_fourth(self, xp):
        """<|d3Q/dt3|^2> / <|dQ/dt|^2>: omega^4 of a wave of one frequency, as it is now.

        A running mean is that of some time ago, and one of it of as long before: from their ratio what it is now, where
        it has not changed by more than FASTEST. In logarithms this is Brown's double exponential smoothing (Brown 1963,
        Smoothing, Forecasting and Prediction of Discrete Time Series).
        """
        moving = xp.min(self.first_square) > 0.0
        once, twice = xp.where(moving, self.third_square / xp.where(moving, self.first_square, 1.0), 0.0)
        growth = once / xp.where(twice > 0.0, twice, xp.where(once > 0.0, once, 1.0))
        return once * xp.minimum(growth, FASTEST)


def averaged(xp, means, value, share):
    """A running mean that takes in a share of the value, and one that takes in as much of the mean, (2,)."""
    once = means[0] + share * (value - means[0])
    return xp.stack([once, means[1] + share * (once - means[1])])


def without_trace(xp, tensor):
    """The part of a matrix (3, 3) that has no trace."""
    return tensor - xp.trace(tensor) / 3.0 * xp.eye(3)


@pytree
@dataclass(frozen=True, eq=False)
class RadiationReaction(Effect):
    """a_i = -(2/5) (G/c^5) d5 (Q_ij - tr(Q) delta_ij/3)/dt5 x_j (Burke & Thorne 1970; MTW 1973, eq. 36.8).

    An affine body: the fifth derivative is that of the motion under gravity and pressure alone, to lowest order in
    1/c^5. On average over a period the energy falls by (1/5) (G/c^5) (d3 Q/dt3)^2, the quadrupole formula.

    Particles: five derivatives of sums over particles are noise, and what they feed back runs away. Waves of one
    frequency have d5Q/dt5 = omega^4 dQ/dt, and dQ/dt is a sum over places and velocities; omega^4 is the ratio of the
    means of |d3Q/dt3|^2 and |dQ/dt|^2 over two periods, less their lag (waves of a frequency that rises). That takes
    the energy of the quadrupole formula in the mean of any motion, and never gives any; it takes the angular momentum
    of that formula from a figure that turns, a bar or bodies on a circle, of which all waves have one frequency. On an
    eccentric orbit the loss of angular momentum is that of its mean frequency.
    """

    speed_of_light: Any

    kind: ClassVar[str] = "radiation_reaction"
    external: ClassVar[bool] = True
    whole_body: ClassVar[bool] = True

    @property
    def inertial(self):
        """What rests in a rotating frame sends out waves."""
        return "follows from how the quadrupole moves in inertial axes"

    def affine_force(self, body):
        """q M F, of the acceleration M x."""
        from astroinertia.bodies import affine_motion

        fifth = affine_motion.second_moment_derivatives(
            body.deformation, body.rate, body.second_moment, body.conservative
        )[-1]
        reaction = affine_motion.radiation_reaction_tensor(fifth, self.speed_of_light**-5.0)
        return body.second_moment * reaction @ body.deformation

    def initial_history(self, xp):
        """Nothing known yet."""
        zero, none, means = xp.zeros(()), xp.zeros((3, 3)), xp.zeros(2)
        return Waves(zero, zero, none, none, means, means, zero)

    def history(self, xp, fluid):
        """The waves with what is seen now: differences over the last two steps."""
        waves = fluid.points[self.kind]
        dt = fluid.time - waves.time
        mixed = moments(fluid)[1]
        first = without_trace(xp, mixed + mixed.T)
        step = xp.where(dt > 0.0, dt, 1.0)
        second = (first - waves.first) / step
        third = (second - waves.second) / (0.5 * (step + waves.last))
        squares = xp.sum(waves.first**2), xp.sum(third**2)  # of one time: the third derivative is that of a step ago
        # Two differences need three steps.
        enough = waves.steps >= UNSEEN
        period = 2.0 * math.pi / xp.maximum(waves.frequency_to_the_fourth(xp), 1e-300) ** 0.25
        # At first the mean is that of all there is.
        share = xp.maximum(xp.minimum(dt / (PERIODS * period), 1.0), 1.0 / xp.maximum(waves.steps - UNSEEN + 1.0, 1.0))
        seen = Waves(
            time=fluid.time,
            last=dt,
            first=first,
            second=second,
            first_square=xp.where(enough, averaged(xp, waves.first_square, squares[0], share), 0.0),
            third_square=xp.where(enough, averaged(xp, waves.third_square, squares[1], share), 0.0),
            steps=waves.steps + 1.0,
        )
        later = (dt > 0.0) | (waves.steps == 0.0)
        return Waves(*(xp.where(later, getattr(seen, f.name), getattr(waves, f.name)) for f in fields(Waves)))

    def matrix(self, xp, fluid):
        """M of the acceleration M (x - c), (3, 3)."""
        mixed = moments(fluid)[1]
        strength = 0.4 * self.speed_of_light**-5.0 * fluid.points[self.kind].frequency_to_the_fourth(xp)
        return -strength * without_trace(xp, mixed + mixed.T)

    def acceleration(self, xp, fluid):
        """M (x - c)."""
        return (fluid.position - fluid.centre) @ self.matrix(xp, fluid)

    def virial(self, xp, fluid):
        """V = Q M."""
        return moments(fluid)[0] @ self.matrix(xp, fluid)

    def timestep(self, xp, fluid):
        """The time in which the reaction alone changes velocities by the size of the body over that time."""
        return 1.0 / xp.sqrt(xp.sqrt(xp.sum(self.matrix(xp, fluid) ** 2)) + 1e-60)


def inspiral_time(constant: float, light: float, masses: tuple[float, float], distance: float) -> float:
    """The time in which waves bring two points on a circle together, (5/256) c^5 a^4/(G^3 m1 m2 M) (Peters 1964)."""
    one, other = masses
    return 5.0 / 256.0 * light**5 * distance**4 / (constant**3 * one * other * (one + other))


def _size(body: Characteristic, options: Options) -> Found:
    body = lit(body, options)
    light, compact = body.speed_of_light, body.compactness
    assert body.mass is not None and body.radius is not None and body.moments is not None
    assert light is not None and compact is not None
    if body.pair is not None:
        share = body.end / inspiral_time(body.gravitational_constant, light, body.pair.masses, body.pair.distance)
        return compact, within_all(share)
    least, middle, largest = body.moments
    if largest == 0.0:
        return compact, 0.0
    # a figure that turns, and one that swings through what it is from round, with its dynamical rate
    motion = (body.spin or 0.0) * (body.dynamical_time or 0.0)
    uneven = (middle - least) / largest
    zone = body.zone
    swings = 0.0 if zone is None else (largest - least) / largest * zone.imbalance
    strength = 6.4 * compact**2.5 * largest / (body.mass * body.radius**2) * (body.run_length or 0.0)
    return compact, within_all(strength * ((uneven * motion**2) ** 2 + swings**2))


ENTRY = Entry(
    "loss of energy and angular momentum to gravitational waves, by the quadrupole",
    {"speed_of_light": positive("velocity", LIGHT, "c; smaller than it is, all goes faster")},
    "body", "Burke & Thorne 1970; Misner, Thorne & Wheeler 1973, eq. 36.8", ("sph", "ellipsoid"), colour="orange",
    auto="always", made=RadiationReaction, rank=14,
    size=Measure(
        "G M/(R c^2)", "6.4 (G M/(R c^2))^(5/2) ((B - A)/C)^2 (omega t_dyn)^4 t/t_dyn; t over inspiral",
        "Peters 1964; Misner, Thorne & Wheeler 1973, eq. 36.8", _size, ("mass", "radius", "moments"),
    ),
)  # fmt: skip
