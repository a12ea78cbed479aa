"""Artificial viscosity, which turns the kinetic energy that a shock loses into heat."""

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

from astroinertia.effects import Characteristic, Effect, Entry, Output, PairTerm, pytree
from astroinertia.effects.gradients import (
    VELOCITY_GRADIENT,
    Separation,
    Symmetric,
    along,
    converging_share,
    curl_size,
    flow_sums,
    inertial_flow_sums,
    linear_gradient,
    shear,
    strain,
    trace,
    trace_of_square,
)
from astroinertia.effects.measure import ZONE, Found, Measure, Options, within_all
from astroinertia.effects.one_zone import braked
from astroinertia.engines.elementwise import elementwise
from astroinertia.units import choice, not_negative, positive

NOISE = 1e-4  # of c/h: what limiters count of any flow, as Balsara's does
# Of c/h: of a flow that only turns, the divergence is round-off, whose sign would be another on every processor: 1e-16
# of what float64 pairs sum, 1e-7 of float32. A hundred times that is still a tenth of the limiters' noise.
QUIET = 1e-5


class Side(NamedTuple):
    """What a particle of a pair brings with it: coefficients are those of w and w^2 in Pi_ij."""

    dW: Any
    density: Any
    sound_speed: Any
    viscosity_linear: Any
    viscosity_quadratic: Any


def viscosity_pair(xp, v_r, i: Side, j: Side):
    """Push, heat and signal velocity of a pair (Monaghan 1997)."""
    inward = xp.minimum(v_r, 0.0)
    return damped(xp, inward, inward, i, j)


def reconstructed_pair(xp, r, v_r, ij: Separation, i: Side, j: Side, strain_i: Symmetric, strain_j: Symmetric):
    """The same for the jump left where both sides' linear flows meet (Frontiere et al. 2017, eqs. 41 to 43)."""
    mine, other = along(xp, ij, strain_i), along(xp, ij, strain_j)
    approach = closing(xp, r, v_r, mine + other, agreement(xp, mine, other))
    return damped(xp, xp.minimum(v_r, 0.0), approach, i, j)


def guarded_pair(
    xp, r, v_r, ij: Separation, i: Side, j: Side, strain_i: Symmetric, strain_j: Symmetric, spacing_i, spacing_j
):
    """The same, but the nearer a pair is than particles should be, the less of the linear flows is taken out."""
    mine, other = along(xp, ij, strain_i), along(xp, ij, strain_j)
    trusted = agreement(xp, mine, other) / crowding(xp, r / xp.maximum(spacing_i, spacing_j))
    approach = closing(xp, r, v_r, mine + other, trusted)
    return damped(xp, xp.minimum(v_r, 0.0), approach, i, j)


def trace_free_pair(
    xp, r, v_r, ij: Separation, i: Side, j: Side, strain_i: Symmetric, strain_j: Symmetric, tension_i, tension_j
):
    """The reconstructed pair without the isotropic part of both sides' viscous stress."""
    pair = reconstructed_pair(xp, r, v_r, ij, i, j, strain_i, strain_j)
    return without_isotropic(xp, v_r, pair, tension_i * i.dW, tension_j * j.dW)


def guarded_trace_free_pair(
    xp, r, v_r, ij: Separation, i: Side, j: Side, strain_i: Symmetric, strain_j: Symmetric, spacing_i, spacing_j,
    tension_i, tension_j,
):  # fmt: skip
    """The guarded pair without it."""
    pair = guarded_pair(xp, r, v_r, ij, i, j, strain_i, strain_j, spacing_i, spacing_j)
    return without_isotropic(xp, v_r, pair, tension_i * i.dW, tension_j * j.dW)


def without_isotropic(xp, v_r, pair, mine, other):
    """Push, heat and signal less what the isotropic parts of the stress push apart, and heat by their own work."""
    push, heat, signal = pair
    return push - mine - other, heat - mine * v_r, signal


