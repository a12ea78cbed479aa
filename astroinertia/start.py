"""The body of a scene as particles: placed, at its temperature, turning (all in code units)."""

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.bodies.rotating_star import RotatingStar, rotating_star, rotating_star_with
from astroinertia.bodies.rotation_laws import RotationLaw
from astroinertia.bodies.scf_matter import polytropic_matter
from astroinertia.engines import numba_cpu
from astroinertia.errors import NumericalError, SceneError
from astroinertia.models import relaxation
from astroinertia.models.sph import Problem
from astroinertia.scene.fluids import FROM_BODY
from astroinertia.scene.schema import Scene
from astroinertia.sph import eos, profiles
from astroinertia.sph.initial import place
from astroinertia.sph.profiles import Profile
from astroinertia.sph.rotating import mapped
from astroinertia.sph.rotation import linear_velocity, rotation_velocity
from astroinertia.sph.table import read_table
from astroinertia.units import CodeUnits, pressure_constant_dimension

_PRESSURE_NODES = 4096
# Smoothing and the surface leave this much of the density at 4000 particles; the error falls as N^-1/3.
_DENSITY_ERROR = 0.12
_STABLE_GAMMA = 5.0 / 3.0  # of the gas in which bodies settle, at least
_OUTERMOST = 1e-6  # of the mass: what is outside the shell where profiles are floored


@dataclass(frozen=True)
class Particles:
    """mass (N,), position (N, 3), velocity (N, 3), and either entropy (N,) or specific internal_energy (N,)."""

    mass: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    entropy: np.ndarray | None
    internal_energy: np.ndarray | None


