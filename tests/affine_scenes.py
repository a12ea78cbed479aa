"""Scenes of the exact families of affine bodies, and other solutions of the same equations to hold them to."""

import math
from typing import Any

import jax
import numpy as np

from astroinertia.bodies import ellipsoid_gravity
from astroinertia.build.assemble import prepare
from astroinertia.models.ellipsoid.evolution import Ellipsoid
from astroinertia.scene import load

SCENE = """
name = "affine"
model = "ellipsoid"
units = "code"
[body]
{body}
mass = 1.0
radius = 1.0
axes = {axes}
velocity_gradient = {gradient}
[equation_of_state]
{fluid}
{effects}
[time]
end = 1e6
"""
UNIFORM = 'kind = "uniform"'
GRAVITY, PRESSURE = "[effects.gravity]\n", "[effects.pressure]\n"


def text(axes: Any, gradient: Any, body: str, fluid: str, effects: str) -> str:
    axes, gradient = np.asarray(axes, float).tolist(), np.asarray(gradient, float).tolist()
    return SCENE.format(axes=axes, gradient=gradient, body=body, fluid=fluid, effects=effects)


def compressible(axes: Any, gradient: Any, gamma: float, central: float) -> str:
    """Homogeneous, with P = rho central (1 - s^2) at the start; that of the sphere's equilibrium is 1/2 there."""
    fraction = central / 0.5 * float(np.prod(axes)) ** (gamma - 1)
    body = f"{UNIFORM}\npressure_fraction = {fraction!r}"
    return text(axes, gradient, body, f'kind = "ideal"\ngamma = {gamma!r}', GRAVITY + PRESSURE)


def isentropic(axes: Any, gradient: Any, gamma: float, enthalpy: float, k: float = 0.0) -> str:
    """Dyson's gas with a central enthalpy at the start, in the field of k x^2/2."""
    n = 1 / (gamma - 1)
    central = math.exp(math.lgamma(n + 2.5) - math.lgamma(n + 1)) / math.pi**1.5 / float(np.prod(axes))
    constant = enthalpy / (n + 1) * central ** (1 - gamma)
    field = f"[effects.external_field]\nquadratic = {(k * np.eye(3)).tolist()}\n" if k else ""
    fluid = f'kind = "polytropic"\ngamma = {gamma!r}\nconstant = {constant!r}'
    return text(axes, gradient, f'kind = "dyson"\ngamma = {gamma!r}', fluid, PRESSURE + field)


def cold(axes: Any, gradient: Any) -> str:
    return text(axes, gradient, UNIFORM, 'kind = "ideal"', GRAVITY)


def incompressible(axes: Any, gradient: Any, effects: str = "") -> str:
    return text(axes, gradient, UNIFORM, 'kind = "incompressible"', GRAVITY + PRESSURE + effects)


def started(scene: str, *settings: str) -> Ellipsoid:
    with jax.enable_x64(True):
        body: Any = prepare(load.loads(scene, settings)).evolution
    return body


def semi_axes(body: Ellipsoid) -> np.ndarray:
    """Semi-axes of the homogeneous ellipsoid F of the unit sphere, descending."""
    return np.linalg.svd(np.asarray(body.state.deformation), compute_uv=False)


def gravity_of(deformation: np.ndarray) -> np.ndarray:
    """d2F/dt2 by the gravity of the homogeneous ellipsoid, from scipy's integrals along principal axes."""
    left, axes, right = np.linalg.svd(deformation)
    symbols = ellipsoid_gravity.index_symbols(axes)
    return -1.5 / np.prod(axes) * left @ np.diag(symbols * axes) @ right
