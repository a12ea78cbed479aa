"""Characteristic numbers of a scene, from the scene alone and before anything is built; rough, and None if unknown.

Tests: tests/unit/effects/test_sizes.py.
"""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.effects.characteristic import Characteristic, Neighbour, Pair
from astroinertia.errors import SceneError
from astroinertia.inertia.tensor import axial_vector, inertia_from_second_moment, second_moment_from_inertia
from astroinertia.rotation.attitude import cross_matrix
from astroinertia.scene.companions import Companion
from astroinertia.scene.fluids import FROM_BODY, MONATOMIC
from astroinertia.scene.further_pressure import further_pressure
from astroinertia.scene.initial_body import ascending, unit
from astroinertia.scene.scales import code_units
from astroinertia.scene.schema import Scene
from astroinertia.units import SPEED_OF_LIGHT

_NODES = 64  # shells of a profile
_MOST = 700.0  # natural logarithm of about the largest number


def characteristic(scene: Scene) -> Characteristic:
    """The numbers of the first body of a scene, with its neighbours and its run."""
    body: Any = scene.body
    fluid: Any = scene.equation_of_state
    numbers: dict[str, Any] = {
        "end": scene.time.end,
        "gravitational_constant": scene.gravitational_constant,
        "speed_of_light": None if scene.dimensionless else SPEED_OF_LIGHT,
        "deforms": scene.model != "rigid" and not body.solid and body.change is None,
        "held": fluid is not None and fluid.kind == "incompressible",
        "bodies": max(1, len(scene.bodies)),
        "touching": bool(scene.bodies) or body.composite,
        "rate_needs_gravity": scene.model == "rigid" and getattr(body.rotation, "t_over_w", None) is not None,
        "homologous": body.homologous,
        "position": (not scene.bodies and scene.body.position) or (0.0, 0.0, 0.0),
        "stars": _stars(scene),
        "gamma": MONATOMIC if fluid is None else fluid.first_gamma,
        "expansion": _expansion(body)
        + (body.expansion(body.mass, body.radius, scene.gravitational_constant) if body.homologous else 0.0),
    }
    if body.kind == "table" and scene.origin is not None and body.rotation is None and not _gradient(body).any():
        numbers |= _of_table(scene)
    elif body.kind == "profile":
        numbers |= _of_shells(scene)
    elif (profile := body.profile()) is not None:
        numbers |= _sphere(scene, profile, body.mass, body.radius)
    else:
        numbers |= body.characteristic()
    mass = numbers.get("mass", body.mass)
    if mass is None:
        numbers["neighbours"] = None if scene.companions else ()
    else:
        numbers["neighbours"] = _neighbours(scene, mass)
    if scene.bodies:
        numbers |= _several(scene)
    found = Characteristic(**numbers)
    return replace(found, added_weight=added_weight(scene, found, scene.effects))


def _stars(scene: Scene) -> tuple[tuple[float, float], ...]:
    origin = (0.0, 0.0, 0.0)
    centre = scene.body.position or origin
    return tuple((sink.mass, math.dist(sink.position or origin, centre)) for sink in scene.sinks)


def added_weight(scene: Scene, body: Characteristic, kinds: Iterable[str]) -> float:
    """What effects of these kinds add to |W| of a body over it."""
    of_effects = [(scene.entries[kind].added_weight, scene.effects[kind]) for kind in kinds]
    return sum(added(body, options) or 0.0 for added, options in of_effects if added is not None)


def _gradient(body: Any) -> np.ndarray:
    return np.zeros((3, 3)) if body.velocity_gradient is None else np.asarray(body.velocity_gradient, dtype=float)


def _expansion(body: Any) -> float:
    return float(_gradient(body).trace()) / 3.0


def _of_shells(scene: Scene) -> dict[str, Any]:
    body: Any = scene.body
    try:
        shells = body.shells(scene)
    except SceneError:  # said where the body is made
        return {}
    return _sphere(scene, shells.profile(), float(shells.mass[-1]), float(shells.radius[-1]), shells)


