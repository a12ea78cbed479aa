"""Scenes with exact answers and random parameters, and the accuracy that each is asked for.

Nothing of the program was fitted to them: a seed gives scenes that no one has looked at.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from astroinertia.accuracy import measuring
from astroinertia.accuracy.choice import Choice
from astroinertia.accuracy.measuring import Measured
from astroinertia.bodies import maclaurin
from astroinertia.scene import load
from astroinertia.scene.schema import Scene
from tests.tradeoff_scenes import PULSATION, SIMS, TOY_STAR

OF_FLUIDS = (3e-2, 1e-2, 3e-3)
OF_FREE_FLUIDS = (*OF_FLUIDS, 1e-3)  # without gravity

ELLIPSOID = """
name = "oscillating"
description = "An incompressible ellipsoid far from equilibrium turns and oscillates."
model = "ellipsoid"
units = "code"
[body]
kind = "uniform"
mass = 1.0
radius = 1.0
[equation_of_state]
kind = "incompressible"
[effects.gravity]
[effects.pressure]
[time]
end = 20.0
"""


@dataclass(frozen=True)
class Asked:
    """A scene with an accuracy; rungs: particles, or models without."""

    family: str
    number: int
    accuracy: float
    text: str
    settings: tuple[str, ...]

    @property
    def name(self) -> str:
        return f"{self.family} {self.number}"

    def scene(self, *more: str) -> Scene:
        settings = (*self.settings, f"accuracy={self.accuracy!r}", *more)
        return load.loads(self.text, settings)


def _numbers(values) -> str:
    return "[" + ", ".join(f"{float(value):.4g}" for value in values) + "]"


def _toy_star(random: np.random.Generator):
    gamma = float(random.choice([1.6666666666666667, 2.0]))
    return TOY_STAR, (
        "model='sph'", f"body.gamma={gamma!r}", f"equation_of_state.gamma={gamma!r}",
        f"body.axes={_numbers(random.uniform(0.85, 1.2, 3))}", f"body.rotation.rate={random.uniform(0.1, 0.5):.4g}",
        f"time.end={random.uniform(1.5, 4.0):.4g}",
    )  # fmt: skip


def _dyson(random: np.random.Generator):
    return (SIMS / "dyson_ellipsoid.toml").read_text(), (
        f"body.axes={_numbers(random.uniform(0.6, 1.2, 3))}", f"body.rotation.rate={random.uniform(0.2, 1.2):.4g}",
        f"time.end={random.uniform(1.0, 4.0):.4g}",
    )  # fmt: skip


def _cold_spheroid(random: np.random.Generator):
    return (SIMS / "cold_spheroid.toml").read_text(), (
        f"body.axes={_numbers([1.0, 1.0, random.uniform(0.85, 1.1)])}",
        f"body.rotation.rate={random.uniform(0.1, 0.4):.4g}", f"time.end={random.uniform(0.5, 0.8):.4g}",
    )  # fmt: skip


def _pulsation(random: np.random.Generator):
    rate = f"{random.uniform(0.005, 0.02):.4g}"
    gradient = f"[[{rate}, 0.0, 0.0], [0.0, {rate}, 0.0], [0.0, 0.0, {rate}]]"
    return PULSATION, (
        "model='sph'", f"body.velocity_gradient={gradient}", f"time.end={random.uniform(10.0, 16.0):.4g}",
        'judged_by=["frequency of inertia_tensor z z"]',
    )  # fmt: skip


def _free_top(random: np.random.Generator):
    moments = np.sort(random.uniform(1.0, 1.9, 3)) * 1e-3
    moments_text = "[" + ", ".join(f'"{each:.6g} kg m2"' for each in moments) + "]"
    return (SIMS / "tennis_racket.toml").read_text(), (
        f"body.moments={moments_text}", f"body.rotation.axis={_numbers(random.normal(size=3))}",
        f'body.rotation.rate="{random.uniform(2.0, 20.0):.4g} rad/s"', f'time.end="{random.uniform(2.0, 10.0):.4g} s"',
    )  # fmt: skip


def _precession(random: np.random.Generator):
    tilt = random.uniform(0.1, 0.8)
    axes = f"[[1, 0, 0], [0, {math.cos(tilt)!r}, {-math.sin(tilt)!r}], [0, {math.sin(tilt)!r}, {math.cos(tilt)!r}]]"
    ratio = random.uniform(0.25, 0.35)
    ratios = f"[{ratio:.9f}, {ratio:.9f}, {ratio * (1 + random.uniform(0.002, 0.01)):.9f}]"
    rate = random.uniform(3e-5, 1.5e-4)
    return (SIMS / "earth_precession.toml").read_text(), (
        f"body.axes_at_start={axes}", f"body.moment_ratios={ratios}",
        f'body.rotation={{ rate = "{rate:.4g} rad/s", axis = [0, {math.sin(tilt)!r}, {math.cos(tilt)!r}] }}',
        f'time.end="{random.uniform(10.0, 60.0):.4g} d"',
    )  # fmt: skip


def _maclaurin(random: np.random.Generator):
    figure = maclaurin.from_eccentricity(random.uniform(0.3, 0.8))
    axes = [float(each) for each in figure.axes / figure.mean_radius]
    rate = float(figure.angular_velocity / math.sqrt(figure.mass / figure.mean_radius**3))
    return ELLIPSOID, (
        f"body.axes={axes}", f"body.rotation={{ rate = {rate!r}, axis = [0, 0, 1] }}",
        f"time.end={random.uniform(20.0, 100.0):.4g}",
    )  # fmt: skip


def _oscillating(random: np.random.Generator):
    axes = random.uniform(0.8, 1.2, 3)
    return ELLIPSOID, (
        f"body.axes={_numbers(axes / np.prod(axes) ** (1 / 3))}",
        f"body.rotation={{ rate = {random.uniform(0.1, 0.5):.4g}, axis = [0, 0, 1] }}",
        f"time.end={random.uniform(5.0, 30.0):.4g}",
    )


FAMILIES: dict[str, tuple[int, Callable, tuple[float, ...]]] = {
    "toy star": (14, _toy_star, OF_FREE_FLUIDS),
    "dyson": (12, _dyson, OF_FREE_FLUIDS),
    "cold spheroid": (9, _cold_spheroid, OF_FLUIDS),
    "pulsation": (4, _pulsation, OF_FLUIDS[:1]),
    "free top": (12, _free_top, ()),
    "precession": (10, _precession, ()),
    "maclaurin": (8, _maclaurin, ()),
    "oscillating": (8, _oscillating, ()),
}
"""How many of each, the scene, and the accuracies that are asked in turn; of the others any from 1e-3 to 1e-10."""


def asked(seed: int) -> Iterator[Asked]:
    """All scenes of a seed."""
    for place, (family, (count, made, accuracies)) in enumerate(FAMILIES.items()):
        random = np.random.default_rng([seed, place])
        for number in range(count):
            accuracy = accuracies[number % len(accuracies)] if accuracies else float(10 ** -random.uniform(3.0, 10.0))
            text, settings = made(random)
            yield Asked(family, number, float(f"{accuracy:.2g}"), text, settings)


def carried_out(choice: Choice, folder: Path) -> Measured:
    """What the chosen setting gives and takes, as a tradeoff measures it."""
    observables = choice.pilots.observables
    quiet = measuring.scene_of(choice.scene, measuring.AS_IT_IS, observables)
    place = measuring.folder_of(folder, quiet, measuring.AS_IT_IS)
    return measuring.stored(place, observables) or measuring.measure(quiet, observables, place)
