"""The scaling model of a scene: its body at scale 1, what says its size, and its torques."""

import math
from collections.abc import Mapping
from typing import Any

import jax
import numpy as np
from numpy.polynomial.legendre import leggauss

from astroinertia.bodies.ellipsoid_gravity import potential_energy_tensor
from astroinertia.bodies.rotation_laws import RotationLaw
from astroinertia.build.effects import effects_of
from astroinertia.build.flow import own_expansion
from astroinertia.build.fluids import entropies, equation_of_state
from astroinertia.build.spheres import Sphere, Star, sphere
from astroinertia.build.spin import rigid_moments, rotation_amount, rotation_axis
from astroinertia.effects.effect import Effect
from astroinertia.errors import SceneError
from astroinertia.inertia.prescribed import change
from astroinertia.inertia.tensor import inertia_from_second_moment, second_moment_from_inertia
from astroinertia.models import checkpoint
from astroinertia.models.scaling.evolution import (
    HeldPressure,
    Homologous,
    PowerLawPressure,
    Pressure,
    Scaling,
    ShellPressure,
    Shells,
    turning_body,
)
from astroinertia.models.scaling.homology import Dynamic, Fixed, Kepler, Prescribed, SizeLaw
from astroinertia.models.sph.record import RADIUS_BINS
from astroinertia.process.roots import root_between
from astroinertia.rotation.collapsing_shells import mass_quadrature
from astroinertia.scene.schema import Scene
from astroinertia.sph import profiles
from astroinertia.units import CodeUnits

_NODES = 160  # shells of the pressure integral
_ANGLES, _WEIGHTS = leggauss(24)  # cosines of the angle to the axis; differential rotation is even and smooth in them
_LEAST_DENSITY = 1e-200  # at the surface, where it vanishes: no power of it that is needed under- or overflows
_HYDROSTATIC = 1e-4  # a pressure that differs by less from what holds the body is that which holds it
_IN_EQUILIBRIUM = 1e-9  # of |W|: what is left of the virial theorem in a body that stays as it is
_LARGEST, _SWELLING = 20.0, 1.02  # how far a body may swell when it settles with its rotation, and by which steps
EXACT = "the angular momentum law of a body that keeps its profile and shape is exact; "


def evolution(scene: Scene, units: CodeUnits) -> Scaling:
    """The body at time 0. SceneError where the scene asks for what scaling laws cannot tell."""
    body: Any = scene.body
    expansion = _expansion(scene, units)
    opening, scale = _body(scene, units)
    effects = effects_of(scene, units)
    for effect in _acting(effects):
        if getattr(effect, "magnetic_axis", None) is not None or getattr(effect, "frame", "inertial") == "body":
            raise SceneError(
                f"[effects.{effect.kind}] is given in the body's axes, which the model scaling does not follow: take "
                "the model rigid."
            )
    end = units.to_code(scene.time.end, "time")
    if body.change is not None:
        times = [units.to_code(time, "time") for time in body.change.times]
        curve = change(times, body.change.factors)
        approximation = EXACT + "its size is prescribed"
        return _evolution(opening, Prescribed(curve, scale), effects, end, approximation, False, tuple(times))
    law, approximation = _size_law(scene, opening, scale, expansion)
    if law is None or (isinstance(law, Kepler) and _acting(effects)):
        return _evolution(opening, None, effects, end, approximation, True, (), (scale, scale * expansion))
    return _evolution(opening, law, effects, end, approximation, isinstance(law, Kepler))


def resumed(scene: Scene, units: CodeUnits, arrays: Mapping[str, np.ndarray]) -> Scaling:
    """The body at a checkpoint: the state is a function of the time. ValueError where that is none of the run's."""
    body = evolution(scene, units)
    end = units.to_code(scene.time.end, "time") * (1.0 + checkpoint.LATE)
    checkpoint.check(arrays, checkpoint.described(body.arrays()), {"time": (0.0, end), "steps": checkpoint.COUNT})
    return body.at(float(arrays["time"]), int(arrays["steps"]))


