"""A given gravitational field that the body moves in."""

import math
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import Characteristic, Effect, Entry, pytree
from astroinertia.effects.characteristic import tidal_parameter
from astroinertia.effects.effect import affine_moments, moments
from astroinertia.effects.measure import Found, Measure, Options, tidal_change
from astroinertia.effects.passes import time_beside
from astroinertia.gravity.point_masses import central_moment, excess, virial
from astroinertia.units import Option, positive

_WIDE = 1e3  # softening over the radius, beyond which the limit has more digits than the closed form


@pytree
@dataclass(frozen=True, eq=False)
class ExternalField(Effect):
    """The sum of those fields that are given, about the origin o, with d = x - o.

        uniform         a = g                              potential -g.d
        quadratic       a = -A d                           d.A.d/2, A symmetric
        logarithmic     a = -v^2 d/(d^2 + core^2)          v^2/2 ln(1 + d^2/core^2)
        point mass      a = -M d/(d^2 + softening^2)^1.5   -M/sqrt(d^2 + softening^2)

    Binney & Tremaine (2008), Galactic Dynamics, sections 2.2.2 and 2.3.2.
    """

    uniform: Any = None
    quadratic: Any = None
    circular_speed: Any = None
    core: Any = None
    point_mass: Any = None
    softening: Any = None
    origin: Any = (0.0, 0.0, 0.0)

    kind: ClassVar[str] = "external_field"
    external: ClassVar[bool] = True
    follows_place: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses a field of nothing, a field without its length, and a matrix that is not symmetric."""
        present = {name for name, value in options.items() if value is not None}
        if not present & {"uniform", "quadratic", "circular_speed", "point_mass"}:
            raise ValueError("it needs one of uniform, quadratic, circular_speed and point_mass")
        for one, other in (("circular_speed", "core"), ("point_mass", "softening")):
            if len(present & {one, other}) == 1:
                raise ValueError(f"it needs both {one} and {other}, or neither")
        matrix = options["quadratic"]
        if matrix is not None and any(matrix[i][j] != matrix[j][i] for i in range(3) for j in range(i)):
            raise ValueError("the quadratic matrix must be symmetric")
        return cls(**options)

    def separation(self, xp, fluid):
        """From the origin o to the particles, (N, 3)."""
        return fluid.position - xp.asarray(self.origin)

    def central_weights(self, xp, separation):
        """Weights w, (N,) each, of the parts a = -w d: logarithmic field and point mass, where given."""
        squared = xp.sum(separation**2, axis=1)
        weights = []
        if self.circular_speed is not None:
            weights.append(self.circular_speed**2 / (squared + self.core**2))
        if self.point_mass is not None:
            weights.append(self.point_mass * (squared + self.softening**2) ** -1.5)
        return weights

    def acceleration(self, xp, fluid):
        """Sum of the fields given."""
        separation = self.separation(xp, fluid)
        total = xp.zeros_like(separation)
        if self.uniform is not None:
            total = total + xp.asarray(self.uniform)
        if self.quadratic is not None:
            total = total - separation @ xp.asarray(self.quadratic).T
        for weight in self.central_weights(xp, separation):
            total = total - weight[:, None] * separation
        return total

    def specific_potential(self, xp, position):
        """The sum of the potentials given, of unit mass at places (..., 3)."""
        separation = position - xp.asarray(self.origin)
        squared = xp.sum(separation**2, axis=-1)
        total = xp.zeros_like(squared)
        if self.uniform is not None:
            total = total - separation @ xp.asarray(self.uniform)
        if self.quadratic is not None:
            total = total + 0.5 * xp.sum(separation * (separation @ xp.asarray(self.quadratic)), axis=-1)
        if self.circular_speed is not None:
            total = total + 0.5 * self.circular_speed**2 * xp.log1p(squared / self.core**2)
        if self.point_mass is not None:
            total = total - self.point_mass * (squared + self.softening**2) ** -0.5
        return total

    def potential_energy(self, xp, fluid):
        """Sum of m times the potentials given."""
        return fluid.mass @ self.specific_potential(xp, fluid.position)

    def virial(self, xp, fluid):
        """-Q A of the quadratic field, and what is not uniform over the body of the others (gravity.point_masses)."""
        tensor, origin = xp.zeros((3, 3)), xp.asarray(self.origin)
        if self.quadratic is not None:
            tensor = tensor - moments(fluid)[0] @ xp.asarray(self.quadratic)
        if self.circular_speed is not None:
            square = self.core**2
            at_centre = 1.0 / (xp.sum((fluid.centre - origin) ** 2) + square)
            weight = 1.0 / (xp.sum(self.separation(xp, fluid) ** 2, axis=1) + square)
            growth = excess(xp, fluid.position - fluid.centre, origin - fluid.centre, square)
            where = fluid.mass, fluid.position, fluid.centre, origin
            tensor = tensor - self.circular_speed**2 * central_moment(xp, *where, weight, at_centre, growth)
        if self.point_mass is not None:
            point = xp.asarray(self.point_mass).reshape(1), origin[None], self.softening**2
            tensor = tensor + virial(xp, fluid.mass, fluid.position, fluid.centre, *point)
        return tensor

    def timestep(self, xp, fluid):
        """The shortest of the times over which the fields turn a free particle (1/frequency), or it passes the mass."""
        squared_frequencies = [xp.max(weight) for weight in self.central_weights(xp, self.separation(xp, fluid))]
        if self.quadratic is not None:
            squared_frequencies.append(xp.sqrt(xp.sum(xp.asarray(self.quadratic) ** 2)))
        if not squared_frequencies:
            return None
        turning = 1.0 / xp.sqrt(xp.max(xp.stack(squared_frequencies)) + 1e-60)
        if self.point_mass is None:
            return turning
        mass, place = xp.asarray(self.point_mass).reshape(1), xp.asarray(self.origin)[None]
        beside = time_beside(xp, fluid, mass, place, xp.zeros((1, 3)), self.softening**2)
        return xp.minimum(turning, xp.min(beside))

    def affine_potential(self, body):
        """M Phi(centre) + 1/2 Q : (the second derivatives of Phi there); exact where Phi is quadratic."""
        return self._expanded(body, body.centre, body.deformation)

    def affine_force(self, body):
        """Minus the derivative of that potential by F: -q (second derivatives) F."""
        return self._push(body, argument=2)

    def affine_push(self, body):
        """Minus its derivative by the centre, where the moments of the body act too."""
        return self._push(body, argument=1)

    def affine_virial(self, body):
        """-Q A, A the second derivatives."""
        second, _ = affine_moments(body)
        return -second @ self._curvature(body.centre)

    def _push(self, body, argument):
        import jax

        return -jax.grad(self._expanded, argnums=argument)(body, body.centre, body.deformation)

    def _curvature(self, place):
        import jax

        return jax.hessian(partial(self.specific_potential, jnp))(place)

    def _expanded(self, body, centre, deformation):
        second = body.second_moment * deformation @ deformation.T
        curvature = self._curvature(centre)
        return body.mass * self.specific_potential(jnp, centre) + 0.5 * (second * curvature).sum()


def _added_weight(body: Characteristic, options: Options) -> float | None:
    """Of a point mass in the middle of a uniform sphere, -tr V over 3/5 G M^2/R; one outside raises a tide.

    With a softening s = a R that is 5 M'/M ((1 + 3 a^2)/(2 (1 + a^2)^(1/2)) - 3/2 a^2 arsinh(1/a)).
    """
    if not body.mass or not body.radius:
        return None
    if options["point_mass"] is None or math.dist(options["origin"], body.position) >= body.radius:
        return 0.0
    a, ratio = (options["softening"] or 0.0) / body.radius, options["point_mass"] / body.mass
    if a > _WIDE:
        return ratio * a**-3
    softer = 1.5 * a**2 * math.asinh(1.0 / a) if a > 0.0 else 0.0
    return 5.0 * ratio * ((1.0 + 3.0 * a**2) / (2.0 * math.hypot(1.0, a)) - softer)


def _size(body: Characteristic, options: Options) -> Found:
    assert body.dynamical_time is not None and body.radius is not None
    pull, away = 0.0, math.dist(options["origin"], body.position)
    if options["quadratic"] is not None:
        pull += max(abs(entry) for row in options["quadratic"] for entry in row)
    if options["circular_speed"] is not None:
        near = max(away, options["core"] or 0.0)
        pull += options["circular_speed"] ** 2 / near**2 if near > 0.0 else math.inf
    parameter = pull * body.dynamical_time**2
    if options["point_mass"] is not None and away < body.radius:
        parameter += _added_weight(body, options) or 0.0  # not a tide: most of the body is farther away than its middle
    elif options["point_mass"] is not None:
        parameter += tidal_parameter(body, options["point_mass"], max(away, options["softening"] or 0.0))
    return parameter, tidal_change(body, parameter)


ENTRY = Entry(
    "a given gravitational field: uniform, quadratic, logarithmic or of a softened point mass, or their sum",
    {
        "uniform": Option("acceleration", None, "uniform acceleration g", shape=(3,)),
        "quadratic": Option(
            "inverse_time_squared", None, "symmetric matrix A of the potential (x - o).A.(x - o)/2", shape=(3, 3),
        ),
        "circular_speed": positive("velocity", None, "v of the potential v^2/2 ln(1 + |x - o|^2/core^2)"),
        "core": positive("length", None, "core radius of that potential"),
        "point_mass": positive("mass", None, "M of the potential -M/sqrt(|x - o|^2 + softening^2)"),
        "softening": positive("length", None, "softening of that potential"),
        "origin": Option("length", (0.0, 0.0, 0.0), "origin o of all of them", shape=(3,)),
    },
    "particles", "Binney & Tremaine 2008, sections 2.2 and 2.3", ("sph", "ellipsoid"), colour="purple",
    size=Measure(
        "tidal field times R^3/(G M)", "as a tide of that size",
        "Binney & Tremaine 2008, section 8.2", _size, ("mass", "radius"), ("origin",),
    ),
    made=ExternalField, rank=12, added_weight=_added_weight,
)  # fmt: skip
