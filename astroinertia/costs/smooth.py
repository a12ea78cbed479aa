"""How many steps the models without particles take: by how fast their bodies turn and fall."""

import math
from typing import Any

import numpy as np

from astroinertia.effects.characteristic import Characteristic
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.initial_body import unit, wobbling
from astroinertia.scene.schema import Scene

# Radians of the fastest motion in a step of order 8(7), over tolerance^(1/8): 4.6 to 5.0 and 8 to 11 as measured on a
# pulsating spheroid and a free top, at tolerances of 1e-6 to 1e-12.
REACH = {"ellipsoid": 4.9, "adaptive": 9.5}
STAGES = {2: 1, 4: 5, 6: 9, 8: 17}  # of a splitting, by its order; the machine's steps are of order 8
# What a step of a rigid body takes with a companion, whose place and torque are found at every stage, over one without:
# 74 over 7.3 and 56 over 21 us, of the Earth with the Moon.
WITH_COMPANIONS = {"splitting": 10.0, "adaptive": 2.6}
# The same with an effect that follows the spin, which every kick looks for again: 171 to 256 over 11 to 17 us, and 53
# to 55 over 16 to 19 us, of a top with internal friction; with a companion's tide both add up.
FOLLOWING_SPIN = {"splitting": 15.0, "adaptive": 3.0}


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
    numerics, interval = scene.numerics, scene.time.end / max(1, written - 1)
    if kind(scene) == "splitting":
        turns = interval * fastest_spin(scene) / (2.0 * math.pi)
        per_record = math.ceil(turns * numerics.steps_per_rotation - 1e-6)
    else:
        pace = fastest_spin(scene) if scene.model == "rigid" else _pace(characteristic(scene))
        per_record = math.ceil(interval * pace / (REACH[kind(scene)] * numerics.tolerance**0.125))
    return float(max(1, per_record) * (written - 1))


def of_step(scene: Scene) -> float:
    """What a step takes over one of the default order without companions and torques."""
    if scene.model != "rigid":
        return 1.0
    integrator, times = kind(scene), 1.0
    if scene.companions:
        times += WITH_COMPANIONS[integrator] - 1.0
    if any(scene.entries[effect].made.follows_spin for effect in scene.effects):
        times += FOLLOWING_SPIN[integrator] - 1.0
    return times * (STAGES[scene.numerics.order] / STAGES[8] if integrator == "splitting" else 1.0)


def _pace(body: Characteristic) -> float:
    """The fastest of fall, turning and flow."""
    return max(1.0 / (body.dynamical_time or math.inf), body.spin or 0.0, body.shear, abs(body.expansion))


def fastest_spin(scene: Scene) -> float:
    """The fastest spin of a free body on its way round: the squares of its momenta change in proportion."""
    body: Any = scene.body
    rate = characteristic(scene).spin or 0.0
    moments = getattr(body, "moments", None) or getattr(body, "moment_ratios", None)
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
