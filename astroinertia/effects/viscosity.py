"""Artificial viscosity, which turns the kinetic energy that a shock loses into heat."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

from astroinertia.effects.effect import Effect
from astroinertia.effects.gradients import divergence_and_curl, gradient, shear_squared
from astroinertia.engines.terms import Output, PairTerm
from astroinertia.pytree import pytree


def viscosity_pair(
    xp,
    v_r,
    dW_i,
    dW_j,
    density_i,
    density_j,
    sound_speed_i,
    sound_speed_j,
    viscosity_linear_i,
    viscosity_linear_j,
    viscosity_quadratic_i,
    viscosity_quadratic_j,
):
    """Push, heat and signal velocity of a pair."""
    approach = xp.minimum(v_r, 0.0)
    drag = 0.5 * (viscosity_linear_i + viscosity_linear_j - (viscosity_quadratic_i + viscosity_quadratic_j) * approach)
    # Pi_ij times the mean slope of the kernels: both factors are <= 0, so that the push is outwards, the heat positive.
    push = drag * approach * (dW_i + dW_j) / (density_i + density_j)
    return -push, 0.5 * push * -approach, 0.5 * (sound_speed_i + sound_speed_j) - approach + drag


def reconstructed_pair(
    xp,
    r,
    v_r,
    x_ij,
    y_ij,
    z_ij,
    dW_i,
    dW_j,
    density_i,
    density_j,
    sound_speed_i,
    sound_speed_j,
    viscosity_linear_i,
    viscosity_linear_j,
    viscosity_quadratic_i,
    viscosity_quadratic_j,
    strain_xx_i,
    strain_yy_i,
    strain_zz_i,
    strain_xy_i,
    strain_xz_i,
    strain_yz_i,
    strain_xx_j,
    strain_yy_j,
    strain_zz_j,
    strain_xy_j,
    strain_xz_j,
    strain_yz_j,
):
    """The same for the jump of the velocity that is left where both sides' linear flows meet."""
    xx, yy, zz = x_ij * x_ij, y_ij * y_ij, z_ij * z_ij
    xy, xz, yz = 2.0 * x_ij * y_ij, 2.0 * x_ij * z_ij, 2.0 * y_ij * z_ij
    mine = (
        strain_xx_i * xx + strain_yy_i * yy + strain_zz_i * zz + strain_xy_i * xy + strain_xz_i * xz + strain_yz_i * yz
    )
    other = (
        strain_xx_j * xx + strain_yy_j * yy + strain_zz_j * zz + strain_xy_j * xy + strain_xz_j * xz + strain_yz_j * yz
    )
    # van Leer's limiter: 1 where both sides see the same gradient, 0 where they see opposite ones.
    both = mine + other
    agreement = xp.maximum(4.0 * mine * other / (both * both + 1e-18), 0.0)
    jump = v_r - 0.5 * agreement * both / xp.maximum(r, 1e-15)
    # Particles that part are left alone, so that the heat is never negative.
    approach = xp.where(v_r < 0.0, xp.minimum(jump, 0.0), 0.0)
    drag = 0.5 * (viscosity_linear_i + viscosity_linear_j - (viscosity_quadratic_i + viscosity_quadratic_j) * approach)
    push = drag * approach * (dW_i + dW_j) / (density_i + density_j)
    signal = 0.5 * (sound_speed_i + sound_speed_j) - xp.minimum(v_r, 0.0) + drag
    return -push, 0.5 * push * xp.maximum(-v_r, 0.0), signal


def gradient_pair(xp, dW_i):
    """Weights of the moment matrix and of the velocity gradient."""
    return dW_i, dW_i


def trend_pair(xp, v_r, W_i, dW_i, sound_speed_i, sound_speed_j, viscosity_trend_j):
    """Weights of the acceleration gradient and of the signs of div v around, and the signal velocity."""
    return dW_i, viscosity_trend_j * W_i, 0.5 * (sound_speed_i + sound_speed_j) - xp.minimum(v_r, 0.0)