def _size_law(scene: Scene, opening: Homologous, scale: float, expansion: float) -> tuple[SizeLaw | None, str]:
    """What says the size; None where it is integrated."""
    if scene.body.solid or isinstance(opening.pressure, HeldPressure):
        return Fixed(scale), EXACT + "its size stays"
    if opening.gravity_tensor is None and opening.pressure is None and scene.equation_of_state is None:
        return Fixed(scale), EXACT + "its size stays, for the scene lists neither gravity nor pressure"
    momentum, trace = opening.angular_momentum, float(np.trace(opening.second_moment))
    force = opening.acceleration(momentum, scale) * trace * scale
    binding = max(abs(opening.gravitational_energy) / scale, opening.rotational_energy(momentum, scale))
    if expansion == 0.0 and abs(force) <= _IN_EQUILIBRIUM * binding:
        return Fixed(scale), EXACT + "the body is in equilibrium and stays so"
    approximation = EXACT + "its size follows the scalar virial theorem of one zone"
    repulsion, attraction = 2 * opening.rotational_energy(momentum, 1.0), -opening.gravitational_energy
    gas = opening.pressure
    if gas is not None:
        gamma = gas.gamma if isinstance(gas, PowerLawPressure) else 0.0
        if abs(gamma - 5 / 3) < 1e-12:
            repulsion += 3 * gas.integral(1.0)
        elif abs(gamma - 4 / 3) < 1e-12:
            attraction -= 3 * gas.integral(1.0)
        else:
            return None, approximation
    exact = ", in closed form"
    return Kepler(repulsion / trace, attraction / trace, scale, scale * expansion), approximation + exact


def _evolution(
    body: Homologous, law: SizeLaw | None, effects: tuple[Any, ...], end: float, approximation: str, free: bool,
    breaks: tuple[float, ...] = (), motion: tuple[float, float] = (1.0, 0.0),
) -> Scaling:  # fmt: skip
    breaks = (*breaks, *(time for effect in _acting(effects) for time in effect.breaks(0.0, end)))
    torques = {effect.kind: jax.jit(effect.torque) for effect in _acting(effects)}
    names = tuple(effect.kind for effect in effects)
    spin = float(np.linalg.norm(body.angular_momentum))
    # L and work in units of their own size, so that an error allowed in the state means the same for all of it.
    unit = spin if spin > 0 else 1.0
    work_unit = max(body.spin_constant * unit**2, 1e-300)
    if law is not None and not torques:
        return Scaling(body, law, None, {}, names, (unit, work_unit), approximation, free)

    def slope(time: float, state: np.ndarray) -> np.ndarray:
        momentum = unit * state[2:5]
        scale = float(state[0]) if law is None else law.at(time).scale
        seen = turning_body(body, time, scale, momentum)
        pulls = [np.asarray(torque(seen), dtype=float) for torque in torques.values()]
        rate = 2 * body.spin_constant * momentum / scale**2  # dT/dL: what the torque works against
        motion = (0.0, 0.0) if law is not None else (state[1], body.acceleration(momentum, scale))
        powers = [pull @ rate / work_unit for pull in pulls]
        return np.array([*motion, *(sum(pulls, np.zeros(3)) / unit), *powers])

    state = np.array([*motion, *(body.angular_momentum / unit), *([0.0] * len(torques))])
    dynamics = Dynamic(slope, state, end, pulsates=not torques, breaks=breaks)
    if law is None and torques:
        dynamics.look_ahead()
    return Scaling(body, law, dynamics, torques, names, (unit, work_unit), approximation, free)


def _acting(effects: tuple[Any, ...]) -> list[Any]:
    """Those of the effects that turn a body."""
    return [effect for effect in effects if type(effect).torque is not Effect.torque]


def _expansion(scene: Scene, units: CodeUnits) -> float:
    own, gradient = own_expansion(scene, units), scene.body.velocity_gradient
    if gradient is None:
        return own
    matrix = np.asarray(gradient, dtype=float)
    rate = matrix.trace() / 3
    if np.abs(matrix - rate * np.eye(3)).max() > 1e-12 * np.abs(matrix).max():
        raise SceneError(
            "[body] velocity_gradient must be a multiple of the unit matrix for the model scaling, which keeps shapes."
        )
    return own + float(units.to_code(rate, "velocity_gradient"))


def _body(scene: Scene, units: CodeUnits) -> tuple[Homologous, float]:
    """The body at scale 1 and the scale at which it begins, which is not 1 where it settles with its rotation."""
    if scene.body.solid:
        return _rigid(scene, units), 1.0
    initial = sphere(scene, units)
    if isinstance(initial, Star):
        return _star(scene, units, initial), 1.0
    assert initial is not None  # the schema has no tables for this model
    return _ball(scene, units, initial)


def _rigid(scene: Scene, units: CodeUnits) -> Homologous:
    body: Any = scene.body
    mass = units.to_code(body.mass, "mass")
    moments, rows = rigid_moments(scene, units)
    inertia = rows.T @ np.diag(moments) @ rows
    second = second_moment_from_inertia(inertia)
    axis = rotation_axis(scene)
    _symmetric_about(axis, second)
    moment = float(axis @ inertia @ axis)
    amount = rotation_amount(scene, units, False)
    spin = amount.get("angular_momentum", amount.get("rate", 0.0) * moment)
    return Homologous(mass, second, None, None, spin * axis, axis, 0.5 / moment)


