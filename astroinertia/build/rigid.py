"""The rigid model of a scene: moments and axes of its body, how it turns, what acts on it and what goes round it."""

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from astroinertia.build import companions
from astroinertia.build.effects import effects_of
from astroinertia.build.spheres import Star, building, sphere
from astroinertia.build.spin import rigid_moments, rotation_amount, rotation_axis
from astroinertia.dataset.bounds import FAR
from astroinertia.errors import SceneError
from astroinertia.inertia.prescribed import change
from astroinertia.inertia.principal import principal_frame
from astroinertia.inertia.spin import angular_momentum
from astroinertia.inertia.tensor import about_point, inertia_from_second_moment, inertia_tensor
from astroinertia.models.rigid import body as rigid
from astroinertia.models.rigid.evolution import RigidBody, Settings
from astroinertia.rotation.attitude import nearest_rotation, quaternion, rotation
from astroinertia.rotation.ephemeris import Ephemeris
from astroinertia.scene.initial_body import wobbling
from astroinertia.scene.schema import Scene
from astroinertia.sph import profiles
from astroinertia.sph.table import read_body
from astroinertia.units import CodeUnits

Moments = tuple[float, np.ndarray, np.ndarray, float | None, np.ndarray | None]
"""Mass, principal moments, axes as rows, energy of self-gravity, and L where the body itself says it."""
_ROUND_OFF = 1e-15  # of a moment, over the sum of the three


def evolution(scene: Scene, units: CodeUnits) -> RigidBody:
    """The body at time 0; SceneError where the scene asks for what a rigid body cannot do."""
    _refuse_what_flows(scene)
    mass, moments, rows, energy, spun = building(scene.body.moments_from)(scene, units)
    effects = effects_of(scene, units)
    deformable = [effect for effect in effects if hasattr(effect, "deformability")]
    pivots = [effect for effect in effects if effect.kind == "pivot"]
    _refuse_together(scene, effects, deformable, pivots)
    arm = None
    tensor = np.diag(moments)  # in the scene's axes of the body
    if pivots:
        arm = _arm(pivots[0], mass, moments)
        tensor = about_point(tensor, mass, arm)
    deformability, rate = None, 0.0
    if deformable:
        deformability, rate = deformable[0].deformability, deformable[0].rate
        tensor = _at_rest(tensor, deformability, rate)
    # A run that so many steps may end needs no more than the first orbits, unless it comes further.
    brief = scene.time.max_steps is not None
    others = _outside(scene, units, mass, companions.AT_FIRST if brief else math.inf)
    further = partial(_outside, scene, units, mass) if brief and isinstance(others, Ephemeris) else None
    principal, axes = principal_frame(tensor)
    if deformable and scene.body.rotation is not None and scene.body.rotation.angular_momentum is not None:
        raise SceneError("[body.rotation] needs a rate or a period with the effect rotational_deformation.")
    if deformable and principal[0] <= 0.0:
        raise SceneError("[effects.rotational_deformation] leaves the body at rest with a moment that is not positive.")
    body = rigid.body(
        mass,
        np.maximum(principal, 0.0),
        spin=rate,
        deformability=deformability,
        axes=axes.T,
        effects=effects,
        companions=others,
        change=_change(scene, units),
        arm=None if arm is None else axes @ arm,
    )
    along = rotation_axis(scene)
    if scene.body.rotation is not None and scene.body.rotation.wobble is not None:
        swollen = principal
        if deformability is not None:
            swollen = principal + 2.0 / 3.0 * deformability * rotation_amount(scene, units, False).get("rate", 0.0) ** 2
        rows, along = _wobbling(scene, swollen, axes, rows, along)
    attitude = nearest_rotation(axes @ rows)
    spin = _spin(scene, units, rows.T @ tensor @ rows, energy, along)
    stiffening = 0.0 if deformability is None else 2.0 / 3.0 * deformability * spin @ spin
    # In the principal axes, in which a small moment keeps its digits.
    momentum = (body.moments + stiffening) * (attitude @ spin) if spun is None else attitude @ spun
    chosen = scene.numerics
    settings = Settings(chosen.integrator, chosen.tolerance, chosen.steps_per_rotation, chosen.order)
    names = companions.names(scene, units) if scene.orbits.back_reaction else ()
    return RigidBody(body, quaternion(attitude), momentum, settings, names, further)


