"""Exact motions of ellipsoids, from the scene to the record, against independent integrations of their equations."""

import math

import jax
import numpy as np

from astroinertia.build.assemble import prepare
from astroinertia.scene.load import loads
from astroinertia.verify.comparison import Quantities

_SCENE = """
name = "exact_motion"
model = "ellipsoid"
units = "code"
[body]
{body}
mass = 1.0
radius = 1.0
axes = {axes}
[body.rotation]
rate = {rate}
[equation_of_state]
{fluid}
{effects}
[time]
end = 1e6
"""
_GAMMA = 5.0 / 3.0
_GRAVITY, _PRESSURE = "[effects.gravity]", "[effects.pressure]"


def riemann() -> Quantities:
    """A homogeneous gas with P = 0.45 rho (1 - s^2) at the start, gravitating and turning."""
    axes = (1.2, 1.0, 0.8)
    fraction = 0.45 / 0.5 * math.prod(axes) ** (_GAMMA - 1)  # of the equilibrium of the sphere, 1/2 at the centre
    fluid = f'kind = "ideal"\ngamma = {_GAMMA!r}'
    body = f'kind = "uniform"\npressure_fraction = {fraction!r}'
    return _figures("riemann", _at(3.0, body, axes, 0.5, fluid, f"{_GRAVITY}\n{_PRESSURE}"))


def dyson() -> Quantities:
    """A turning isentropic gas without gravity that expands, of enthalpy 1 at its centre."""
    axes, n = (1.0, 0.8, 0.6), 1.0 / (_GAMMA - 1.0)
    central = math.gamma(n + 2.5) / math.gamma(n + 1) / math.pi**1.5 / math.prod(axes)
    fluid = f'kind = "polytropic"\ngamma = {_GAMMA!r}\nconstant = {central ** (1 - _GAMMA) / (n + 1)!r}'
    return _figures("dyson", _at(4.0, f'kind = "dyson"\ngamma = {_GAMMA!r}', axes, 1.0, fluid, _PRESSURE))


def dirichlet() -> Quantities:
    """An incompressible ellipsoid out of balance."""
    axes = (1.1, 1.0, 1.0 / 1.1)
    effects = f"{_GRAVITY}\n{_PRESSURE}"
    return _figures("dirichlet", _at(10.0, 'kind = "uniform"', axes, 0.4, 'kind = "incompressible"', effects))


def _at(
    time: float, body: str, axes: tuple[float, ...], rate: float, fluid: str, effects: str
) -> dict[str, np.ndarray]:
    text = _SCENE.format(body=body, axes=list(axes), rate=rate, fluid=fluid, effects=effects)
    with jax.enable_x64(True):
        evolution = prepare(loads(text)).evolution
        opening = evolution.record(None)["potential_energy"]
        while evolution.time < time:
            evolution.advance(time)
        return evolution.record(opening)


def _figures(name: str, record: dict[str, np.ndarray]) -> Quantities:
    return {
        f"{name}_moment": float(record["inertia_tensor"][2, 2]),
        f"{name}_product": float(record["second_moment"][0, 1]),
        f"{name}_energy": float(record["total_energy"]),
        f"{name}_closure": float(record["ledger_closure"]),
    }


COMPUTATIONS = (riemann, dyson, dirichlet)