def agreement(xp, mine, other):
    """van Leer's limiter: 1 where both sides see the same gradient, 0 where they see opposite ones."""
    both = mine + other
    return xp.maximum(4.0 * mine * other / (both * both + 1e-18), 0.0)


def crowding(xp, apart):
    """exp of the square of how much nearer than their spacing particles are, in fifths of it; three terms of it."""
    square = xp.maximum(5.0 - 5.0 * apart, 0.0) ** 2
    return 1.0 + square + 0.5 * square**2


def closing(xp, r, v_r, both, trusted):
    """The approach of a pair, <= 0, without what is trusted of both sides' linear flow."""
    jump = v_r - 0.5 * trusted * both / xp.maximum(r, 1e-15)
    # Particles that part are left alone, so that the heat is never negative; no jump is larger than what closes the
    # pair, so that the push goes to zero with that: else whether there is one would hang on round-off.
    return xp.minimum(xp.maximum(jump, v_r), 0.0)


def damped(xp, inward, approach, i: Side, j: Side):
    """Push, heat and signal velocity of a pair that comes together at `inward` <= 0, `approach` of which is damped."""
    quadratic = (i.viscosity_quadratic + j.viscosity_quadratic) * approach
    drag = 0.5 * (i.viscosity_linear + j.viscosity_linear - quadratic)
    inverse = 1.0 / (i.density + j.density)
    mine = share(xp, i.density * inverse, j.density * inverse)
    other = share(xp, j.density * inverse, i.density * inverse)
    # Pi_ij times the slope of the kernel: both factors are <= 0, so that the push is outwards, the heat positive.
    push = 2.0 * drag * approach * inverse * (mine * i.dW + other * j.dW)
    return -push, other * push * -inward, 0.5 * (i.sound_speed + j.sound_speed) - inward + drag


def share(xp, mine, other):
    """a^2/(a^2 + b^2) where a + b = 1, so that the squares neither overflow nor vanish together."""
    square = mine * mine
    return square / (square + other * other)


def trend_pair(xp, v_r, W_i, dW_i, sound_speed_i, sound_speed_j, viscosity_trend_j):
    """Weights of the acceleration gradient and of the signs of div v around, and the signal velocity."""
    return dW_i, viscosity_trend_j * W_i, 0.5 * (sound_speed_i + sound_speed_j) - xp.minimum(v_r, 0.0)


VISCOSITY = PairTerm(
    "viscosity", viscosity_pair, (Output("acceleration", "central"), Output("heating", "sum"), Output("signal", "max"))
)
RECONSTRUCTED = PairTerm("viscosity", reconstructed_pair, VISCOSITY.outputs)
GUARDED = PairTerm("viscosity", guarded_pair, VISCOSITY.outputs)
TRACE_FREE = PairTerm("viscosity", trace_free_pair, VISCOSITY.outputs)
GUARDED_TRACE_FREE = PairTerm("viscosity", guarded_trace_free_pair, VISCOSITY.outputs)
TREND = PairTerm(
    "viscosity",
    trend_pair,
    (Output("acceleration", "outer", of="acceleration"), Output("trend", "sum"), Output("signal", "max")),
)


def shear_limiter(xp, flow, density, noise, trend):
    """The xi of Cullen & Dehnen (2010), eq. 18: 1 where all converges, small in shear or noise."""
    converging = (2.0 * (1.0 - trend / density) ** 4 * trace(xp, flow)) ** 2
    return converging / (converging + shear(xp, flow) + noise**2 + 1e-60)