def _outside(scene: Scene, units: CodeUnits, mass: float, turns: float = math.inf) -> Any:
    """The companions; SceneError where known orbits lead one within the body, to which the others may have pushed it.

    Known orbits end after so many radians of the fastest of them, or with the run.
    What its own orbit says alone is refused before (build.refusals); those that the body acts on, during the run.
    """
    others, radius = companions.of_rigid(scene, units, mass, turns), scene.body.radius
    if others is None or radius is None or scene.orbits.back_reaction:
        return others
    if (found := others.within(units.to_code(radius, "length"))) is None:
        return others
    when = scene.shown(units.to_si(found[0], "time"), "time", 4)
    raise SceneError(
        f"companion {others.names[found[1]]} comes within the body at {when}, nearer to its centre than the radius of "
        f"the rigid body, {scene.shown(radius, 'length', 4)}: end the run before."
    )


def resumed(scene: Scene, units: CodeUnits, arrays: Mapping[str, np.ndarray]) -> RigidBody:
    """The body of a checkpoint."""
    body = evolution(scene, units)
    body.resume(arrays)
    return body


def refuse_branch(run: Scene, branch: Scene) -> None:
    """SceneError where companions have a state of their own, or a branch would be of another shape."""
    if run.orbits.back_reaction or branch.orbits.back_reaction:
        raise SceneError("[orbits] back_reaction: companions have a state of their own, which no branch takes over.")
    for kind in ("pivot", "rotational_deformation"):
        if run.effects.get(kind) != branch.effects.get(kind):
            raise SceneError(f"[effects.{kind}] belongs to the shape of the body, and stays as it is in a branch.")


def branched(scene: Scene, units: CodeUnits, parent: RigidBody) -> RigidBody:
    """The body of another run where it is, in this scene."""
    body = evolution(scene, units)
    body.begin(parent)
    return body


def _refuse_what_flows(scene: Scene) -> None:
    body = scene.body
    if body.velocity_gradient is not None:
        raise SceneError("[body] velocity_gradient is a flow that a rigid body does not have; give [body.rotation].")
    if (body.rotation is not None and body.rotation.law != "rigid") or getattr(body, "law", "rigid") != "rigid":
        raise SceneError("[body.rotation] law must be rigid for the model rigid.")


def _refuse_together(scene: Scene, effects: Sequence[Any], deformable: Sequence[Any], pivots: Sequence[Any]) -> None:
    """SceneError where effects do not go with one another, or with the rest of the scene."""
    if scene.body.change is not None and (deformable or pivots):
        other = (deformable or pivots)[0].kind
        raise SceneError(f"[body.change] prescribes the size, so the effect {other} cannot be listed with it.")
    if pivots and (deformable or scene.companions):
        other = "companions" if scene.companions else deformable[0].kind
        raise SceneError(
            f"{scene.where_listed('pivot')} holds a point of the body at rest, so there can be no {other} with it."
        )
    for effect in effects:
        if deformable and hasattr(effect, "function"):
            raise SceneError(
                f"[effects.{effect.kind}] is a function, whose change with time the effect {deformable[0].kind} would "
                "need to know: write it as the class of an effect."
            )


def _arm(pivot: Any, mass: float, moments: np.ndarray) -> np.ndarray:
    """From the pivot to the centre of mass (3,); SceneError where the body is small beside it."""
    arm = np.asarray(pivot.arm, dtype=float)
    size = math.sqrt(np.max(moments) / mass)
    if (away := float(np.linalg.norm(arm))) > FAR * size > 0.0:
        raise SceneError(
            f"[effects.pivot] arm: is {away / size:.2g} times the body's radius of gyration, where its shape is "
            f"rounded away; it may be at most {FAR:g} times that."
        )
    return arm


def of_solid(scene: Scene, units: CodeUnits) -> Moments:
    """Those that the scene gives."""
    moments, rows = rigid_moments(scene, units)
    return units.to_code(scene.body.mass, "mass"), moments, rows, None, None