def _sphere(scene: Scene, profile: Any, mass: float, at_surface: float, shells: Any = None) -> dict[str, Any]:
    """Of a profile with a mass and a radius, before axes stretch it; shells: those of a stellar profile."""
    from astroinertia.sph import profiles  # only here: whoever reads a scene does not ask how large its effects are

    body: Any = scene.body
    constant = scene.gravitational_constant
    axes = at_surface * np.asarray(getattr(body, "axes", (1.0, 1.0, 1.0)), dtype=float)
    radius = float(np.prod(axes)) ** (1.0 / 3.0)
    rows = body.rows_at_start
    second = rows.T @ np.diag(profile.second_moment * mass * axes**2) @ rows
    tensor = inertia_from_second_moment(second)
    gravitational = -constant * profiles.ellipsoid_gravitational_energy(profile, mass, axes)
    if not math.isfinite(gravitational):
        gravitational = constant * mass**2 / radius * 10.0
    star = _forwards(body).equilibrium(constant) if body.quickly_known else None
    if star is not None:
        tensor, gravitational = np.diag([star.equatorial_moment] * 2 + [star.polar_moment]), -star.gravitational_energy
        second = second_moment_from_inertia(tensor)
    numbers = {
        "mass": mass, "radius": radius, "moments": ascending(np.linalg.eigvalsh(tensor)),
        "second_moment": float(np.trace(second)), "gravitational": gravitational,
    }  # fmt: skip
    if shells is not None and body.rotation is None:
        numbers |= _turning_shells(shells, body.rotation_factor, float(tensor[2, 2]))
    else:
        numbers |= body.turning(tensor, gravitational) if star is None else _of_star(star, body)
    if numbers["spin"] is not None:
        numbers |= _flow(body, second, numbers)
    if shells is None:
        share = np.polynomial.legendre.leggauss(_NODES)
        nodes, weights = (share[0] + 1.0) / 2.0, share[1] / 2.0
    else:
        nodes, weights = shells.mass / mass, np.diff(shells.mass, prepend=0.0) / mass
    s = np.asarray(profile.radius(nodes), dtype=float)
    with np.errstate(over="ignore"):
        density = np.asarray(profile.density(s), dtype=float) * mass / radius**3
    numbers["central_density"] = float(density[0])
    numbers |= _heat(scene, numbers, density, weights, shells)
    numbers["further_pressure"] = _further(scene, density, mass * weights)
    falls = math.pi / 2.0 * np.sqrt((s * radius) ** 3 / (2.0 * constant * mass * nodes))
    numbers["fallen"] = float(weights[falls <= scene.time.end].sum())
    return numbers


def _of_table(scene: Scene) -> dict[str, Any]:
    from astroinertia.scene.table_numbers import of_table  # only where there is a file to open

    try:
        return of_table(scene)
    except (SceneError, OSError, ArithmeticError, np.linalg.LinAlgError):  # said where the body is made
        return {}


def _turning_shells(shells: Any, factor: float, moment: float) -> dict[str, Any]:
    """How the shells of a stellar profile turn about z, stretched to that moment; the mean rate has their L."""
    spin, stretch = factor * shells.angular_momentum / shells.moment_of_inertia, moment / shells.moment_of_inertia
    axis, energy = (0.0, 0.0, -1.0 if spin < 0.0 else 1.0), factor**2 * shells.rotational_energy * stretch
    return {"spin": abs(spin), "spin_axis": axis, "wobble": 0.0, "rotational": energy, "shear": abs(spin)}


def _forwards(star: Any) -> Any:
    backwards = {
        name: abs(value) for name in ("rate", "angular_momentum") if (value := getattr(star, name)) is not None
    }
    return star.model_copy(update=backwards)


def _of_star(star: Any, body: Any) -> dict[str, Any]:
    """How it turns; the mean rate has its angular momentum."""
    spin = star.angular_momentum / star.polar_moment
    axis = (0.0, 0.0, -1.0 if (body.rate or body.angular_momentum or 0.0) < 0.0 else 1.0)
    shear = 0.0 if body.law == "rigid" else spin
    return {"spin": spin, "spin_axis": axis, "wobble": 0.0, "rotational": star.kinetic_energy, "shear": shear}


