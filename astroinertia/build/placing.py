"""The body of a scene as particles: placed, at its temperature, turning, settled where it is asked for (code units)."""

import importlib
import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.build.flow import flow_of_shells, initial_velocity, linear_flow, rotation_flow
from astroinertia.build.fluids import entropies, materials_of
from astroinertia.build.spheres import Sphere, Star, building, stretch
from astroinertia.build.spin import rotation_amount
from astroinertia.engines import numba_cpu
from astroinertia.errors import SceneError
from astroinertia.matter import gases
from astroinertia.models.sph import relaxation
from astroinertia.models.sph.state import Problem
from astroinertia.scene.schema import Scene
from astroinertia.sph.placement import azimuthal_mode, place, turned
from astroinertia.sph.rotating import mapped
from astroinertia.sph.rotation import rotation_velocity
from astroinertia.sph.standard_volumes import DENSITY_FACTOR
from astroinertia.sph.table import read_body
from astroinertia.units import CodeUnits

# Smoothing and the surface leave this much of the density at 4000 particles; the error falls as N^-1/3.
_DENSITY_ERROR = 0.12
_LAYERED_DENSITY_ERROR = 0.2  # more where the density jumps, which smoothing spreads over a few layers of particles
_FALLING_DENSITY_ERROR = 0.2  # a gas of exponent 4/3 yields to what smoothing does
_FALLING_RESIDUAL = 2.5e-4  # of gravity, in a collapse, which lets what is left grow
_FALLING_STEPS = 6000  # at most: so small a residual takes 900 steps with 300 particles, 1500 with 1000
_STABLE_GAMMA = 5.0 / 3.0  # of the gas in which bodies settle, at least


@dataclass(frozen=True)
class Particles:
    """mass (N,), position (N, 3), velocity (N, 3), and either entropy (N,) or specific internal_energy (N,).

    material: (N,), where the equation of state has several; memory: what effects know of the particles beforehand, (N,)
    each.
    """

    mass: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    entropy: np.ndarray | None
    internal_energy: np.ndarray | None
    material: np.ndarray | None = None
    memory: dict[str, np.ndarray] = field(default_factory=dict)

    def moved(self, position: np.ndarray, velocity: np.ndarray) -> "Particles":
        """The same body elsewhere and in motion."""
        return replace(self, position=self.position + position, velocity=self.velocity + velocity)


def particles(scene: Scene, units: CodeUnits, initial: Any, problem: Problem) -> Particles:
    """The particles of a scene, settled to equilibrium where the scene asks for it."""
    placed = building(scene.body.placing)(scene, units, initial, problem)
    if placed.material is None and materials_of(problem.equation_of_state) > 1:
        return replace(placed, material=np.zeros(len(placed.mass), dtype=int))  # a body without layers is of the first
    return placed


def of_sphere(scene: Scene, units: CodeUnits, initial: Any, problem: Problem) -> Particles:
    """The particles of a Sphere or a Star, settled or not."""
    body: Any = scene.body
    mass = np.full(body.particles, initial.mass / body.particles)
    unit_sphere = place(initial.profile, body.particles, body.placement, body.seed)
    factor = 1.0  # of the entropies
    if isinstance(initial, Star):
        settles = body.relax and scene.has_equilibrium
        where, position, velocity = _placed_star(body, initial, problem, mass, unit_sphere, settles)
    else:
        where = np.linalg.norm(unit_sphere, axis=1)
        stretched = stretch(body)
        if not scene.settles:
            position = unit_sphere * initial.radius @ stretched
            velocity = flow_of_shells(scene, units, initial, mass, position, where)
        elif body.homologous:
            position, velocity, factor = _settled_core(scene, initial, problem, mass, unit_sphere)
            position, velocity = position @ stretched, velocity @ stretched
        else:
            position, velocity = _settled_sphere(scene, units, initial, problem, mass, unit_sphere)
            position, velocity = position @ stretched, velocity @ stretched
    velocity = velocity - mass @ velocity / mass.sum()  # differential rotation makes a push of the placement's noise
    if (uneven := body.perturbation) is not None:  # what turns about z turns as before
        angle = azimuthal_mode(position, uneven.mode, uneven.amplitude)
        position, velocity = turned(position, angle), turned(velocity, angle)
    velocity = velocity + linear_flow(scene, units, position)
    fluid = problem.equation_of_state
    if fluid.thermal and (energy := _stated_energy(body, units, initial, where)) is not None:
        return Particles(mass, position, velocity, None, energy)
    return Particles(mass, position, velocity, factor * entropies(scene, units, initial, fluid, where), None)


