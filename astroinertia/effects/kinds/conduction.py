"""Artificial conduction, which gives jumps of thermal energy the width that the particles can resolve."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

from astroinertia.effects import Characteristic, Effect, Entry, Found, Measure, Options, Output, PairTerm, pytree
from astroinertia.effects.gradients import VELOCITY_GRADIENT, converging_share, inertial_flow_sums, linear_gradient
from astroinertia.engines.elementwise import elementwise
from astroinertia.units import choice, not_negative

NONE = 1e-100  # rates below this, in code units, are no limit


def relative_velocity_pair(xp, v_r, dW_i, dW_j, density_i, density_j, conduction_energy_i, conduction_energy_j):
    """Heat exchanged at the speed at which the pair closes or separates, and the rate of the exchange."""
    rate = -xp.abs(v_r) * (dW_i + dW_j) / (density_i + density_j)
    return rate * (conduction_energy_j - conduction_energy_i), rate


def shear_limited_pair(
    xp, v_r, dW_i, dW_j, density_i, density_j, conduction_energy_i, conduction_energy_j, conduction_share_i,
    conduction_share_j,
):  # fmt: skip
    """The same, less by the mean of both sides' shares where the flow shears."""
    speed = 0.5 * (conduction_share_i + conduction_share_j) * xp.abs(v_r)
    rate = -speed * (dW_i + dW_j) / (density_i + density_j)
    return rate * (conduction_energy_j - conduction_energy_i), rate


def pressure_jump_pair(
    xp, dW_i, dW_j, density_i, density_j, pressure_i, pressure_j, conduction_energy_i, conduction_energy_j
):
    """Heat exchanged at the speed that the pair's pressure difference would drive, and the rate of the exchange."""
    jump = 2.0 * xp.abs(pressure_i - pressure_j) / (density_i + density_j)
    # The square root has no derivative at 0, where there is no flow.
    speed = xp.where(jump > 0.0, xp.sqrt(xp.where(jump > 0.0, jump, 1.0)), 0.0)
    rate = -speed * (dW_i + dW_j) / (density_i + density_j)
    return rate * (conduction_energy_j - conduction_energy_i), rate


OUTPUTS = (Output("heating", "sum"), Output("rate", "sum"))
RELATIVE_VELOCITY = PairTerm("conduction", relative_velocity_pair, OUTPUTS)
SHEAR_LIMITED = PairTerm("conduction", shear_limited_pair, OUTPUTS)
PRESSURE_JUMP = PairTerm("conduction", pressure_jump_pair, OUTPUTS)


def share_of_flow(xp, sound_speed, h, moment, velocity_sum):
    """How far the flow around a particle converges or expands, rather than shears."""
    return (converging_share(xp, linear_gradient(xp, moment, velocity_sum), sound_speed, h),)


@pytree
@dataclass(frozen=True, eq=False)
class Conduction(Effect):
    """du_i/dt = sum_j m_j coefficient v_sig (u_i - u_j) (dW_i + dW_j)/2 / [rho], antisymmetric: sum m u is kept.

    u is the thermal energy, without the part on the cold curve. signal "relative_velocity": v_sig = |v_r| (Wadsley,
    Veeravalli & Couchman 2008, MNRAS 387, 427; Price et al. 2018, PASA 35, e031, eq. 43), which leaves a star at rest
    alone although its thermal energy has a gradient. "pressure_jump": sqrt(|P_i - P_j|/[rho]) (Price 2008, JCP 227,
    10040, eq. 37), for contact discontinuities; with gravity it would conduct in equilibrium.

    limiter "shear", of the signal "relative_velocity": v_sig is |v_r| times the mean over the pair of

        d^2/(d^2 + |curl v|^2 + (1e-4 c/h)^2),   d = div v,

    by which the viscosity's limiter "reconstruction" reduces alpha (after Balsara 1995, JCP 121, 357). Particles that
    slide past each other come nearer and part again without a jump between them; |v_r| alone mixes the heat of two
    streams at the speed of the one in the other. What has to be smoothed is made where the flow converges (Read &
    Hayfield 2012, MNRAS 422, 3037, whose dissipation of entropy has a switch for this), and shocks keep their
    conduction.
    """

    coefficient: Any = 1.0
    signal: str = field(default="relative_velocity", metadata={"static": True})
    limiter: str = field(default="none", metadata={"static": True})

    kind: ClassVar[str] = "conduction"

    @classmethod
    def from_options(cls, options):
        """Refuses a limiter of relative velocities for a signal that has none."""
        if options["limiter"] == "shear" and options["signal"] != "relative_velocity":
            raise ValueError('limiter = "shear" is for signal = "relative_velocity"; leave one of the two away.')
        return cls(**options)

    @property
    def gradient_terms(self):
        """The velocity gradient, for the limiter."""
        return () if self.limiter == "none" else (VELOCITY_GRADIENT,)

    @property
    def neighbour_terms(self):
        """The exchange with the chosen signal velocity."""
        if self.limiter == "shear":
            return (SHEAR_LIMITED,)
        return (RELATIVE_VELOCITY,) if self.signal == "relative_velocity" else (PRESSURE_JUMP,)

    def fields(self, xp, fluid):
        """What the exchange needs."""
        fields = {"density": fluid.density, "conduction_energy": self.coefficient * fluid.thermal_energy}
        if self.signal == "pressure_jump":
            fields["pressure"] = fluid.pressure
        if self.limiter == "shear":
            (fields["conduction_share"],) = elementwise(
                xp, share_of_flow, fluid.sound_speed, fluid.smoothing_length, *inertial_flow_sums(fluid)
            )
        return fields

    def timestep(self, xp, fluid):
        """1/sum_j of what the particle exchanges with each neighbour per time.

        A step explicit in time is stable below 2 over the largest rate at which differences decay, which is at most
        twice the largest of these sums (Gershgorin): below this limit.
        """
        return 1.0 / xp.maximum(self.coefficient * fluid.sums[self.kind]["rate"], NONE)


def _size(body: Characteristic, options: Options) -> Found:
    return (1.0, 1.0) if body.touching else (0.0, 0.0)


ENTRY = Entry(
    "artificial conduction, which smooths jumps of thermal energy",
    {
        "coefficient": not_negative("dimensionless", 1.0, "strength of the exchange of thermal energy"),
        "signal": choice(
            "speed of the exchange: relative_velocity leaves a star in equilibrium alone, pressure_jump is for "
            "contact discontinuities without gravity",
            "relative_velocity", "pressure_jump",
        ),
        "limiter": choice(
            "what keeps conduction out of smooth flow: shear weakens relative_velocity where the flow turns rather "
            "than converges, so that streams that slide past each other keep their heat",
            "none", "shear",
        ),
    },
    "neighbours", "Price 2008; Wadsley, Veeravalli & Couchman 2008", numerical=True, colour="orange",
    auto="touching", needs=("pressure",), limit_power=1.0 / 3.0, made=Conduction, rank=4,
    size=Measure(
        "contacts of materials", "all where matter of different kinds meets; elsewhere it has no size of its own",
        "Price 2008", _size,
    ),
    gradients=lambda options: options["limiter"] != "none",
)  # fmt: skip
