"""How many steps the models without particles take: by how fast their bodies turn and fall."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.costs.fields import fields
from astroinertia.effects.characteristic import Neighbour
from astroinertia.effects.one_zone import lasting, spread
from astroinertia.inertia.prescribed import change
from astroinertia.orbits.kepler import eccentric_anomaly
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.initial_body import unit, wobbling
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene

# Radians of the fastest motion in a step of order 8(7), over tolerance^(1/8): 4.6 to 5.0 and 8 to 11 as measured on a
# pulsating spheroid and a free top, at tolerances of 1e-6 to 1e-12.
REACH = {"ellipsoid": 4.9, "adaptive": 9.5}
# Radians of it, below which one step goes from a record to the next: the first of a run is no longer, and each later
# call begins with the mean of the one before: half of the way, and again half.
FIRST = {"ellipsoid": 1e-3, "adaptive": 0.05}
NEAR = 1e-3  # of the radius: where a field is as an affine body has it, linear about the centre
IN_BALANCE = 0.02  # departure from equilibrium, up to which a body rests
STAGES = {2: 1, 4: 5, 6: 9, 8: 17}  # of a splitting, by its order; the machine's steps are of order 8
# What a step of a rigid body takes with a companion, whose torque is found at every stage, over one without: 57 to 67
# over 7.6 to 8.3 us, of a top with a moon, and 56 over 21 us, of the Earth with the Moon.
WITH_COMPANIONS = {"splitting": 7.8, "adaptive": 2.6}
# The same where it acts back on them, for which no table of orbits is looked up: without any, and for each of them (1,
# 2 and 5 moons: 18, 22 and 28 over 6.7 us, and 39, 44 and 52 over 10 us).
WITH_MOVED, WITH_MOVED_EACH = {"splitting": 2.3, "adaptive": 3.6}, {"splitting": 0.4, "adaptive": 0.3}
# The same with an effect that follows the spin, which every kick looks for again: 171 to 256 over 11 to 17 us of a top
# with internal friction; 27 over 10 us adaptively, and 0.2 to 2.3 free steps more with the tide of a moon.
FOLLOWING_SPIN = {"splitting": 15.0, "adaptive": 2.3}


def kind(scene: Scene) -> str:
    """What costs are named after: the model, or the integrator of a rigid body."""
    return scene.numerics.integrator if scene.model == "rigid" else scene.model


def compiled(scene: Scene) -> tuple[str, ...]:
    """The costs of what is compiled before the first step."""
    names = {"splitting": ("prepare.splitting",), "adaptive": ("prepare.splitting", "prepare.adaptive")}
    names_of_kind = names.get(kind(scene), (f"prepare.{kind(scene)}",))
    return (*names_of_kind, "companions") if scene.companions else names_of_kind


def steps(scene: Scene, written: int) -> float:
    """Steps of an ellipsoid or a rigid body that is recorded so many times."""
    numerics, parts = scene.numerics, max(1, written - 1)
    angle = scene.time.end / parts * paces(scene, spread(scene.time.end))  # from one record to the next
    if kind(scene) == "splitting":
        each = np.ceil(angle * numerics.steps_per_rotation / (2.0 * math.pi) - 1e-6)
    else:
        each = np.ceil(angle / (REACH[kind(scene)] * numerics.tolerance**0.125))
        each = np.where(angle > FIRST[kind(scene)], np.maximum(each, 2.0), each)
    return float(np.maximum(each, 1.0).mean() * parts)


def of_step(scene: Scene) -> float:
    """What a step takes over one of the default order without companions and torques."""
    if scene.model != "rigid":
        return 1.0
    integrator, times = kind(scene), 1.0
    if scene.orbits.back_reaction:
        times += WITH_MOVED[integrator] + WITH_MOVED_EACH[integrator] * len(scene.companions) - 1.0
    elif scene.companions:
        times += WITH_COMPANIONS[integrator] - 1.0
    if any(scene.entries[effect].made.follows_spin for effect in scene.effects):
        times += FOLLOWING_SPIN[integrator] - 1.0
    return times * (STAGES[scene.numerics.order] / STAGES[8] if integrator == "splitting" else 1.0)


def paces(scene: Scene, times: np.ndarray) -> np.ndarray:
    """The rates (K,) of the fastest motion at times (K,) of a run."""
    return _of_rigid(scene, times) if scene.model == "rigid" else _of_ellipsoid(scene, times)


def _of_ellipsoid(scene: Scene, times: np.ndarray) -> np.ndarray:
    """Of fall, turning and flow, as the size of the body goes, and of what given fields and frames ask for."""
    body, units = characteristic(scene), code_units(scene)
    pace = max(1.0 / (body.dynamical_time or math.inf), body.spin or 0.0, body.shear, abs(body.expansion))
    given, zone = fields(scene), body.zone
    entries = {kind: scene.entries[kind] for kind in scene.effects if scene.model in scene.entries[kind].models}
    asked = [1.0 / one.pace(scene.effects[kind])[0] for kind, one in entries.items() if one.pace is not None]
    pulled = 0.0
    if given is not None:
        near = np.full(1, NEAR if body.radius is None else NEAR * float(units.to_code(body.radius, "length")))
        pulled = float((given.inward(near) / near)[0]) / units.time**2
        asked += [1.0 / (limit * units.time) for limit in given.timesteps(near, 0.0 * near, 0.0 * near).values()]
    pace = max([pace, *asked])
    zone = None if zone is None else replace(zone, field=pulled)
    if zone is None or body.held or not body.deforms or (zone.imbalance < IN_BALANCE and not zone.expansion):
        return np.full_like(times, pace)
    path = lasting(zone, scene.time.end)
    at = np.minimum(times, path.time[-1])
    size, speed = (np.interp(at, path.time, of) for of in (path.size, path.speed))
    swings = np.sqrt(np.maximum(zone.stiffness(size), 0.0))
    return np.maximum.reduce([pace * np.minimum(size, 1.0) ** -1.5, swings, np.abs(speed) / size])


def _of_rigid(scene: Scene, times: np.ndarray) -> np.ndarray:
    """Of its spin, as torques and a prescribed size change it, of what torques turn it by, and of companions' turns."""
    body: Any = scene.body
    size, found = np.ones_like(times), characteristic(scene)
    if body.change is not None:
        size = change(np.asarray(body.change.times), np.asarray(body.change.factors)).factor(times)
    spin, torque = np.full_like(times, fastest_spin(scene)), np.zeros_like(times)
    friction = scene.effects.get("internal_dissipation")
    if friction is not None and found.moments is not None and spin[0] > 0.0:
        least = float(np.linalg.norm(_momentum(scene, max(found.moments)))) / max(found.moments)  # of all with its L
        scale = friction["time_scale"]
        if friction["rate"] is not None and least > 0.0:
            scale *= (friction["rate"] / least) ** 3
        # The square of the wobble, which its energy goes with, falls twice as fast as the wobble.
        spin = least + (spin - least) * np.exp(-2.0 * times / scale)
    options = scene.effects.get("constant_torque")
    if options is not None and found.moments is not None:
        gained = np.asarray(options["vector"], float)
        gained = body.rows_at_start.T @ gained if options["frame"] == "body" else gained
        last = math.inf if options["until"] is None else options["until"]
        acted = np.clip(times, options["begin"], max(last, options["begin"])) - options["begin"]
        at_start, along = _momentum(scene, max(found.moments)), np.linalg.norm(gained)
        momentum = np.linalg.norm(at_start + acted[:, None] * gained, axis=1)
        whole = float(np.linalg.norm(at_start))
        if whole > 0.0:
            spin = spin * momentum / whole
        elif (turned := float(gained @ _tensor(scene, max(found.moments)) @ gained)) > 0.0:  # from rest, about itself
            spin = momentum * along**2 / turned
        acts = (times >= options["begin"]) & (times < last)
        torque = np.where(acts, math.sqrt(along / sorted(found.moments)[1]), 0.0)
    frequencies = [spin / size, torque / np.sqrt(size)]
    for other in found.neighbours or ():
        orbit = next(one for one in scene.companions if one.name == other.name)
        frequencies.append(turning_rate(other, orbit.mean_anomaly, times))
    return np.maximum.reduce(frequencies)