def _stated_energy(body: Any, units: CodeUnits, initial: Any, where: np.ndarray) -> np.ndarray | None:
    """The specific internal energy (N,) that the scene or its shells state; None where neither does."""
    if body.specific_internal_energy is not None:
        return np.full(len(where), units.to_code(body.specific_internal_energy, "specific_energy"))
    shells = initial.shells if isinstance(initial, Sphere) and initial.tabulated is None else None
    if shells is None or shells.internal_energy is None:
        return None
    if body.entropy is not None or body.pressure_fraction is not None:
        return None
    return shells.at(units.to_code(shells.internal_energy, "specific_energy"), where)


def _placed_star(
    body: Any, initial: Star, problem: Problem, mass: np.ndarray, unit_sphere: np.ndarray, settles: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where particles stand in the exact star, and their positions and velocities, settled or not."""
    star, law = initial.star, initial.star.rotation_law
    exact = mapped(star, initial.profile.enclosed(np.linalg.norm(unit_sphere, axis=1)), unit_sphere)
    if not settles:
        spin = rotation_velocity(mass, exact, law, angular_momentum=star.angular_momentum)
        return exact, exact, spin
    gamma = max(1 + 1 / body.index, _STABLE_GAMMA)
    pressure, density = initial.hydrostatic(exact)
    rotation = relaxation.Rotation("angular_momentum", star.angular_momentum, law=law, edge=star.equatorial_radius)
    with np.errstate(all="ignore"):
        entropy = pressure / density**gamma
    return exact, *_settled(problem, mass, exact, gamma, entropy, rotation, None)


def of_planet(scene: Scene, units: CodeUnits, planet: Any, problem: Problem) -> Particles:
    """The layers of a planet, each of its material on its isentrope, settled or not."""
    body: Any = scene.body
    mass = np.full(body.particles, planet.mass / body.particles)
    unit_sphere = place(planet.profile, body.particles, body.placement, body.seed)
    layer = planet.layer_of(np.linalg.norm(unit_sphere, axis=1))
    entropy = planet.labels[layer]
    material = planet.numbers[layer] if materials_of(problem.equation_of_state) > 1 else None
    position = unit_sphere * planet.radius
    memory = {}
    if body.surface == "full":
        from astroinertia.build.surfaces import density_factors  # most bodies do without

        memory = {DENSITY_FACTOR: density_factors(_still(problem), planet, mass, position, layer)}
    if body.relax and scene.has_equilibrium:
        relaxed = relaxation.relax(
            _still(problem), mass, position, entropy, planet.density_enclosing, _rotation(scene, units),
            relaxation.Tolerances(density_error=_density_error(_LAYERED_DENSITY_ERROR, len(mass))), material=material,
            memory=memory,
        )  # fmt: skip
        position, velocity = relaxed.position, relaxed.velocity
    else:
        velocity = rotation_flow(scene, units, planet, mass, position)
    return Particles(mass, position, velocity + linear_flow(scene, units, position), entropy, None, material, memory)


def _rotation(scene: Scene, units: CodeUnits) -> relaxation.Rotation | None:
    spin = scene.body.rotation
    if spin is None:
        return None
    ((measure, value),) = rotation_amount(scene, units, True).items()  # what settles has gravity
    scale = None if spin.scale is None else units.to_code(spin.scale, "length")
    return relaxation.Rotation(measure, value, spin.direction, scale, spin.law)


def _settled_sphere(
    scene: Scene, units: CodeUnits, initial: Sphere, problem: Problem, mass: np.ndarray, unit_sphere: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    body: Any = scene.body
    star = Polytrope(body.index, initial.mass, initial.radius)
    gamma = max(star.gamma, _STABLE_GAMMA)
    entropy = star.constant * initial.density(np.linalg.norm(unit_sphere, axis=1)) ** (star.gamma - gamma)
    return _settled(
        problem, mass, unit_sphere * initial.radius, gamma, entropy, _rotation(scene, units),
        lambda enclosed: initial.density(initial.profile.radius(enclosed / initial.mass)),
    )  # fmt: skip


def _settled_core(
    scene: Scene, initial: Sphere, problem: Problem, mass: np.ndarray, unit_sphere: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Positions and velocities of a homologous collapse seen from its flow, and the factor of its entropies."""
    body: Any = scene.body
    core = body.core(initial.mass, initial.radius)
    exact = initial.mass * initial.radius**2 * 3 * initial.profile.second_moment
    at = unit_sphere - unit_sphere.mean(axis=0)
    at = at * math.sqrt(exact / np.einsum("i,ij,ij->", mass, at, at))
    relaxed = relaxation.relax(
        replace(_still(problem), equation_of_state=gases.ideal(4.0 / 3.0)), mass, at,
        np.full_like(mass, core.constant),
        lambda enclosed: initial.density(initial.profile.radius(enclosed / initial.mass)),
        tolerances=relaxation.Tolerances(
            residual=_FALLING_RESIDUAL, density_error=_density_error(_FALLING_DENSITY_ERROR, len(mass))
        ),
        max_steps=_FALLING_STEPS,
        infall=core.deceleration,
    )  # fmt: skip
    return relaxed.position, relaxed.velocity, relaxed.report.pressure


def _settled(
    problem: Problem, mass: np.ndarray, position: np.ndarray, gamma: float, entropy: np.ndarray,
    rotation: relaxation.Rotation | None, target_density: Any,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    # The polytrope's own pressure, carried by a gas of exponent 5/3 at least: with the entropy rising outwards the body
    # has a stable equilibrium also where its own index has none (n = 3 is neutral). Any stretch comes afterwards.
    if not (np.isfinite(gamma) and np.isfinite(entropy).all()):
        raise SceneError(
            f"[body] has a pressure in proportion to density^{gamma:.3g}, which is too steep to settle particles with: "
            "take a larger index, or relax = false."
        )
    relaxed = relaxation.relax(
        replace(_still(problem), equation_of_state=gases.ideal(gamma)),
        mass,
        position,
        entropy,
        target_density=target_density,
        rotation=rotation,
        tolerances=relaxation.Tolerances(density_error=_density_error(_DENSITY_ERROR, len(mass))),
    )
    return relaxed.position, relaxed.velocity


def _still(problem: Problem) -> Problem:
    """What bodies settle under: gravity and pressure alone, in the precision of the run, whose programs then serve."""
    effects = tuple(effect.settling for effect in problem.effects if effect.kind in ("gravity", "pressure"))
    later = tuple(problem.terms(name) for name in ("gradient_terms", "neighbour_terms"))
    engine = numba_cpu.Engine(precision=problem.engine.precision, programs=later)
    return replace(problem, engine=engine, effects=effects)


def _density_error(at_4000: float, count: int) -> float:
    return at_4000 * max(1.0, (4000 / count) ** (1 / 3))


def of_table(scene: Scene, units: CodeUnits, initial: None, problem: Problem) -> Particles:
    """The user's own particles."""
    body: Any = scene.body
    fluid = problem.equation_of_state
    table = read_body(body.path(scene), units, body.velocity_unit)
    velocity = table.velocity + initial_velocity(scene, units, None, table.mass, table.position)
    return _at_its_temperature(scene, units, fluid, table.mass, table.position, velocity, table.internal_energy)


def of_class(scene: Scene, units: CodeUnits, initial: None, problem: Problem) -> Particles:
    """The particles of a body that is not of this package, with the rotation and the flow of the scene besides."""
    made = own_particles(scene, units)
    mass, position = made["mass"], made["position"]
    velocity = made["velocity"] + initial_velocity(scene, units, None, mass, position)
    return _at_its_temperature(
        scene, units, problem.equation_of_state, mass, position, velocity, made.get("internal_energy")
    )


def own_particles(scene: Scene, units: CodeUnits) -> dict[str, np.ndarray]:
    """What the class of a body that is not of this package makes; SceneError names it where that is wrong."""
    from astroinertia.sph.placed import particles as made_by  # only where there is such a body

    body: Any = scene.body
    try:
        return made_by(body.made(units), body.particles, body.seed)
    except ValueError as error:
        raise body.refused(error) from None


def _at_its_temperature(
    scene: Scene, units: CodeUnits, fluid: Any, mass: np.ndarray, position: np.ndarray, velocity: np.ndarray,
    energy: np.ndarray | None,
) -> Particles:  # fmt: skip
    """Particles of no known structure, with energies of their own or those of the scene."""
    if energy is None and scene.body.specific_internal_energy is not None:
        energy = np.full_like(mass, units.to_code(scene.body.specific_internal_energy, "specific_energy"))
    if energy is not None and fluid.thermal:
        return Particles(mass, position, velocity, None, energy)
    return Particles(mass, position, velocity, entropies(scene, units, None, fluid, np.zeros_like(mass)), None)


def of_problem(scene: Scene, units: CodeUnits, initial: None, problem: Problem) -> Particles:
    """The gas of a standard problem."""
    # Only the problem that is asked for is imported; such scenes are in code units.
    body: Any = scene.body
    module = importlib.import_module("astroinertia.test_problems.matter")
    lengths = scene.box_lengths
    matter = module.standard(body.problem).place(body.particles, lengths, problem.equation_of_state.gamma)
    return Particles(matter.mass, matter.position, matter.velocity, None, matter.internal_energy)
