"""Rotating core collapse in two dimensions, by a grid that moves with the matter: the source of `data/references.toml`.

    python tests/benchmarks/axisymmetric_core.py pulsar_collapse --shells 300 --angles 25

What is solved, and how, is in axisymmetric_grid.py. It shares nothing with particles.

The bodies are those of the scenes: for pulsar_collapse the polytrope whose shells keep their pressure / density^(5/3)
while it settles in rotation, as particles do; for core_collapse the rotating star (bodies.rotating_star). Angular
momentum is kept to round-off; the change of the total energy is printed. At rest it gives what tests/lagrangian_core.py
does.
"""

import argparse
import time as clock
from pathlib import Path
from typing import NamedTuple

import numpy as np
from axisymmetric_grid import COLUMNS, Angles, G, Matter, angles, evolve
from numpy.polynomial import legendre

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.bodies.rotating_star import rotating_star
from astroinertia.bodies.rotation_laws import RotationLaw
from astroinertia.matter.barotropes import polytropic_matter
from astroinertia.scene import load

ROOT = Path(__file__).parents[2]
OUTSIDE = 1e-5  # of the mass: the rare surface
SPACING = 1.5  # shares of the mass go as its power of the number of a shell, from the centre and from the surface
FLOOR = 1e-6  # of a shell's mean density: what cells beyond a flattened surface are filled with


class Body(NamedTuple):
    """Edges of shells r (N + 1,), masses (N, M), entropies A (N, M) and specific angular momenta (N, M)."""

    edges: np.ndarray
    mass: np.ndarray
    entropy: np.ndarray
    momentum: np.ndarray


def _cells(edges: np.ndarray, count: int, density, rate) -> tuple[np.ndarray, np.ndarray]:
    """Masses and specific angular momenta of cells, by Gauss's rule with 6 x 6 points in r and cos(theta)."""
    nodes, weights = legendre.leggauss(6)
    mu = np.cos(np.linspace(0.0, np.pi / 2, count + 1))
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    radius = middle[:, None] + half[:, None] * nodes
    centre, spread = 0.5 * (mu[1:] + mu[:-1]), 0.5 * (mu[:-1] - mu[1:])
    cosine = centre[:, None] + spread[:, None] * nodes
    x, c = radius[:, None, :, None], cosine[None, :, None, :]
    far, high = x * np.sqrt(1 - c**2), x * c
    weight = 4 * np.pi * x**2 * (half[:, None] * weights)[:, None, :, None] * (spread[:, None] * weights)[None, :, None]
    matter = weight * density(far, high)
    mass = matter.sum(axis=(2, 3))
    return mass, (matter * rate(far) * far**2).sum(axis=(2, 3)) / np.maximum(mass, 1e-300)


def _filled(edges: np.ndarray, mass: np.ndarray, momentum: np.ndarray, cells: Angles) -> tuple[np.ndarray, np.ndarray]:
    """The same with a floor under densities; what is filled turns with its shell."""
    shells = np.diff(edges**3)[:, None] / 3 * cells.solid
    mean = mass.sum(axis=1, keepdims=True) / shells.sum(axis=1, keepdims=True)
    least = FLOOR * mean * shells
    lever = 0.6 * (np.diff(edges**5) / np.diff(edges**3))[:, None] * cells.squared
    turning = (mass * momentum).sum(axis=1, keepdims=True) / (mass * lever).sum(axis=1, keepdims=True)
    return np.maximum(mass, least), np.where(mass < least, turning * lever, momentum)


def _shares(count: int) -> np.ndarray:
    return (1 - OUTSIDE) * (1 - (1 - np.linspace(0.0, 1.0, count + 1) ** SPACING) ** SPACING)


def pulsar_collapse(shells: int, cells: Angles) -> tuple[Body, Matter]:
    """The n = 3 polytrope of sims/pulsar_collapse.toml, settled in rotation."""
    scene = load.load_file(ROOT / "sims" / "pulsar_collapse.toml")
    body, fluid = scene.body, scene.equation_of_state
    star = Polytrope(body.index, body.mass, body.radius, G)
    edges = np.asarray(star.radius_enclosing(_shares(shells) * body.mass))
    edges[0] = 0.0
    mass = np.diff(_shares(shells))[:, None] * body.mass * cells.solid / (4 * np.pi)
    constant = body.pressure_fraction * star.central_pressure / star.central_density**fluid.gamma_1
    collapsing = Matter(constant, fluid.gamma_1, fluid.nuclear_density, fluid.gamma_2, fluid.gamma_thermal)
    density = mass / (np.diff(edges**3)[:, None] / 3 * cells.solid)
    gas = Matter(0.0, 4 / 3, 1e300, 2.5, 5 / 3)
    settled = Body(edges, mass, star.central_pressure / star.central_density ** (4 / 3) * density ** (4 / 3 - 5 / 3),
                   np.zeros_like(mass))  # fmt: skip
    period = (body.radius**3 / (G * body.mass)) ** 0.5
    table, *_ = evolve(*settled, gas, cells, 3 * period, 0.1 * period, 5.0 / period, body.rotation.t_over_w, 0.0)
    print(f"# settled: I {table[0, 2]:.5e} to {table[-1, 2]:.5e} kg m2, the last "
          f"{table[-1, 2] / table[-6, 2] - 1:.1e}; T/|W| {body.rotation.t_over_w}")  # fmt: skip
    return settled._replace(entropy=np.zeros_like(mass)), collapsing