def _flow(body: Any, second: np.ndarray, numbers: dict[str, Any]) -> dict[str, Any]:
    """Rotation with a linear flow besides: its energy without what swells the body, its spin and its shear."""
    gradient = _gradient(body) - np.eye(3) * _expansion(body)
    law = getattr(body.rotation, "law", "rigid")
    shear = 0.0 if law == "rigid" else numbers["spin"]
    if not gradient.any():
        return {"shear": shear or numbers.get("shear", 0.0)}
    about = numbers["spin"] * np.asarray(numbers["spin_axis"])
    whole = gradient + cross_matrix(about)
    strain = float(np.linalg.norm(whole + whole.T)) / 2.0
    momentum = axial_vector(second @ whole.T)
    # A needle may have no moment about its own axis, to rounding, and no spin about it that could be stated.
    spin = np.linalg.pinv(inertia_from_second_moment(second), hermitian=True) @ momentum
    rate = float(np.linalg.norm(spin))
    energy = 0.5 * float(np.trace(whole @ second @ whole.T))
    axis = unit(spin) if rate > 0.0 else numbers["spin_axis"]
    return {"rotational": energy, "shear": max(shear, strain), "spin": rate, "spin_axis": axis}


def _heat(
    scene: Scene, numbers: dict[str, Any], density: np.ndarray, weights: np.ndarray, shells: Any = None
) -> dict[str, Any]:
    """3 Pi and U: as the scene gives them, as shells of a stellar profile have them, or as they hold the body up."""
    body: Any = scene.body
    fluid: Any = scene.equation_of_state
    mass, weight = numbers["mass"], numbers["gravitational"]
    if fluid is not None and fluid.kind == "own":
        with fluid.entry.at_work():
            return _own_heat(fluid.matter(), body, mass, density, weights)
    gamma = MONATOMIC if fluid is None else fluid.first_gamma
    if body.specific_internal_energy is not None:
        energy = body.specific_internal_energy * mass
        return {"triple_pressure": 3.0 * max(gamma - 1.0, 0.0) * energy, "thermal_energy": energy}
    constant = body.entropy
    if constant is None and fluid is not None and fluid.stated_constant != FROM_BODY:
        constant = fluid.stated_constant
    if constant is not None:
        exponent = fluid.thermal_gamma if fluid is not None and constant == body.entropy else gamma
        triple = 3.0 * mass * constant * _mean_power(density, weights, (exponent or gamma) - 1.0)
    elif fluid is not None and fluid.kind == "isothermal":
        triple = 3.0 * mass * fluid.sound_speed**2
    elif shells is not None:
        if fluid is not None and fluid.kind == "materials":
            return {}  # at their coldest, unless the scene says how warm
        held = _entropy_of_shells(scene, shells, gamma)
        triple = 3.0 * mass * float(weights @ (held * density ** (gamma - 1.0)))
    else:
        settled = scene.model == "sph" and body.relax
        turning = body.spin is body or settled or (scene.model == "scaling" and fluid is None)
        turning = turning or (fluid is not None and fluid.kind == "incompressible")
        triple = max(weight - (2.0 * numbers.get("rotational", 0.0) if turning else 0.0), 0.0)
        triple *= (body.pressure_fraction or 1.0) * body.support
        if fluid is not None and fluid.stated_constant == FROM_BODY and body.polytropic_index:
            # One constant, of the centre, holds up matter of another exponent there alone.
            thin = density / density[0]
            triple *= float(weights @ thin ** (gamma - 1.0)) / float(weights @ thin ** (1.0 / body.polytropic_index))
    # Of a gas at one temperature, what it would have as a monatomic one.
    gamma = MONATOMIC if fluid is not None and fluid.kind == "isothermal" else gamma
    return {"triple_pressure": triple, "thermal_energy": triple / (3.0 * max(gamma - 1.0, 1e-3))}


def _mean_power(density: np.ndarray, weights: np.ndarray, exponent: float) -> float:
    """The weighted mean of a power of densities; infinite where that is more than numbers hold."""
    some = density > 0.0
    logs = exponent * np.log(density[some])
    return float(weights[some] @ np.exp(logs)) if logs.max() < _MOST else math.inf


def _entropy_of_shells(scene: Scene, shells: Any, gamma: float) -> np.ndarray:
    """P/rho^gamma (K,) by the pressures of a profile, or its energies, or its balance; or that of its centre."""
    body: Any = scene.body
    constant = None if scene.equation_of_state is None else scene.equation_of_state.stated_constant
    pressure = shells.pressure
    if pressure is None and constant is None and shells.internal_energy is not None and not body.pressure_fraction:
        pressure = (gamma - 1.0) * shells.density * shells.internal_energy
    elif pressure is None:
        pressure = shells.pressure_in_balance(scene.gravitational_constant)
    entropy = (body.pressure_fraction or 1.0) * pressure / shells.density**gamma
    return entropy if constant is None else np.full_like(entropy, entropy[0])


