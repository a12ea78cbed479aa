"""The affine body of a scene: a sphere with its profile, stretched and set in motion, and the fluid it is made of."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.special import expit

from astroinertia.build.effects import effects_of
from astroinertia.build.flow import initial_velocity
from astroinertia.build.fluids import entropies, equation_of_state
from astroinertia.build.spheres import Sphere, sphere, stretch
from astroinertia.errors import SceneError
from astroinertia.models.ellipsoid import evolution as ellipsoid
from astroinertia.models.ellipsoid.affine_body import PRESSURE, Matter, Problem
from astroinertia.models.ellipsoid.evolution import Ellipsoid
from astroinertia.scene.schema import Scene
from astroinertia.sph.profiles import Profile
from astroinertia.units import CodeUnits, pressure_constant_dimension

# Tanh-sinh rule in s: steps of the transformed variable, and where it ends (s or 1 - s of 1e-40).
_SHELL_STEP, _SHELL_END = 1 / 32, 4.0
# Of the directions in which a rotation law is sampled: Gauss points in cos(theta), twice as many in phi.
_LATITUDES, _SAMPLED_STEP = 16, 1 / 10
_TRACE = 1e-9  # of a velocity gradient, beyond which an incompressible body would change its volume


def evolution(scene: Scene, units: CodeUnits) -> Ellipsoid:
    """The body at time 0; SceneError where the scene asks for what an ellipsoid cannot be."""
    if scene.companions:
        raise SceneError(
            "[[companions]] act on the model rigid; what another body does to an ellipsoid is [effects.tide]."
        )
    if scene.numerics.integrator != "adaptive":
        raise SceneError(
            f"[numerics] integrator {scene.numerics.integrator} is for the model rigid, not for ellipsoid."
        )
    initial = sphere(scene, units)
    if not isinstance(initial, Sphere):
        raise SceneError(
            f"[body] of the kind {scene.body.title} is no stretched sphere, which the model ellipsoid needs: take a "
            "polytrope, uniform, power_law or dyson body."
        )
    body: Any = scene.body
    deformation = stretch(body)
    volume = float(np.prod(body.axes))
    rate = _initial_rate(scene, units, initial, deformation)
    matter, heat, kept = _fluid(scene, units, initial, deformation, rate)
    problem = Problem(
        effects=effects_of(scene, units),
        mass=initial.mass,
        radius=initial.radius,
        second_moment=initial.mass * initial.radius**2 * initial.profile.second_moment,
        sphere_energy=_sphere_energy(scene, initial),
        matter=matter,
        volume=volume if kept else None,
    )
    with np.errstate(over="ignore"):
        central = float(initial.profile.density(np.array(0.0))) * initial.mass / initial.radius**3
    return ellipsoid.started(
        problem, deformation, rate, heat,
        tolerance=scene.numerics.tolerance,
        density=central if _bounded(initial.profile) else math.nan,
        approximation=_approximation(scene),
    )  # fmt: skip


def resumed(scene: Scene, units: CodeUnits, arrays: Mapping[str, np.ndarray]) -> Ellipsoid:
    """The body of a checkpoint."""
    body = evolution(scene, units)
    body.resume(arrays)
    return body


def refuse_branch(run: Scene, branch: Scene) -> None:
    """SceneError where one of a run and its branch knows nothing of heat."""
    if (PRESSURE in run.effects) != (PRESSURE in branch.effects):
        raise SceneError("[effects.pressure] of an ellipsoid is listed by a run and its branch, or by neither.")


def branched(scene: Scene, units: CodeUnits, parent: Ellipsoid) -> Ellipsoid:
    """The body of another run where it is, in this scene."""
    body = evolution(scene, units)
    body.begin(parent)
    return body


def shells(profile: Profile, step: float = _SHELL_STEP) -> tuple[np.ndarray, np.ndarray]:
    """Share of the mass (K,) and radius s (K,) of shells, by which sums over shells are integrals over the mass.

    The tanh-sinh rule, exact to 1e-14 for what is smooth inside, also where it rises without bound at the centre or
    falls to nothing at the surface (Takahasi & Mori 1974, Publ. RIMS 9, 721).
    """
    t = np.arange(-round(_SHELL_END / step), round(_SHELL_END / step) + 1) * step
    s, rest = expit(math.pi * np.sinh(t)), expit(-math.pi * np.sinh(t))
    share = 4 * math.pi * s**3 * rest * profile.density(s) * math.pi * np.cosh(t) * step
    inside = share > 1e-30 * share.max()
    return share[inside] / share[inside].sum(), s[inside]


def _initial_rate(scene: Scene, units: CodeUnits, initial: Sphere, deformation: np.ndarray) -> np.ndarray:
    # Of all linear flows the one with the mixed moment of the scene's: the flow itself where that is linear.
    share, s = shells(initial.profile, _SAMPLED_STEP)
    cosine, weight = np.polynomial.legendre.leggauss(_LATITUDES)
    phi = np.arange(2 * _LATITUDES) * (math.pi / _LATITUDES)
    sine = np.sqrt(1 - cosine**2)
    direction = np.stack(
        [np.outer(sine, np.cos(phi)), np.outer(sine, np.sin(phi)), np.outer(cosine, np.ones_like(phi))], axis=-1
    ).reshape(-1, 3)
    angular = np.repeat(weight / (2 * len(phi)), len(phi))
    xi = (s[:, None, None] * direction).reshape(-1, 3)
    mass = initial.mass * np.outer(share, angular).reshape(-1)
    velocity = initial_velocity(scene, units, initial, mass, initial.radius * xi @ deformation.T)
    moment = (mass[:, None] * xi).T @ xi
    return np.linalg.solve(moment, (mass[:, None] * xi).T @ velocity).T / initial.radius


def _fluid(
    scene: Scene, units: CodeUnits, initial: Sphere, deformation: np.ndarray, rate: np.ndarray
) -> tuple[Matter | None, float, bool]:
    """The matter, its heat, and whether it keeps its volume."""
    chosen, body = scene.equation_of_state, scene.body
    assert chosen is not None  # the schema asks for it
    if chosen.kind == "incompressible":
        _check_incompressible(scene, deformation, rate)
        return None, 0.0, True
    if PRESSURE not in scene.effects:
        return None, 0.0, False
    fluid = equation_of_state(scene, units, initial)
    share, s = shells(initial.profile)
    mass, density = initial.mass * share, initial.mass / initial.radius**3 * initial.profile.density(s)
    if chosen.kind == "polytropic":
        power = fluid.gamma - 1
        mean = (mass @ density**power / initial.mass) ** (1 / power)
        return Matter(np.array([initial.mass]), np.array([mean]), fluid), 0.0, False
    if chosen.kind == "isothermal":
        mean = math.exp(mass @ np.log(density) / initial.mass)
        return Matter(np.array([initial.mass]), np.array([mean]), fluid), 0.0, False
    if not fluid.thermal:
        return Matter(mass, density, fluid), 0.0, False
    entropies(scene, units, initial, fluid, np.array([0.5]))  # refuses what it refuses for particles
    gamma: Any = chosen.thermal_gamma
    per_entropy = mass @ density ** (gamma - 1) / (gamma - 1)
    volume = float(np.linalg.det(deformation))
    if body.specific_internal_energy is not None:
        energy = units.to_code(body.specific_internal_energy, "specific_energy")
        at_start = density / volume
        cold = fluid.internal_energy(np, at_start, np.zeros_like(density))
        heat = mass @ np.maximum(energy - cold, 0.0) * volume ** (gamma - 1)
    elif body.entropy is not None:
        heat = per_entropy * units.to_code(body.entropy, pressure_constant_dimension(gamma))
    elif chosen.kind == "hybrid":
        heat = 0.0
    else:
        # The pressure of equilibrium has the integral -W/3 over the volume of the sphere (the virial theorem).
        share = (body.pressure_fraction or 1.0) * body.support
        heat = -share * _sphere_energy(scene, initial) / (3 * (gamma - 1))
    thermal = Matter(mass, density, None if chosen.kind == "ideal" else fluid, gamma)
    return (
        (replace(thermal, shell_mass=mass[:1], shell_density=density[:1]) if thermal.cold is None else thermal),
        float(heat),
        False,
    )


def _check_incompressible(scene: Scene, deformation: np.ndarray, rate: np.ndarray) -> None:
    body = scene.body
    if PRESSURE not in scene.effects:
        raise SceneError("[equation_of_state] incompressible needs [effects.pressure], which keeps the volume.")
    for name in ("specific_internal_energy", "entropy", "pressure_fraction"):
        if getattr(body, name) is not None:
            raise SceneError(f"[body] {name} is for a gas, and the fluid is incompressible.")
    if not np.linalg.cond(deformation) < 1.0 / np.finfo(float).eps:
        raise SceneError("[body] axes are so unlike that the volume, which the fluid is to keep, is rounded away.")
    gradient = rate @ np.linalg.inv(deformation)
    if abs(np.trace(gradient)) > _TRACE * np.abs(gradient).max():
        raise SceneError(
            "[body] velocity_gradient has a trace, by which the volume would change, and the fluid is incompressible."
        )


def _sphere_energy(scene: Scene, initial: Sphere) -> float:
    if "gravity" not in scene.effects:
        return 0.0
    energy = initial.profile.gravitational_energy * initial.mass**2 / initial.radius
    if not math.isfinite(energy):
        raise SceneError("[body] exponent: from 2.5 on the gravitational energy of a power_law has no bound.")
    return energy


def _bounded(profile: Profile) -> bool:
    inner = profile.density(np.array([1e-3, 1e-6]))
    return bool(inner[1] < 1.01 * inner[0])


def _approximation(scene: Scene) -> str:
    """What is exact for this body, or what is approximated."""
    body: Any = scene.body
    listed = set(scene.effects)
    fluid: Any = scene.equation_of_state
    law = None if body.rotation is None else body.rotation.law
    reasons = []
    falls = body.homologous and listed == {"gravity", PRESSURE} and law is None and set(body.axes) == {1.0}
    if falls and fluid.kind in ("ideal", "polytropic") and abs(fluid.gamma - 4.0 / 3.0) < 1e-12:
        return "exact: pressure and gravity leave an acceleration that is linear in position"
    if "gravity" in listed and not body.homogeneous:
        reasons.append("the density is not uniform")
    if PRESSURE in listed:
        equilibrium = fluid.kind == "ideal" and body.entropy is None and body.specific_internal_energy is None
        parabolic = body.homogeneous and (equilibrium or fluid.kind == "incompressible")
        isentropic = fluid.kind == "polytropic" or (fluid.kind == "ideal" and body.entropy is not None)
        if not (parabolic or (body.isentropic and isentropic and fluid.gamma == body.gamma)):
            reasons.append("the pressure force is not linear in position")
    if law not in (None, "rigid"):
        reasons.append(f"the rotation {law} is not linear in position")
    if "shear_viscosity" in listed:
        reasons.append("viscosity makes boundary layers")
    field = scene.effects.get("external_field", {})
    if field.get("circular_speed") is not None or field.get("point_mass") is not None:
        reasons.append("the external field is taken to second order")
    if "tide" in listed:
        reasons.append("the tide is taken to second order")
    if not reasons:
        return "exact: the fluid keeps a velocity that is linear in position"
    return f"affine approximation: {', '.join(reasons)}; the tensor virial equations hold, the shells stay similar"