@dataclass(frozen=True)
class Sphere:
    """The sphere that a body is before it is stretched: a profile with a mass and a radius."""

    profile: Profile
    mass: float
    radius: float
    radius_convention = "radius of the initial body before its axes stretch it"

    def density(self, s: np.ndarray) -> np.ndarray:
        """Density at s = r/R, floored where the profile ends so that particles at the surface keep a temperature."""
        inside = np.minimum(s, float(self.profile.radius(np.array(1.0 - _OUTERMOST))))
        return self.profile.density(inside) * self.mass / self.radius**3

    def pressure(self, s: np.ndarray) -> np.ndarray:
        """Pressure of hydrostatic equilibrium at s: the weight of what lies above, int_s^1 rho m / s^2 ds."""
        nodes = 1.0 - (1.0 - np.linspace(0.0, 1.0, _PRESSURE_NODES)) ** 2  # dense at the surface
        nodes[0] = 1e-6
        weight = self.profile.density(nodes) * self.profile.enclosed(nodes) / nodes**2
        slices = 0.5 * (weight[1:] + weight[:-1]) * np.diff(nodes)
        above = np.concatenate([np.cumsum(slices[::-1])[::-1], [0.0]])
        inside = np.minimum(s, float(self.profile.radius(np.array(1.0 - _OUTERMOST))))
        return np.interp(inside, nodes, above) * self.mass**2 / self.radius**4

    def hydrostatic(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pressure of equilibrium and density at s."""
        return self.pressure(s), self.density(s)

    def densest(self) -> tuple[float, float]:
        """Pressure of equilibrium and density near the centre."""
        centre = np.array([1e-3])
        return float(self.pressure(centre)[0]), float(self.density(centre)[0])


@dataclass(frozen=True)
class Star:
    """A rotating star in equilibrium, with the polytrope at rest whose glass is mapped to it."""

    star: RotatingStar
    profile: Profile
    radius_convention = "equatorial radius of the initial star"

    @property
    def mass(self) -> float:
        """Total mass."""
        return self.star.mass

    @property
    def radius(self) -> float:
        """Equatorial radius."""
        return self.star.equatorial_radius

    def hydrostatic(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pressure of equilibrium and density at positions (N, 3), floored at the surface."""
        star = self.star
        level = star.level(np.hypot(position[:, 0], position[:, 1]), position[:, 2])
        level = np.maximum(level, star.level_enclosing(1 - _OUTERMOST))
        matter = star.field.matter
        return star.max_density * star.max_enthalpy * matter.pressure(level), star.max_density * matter.density(level)

    def densest(self) -> tuple[float, float]:
        """The largest pressure and density."""
        return self.star.max_pressure, self.star.max_density


def stretch(body: Any) -> np.ndarray:
    """The symmetric matrix (3, 3) that makes the sphere an ellipsoid: `axes` along `axes_at_start`."""
    rows = np.asarray(body.axes_at_start, dtype=float)
    left, _, right = np.linalg.svd(rows / np.linalg.norm(rows, axis=1, keepdims=True))
    nearest = left @ right  # at right angles to round-off
    return nearest.T @ np.diag(np.asarray(body.axes, dtype=float)) @ nearest


def sphere(scene: Scene, units: CodeUnits) -> Sphere | Star | None:
    """The unstretched sphere, or the rotating star, of a scene's body; None for a particle table or a rigid body."""
    body: Any = scene.body
    if body.kind in ("table", "rigid"):
        return None
    mass, radius = units.to_code(body.mass, "mass"), units.to_code(body.radius, "length")
    if body.kind == "rotating_star":
        return Star(_rotating_star(body, units, mass, radius), profiles.polytrope(body.index))
    profile = {
        "polytrope": lambda: profiles.polytrope(body.index),
        "uniform": profiles.uniform,
        "power_law": lambda: profiles.power_law(body.exponent),
        "dyson": lambda: profiles.dyson(body.gamma),
    }[body.kind]()
    return Sphere(profile, mass, radius)


def _rotating_star(body: Any, units: CodeUnits, mass: float, radius: float) -> RotatingStar:
    # In units of mass and equatorial radius, in which the law's scale is given to the solver.
    rate, spin = (mass / radius**3) ** 0.5, (mass**3 * radius) ** 0.5
    wanted = {
        "axis_ratio": body.axis_ratio,
        "rotational_to_gravitational": body.t_over_w,
        "angular_velocity": None if body.rate is None else units.to_code(body.rate, "angular_velocity") / rate,
        "angular_momentum": None
        if body.angular_momentum is None
        else units.to_code(body.angular_momentum, "angular_momentum") / spin,
    }
    ((quantity, value),) = ((name, value) for name, value in wanted.items() if value is not None)
    scale = None if body.scale is None else units.to_code(body.scale, "length") / radius
    try:
        unit_star = _unit_star(body.index, RotationLaw(body.law, scale), quantity, value)
    except (ValueError, NumericalError) as error:
        units_told = " (in units of its mass, equatorial radius and G)" if quantity.startswith("angular") else ""
        raise SceneError(f"[body] {error}{units_told}.") from None
    return replace(unit_star, mass=mass, equatorial_radius=radius)


@lru_cache(maxsize=8)
def _unit_star(index: float, law: RotationLaw, quantity: str, value: float) -> RotatingStar:
    matter = polytropic_matter(index)
    if quantity == "axis_ratio":
        return rotating_star(matter, value, law)
    return rotating_star_with(quantity, value, matter, law)


def equation_of_state(scene: Scene, units: CodeUnits, ball: Sphere | Star | None) -> Any:
    """The scene's equation of state in code units, its constant taken from the body where the scene says so."""
    chosen = scene.equation_of_state
    assert chosen is not None  # the schema asks for it where the model needs it
    if chosen.kind == "ideal":
        return eos.ideal(chosen.gamma)
    if chosen.kind == "isothermal":
        return eos.isothermal(units.to_code(chosen.sound_speed, "velocity"))
    if chosen.kind == "polytropic":
        return eos.polytropic(chosen.gamma, _constant(scene, units, ball, chosen.gamma))
    if chosen.kind == "piecewise_polytropic":
        densities = [units.to_code(density, "density") for density in chosen.densities]
        return eos.piecewise_polytropic(densities, chosen.gammas, _constant(scene, units, ball, chosen.gammas[0]))
    assert chosen.kind == "hybrid"  # incompressible fluids have no equation that particles could follow
    nuclear = units.to_code(chosen.nuclear_density, "density")
    constant = _constant(scene, units, ball, chosen.gamma_1)
    return eos.hybrid(nuclear, chosen.gamma_1, chosen.gamma_2, chosen.gamma_thermal, constant)


def entropies(scene: Scene, units: CodeUnits, ball: Sphere | Star | None, fluid: Any, where: np.ndarray) -> np.ndarray:
    """The entropy function of particles, (N,), at s = r/R in the unstretched sphere or at positions in the star.

    What the scene gives, or that of hydrostatic equilibrium times its pressure_fraction; zero where the equation of
    state is barotropic, and for the hybrid one, whose cold part holds the body.
    """
    body = scene.body
    if not fluid.thermal:
        return np.zeros(len(where))
    if body.entropy is not None:
        gamma = fluid.gamma_thermal if _hybrid(scene) else fluid.gamma
        return np.full(len(where), units.to_code(body.entropy, pressure_constant_dimension(gamma)))
    if ball is None:
        raise SceneError("[body] a table without a column u needs specific_internal_energy or entropy.")
    if _hybrid(scene) or "pressure" not in scene.effects:
        return np.zeros(len(where))
    if "gravity" not in scene.effects:
        raise SceneError(
            "[body] needs specific_internal_energy or entropy: without gravity there is no equilibrium to take it from."
        )
    pressure, density = ball.hydrostatic(where)
    return (body.pressure_fraction or 1.0) * pressure / density**fluid.gamma


def _hybrid(scene: Scene) -> bool:
    return scene.equation_of_state is not None and scene.equation_of_state.kind == "hybrid"


def particles(
    scene: Scene, units: CodeUnits, ball: Sphere | Star | None, problem: Problem, listener: Any = None
) -> Particles:
    """The particles of a scene, settled to equilibrium where the scene asks for it; `listener` hears how that goes."""
    body: Any = scene.body
    fluid = problem.equation_of_state
    if ball is None:
        return _table(scene, units, fluid)
    mass = np.full(body.particles, ball.mass / body.particles)
    unit_sphere = place(ball.profile, body.particles, body.placement, body.seed)
    settles = body.relax and {"gravity", "pressure"} <= set(scene.effects)
    if isinstance(ball, Star):
        where, position, velocity = _placed_star(body, ball, problem, mass, unit_sphere, settles, listener)
    else:
        where = np.linalg.norm(unit_sphere, axis=1)
        settles = settles and body.kind == "polytrope" and body.index > 0
        stretched = stretch(body)
        if settles:
            position, velocity = _settled_sphere(scene, units, ball, problem, mass, unit_sphere, listener)
            position, velocity = position @ stretched, velocity @ stretched
        else:
            position = unit_sphere * ball.radius @ stretched
            velocity = _rotation(scene, units, ball, mass, position)
    velocity = velocity + _flow(scene, units, position)
    if body.specific_internal_energy is not None and fluid.thermal:
        energy = units.to_code(body.specific_internal_energy, "specific_energy")
        return Particles(mass, position, velocity, None, np.full_like(mass, energy))
    return Particles(mass, position, velocity, entropies(scene, units, ball, fluid, where), None)


def _placed_star(
    body: Any, ball: Star, problem: Problem, mass: np.ndarray, unit_sphere: np.ndarray, settles: bool, listener: Any
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where particles stand in the exact star, and their positions and velocities, settled or not."""
    star, law = ball.star, ball.star.rotation_law
    exact = mapped(star, ball.profile.enclosed(np.linalg.norm(unit_sphere, axis=1)), unit_sphere)
    if not settles:
        spin = rotation_velocity(mass, exact, law.kind, scale=law.scale, angular_momentum=star.angular_momentum)
        return exact, exact, spin
    gamma = max(1 + 1 / body.index, _STABLE_GAMMA)
    pressure, density = ball.hydrostatic(exact)
    rotation = relaxation.Rotation(
        "angular_momentum", star.angular_momentum, scale=law.scale, law=law.kind, edge=star.equatorial_radius
    )
    return exact, *_settled(problem, mass, exact, gamma, pressure / density**gamma, rotation, None, listener)


def _settled_sphere(
    scene: Scene, units: CodeUnits, ball: Sphere, problem: Problem, mass: np.ndarray, unit_sphere: np.ndarray,
    listener: Any,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    body: Any = scene.body
    star = Polytrope(body.index, ball.mass, ball.radius)
    gamma = max(star.gamma, _STABLE_GAMMA)
    entropy = star.constant * ball.density(np.linalg.norm(unit_sphere, axis=1)) ** (star.gamma - gamma)
    rotation, spin = None, body.rotation
    if spin is not None:
        ((measure, value),) = _amount(scene, units).items()
        scale = None if spin.scale is None else units.to_code(spin.scale, "length")
        rotation = relaxation.Rotation(measure, value, spin.axis, scale, spin.law)
    return _settled(
        problem, mass, unit_sphere * ball.radius, gamma, entropy, rotation,
        lambda enclosed: ball.density(ball.profile.radius(enclosed / ball.mass)), listener,
    )  # fmt: skip


def _settled(
    problem: Problem, mass: np.ndarray, position: np.ndarray, gamma: float, entropy: np.ndarray,
    rotation: relaxation.Rotation | None, target_density: Any, listener: Any,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    # The polytrope's own pressure, carried by a gas of exponent 5/3 at least: with the entropy rising outwards the body
    # has a stable equilibrium also where its own index has none (n = 3 is neutral). Any stretch comes afterwards.
    still = replace(
        problem,
        engine=numba_cpu.Engine(precision="float64"),
        equation_of_state=eos.ideal(gamma),
        effects=tuple(effect for effect in problem.effects if effect.kind in ("gravity", "pressure")),
    )
    relaxed = relaxation.relax(
        still,
        mass,
        position,
        entropy,
        target_density=target_density,
        rotation=rotation,
        tolerances=relaxation.Tolerances(density_error=_DENSITY_ERROR * max(1.0, (4000 / len(mass)) ** (1 / 3))),
        listener=listener,
    )
    return relaxed.position, relaxed.velocity


def initial_velocity(
    scene: Scene, units: CodeUnits, ball: Sphere | Star | None, mass: np.ndarray, position: np.ndarray
) -> np.ndarray:
    """Velocities (N, 3) of the scene's rotation and linear flow at positions (N, 3), not settled."""
    return _flow(scene, units, position) + _rotation(scene, units, ball, mass, position)


def _flow(scene: Scene, units: CodeUnits, position: np.ndarray) -> np.ndarray:
    gradient = scene.body.velocity_gradient
    if gradient is None:
        return np.zeros_like(position)
    return linear_velocity(position, units.to_code(np.array(gradient), "velocity_gradient"))


def _amount(scene: Scene, units: CodeUnits) -> dict[str, float]:
    # The one measure of the amount of rotation that a scene gives.
    measures = {"rate": "angular_velocity", "period": "time", "angular_momentum": "angular_momentum"}
    measures["t_over_w"] = "dimensionless"
    given = {name: getattr(scene.body.rotation, name) for name in measures}
    return {name: units.to_code(value, measures[name]) for name, value in given.items() if value is not None}


def _rotation(
    scene: Scene, units: CodeUnits, ball: Sphere | Star | None, mass: np.ndarray, position: np.ndarray
) -> np.ndarray:
    body: Any = scene.body
    spin, binding = body.rotation, None
    if spin is None:
        return np.zeros_like(position)
    if isinstance(ball, Sphere) and "gravity" in scene.effects:
        semi_axes = ball.radius * np.asarray(body.axes)
        binding = profiles.ellipsoid_gravitational_energy(ball.profile, ball.mass, semi_axes)
    scale = None if spin.scale is None else units.to_code(spin.scale, "length")
    try:
        return rotation_velocity(mass, position, spin.law, spin.axis, scale, binding, **_amount(scene, units))
    except ValueError as error:
        raise SceneError(f"[body.rotation] {error}.") from None


def _table(scene: Scene, units: CodeUnits, fluid: Any) -> Particles:
    body: Any = scene.body
    table = read_table(Path(scene.origin or ".") / body.file)
    mass = units.to_code(table.mass, "mass")
    position = units.to_code(table.position, "length")
    velocity = units.to_code(table.velocity, "velocity") + initial_velocity(scene, units, None, mass, position)
    energy = table.internal_energy
    if energy is None and body.specific_internal_energy is not None:
        energy = np.full_like(mass, body.specific_internal_energy)
    if energy is not None and fluid.thermal:
        return Particles(mass, position, velocity, None, units.to_code(energy, "specific_energy"))
    return Particles(mass, position, velocity, entropies(scene, units, None, fluid, np.zeros_like(mass)), None)


def _constant(scene: Scene, units: CodeUnits, ball: Sphere | Star | None, gamma: float) -> float:
    body: Any = scene.body
    chosen: Any = scene.equation_of_state
    constant = chosen.constant
    if constant != FROM_BODY:
        return units.to_code(constant, pressure_constant_dimension(gamma))
    if ball is None:
        raise SceneError('[equation_of_state] constant = "from body" needs a body of known structure, not a table.')
    if body.kind == "polytrope":
        star = Polytrope(body.index, ball.mass, ball.radius)
        pressure, density = star.central_pressure, star.central_density
    else:
        pressure, density = ball.densest()
    return (body.pressure_fraction or 1.0) * eos.polytropic_constant(density, pressure, gamma)