def switched(
    xp, density, sound_speed, h, alpha, moment, velocity_sum, acceleration_sum, trend, signal, interval, alpha_max,
    alpha_min, decay_length,
):  # fmt: skip
    """The coefficient alpha after `interval`, and the sign of div v."""
    flow = linear_gradient(xp, moment, velocity_sum)
    rate = trace(xp, linear_gradient(xp, moment, acceleration_sum)) - trace_of_square(xp, flow)
    limited = shear_limiter(xp, flow, density, NOISE * sound_speed / h, trend)
    # The particle's own sound is a signal too, where it has no neighbour.
    fastest = xp.maximum(signal, sound_speed) + 1e-30
    steepening = 4.0 * h**2 * limited * xp.maximum(-rate, 0.0)
    wanted = xp.minimum(alpha_max, steepening / (sound_speed**2 + 1e-30))
    decayed = wanted + (alpha - wanted) * xp.exp(-interval * fastest / (decay_length * h))
    divergence, quiet = trace(xp, flow), QUIET * sound_speed / h
    sign = xp.where(divergence > quiet, 1.0, xp.where(divergence < -quiet, -1.0, 0.0))
    return xp.maximum(xp.maximum(wanted, decayed), alpha_min), sign


def coefficients(xp, sound_speed, alpha, beta):
    """What multiplies the approach and its square."""
    return alpha * sound_speed, beta * alpha


def balsara_coefficients(xp, sound_speed, alpha, beta, h, moment, velocity_sum, least):
    """The same, weaker where the flow turns rather than converges, but not below the least alpha."""
    flow = linear_gradient(xp, moment, velocity_sum)
    divergence = xp.abs(trace(xp, flow))
    spared = divergence / (divergence + curl_size(xp, flow) + NOISE * sound_speed / h + 1e-30)
    return coefficients(xp, sound_speed, least + (alpha - least) * spared, beta)


def reconstructed_coefficients(xp, sound_speed, alpha, beta, h, moment, velocity_sum, least):
    """The same for reconstructed flows, which need their strain rates as well."""
    flow = linear_gradient(xp, moment, velocity_sum)
    spared = converging_share(xp, flow, sound_speed, h)
    linear, quadratic = coefficients(xp, sound_speed, least + (alpha - least) * spared, beta)
    xx, yy, zz, xy, xz, yz = strain(xp, flow)
    return linear, quadratic, xx, yy, zz, xy, xz, yz


LIMITED = {
    "balsara": balsara_coefficients,
    "reconstruction": reconstructed_coefficients,
    "guarded_reconstruction": reconstructed_coefficients,
}
PAIRS = {"reconstruction": RECONSTRUCTED, "guarded_reconstruction": GUARDED}
TRACE_FREE_PAIRS = {"reconstruction": TRACE_FREE, "guarded_reconstruction": GUARDED_TRACE_FREE}
STRAIN = tuple(f"strain_{axes}" for axes in Symmetric._fields)


def spacing(xp, mass, density):
    """How far apart particles are on average."""
    return (xp.power(mass / density, 1.0 / 3.0),)


def isotropic_part(xp, density, pressure, thermal_energy, moment, velocity_sum, heating):
    """The pressure p_v in a particle's viscous stress, from the heat per mass of the whole stress."""
    flow = linear_gradient(xp, moment, velocity_sum)
    rate = xp.maximum(-trace(xp, flow), 0.0)
    xx, yy, zz, xy, xz, yz = strain(xp, flow)
    square = xx**2 + yy**2 + zz**2 + 2.0 * (xy**2 + xz**2 + yz**2)
    part = 5.0 / 3.0 * rate * density * heating / (2.0 * square + rate**2 + 1e-30)
    return (xp.minimum(part, xp.minimum(xp.maximum(pressure, 0.0), density * thermal_energy)),)


def heating_of_all(xp, density, heating, viscous_pressure, velocity_sum):
    """The heat per mass of the whole stress, from that of the rest: p_v cooled by p_v/rho^2 sum m dW v_r."""
    return (heating + viscous_pressure / density**2 * trace(xp, velocity_sum),)


def tension(xp, density, viscous_pressure):
    """p_v/rho^2."""
    return (viscous_pressure / density**2,)


def crossing_time(xp, h, signal):
    """h/v_signal."""
    return (1.0 / xp.maximum(signal / h, 1e-30),)