def turning_rate(other: Neighbour, mean_anomaly: float, times: np.ndarray) -> np.ndarray:
    """How fast (K,) the direction to a companion turns, at times (K,) of an orbit with that mean anomaly at time 0."""
    e = other.eccentricity
    if e >= 1.0:  # one that passes by turns little, and is near only once
        return np.zeros_like(times)
    anomaly = eccentric_anomaly(np, np.mod(mean_anomaly + other.rate * times, 2.0 * math.pi), e)
    return other.rate * math.sqrt(1.0 - e * e) / (1.0 - e * np.cos(anomaly)) ** 2


def _momentum(scene: Scene, largest: float) -> np.ndarray:
    """The angular momentum (3,) of a rigid body, in inertial axes, whose largest moment is that."""
    body, found = scene.body, characteristic(scene)
    rate = found.spin or 0.0
    if rate == 0.0:
        return np.zeros(3)
    tensor = _tensor(scene, largest)
    if body.rotation is None or body.rotation.wobble is None:
        return rate * tensor @ np.asarray(unit(found.spin_axis))
    inertia = np.linalg.eigvalsh(tensor)
    momentum = rate * np.linalg.norm(inertia * np.asarray(wobbling(inertia, body.rotation.wobble)[1]))
    return momentum * np.asarray(unit(body.rotation.direction))


def _tensor(scene: Scene, largest: float) -> np.ndarray:
    """The inertia tensor (3, 3) at time 0, in inertial axes, of a rigid body whose largest moment is that."""
    body: Any = scene.body
    inertia = np.asarray(_stated_moments(body) or characteristic(scene).moments, float)
    rows = body.rows_at_start
    return rows.T @ np.diag(inertia * (largest / inertia.max())) @ rows


def _stated_moments(body: Any) -> Any:
    """Those of a body that states them, about its own axes and in any unit; None of another one."""
    return getattr(body, "moments", None) or getattr(body, "moment_ratios", None)


def fastest_spin(scene: Scene) -> float:
    """The fastest spin of a free body on its way round: the squares of its momenta change in proportion."""
    body: Any = scene.body
    rate = characteristic(scene).spin or 0.0
    moments = _stated_moments(body)
    if moments is None or rate == 0.0 or min(moments) <= 0.0:
        return rate
    inertia = np.asarray(moments, float)
    if body.rotation.wobble is None:
        spin = rate * body.rows_at_start @ unit(body.rotation.direction)
    else:
        inertia = np.sort(inertia)
        spin = rate * wobbling(inertia, body.rotation.wobble)[1]
    energy, momentum = inertia @ spin**2, (inertia**2) @ spin**2
    # At the ends of the polhode one component of the spin vanishes.
    fastest = spin @ spin
    for gone in range(3):
        left = [axis for axis in range(3) if axis != gone]
        matrix = np.array([inertia[left], inertia[left] ** 2])
        if abs(np.linalg.det(matrix)) > 0.0:
            squares = np.linalg.solve(matrix, [energy, momentum])
            if (squares >= -1e-12 * fastest).all():
                fastest = max(fastest, float(squares.sum()))
    return math.sqrt(fastest)
