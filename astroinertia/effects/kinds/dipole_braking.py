"""The torque by which a pulsar slows down."""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import TURNS, Characteristic, Effect, Entry, Found, Measure, Options, pytree, within_all
from astroinertia.effects.effect import moments
from astroinertia.effects.measure import lit
from astroinertia.inertia.tensor import axial_vector, inertia_from_second_moment
from astroinertia.rotation.attitude import cross_matrix
from astroinertia.units import DIMENSIONLESS, SPEED_OF_LIGHT, Option, positive


@pytree
@dataclass(frozen=True, eq=False)
class DipoleBraking(Effect):
    """tau = -k |omega|^(n-1) (omega - (omega . u) u) with the magnetic axis u, without one -k |omega|^(n-1) omega.

    A dipole in vacuum has n = 3 and k = 2 B^2 R^6 / (3 c^3) in Gaussian units, with the field B at the magnetic equator
    at R, or k = 8 pi b^2 R^6 / (3 c^3) with the b = B / mu_0^(1/2) in which fields are given here: its part along the
    spin slows it down, the one across aligns it (Goldreich 1970, ApJ 160, L11; Davis &
    Goldstein 1970, ApJ 159, L81; Michel & Goldwire 1970, Astrophysical Letters 5, 21). The part of the torque that
    neither brakes nor aligns, and makes the spin precess, depends on the star's interior and is left out. Or k is such
    that at a period P the period grows at the rate dP/dt, with the magnetic axis at right angles to the spin:
    k = I (dP/dt / P) (P / 2 pi)^(n-1), with the present moment I about the spin.

    On particles it acts as it does on a solid crust that holds the whole star: a = alpha x (x - c), I alpha = tau, with
    omega = I^-1 L and no magnetic axis, so that the rotation law is left as it is and L falls as that of a rigid body.
    """

    field: Any = None
    radius: Any = None
    speed_of_light: Any = None
    magnetic_axis: Any = None
    period: Any = None
    period_derivative: Any = None
    index: Any = 3.0

    kind: ClassVar[str] = "dipole_braking"
    external: ClassVar[bool] = True
    whole_body: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses two measures of its strength or none, and a dipole that brakes otherwise than a dipole does."""
        by_field = [options["field"] is not None, options["radius"] is not None]
        by_period = [options["period"] is not None, options["period_derivative"] is not None]
        if by_field not in ([True, True], [False, False]) or by_period != [not by_field[0]] * 2:
            raise ValueError("give either field and radius, or period and period_derivative")
        if by_field[0] and options["index"] != 3.0:
            raise ValueError("the braking index of a field is 3; give period and period_derivative for another one")
        return cls(**options)

    def in_units(self, units):
        """With the speed of light where its field needs one; ValueError where that has no value."""
        if self.field is None or self.speed_of_light is not None:
            return self
        if units == DIMENSIONLESS:
            raise ValueError("speed_of_light is missing, which the field of a scene in code units needs")
        return replace(self, speed_of_light=units.to_code(SPEED_OF_LIGHT, "velocity"))

    @property
    def inertial(self):
        """The torque is that of the whole spin."""
        return "follows from the spin in inertial axes"

    def strength(self, xp, spin, angular_momentum):
        """k |omega|^(n-1), zero where nothing turns."""
        square = xp.sum(spin**2)
        speed = xp.sqrt(xp.where(square > 0.0, square, 1.0))
        if self.field is not None:
            return 8.0 * math.pi / 3.0 * self.field**2 * self.radius**6 / self.speed_of_light**3 * square
        rate = 2.0 * math.pi / self.period
        moment = xp.sum(spin * angular_momentum) / speed**2
        growth = self.period_derivative / self.period
        return xp.where(square > 0.0, moment * growth * (speed / rate) ** (self.index - 1.0), 0.0)

    def torque(self, body):
        """In inertial axes."""
        across = spin = body.angular_velocity
        if self.magnetic_axis is not None:
            axis = body.attitude.T @ jnp.asarray(self.magnetic_axis)
            across = spin - axis * (jnp.sum(spin * axis) / jnp.sum(axis**2))
        return -self.strength(jnp, spin, body.angular_momentum) * across

    def turning(self, xp, fluid):
        """The angular acceleration alpha (3,), and the second moment Q (3, 3)."""
        second, mixed = moments(fluid)
        angular_momentum = axial_vector(mixed)
        # A body without a moment of inertia about some axis is not turned about it.
        inverse = xp.linalg.pinv(inertia_from_second_moment(second), hermitian=True)
        spin = inverse @ angular_momentum
        return inverse @ (-self.strength(xp, spin, angular_momentum) * spin), second

    def acceleration(self, xp, fluid):
        """alpha x (x - c)."""
        return xp.cross(self.turning(xp, fluid)[0], fluid.position - fluid.centre)

    def virial(self, xp, fluid):
        """Q [alpha]^T, whose antisymmetric part is the torque."""
        alpha, second = self.turning(xp, fluid)
        return second @ cross_matrix(alpha).T

    def timestep(self, xp, fluid):
        """L over the torque: the moment over its k |omega|^(n-1)."""
        second, mixed = moments(fluid)
        angular_momentum = axial_vector(mixed)
        inertia = inertia_from_second_moment(second)
        spin = xp.linalg.pinv(inertia, hermitian=True) @ angular_momentum
        smallest = 0.5 * (xp.trace(inertia) - xp.sqrt(xp.sum(inertia**2)))
        return smallest / xp.maximum(self.strength(xp, spin, angular_momentum), 1e-100)


def _size(body: Characteristic, options: Options) -> Found:
    assert body.moments is not None and body.spin is not None
    index = options["index"]
    if options["field"] is not None and options["radius"] is not None:
        light: Any = lit(body, options).speed_of_light
        field = 8.0 * math.pi / 3.0 * options["field"] ** 2 * options["radius"] ** 6 / light**3
        decay = field * body.spin**2 / body.moments[2]
    else:
        rate = 2.0 * math.pi / options["period"]
        decay = options["period_derivative"] / options["period"] * (body.spin / rate) ** (index - 1.0)
    if abs(index - 1.0) < 1e-9:
        change = -math.expm1(-decay * body.end)
    else:
        base = 1.0 + (index - 1.0) * decay * body.end
        change = 1.0 - base ** (-1.0 / (index - 1.0)) if base > 0.0 else 1.0
    return decay / body.spin if body.spin else 0.0, within_all(change)


ENTRY = Entry(
    "the torque by which a pulsar slows down: of a magnetic dipole, or of any braking index",
    {
        "field": positive("magnetic_field", None, "field at the magnetic equator; or give period_derivative"),
        "radius": positive("length", None, "where the field is that"),
        "speed_of_light": positive("velocity", None, "c, which a field in code units needs; else that of light"),
        "magnetic_axis": Option(
            "dimensionless", None, "in body axes; at right angles to the spin without it", shape=(3,),
            models=("rigid", "scaling"), nonzero=True,
        ),
        "period": positive("time", None, "rotation period at which the period grows by period_derivative"),
        "period_derivative": positive("dimensionless", None, "dP/dt, instead of a field"),
        "index": Option("dimensionless", 3.0, "braking index n: the torque goes with the n-th power of the spin"),
    },
    "body", "Goldreich 1970; Davis & Goldstein 1970; Michel & Goldwire 1970", ("sph", "rigid", "scaling"),
    colour="purple", made=DipoleBraking, rank=21,
    size=Measure(
        "torque over L omega", "1 - (1 + (n - 1) t/tau)^(-1/(n - 1)) with the age tau of the torque of now",
        "Goldreich 1970", _size, TURNS,
    ),
)  # fmt: skip