def core_collapse(shells: int, cells: Angles) -> tuple[Body, Matter]:
    """The rotating star of sims/core_collapse.toml."""
    scene = load.load_file(ROOT / "sims" / "core_collapse.toml")
    body, fluid = scene.body, scene.equation_of_state
    law = RotationLaw(body.law, body.scale / body.radius)
    star = rotating_star(polytropic_matter(body.index), body.axis_ratio, law, body.mass, body.radius, G)
    fine = np.linspace(0.0, body.radius, 4001)
    mass, _ = _cells(fine, 40, star.density, star.rotation_rate)
    enclosed = np.concatenate([[0.0], np.cumsum(mass.sum(axis=1))])
    edges = np.interp(_shares(shells) * enclosed[-1], enclosed, fine)
    # Linear between points of the fine grid, but as a cube where that is coarse: at the centre.
    inside = edges < fine[40]
    edges[inside] = np.interp(_shares(shells)[inside] * enclosed[-1], enclosed, fine**3) ** (1 / 3)
    mass, momentum = _filled(edges, *_cells(edges, len(cells.solid), star.density, star.rotation_rate), cells)
    matter = Matter(fluid.constant, fluid.gamma_1, fluid.nuclear_density, fluid.gamma_2, fluid.gamma_thermal)
    return Body(edges, mass, np.zeros_like(mass), momentum), matter


def at_rest(shells: int, cells: Angles) -> tuple[Body, Matter]:
    """The core G3 without rotation of tests/lagrangian_core.py, whose bounce is at 47.84 ms and 3.967e17 kg/m^3."""
    _, matter = core_collapse(60, cells)
    density = 1e13
    constant, star = 4.897e14 * 0.1 * 1e-3 ** (4 / 3), Polytrope(3.0)
    radius = 6.896848619 * np.sqrt(constant * density ** (-2 / 3) / (np.pi * G))
    mass = density * radius**3 / star.central_density
    edges = np.asarray(star.radius_enclosing(_shares(shells))) * radius
    edges[0] = 0.0
    masses = np.diff(_shares(shells))[:, None] * mass * cells.solid / (4 * np.pi)
    return Body(edges, masses, np.zeros_like(masses), np.zeros_like(masses)), matter


SCENES = {
    "pulsar_collapse": (pulsar_collapse, 0.12),
    "core_collapse": (core_collapse, 0.07),
    "at_rest": (at_rest, 0.07),
}


def main() -> None:
    """Print the bounce and the fall of the moment of inertia."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", choices=SCENES)
    parser.add_argument("--shells", type=int, default=300)
    parser.add_argument("--angles", type=int, default=25)
    parser.add_argument("--after", type=float, default=7e-3, help="s to follow it for after the bounce")
    parser.add_argument("--rows", type=Path, help="where to write all rows, as text")
    options = parser.parse_args()
    begun = clock.monotonic()
    cells = angles(options.angles, options.shells)
    make, end = SCENES[options.scene]
    body, matter = make(options.shells, cells)
    table, density, time, moment, steps = evolve(*body, matter, cells, end, 1e-4, 0.0, 0.0, options.after)
    if options.rows:
        np.savetxt(options.rows, table, header=" ".join(COLUMNS))
    least = int(table[:, 2].argmin())
    deepest = np.abs(table[:, 6]).max()
    print(f"{options.scene}, {options.shells} x {options.angles}: {steps} steps, {clock.monotonic() - begun:.0f} s")
    print(f"bounce at {1e3 * time:.3f} ms, {density:.4e} kg/m3, I {moment:.4e} of {table[0, 2]:.4e} kg m2")
    print(f"least I {table[least, 2]:.4e} at {1e3 * table[least, 0]:.2f} ms: fall {table[0, 2] / table[least, 2]:.4f}")
    print(f"energy {np.abs(table[:, 3] - table[0, 3]).max() / deepest:.1e} of the deepest binding, "
          f"angular momentum {np.abs(table[:, 4] / max(table[0, 4], 1e-300) - 1).max():.1e}; "
          f"T/|W| at first {table[0, 5] / -table[0, 6]:.4f}")  # fmt: skip


if __name__ == "__main__":
    main()