@pytree
@dataclass(frozen=True, eq=False)
class Viscosity(Effect):
    """a_i = -sum_j m_j Pi_ij dW_ij rhat, du_i/dt = q_j sum_j m_j Pi_ij v_r dW_ij >= 0, dW_ij = q_i dW_i + q_j dW_j.

    Pi_ij = (-[alpha c] w + [beta alpha] w^2)/[rho] where w = v_r < 0, else 0, with [.] the mean over the pair
    (Monaghan 1997, JCP 136, 298, in signal-velocity form; beta is in units of alpha, and 4 by default: with 2 the
    particles behind the strong shock of Evrard's collapse keep a fifth of the kinetic energy as noise). Work and
    heating cancel exactly for the velocities that the pair is evaluated with.

    q_i = rho_i^2/(rho_i^2 + rho_j^2): the kernel is mostly that of the denser side and the heat mostly that of the
    other, which falls into the shock. With q = 1/2, Monaghan's means, gas ahead of a shock feels it through its own
    wide kernel, long before it arrives: a shock is wider, and where the flow converges it heats too much by as much.

    switch "cullen_dehnen": alpha follows Cullen & Dehnen (2010, MNRAS 408, 669). Where the flow begins to converge it
    jumps to min(alpha_max, s/c^2), s = (2 h)^2 xi max(0, -d(div v)/dt) (their eqs. 13 and 18; the minimum is that of
    Price et al. 2018, PASA 35, e031, eq. 45, as their eq. 14 leaves alpha below a half in shocks of Mach 2 to 4), and
    then decays over h decay_length/v_sig (eqs. 15 and 16). d(div v)/dt = div a - tr (grad v)^2 with gradients that are
    exact in linear flows; xi leaves out shear and noise. switch "none": alpha = alpha_max.

    limiter "reconstruction": v_r in Pi_ij is the jump that is left at the midpoint when the linear flow of both sides
    is taken out, with van Leer's limiter of the two gradients (Frontiere, Raskin & Owen 2017, JCP 332, 160, eqs. 41 to
    43; Rosswog 2020, MNRAS 498, 4230), so that a smooth flow heats by next to nothing; it is no larger than v_r, with
    which it vanishes, as its sign would else hang on round-off. alpha is reduced by d^2/(d^2 + |curl v|^2 +
    (1e-4 c/h)^2), d = div v, which spares shocks. limiter "guarded_reconstruction": the same with the other half of
    their limiter: of pairs nearer than the mean spacing s = (m/rho)^(1/3) less of the linear flow is taken out, by
    exp(-((1 - r/s)/0.2)^2), here 1/(1 + x^2 + x^4/2). Layers that a strong shock drives together stay apart so (the
    L1 error of a tube's shock of Mach 60 is a tenth smaller), but particles in disorder heat where a smooth flow
    converges. limiter "balsara": v_r itself, and alpha is reduced by |d|/(|d| + |curl v| + 1e-4 c/h) (Balsara 1995, JCP
    121, 357). None reduces it below alpha_min, which damps noise: of Gresho & Chan's vortex 1452 particles lose 0.162
    (L1 of the velocity) with 0.1, and 0.225 with 0. The figures of shocks are in tests/physics/test_shocks.py: streams
    that collide are stopped, and do not run through each other.

    stress "trace_free": forces along lines between particles make up the stress eta (2 S + (div v) 1) with the strain
    rate S (Murray 1996, MNRAS 279, 402), which pushes sideways of a planar shock with a third of what it pushes along
    it. Where a shock converges that heats the gas a second time, in proportion to the width of its front over its
    radius. So the isotropic part, which a viscosity for converging shocks has not (Tscharnuter & Winkler 1979, Comp.
    Phys. Comm. 18, 171), is taken out where gas is compressed: of the heat rho q = eta (2 S:S + (div v)^2) follows
    eta, and p_v = (5/3) eta |div v| draws each pair together by p_v/rho^2 of both sides and cools it by as much. p_v is
    at most the pressure and the thermal energy in a volume, so that no step cools cold matter by more than it has; it
    is that of the heat of the evaluation before. Pairs still conserve all that they did.
    """

    alpha_max: Any = 1.0
    alpha_min: Any = 0.0
    beta: Any = 4.0
    decay_length: Any = 10.0
    switch: str = field(default="cullen_dehnen", metadata={"static": True})
    limiter: str = field(default="reconstruction", metadata={"static": True})
    stress: str = field(default="whole", metadata={"static": True})

    kind: ClassVar[str] = "viscosity"

    @classmethod
    def from_options(cls, options):
        """Refuses bounds of alpha that cross, and a trace-free stress of flows that are not reconstructed."""
        if options["switch"] == "cullen_dehnen" and options["alpha_min"] > options["alpha_max"]:
            raise ValueError("alpha_min must not be above alpha_max")
        if options["stress"] == "trace_free" and options["limiter"] not in TRACE_FREE_PAIRS:
            raise ValueError(f'stress "trace_free" needs one of the limiters {" and ".join(TRACE_FREE_PAIRS)}')
        return cls(**options)

    @property
    def follows_shocks(self) -> bool:
        """Whether alpha evolves."""
        return self.switch == "cullen_dehnen"

    @property
    def trace_free(self) -> bool:
        """Whether the isotropic part of the stress is taken out."""
        return self.stress == "trace_free"

    @property
    def needs_heat(self):
        """Where the isotropic part of the stress is taken out, which follows from heat that matter keeps."""
        return self.trace_free

    @property
    def gradient_terms(self):
        """What the switch and the limiter need, if there are any."""
        if self.follows_shocks:
            return (VELOCITY_GRADIENT, TREND)
        return () if self.limiter == "none" else (VELOCITY_GRADIENT,)

    @property
    def neighbour_terms(self):
        """Push, heat and signal velocity."""
        return ((TRACE_FREE_PAIRS if self.trace_free else PAIRS).get(self.limiter, VISCOSITY),)

    def gradient_fields(self, xp, fluid):
        """What the switch needs."""
        if not self.follows_shocks:
            return {}
        return {
            "acceleration": fluid.acceleration,
            "sound_speed": fluid.sound_speed,
            "viscosity_trend": fluid.memory["viscosity_trend"],
        }

    def initial_memory(self, xp, fluid):
        """The coefficient alpha, the sign of div v (unknown yet: 0), and the heat and p_v of the stress."""
        none = xp.zeros_like(fluid.density)
        memory = {"viscosity_alpha": none + self.alpha_min, "viscosity_trend": none} if self.follows_shocks else {}
        return memory | ({"viscous_heating": none, "viscous_pressure": none} if self.trace_free else {})

    def remember(self, xp, fluid, interval):
        """The coefficient alpha after `interval`, the sign of div v for the next evaluation's limiter, and p_v."""
        memory = {}
        if self.follows_shocks:
            sums = fluid.gradients[self.kind]
            memory["viscosity_alpha"], memory["viscosity_trend"] = elementwise(
                xp, switched, fluid.density, fluid.sound_speed, fluid.smoothing_length, fluid.memory["viscosity_alpha"],
                *flow_sums(fluid), sums["acceleration"], sums["trend"], sums["signal"], interval, self.alpha_max,
                self.alpha_min, self.decay_length,
            )  # fmt: skip
        if self.trace_free:
            (memory["viscous_pressure"],) = elementwise(
                xp, isotropic_part, fluid.density, fluid.pressure, fluid.thermal_energy, *flow_sums(fluid),
                fluid.memory["viscous_heating"],
            )  # fmt: skip
        return memory

    def remember_sums(self, xp, fluid):
        """The heat per mass of the whole stress, of which the next evaluation's p_v follows."""
        if not self.trace_free:
            return {}
        heating, pressure = fluid.sums[self.kind]["heating"], fluid.memory["viscous_pressure"]
        _, flow = flow_sums(fluid)
        return {"viscous_heating": elementwise(xp, heating_of_all, fluid.density, heating, pressure, flow)[0]}

    def fields(self, xp, fluid):
        """The coefficients alpha c and beta alpha, limited, and the strain rate where flows are reconstructed."""
        alpha = fluid.memory["viscosity_alpha"] if self.follows_shocks else self.alpha_max
        arguments = (fluid.sound_speed, alpha, self.beta)
        if self.limiter == "none":
            values = elementwise(xp, coefficients, *arguments)
        else:
            values = elementwise(
                xp, LIMITED[self.limiter], *arguments, fluid.smoothing_length, *inertial_flow_sums(fluid),
                self.alpha_min,
            )  # fmt: skip
        names = ("viscosity_linear", "viscosity_quadratic", *STRAIN)
        fields = {"density": fluid.density, "sound_speed": fluid.sound_speed, **dict(zip(names, values, strict=False))}
        if self.limiter == "guarded_reconstruction":
            fields["spacing"] = elementwise(xp, spacing, fluid.mass, fluid.density)[0]
        if self.trace_free:
            fields["tension"] = elementwise(xp, tension, fluid.density, fluid.memory["viscous_pressure"])[0]
        return fields

    def timestep(self, xp, fluid):
        """Signals cross the smoothing length: h/v_signal."""
        return elementwise(xp, crossing_time, fluid.smoothing_length, fluid.sums[self.kind]["signal"])[0]