def of_sphere(scene: Scene, units: CodeUnits) -> Moments:
    """Those of a stretched Sphere, or of a Star."""
    body: Any = scene.body
    initial = sphere(scene, units)
    if isinstance(initial, Star):
        star = initial.star
        moments = np.array([star.equatorial_moment, star.equatorial_moment, star.polar_moment])
        return star.mass, moments, np.eye(3), None, np.array([0.0, 0.0, star.angular_momentum])
    axes = initial.radius * np.asarray(body.axes, dtype=float)
    second = np.diag(initial.profile.second_moment * initial.mass * axes**2)
    energy = profiles.ellipsoid_gravitational_energy(initial.profile, initial.mass, axes)
    rows = body.rows_at_start * np.array([[1.0], [1.0], [np.sign(np.linalg.det(body.rows_at_start))]])
    return initial.mass, np.diag(inertia_from_second_moment(second)), rows, energy, None


def of_table(scene: Scene, units: CodeUnits) -> Moments:
    """Those of the user's own particles."""
    body: Any = scene.body
    table = read_body(body.path(scene), units, body.velocity_unit)
    return _of_particles(scene, table.mass, table.position, table.velocity)


def of_class(scene: Scene, units: CodeUnits) -> Moments:
    """Those of the particles of a body that is not of this package."""
    from astroinertia.build.placing import own_particles  # only where there is such a body

    made = own_particles(scene, units)
    return _of_particles(scene, made["mass"], made["position"], made["velocity"])


def _of_particles(scene: Scene, mass: np.ndarray, place: np.ndarray, velocity: np.ndarray) -> Moments:
    moments, rows = principal_frame(inertia_tensor(mass, place))
    own = angular_momentum(mass, place, velocity)
    return float(mass.sum()), moments, rows, None, own if scene.body.rotation is None else None


def _at_rest(tensor: np.ndarray, deformability: float, rate: float) -> np.ndarray:
    """The tensor without the bulge of a spin about the axis of the largest moment."""
    about = principal_frame(tensor)[1][2]
    return tensor - deformability * rate**2 * (np.outer(about, about) - np.eye(3) / 3.0)


def _wobbling(
    scene: Scene, moments: np.ndarray, axes: np.ndarray, rows: np.ndarray, along: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The body's rows turned so that L is along an axis and wobbles as the scene says, and the direction of omega.

    moments (3,) and axes (3, 3), one a row, are the principal ones in the scene's axes of the body.
    """
    chosen = scene.body.rotation
    assert chosen is not None and chosen.wobble is not None
    momentum, spin = (rows.T @ axes.T @ vector for vector in wobbling(moments, chosen.wobble))
    turn = _least_rotation(momentum, along)
    return rows @ turn.T, turn @ spin


def _least_rotation(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The rotation (3, 3) of one unit vector to another by the least angle."""
    about = np.cross(one, other)
    sine, cosine = float(np.linalg.norm(about)), float(one @ other)
    if sine < 1e-9 and cosine < 0.0:
        about, sine = np.cross(one, np.eye(3)[np.argmin(abs(one))]), 0.0
    size = np.linalg.norm(about)
    return rotation(about * (math.atan2(sine, cosine) / size)) if size else np.eye(3)


def _spin(
    scene: Scene, units: CodeUnits, inertia: np.ndarray, energy: float | None, along: np.ndarray
) -> np.ndarray:  # fmt: skip
    """The angular velocity about an axis that the scene gives to a body of that tensor, all in inertial axes."""
    amount = rotation_amount(scene, units, energy is not None and "gravity" in scene.effects)
    per_rate = float(np.linalg.norm(inertia @ along))
    if not amount:
        return np.zeros(3)
    if per_rate <= _ROUND_OFF * np.trace(inertia):
        raise SceneError("[body.rotation] is about a rod's own axis, about which it has no moment.")
    if "rate" in amount:
        return amount["rate"] * along
    if "angular_momentum" in amount:
        return amount["angular_momentum"] / per_rate * along
    assert energy is not None  # amount has seen to it
    return np.sqrt(2.0 * amount["t_over_w"] * abs(energy) / float(along @ inertia @ along)) * along


def _change(scene: Scene, units: CodeUnits) -> Any:
    prescribed = scene.body.change
    if prescribed is None:
        return None
    try:
        return change([units.to_code(time, "time") for time in prescribed.times], prescribed.factors)
    except ValueError as error:
        raise SceneError(f"[body.change] {error}.") from None