def _further(scene: Scene, density: np.ndarray, mass: np.ndarray) -> float:
    """3 times the volume integral of what effects add at the start to the pressure of the equation of state."""
    adds, units = further_pressure(scene), code_units(scene)
    if adds is None:
        return 0.0
    dense = units.to_code(density, "density")
    return 3.0 * units.to_si(float(mass @ (adds(dense) / dense)), "specific_energy")


def _own_heat(matter: Any, body: Any, mass: float, density: np.ndarray, weights: np.ndarray) -> dict[str, Any]:
    """The same of an equation of state that is not built in, by its own functions; as exponent, the mean of c^2 over
    that of P/rho.
    """
    entropy = np.zeros_like(density)
    if matter.thermal:
        if body.specific_internal_energy is None:
            return {}
        entropy = matter.entropy(np, density, entropy + body.specific_internal_energy)
    with np.errstate(all="ignore"):
        ratio = float(weights @ (matter.pressure(np, density, entropy) / density))
        stiffness = float(weights @ matter.sound_speed(np, density, entropy) ** 2)
    if not (math.isfinite(ratio) and math.isfinite(stiffness)) or ratio <= 0.0:
        return {}
    gamma = min(max(stiffness / ratio, 1.0), 10.0)
    energy = body.specific_internal_energy if matter.thermal else ratio / max(gamma - 1.0, 2.0 / 3.0)
    return {"gamma": gamma, "triple_pressure": 3.0 * mass * ratio, "thermal_energy": mass * energy}


def _several(scene: Scene) -> dict[str, Any]:
    all_masses: list[Any] = [body.mass for body in scene.bodies]
    masses = [float(mass) for mass in all_masses if mass is not None]
    if len(masses) != 2 or len(all_masses) != 2:
        return {"mass": None}
    places = [np.asarray(body.position or (0.0, 0.0, 0.0)) for body in scene.bodies]
    orbit: Any = scene.orbit
    apart = float(np.linalg.norm(places[1] - places[0])) if orbit is None else orbit.pericentre
    return {"pair": Pair((masses[0], masses[1]), apart)} if apart else {}


def _neighbours(scene: Scene, mass: float) -> tuple[Neighbour, ...] | None:
    if scene.orbits.archive is not None:
        return None
    neighbours: dict[str, Neighbour] = {}
    for other in scene.companions:
        orbit = _orbit(other, scene.gravitational_constant * (mass + other.mass))
        if other.around in neighbours:  # as far from the body as what it goes round, give or take its own orbit
            centre = neighbours[other.around]
            apart = abs(centre.distance - orbit.distance)
            near = abs(centre.nearest - orbit.distance * (1.0 + orbit.eccentricity))
            orbit = Neighbour(other.name, other.mass, apart, near, 0.0, max(orbit.rate, centre.rate), orbit.normal)
        neighbours[other.name] = orbit
    return tuple(neighbours.values())


def _orbit(other: Companion, parameter: float) -> Neighbour:
    if other.position is not None and other.velocity is not None:
        return _state(other, parameter)
    axis = other.semi_major_axis
    if axis is None:
        assert other.period is not None
        axis = (parameter * (other.period / (2.0 * math.pi)) ** 2) ** (1.0 / 3.0)
    tilt, node = other.inclination, other.node
    normal = (math.sin(tilt) * math.sin(node), -math.sin(tilt) * math.cos(node), math.cos(tilt))
    e = other.eccentricity
    return Neighbour(other.name, other.mass, axis, axis * (1.0 - e), e, math.sqrt(parameter / axis**3), normal)


def _state(other: Companion, parameter: float) -> Neighbour:
    place, speed = np.asarray(other.position, dtype=float), np.asarray(other.velocity, dtype=float)
    distance = float(np.linalg.norm(place))
    momentum = np.cross(place, speed)
    inverse = 2.0 / distance - float(speed @ speed) / parameter
    semilatus = float(momentum @ momentum) / parameter
    e = math.sqrt(max(0.0, 1.0 - semilatus * inverse))
    nearest = semilatus / (1.0 + e)
    normal = unit(momentum) if momentum.any() else (0.0, 0.0, 1.0)
    if inverse <= 0.0:
        return Neighbour(other.name, other.mass, nearest, nearest, 0.0, math.sqrt(parameter / nearest**3), normal)
    return Neighbour(other.name, other.mass, 1.0 / inverse, nearest, e, math.sqrt(parameter * inverse**3), normal)