def _star(scene: Scene, units: CodeUnits, initial: Star) -> Homologous:
    star = initial.star
    axis = np.array([0.0, 0.0, 1.0])
    inertia = np.diag([star.equatorial_moment, star.equatorial_moment, star.polar_moment])
    second = second_moment_from_inertia(inertia)
    kinetic, held = star.kinetic_energy, star.pressure_integral
    # In equilibrium: the tensor virial theorem gives gravity's tensor, of trace W.
    gravity = -kinetic * (np.eye(3) - np.outer(axis, axis)) - held * np.eye(3)
    pressure: Pressure | None = HeldPressure(3 * held)
    if _gaseous(scene):
        field = star.field
        shares = field.mesh.volume_weight[:, None] * field.weight * field.matter.density(field.level)
        density = star.max_density * field.matter.density(field.level)
        inside = (shares > 0) & (density > 0)
        radius = np.broadcast_to(field.mesh.radius[:, None], shares.shape) * star.equatorial_radius
        cosine = np.broadcast_to(field.cosine, shares.shape)
        where = np.stack([radius * np.sqrt(1 - cosine**2), 0 * radius, radius * cosine], axis=-1)[inside]
        mass = shares[inside] * star.mass / shares[inside].sum()
        pressure = _gas(scene, units, initial, mass, density[inside], where, 3 * held)
    return Homologous(
        star.mass,
        second,
        gravity if "gravity" in scene.effects else None,
        pressure if "pressure" in scene.effects else None,
        star.angular_momentum * axis,
        axis,
        kinetic / star.angular_momentum**2 if star.angular_momentum else 0.5 / star.polar_moment,
        initial.densest()[1],
    )


def _ball(scene: Scene, units: CodeUnits, initial: Sphere) -> tuple[Homologous, float]:
    body: Any = scene.body
    profile, axes = initial.profile, np.asarray(body.axes, dtype=float)
    rows = body.rows_at_start
    second = rows.T @ np.diag(profile.second_moment * initial.mass * (initial.radius * axes) ** 2) @ rows
    energy = profiles.ellipsoid_gravitational_energy(profile, initial.mass, initial.radius * axes)
    gravity = None
    if "gravity" in scene.effects:
        if not math.isfinite(energy):
            raise SceneError("[body] has an infinite gravitational energy, from which no scaling law follows.")
        tensor = potential_energy_tensor(initial.radius * axes, 1.0)
        gravity = rows.T @ np.diag(tensor) @ rows * energy / tensor.sum()
    axis = rotation_axis(scene)
    if scene.body.rotation is not None:
        _symmetric_about(axis, second)
    share, mass = mass_quadrature(_NODES)
    s = np.asarray(profile.radius(share), dtype=float)
    volume = float(np.prod(axes))
    pressure: Pressure | None = None
    if "pressure" in scene.effects and _gaseous(scene):
        density = np.maximum(profile.density(s) * initial.mass / (volume * initial.radius**3), _LEAST_DENSITY)
        pressure = _gas(scene, units, initial, mass * initial.mass, density, s, -energy * body.support)
    scale, spin, constant = _settled(scene, units, initial, second, energy, axis)
    if "pressure" in scene.effects and pressure is None:
        if gravity is None:
            raise SceneError("[effects.pressure] needs an equation_of_state, or gravity that it holds up.")
        pressure = HeldPressure(-(2 * constant * spin**2 / scale + energy))
    shells = _shells(scene, units, initial, second) if axes.min() == axes.max() == 1.0 else None
    return (
        Homologous(
            initial.mass, second, gravity, pressure, spin * axis, axis, constant, initial.densest()[1] / volume, shells
        ),
        scale,
    )


def _gaseous(scene: Scene) -> bool:
    return scene.equation_of_state is not None and scene.equation_of_state.kind != "incompressible"


def _gas(
    scene: Scene, units: CodeUnits, initial: Sphere | Star, mass: np.ndarray, density: np.ndarray,
    where: np.ndarray, hydrostatic: float,
) -> Pressure:  # fmt: skip
    """The pressure of the scene's fluid; `hydrostatic` is the 3 Pi that holds the body."""
    body: Any = scene.body
    fluid = equation_of_state(scene, units, initial)
    entropy = np.zeros_like(mass)
    if fluid.thermal and body.specific_internal_energy is not None:
        energy = units.to_code(body.specific_internal_energy, "specific_energy")
        entropy = fluid.entropy(np, density, np.full_like(mass, energy))
    elif fluid.thermal:
        entropy = entropies(scene, units, initial, fluid, where)
    pressure = ShellPressure(fluid, mass, density, entropy)
    if scene.equation_of_state.kind not in ("ideal", "polytropic"):  # type: ignore[union-attr]
        return pressure
    opening = pressure.integral(1.0)
    exact = hydrostatic / 3 * (body.pressure_fraction or 1.0)
    if abs(opening / exact - 1) < _HYDROSTATIC:  # the shells' error, not a lack of balance
        opening = exact
    return PowerLawPressure(opening, fluid.gamma)


