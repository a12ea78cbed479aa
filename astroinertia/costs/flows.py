"""The longest steps that standard problems allow, by their exact flows: tracers drift in these, neighbours and all.

Distances to neighbours say what density particles see, and how they move what signals there are. Tests:
tests/unit/costs/test_flows.py.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.costs.limits import Matter
from astroinertia.costs.signals import LEAST, fastest
from astroinertia.effects.kinds.viscosity import agreement
from astroinertia.scene.plan import smoothing
from astroinertia.scene.schema import Scene
from astroinertia.sph.kernels import KERNELS
from astroinertia.test_problems.matter import standard

MOMENTS = 13
DISORDER = 0.05  # of the speed of sound, with which particles stir their neighbours
TRACERS = 500  # about, at most: of more particles smoothing lengths are shorter, and flows the same


def matter(scene: Scene, end: float) -> list[Matter]:
    """The course of a body of the kind standard, in code units.

    Problems without an exact flow are taken as they begin.
    """
    body: Any = scene.body
    fluid: Any = scene.equation_of_state
    problem, gamma, numerics = standard(body.problem), fluid.gamma, scene.numerics
    lengths = scene.box_lengths
    count = min(body.particles, TRACERS)
    placed = problem.place(count, lengths, gamma)
    position, velocity, energy = placed.position, placed.velocity, placed.internal_energy
    begins = 0.0 if problem.begins is None else problem.begins(float(placed.mass[0]), gamma)
    eta, neighbours = smoothing(scene)
    kernel = KERNELS[numerics.kernel]
    times, found = np.linspace(0.0, end, MOMENTS), []
    for time in times[: 1 if problem.exact is None else MOMENTS]:
        around, apart, reach = _neighbourhoods(position, lengths, round(neighbours))
        length = reach / kernel.support
        density = placed.mass * (eta / length) ** 3
        if time > begins and problem.exact is not None:
            flow = problem.exact(position, float(time), lengths, gamma)
            weight = kernel.w(np, np.linalg.norm(apart, axis=2) / length[:, None]) / kernel.w(np, 0.0)
            velocity, pressure = (_spread(of, around, weight) for of in (flow.velocity, flow.pressure[:, None]))
            energy = pressure[:, 0] / ((gamma - 1.0) * density)
        sound = np.sqrt(gamma * (gamma - 1.0) * energy)
        signal = signals(around, apart, velocity, sound, length, scene.effects.get("viscosity"))
        found.append(Matter(float(time), placed.mass, density, signal))
        position = position + velocity * times[1]
    return found if problem.exact is not None else [found[0], replace(found[0], time=end)]


def _spread(values: np.ndarray, around: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Values (N, ...) as smoothed particles have them, whose shocks are as wide as kernels: means over neighbours."""
    return (values + np.einsum("nk,nki->ni", weight, values[around])) / (1.0 + weight.sum(axis=1))[:, None]


def signals(
    around: np.ndarray, apart: np.ndarray, velocity: np.ndarray, sound: np.ndarray, length: np.ndarray,
    viscosity: Mapping[str, Any] | None,
) -> np.ndarray:  # fmt: skip
    """The fastest signal (N,) between particles and their neighbours (N, K), which are (N, K, 3) away from them.

    length (N,): smoothing lengths. Of many particles in disorder some have the full viscosity, whatever switch it has,
    and whatever limiter where nothing but disorder shears them. Where shear is faster than sound, pressure does not
    keep layers in order: neither limiter nor reconstruction knows it from a shock.
    """
    distance = np.linalg.norm(apart, axis=2)
    relative = velocity[around] - velocity[:, None]
    rate = (relative * apart).sum(axis=2) / distance
    mean_sound = 0.5 * (sound[:, None] + sound[around])
    away = apart.transpose(0, 2, 1)
    gradient = np.linalg.solve(away @ apart, away @ relative)  # d v_j/d x_i
    mine = (apart @ gradient * apart).sum(axis=2) / distance
    other = ((apart[:, :, None] @ gradient[around])[:, :, 0] * apart).sum(axis=2) / distance
    turning = 0.5 * ((gradient - gradient.transpose(0, 2, 1)) ** 2).sum(axis=(1, 2))
    converging = np.trace(gradient, axis1=1, axis2=2) ** 2
    disordered = (turning > converging)[:, None] & (np.abs(rate) > mean_sound)
    trusted = np.where(disordered, 0.0, agreement(np, mine, other))
    alpha: Any = 0.0 if viscosity is None else viscosity["alpha_max"]
    if viscosity is not None and viscosity["limiter"] != "none":
        noise = (DISORDER * sound / length) ** 2
        full = np.maximum(noise + converging, LEAST)
        spared = full / (full + turning)
        alpha = alpha * np.where(disordered, 1.0, 0.5 * (spared[:, None] + spared[around]))
    signal = fastest(rate, mean_sound, viscosity, alpha, 0.5 * (mine + other), trusted)
    return np.maximum(np.maximum(signal.max(axis=1), sound), LEAST)


def _neighbourhoods(position: np.ndarray, lengths: np.ndarray, count: int) -> tuple[np.ndarray, ...]:
    """Of each particle its neighbours (N, K), how they are away (N, K, 3), and how far the last of them is (N,)."""
    images = np.zeros((1, 3))
    if np.isfinite(lengths).all():  # kernels may be wider than half of a flat box
        images = lengths * (np.indices((3, 3, 3)).reshape(3, -1).T - 1.0)
        position = np.mod(position, lengths)
    everywhere = (images[:, None] + position).reshape(-1, 3)
    from scipy.spatial import KDTree  # only here: other scenes do without it

    nearest: Any = KDTree(everywhere).query(position, k=min(count, len(everywhere)))
    distance, around = nearest
    apart = everywhere[around[:, 1:]] - position[:, None]
    return around[:, 1:] % len(position), apart, distance[:, -1]
