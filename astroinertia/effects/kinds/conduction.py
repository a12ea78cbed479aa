"""Artificial conduction, which gives jumps of thermal energy the width that the particles can resolve."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

from astroinertia.effects import Characteristic, Effect, Entry, Found, Measure, Options, Output, PairTerm, pytree
from astroinertia.units import choice, not_negative

NONE = 1e-100  # rates below this, in code units, are no limit


def relative_velocity_pair(xp, v_r, dW_i, dW_j, density_i, density_j, conduction_energy_i, conduction_energy_j):
    """Heat exchanged at the speed at which the pair closes or separates, and the rate of the exchange."""
    rate = -xp.abs(v_r) * (dW_i + dW_j) / (density_i + density_j)
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
PRESSURE_JUMP = PairTerm("conduction", pressure_jump_pair, OUTPUTS)


@pytree
@dataclass(frozen=True, eq=False)
class Conduction(Effect):
    """du_i/dt = sum_j m_j coefficient v_sig (u_i - u_j) (dW_i + dW_j)/2 / [rho], antisymmetric: sum m u is kept.

    u is the thermal energy, without the part on the cold curve. signal "relative_velocity": v_sig = |v_r| (Wadsley,
    Veeravalli & Couchman 2008, MNRAS 387, 427; Price et al. 2018, PASA 35, e031, eq. 43), which leaves a star at rest
    alone although its thermal energy has a gradient. "pressure_jump": sqrt(|P_i - P_j|/[rho]) (Price 2008, JCP 227,
    10040, eq. 37), for contact discontinuities; with gravity it would conduct in equilibrium.
    """

    coefficient: Any = 1.0
    signal: str = field(default="relative_velocity", metadata={"static": True})

    kind: ClassVar[str] = "conduction"

    @property
    def neighbour_terms(self):
        """The exchange with the chosen signal velocity."""
        return (RELATIVE_VELOCITY,) if self.signal == "relative_velocity" else (PRESSURE_JUMP,)

    def fields(self, xp, fluid):
        """What the exchange needs."""
        fields = {"density": fluid.density, "conduction_energy": self.coefficient * fluid.thermal_energy}
        if self.signal == "pressure_jump":
            fields["pressure"] = fluid.pressure
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
    },
    "neighbours", "Price 2008; Wadsley, Veeravalli & Couchman 2008", numerical=True, colour="orange",
    auto="touching", needs=("pressure",), limit_power=1.0 / 3.0, made=Conduction, rank=4,
    size=Measure(
        "contacts of materials", "all where matter of different kinds meets; a device without a size of its own else",
        "Price 2008", _size,
    ),
)  # fmt: skip
