"""Eight scenes with exact answers, on which `tradeoff` is measured, as small as they still converge."""

import math
from dataclasses import dataclass
from pathlib import Path

from astroinertia.bodies import maclaurin
from astroinertia.scene import load
from astroinertia.scene.schema import Scene

SIMS = Path(__file__).parents[1] / "sims"


@dataclass(frozen=True)
class Case:
    """A scene, what it is judged by (its model's defaults where empty), the knobs that are turned (all if empty),
    and for how long.
    """

    name: str
    text: str
    settings: tuple[str, ...] = ()
    observables: tuple[str, ...] = ()
    knobs: tuple[str, ...] = ()
    minutes: float = 10.0

    def scene(self, *more: str) -> Scene:
        return load.loads(self.text, (*self.settings, *more))


def _sim(name: str) -> str:
    return (SIMS / f"{name}.toml").read_text()


# rho_c of rho = rho_c (1 - s^2) with unit mass in semi-axes of product 0.99, and A = h0 (gamma - 1)/(gamma rho_c).
TOY_STAR = f"""
name = "toy_star"
description = "A rotating triaxial toy star of gas oscillates in a harmonic field."
units = "code"
[body]
kind = "dyson"
gamma = 2.0
particles = 1000
mass = 1.0
radius = 1.0
axes = [1.1, 0.9, 1.0]
relax = false
entropy = {0.25 * 8 * math.pi * 0.99 / 15!r}
[body.rotation]
rate = 0.3
[equation_of_state]
kind = "ideal"
gamma = 2.0
[effects.pressure]
[effects.external_field]
quadratic = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
[time]
end = 10.0
"""

PULSATION = """
name = "polytrope_pulsation"
description = "A settled n = 1 polytrope rings at the frequency of its radial fundamental."
units = "code"
[body]
kind = "polytrope"
index = 1.0
particles = 1000
mass = 1.0
radius = 1.0
velocity_gradient = [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]]
[equation_of_state]
kind = "ideal"
gamma = 2.0
[effects.gravity]
[effects.pressure]
[time]
end = 16.0
[output]
series_every = 0.1
"""


def _maclaurin() -> str:
    figure = maclaurin.from_eccentricity(0.6)
    axes = [float(each) for each in figure.axes / figure.mean_radius]
    rate = float(figure.angular_velocity / math.sqrt(figure.mass / figure.mean_radius**3))
    return f"""
name = "maclaurin"
description = "A Maclaurin spheroid of e = 0.6 turns in equilibrium."
model = "ellipsoid"
units = "code"
[body]
kind = "uniform"
mass = 1.0
radius = 1.0
axes = {axes}
[body.rotation]
rate = {rate!r}
axis = [0, 0, 1]
[equation_of_state]
kind = "incompressible"
[effects.gravity]
[effects.pressure]
[time]
end = 100.0
"""


_FLUID = ("timestep_factor", "neighbours", "smoothing_tolerance", "precision")

CASES = (
    Case("dyson", _sim("dyson_ellipsoid"), ("body.particles=2000",), (), (*_FLUID, "model")),
    Case("cold_spheroid", _sim("cold_spheroid"), ("body.particles=600",), (), ("timestep_factor", "model"), 1.2),
    Case("toy_star", TOY_STAR, ("body.particles=600", "time.end=3.0"), (), ("timestep_factor", "model"), 1.2),
    Case(
        "polytrope_pulsation",
        PULSATION,
        ("body.particles=600",),
        ("frequency of inertia_tensor z z",),
        ("timestep_factor",),
    ),
    Case("riemann", _sim("riemann_ellipsoid"), (), ("inertia_tensor x x", "angular_velocity"), ("tolerance",)),
    Case("maclaurin", _maclaurin(), (), (), ("tolerance",)),
    Case("rigid_top", _sim("tennis_racket"), ("numerics.order=4",)),
    Case("earth_precession", _sim("earth_precession"), ("time.end='0.2 yr'",), (), ("order",)),
)