def _size(body: Characteristic, options: Options) -> Found:
    zone = body.zone
    assert zone is not None and body.mass is not None and body.radius is not None
    if zone.pressure == 0.0:
        return 0.0, 0.0
    if body.bodies > 1 or body.touching:
        return math.inf, 1.0
    sound = math.sqrt(body.gamma * zone.pressure / 3.0)
    mach = braked(zone, body.end) / sound if sound > 0.0 else 0.0
    periods = max(1.0, body.end * zone.frequency / (2.0 * math.pi))
    heat = min(1.0, mach) ** 2 * min(1.0, mach * periods)  # waves of Mach number m steepen within 1/m periods
    return mach, max(within_all(heat), 0.0 if body.homologous else body.falling)


ENTRY = Entry(
    "artificial viscosity, which captures shocks",
    {
        "alpha_max": positive("dimensionless", 1.0, "linear coefficient in a shock"),
        "alpha_min": not_negative(
            "dimensionless", 0.0, "linear coefficient far from shocks, which damps noise; limiters leave it",
        ),
        "beta": not_negative("dimensionless", 4.0, "quadratic coefficient, as a multiple of the linear one"),
        "decay_length": positive("dimensionless", 10.0, "smoothing lengths over which the coefficient decays"),
        "switch": choice(
            "how the coefficient follows the flow: with shocks, or constant at alpha_max", "cullen_dehnen", "none",
        ),
        "limiter": choice(
            "what keeps viscosity out of smooth flow: reconstruction sees only the jump that linear flow on both "
            "sides leaves, guarded_reconstruction more where particles are closer than they should be, balsara "
            "weakens it where the flow turns rather than converges",
            "reconstruction", "guarded_reconstruction", "balsara", "none",
        ),
        "stress": choice(
            "viscous stress of pairs: whole, or trace_free, which does not push sideways where gas is compressed: "
            "converging shocks heat by what they should; for limiters that reconstruct",
            "whole", "trace_free",
        ),
    },
    "neighbours", "Cullen & Dehnen 2010; Monaghan 1997; Balsara 1995", numerical=True, colour="green",
    auto="always", needs=("pressure",), limit_power=1.0 / 3.0, made=Viscosity, rank=3,
    size=Measure(
        "Mach number of the braked fall", "M^2 of the heat, once waves of that Mach number have steepened; what falls",
        "Landau & Lifshitz 1987, Fluid Mechanics, section 101", _size, ZONE,
    ),
    gradients=lambda options: options["switch"] != "none" or options["limiter"] != "none",
)  # fmt: skip