VISCOSITY = PairTerm(
    "viscosity",
    viscosity_pair,
    (Output("acceleration", "central"), Output("heating", "sum"), Output("signal", "max")),
)
RECONSTRUCTED = PairTerm("viscosity", reconstructed_pair, VISCOSITY.outputs)
VELOCITY_GRADIENT = PairTerm(
    "viscosity",
    gradient_pair,
    (Output("position", "outer", of="position"), Output("velocity", "outer", of="velocity")),
)
TREND = PairTerm(
    "viscosity",
    trend_pair,
    (Output("acceleration", "outer", of="acceleration"), Output("trend", "sum"), Output("signal", "max")),
)


@pytree
@dataclass(frozen=True, eq=False)
class Viscosity(Effect):
    """a_i = -sum_j m_j Pi_ij (dW_i + dW_j)/2 rhat, du_i/dt = 1/2 sum_j m_j Pi_ij v_r (dW_i + dW_j)/2 >= 0.

    Pi_ij = (-[alpha c] w + [beta alpha] w^2)/[rho] where w = v_r < 0, else 0, with [.] the mean over the pair
    (Monaghan 1997, JCP 136, 298, in signal-velocity form; beta is in units of alpha, and 4 by default: with 2 the
    particles behind the strong shock of Evrard's collapse keep a fifth of the kinetic energy as noise). Work and
    heating cancel exactly for the velocities that the pair is evaluated with.

    switch "cullen_dehnen": alpha follows Cullen & Dehnen (2010, MNRAS 408, 669). Where the flow begins to converge it
    jumps to min(alpha_max, s/c^2), s = (2 h)^2 xi max(0, -d(div v)/dt) (their eqs. 13 and 18; the minimum is that of
    Price et al. 2018, PASA 35, e031, eq. 45, as their eq. 14 leaves alpha below a half in shocks of Mach 2 to 4), and
    then decays over h decay_length/v_sig (eqs. 15 and 16). d(div v)/dt = div a - tr (grad v)^2 with gradients that are
    exact in linear flows; xi leaves out shear and noise. switch "none": alpha = alpha_max.

    limiter "reconstruction": v_r in Pi_ij is the jump that is left at the midpoint when the linear flow of both sides
    is taken out, with van Leer's limiter of the two gradients (Frontiere, Raskin & Owen 2017, JCP 332, 160, eqs. 41 to
    43; Rosswog 2020, MNRAS 498, 4230), so that a smooth flow heats by next to nothing; and alpha is reduced by
    d^2/(d^2 + |curl v|^2 + (1e-4 c/h)^2), d = div v, which spares shocks. limiter "balsara": v_r itself, and alpha is
    reduced by |d|/(|d| + |curl v| + 1e-4 c/h) (Balsara 1995, JCP 121, 357). The figures are in
    tests/physics/test_shocks.py: streams that collide are stopped, and do not run through each other.
    """

    alpha_max: Any = 1.0
    alpha_min: Any = 0.0
    beta: Any = 4.0
    decay_length: Any = 10.0
    switch: str = field(default="cullen_dehnen", metadata={"static": True})
    limiter: str = field(default="reconstruction", metadata={"static": True})

    kind: ClassVar[str] = "viscosity"
    central: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses bounds of alpha that cross."""
        if options["switch"] == "cullen_dehnen" and options["alpha_min"] > options["alpha_max"]:
            raise ValueError("alpha_min must not be above alpha_max")
        return cls(**options)

    @property
    def follows_shocks(self) -> bool:
        """Whether alpha evolves."""
        return self.switch == "cullen_dehnen"

    @property
    def gradient_terms(self):
        """What the switch and the limiter need, if there are any."""
        if self.follows_shocks:
            return (VELOCITY_GRADIENT, TREND)
        return () if self.limiter == "none" else (VELOCITY_GRADIENT,)

    @property
    def neighbour_terms(self):
        """Push, heat and signal velocity."""
        return (RECONSTRUCTED,) if self.limiter == "reconstruction" else (VISCOSITY,)

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
        """The coefficient alpha, and the sign of div v (unknown yet: 0)."""
        if not self.follows_shocks:
            return {}
        none = xp.zeros_like(fluid.density)
        return {"viscosity_alpha": none + self.alpha_min, "viscosity_trend": none}

    def remember(self, xp, fluid, interval):
        """The coefficient alpha after `interval`, and the sign of div v for the next evaluation's limiter."""
        if not self.follows_shocks:
            return {}
        sums = fluid.gradients[self.kind]
        velocity_gradient = gradient(xp, sums, "velocity")
        divergence, _ = divergence_and_curl(xp, velocity_gradient)
        rate = xp.einsum("nii->n", gradient(xp, sums, "acceleration"))
        rate = rate - xp.einsum("nij,nji->n", velocity_gradient, velocity_gradient)
        limited = self.shear_limiter(xp, fluid, divergence, velocity_gradient, sums["trend"])
        # The particle's own sound is a signal too, where it has no neighbour.
        signal = xp.maximum(sums["signal"], fluid.sound_speed) + 1e-30
        steepening = 4.0 * fluid.smoothing_length**2 * limited * xp.maximum(-rate, 0.0)
        wanted = xp.minimum(self.alpha_max, steepening / (fluid.sound_speed**2 + 1e-30))
        decayed = wanted + (fluid.memory["viscosity_alpha"] - wanted) * xp.exp(
            -interval * signal / (self.decay_length * fluid.smoothing_length)
        )
        alpha = xp.maximum(xp.maximum(wanted, decayed), self.alpha_min)
        return {"viscosity_alpha": alpha, "viscosity_trend": xp.sign(divergence)}

    def shear_limiter(self, xp, fluid, divergence, velocity_gradient, trend):
        """The xi of Cullen & Dehnen (2010), eq. 18: 1 where all converges, small in shear or noise."""
        around = trend / fluid.density
        converging = (2.0 * (1.0 - around) ** 4 * divergence) ** 2
        noise = (1e-4 * fluid.sound_speed / fluid.smoothing_length) ** 2 + 1e-60
        return converging / (converging + shear_squared(xp, velocity_gradient) + noise)

    def strength(self, xp, fluid, velocity_gradient):
        """The coefficient alpha with its limiter, (N,); velocity_gradient (N, 3, 3) is what a limiter looks at."""
        alpha = fluid.memory["viscosity_alpha"] if self.follows_shocks else self.alpha_max
        if self.limiter == "none":
            return alpha + xp.zeros_like(fluid.density)
        divergence, curl = divergence_and_curl(xp, velocity_gradient)
        noise = 1e-4 * fluid.sound_speed / fluid.smoothing_length + 1e-30
        if self.limiter == "balsara":
            return alpha * xp.abs(divergence) / (xp.abs(divergence) + curl + noise)
        return alpha * divergence**2 / (divergence**2 + curl**2 + noise**2)

    def fields(self, xp, fluid):
        """The coefficients alpha c and beta alpha, limited, and the strain rate where flows are reconstructed."""
        flow: Any = None if self.limiter == "none" else gradient(xp, fluid.gradients[self.kind], "velocity")
        alpha = self.strength(xp, fluid, flow)
        fields = {
            "density": fluid.density,
            "sound_speed": fluid.sound_speed,
            "viscosity_linear": alpha * fluid.sound_speed,
            "viscosity_quadratic": self.beta * alpha,
        }
        if self.limiter == "reconstruction":
            for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
                fields[f"strain_{'xyz'[a]}{'xyz'[b]}"] = 0.5 * (flow[:, a, b] + flow[:, b, a])
        return fields

    def timestep(self, xp, fluid):
        """Signals cross the smoothing length: h/v_signal."""
        return 1.0 / xp.maximum(fluid.sums[self.kind]["signal"] / fluid.smoothing_length, 1e-30)