def _settled(
    scene: Scene, units: CodeUnits, initial: Sphere, second: np.ndarray, energy: float, axis: np.ndarray
) -> tuple[float, float, float]:
    """Scale, L and T/L^2 at scale 1 of the body with its rotation, swollen where it settles to equilibrium first."""
    body: Any = scene.body
    amount = rotation_amount(scene, units, "gravity" in scene.effects)
    moment = float(axis @ inertia_from_second_moment(second) @ axis)
    if not amount or not any(amount.values()):
        return 1.0, 0.0, 0.5 / moment

    def spin(scale: float) -> tuple[float, float]:
        # L and T at a scale, by the one measure that the scene gives.
        per_rate, energy_per_rate = _law_moments(scene, units, initial, scale, moment)
        if "angular_momentum" in amount:
            return amount["angular_momentum"], energy_per_rate * (amount["angular_momentum"] / per_rate) ** 2
        rate = amount.get("rate")
        if rate is None:
            rate = math.sqrt(amount["t_over_w"] * -energy / scale / energy_per_rate)
        return rate * per_rate, rate**2 * energy_per_rate

    scale = 1.0
    if scene.settles and _gaseous(scene) and body.change is None and body.polytropic_index:
        # As particles do: in the polytrope's own gas, or one of exponent 5/3 where its index has no stable equilibrium.
        gas = PowerLawPressure(-energy / 3, max(1 + 1 / body.index, 5 / 3))

        def excess(scale: float) -> float:
            return 2 * spin(scale)[1] + energy / scale + 3 * gas.integral(scale)

        # The nearest equilibrium: at a given rate there is a second one farther out, which is not stable.
        low, high = 1.0, _SWELLING
        while excess(high) >= 0:
            low, high = high, high * _SWELLING
            if high > _LARGEST:
                raise SceneError("[body.rotation] is too fast: the body finds no equilibrium with it.")
        scale = root_between(excess, low, high)
    momentum, kinetic = spin(scale)
    return scale, momentum, kinetic * scale**2 / momentum**2


def _law_moments(scene: Scene, units: CodeUnits, initial: Sphere, scale: float, moment: float) -> tuple[float, float]:
    """L and T of a body at a scale that turns at a rate of 1 on its axis."""
    rotation = scene.body.rotation
    assert rotation is not None
    if rotation.law == "rigid":
        return moment * scale**2, 0.5 * moment * scale**2
    law = RotationLaw(rotation.law, units.to_code(rotation.scale, "length"))
    share, mass = mass_quadrature(_NODES)
    stretch = float(np.sqrt(moment / (2 * initial.profile.second_moment * initial.mass * initial.radius**2)))
    radius = scale * stretch * initial.radius * np.asarray(initial.profile.radius(share), dtype=float)
    w = radius[:, None] * np.sqrt(1 - _ANGLES**2)
    rate, weight = law.rate(w), initial.mass * mass[:, None] * 0.5 * _WEIGHTS
    return float((weight * rate * w**2).sum()), float((0.5 * weight * (rate * w) ** 2).sum())


def _shells(scene: Scene, units: CodeUnits, initial: Sphere, second: np.ndarray) -> Shells:
    nodes, weights = leggauss(8)
    share = (np.arange(RADIUS_BINS)[:, None] + 0.5 * (nodes + 1)) / RADIUS_BINS
    s = np.asarray(initial.profile.radius(share.ravel()), dtype=float).reshape(share.shape)
    mean = 0.5 * weights
    squared = (initial.radius * s) ** 2 @ mean
    relative = np.ones(RADIUS_BINS)
    rotation = scene.body.rotation
    if rotation is not None and rotation.law != "rigid":
        law = RotationLaw(rotation.law, units.to_code(rotation.scale, "length"))
        w = initial.radius * s[:, :, None] * np.sqrt(1 - _ANGLES**2)
        turning = np.einsum("bnk,k,n->b", law.rate(w) * w**2, 0.5 * _WEIGHTS, mean)
        relative = turning / (2 / 3 * squared)
        relative /= turning.mean() * initial.mass / (2 / 3 * float(np.trace(second)))
    return Shells(initial.radius * s @ mean, initial.density(s.ravel()).reshape(s.shape) @ mean, squared, relative)


def _symmetric_about(axis: np.ndarray, second: np.ndarray) -> None:
    along = float(axis @ second @ axis)
    across = 0.5 * (float(np.trace(second)) - along)
    round_axis = across * np.eye(3) + (along - across) * np.outer(axis, axis)
    if np.abs(second - round_axis).max() > 1e-9 * np.trace(second):
        raise SceneError(
            "[body.rotation] is about an axis that the body is not symmetric about, and the model scaling follows no "
            "attitude: take the model rigid or ellipsoid."
        )
