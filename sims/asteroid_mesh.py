"""An irregular asteroid from a closed triangular mesh: mass, principal moments and axes, and the axis it settles about.

    python sims/asteroid_mesh.py --output asteroid.png
    python sims/asteroid_mesh.py --mesh shape.obj --scale 1000 --density 1190

Without --mesh the asteroid is made here: an elongated ellipsoid with random hills and craters. The integrals over the
mesh are exact. With energy lost inside it, at constant angular momentum, any body ends spinning about the axis of its
largest moment, the shortest axis of its shape. Expected without options: a mass of 9.72e10 kg, a ratio of largest to
smallest moment of 1.75, and that axis 2.5 degrees from the shortest axis of the ellipsoid, z.
"""

import argparse
import math
from pathlib import Path

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from matplotlib.patheffects import withStroke

from astroinertia.errors import AstroinertiaError
from astroinertia.inertia.body import Body
from astroinertia.inertia.mesh import icosphere, mesh_body, read_mesh
from astroinertia.inertia.principal import principal_frame
from astroinertia.inertia.tensor import equivalent_semi_axes
from astroinertia.plots import style

SEMI_AXES = np.array([290.0, 215.0, 175.0])  # m
HILLS, HILL_HEIGHT, WIDTHS = 400, 0.05, (0.07, 0.7)  # bumps; height of a bump over its width; widths in radians
CRATERS, CRATER_SIZES, CRATER_DEPTH = 22, (0.10, 0.42), 0.22  # radii in radians; depth over radius
RIM_WIDTH, RIM_HEIGHT = 0.35, 0.25  # of a crater: over its radius, over its depth
DENSITY = 2150.0  # kg/m^3, a pile of stony rubble
SEED, SUBDIVISIONS = 7, 6
AXIS_COLOURS = (style.GREEN, style.ORANGE, style.VERMILLION)  # of the smallest, middle and largest moment
VIEW = np.radians([35.0, 22.0])  # azimuth and elevation of the eye
LIGHT = np.array([-0.60, 0.50, 0.62])  # towards the sun, in the eye's axes: right, up, to the eye
ROCK = LinearSegmentedColormap.from_list("rock", ["#1f1b18", "#6e645b", "#b7aca0", "#eae4dc"])


def asteroid(subdivisions: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices in m, and faces: an icosphere stretched to SEMI_AXES with random hills and craters along its radii."""
    directions, faces = icosphere(subdivisions)
    random = np.random.default_rng(seed)
    relief = np.zeros(len(directions))
    for centre, width in zip(_directions(random, HILLS), _sizes(random, WIDTHS, HILLS), strict=True):
        relief += HILL_HEIGHT * width * random.normal() * np.exp((directions @ centre - 1) / width**2)
    for centre, size in zip(_directions(random, CRATERS), _sizes(random, CRATER_SIZES, CRATERS), strict=True):
        away = np.arccos(np.clip(directions @ centre, -1, 1)) / size
        bowl = -CRATER_DEPTH * size * np.clip(1 - away**2, 0, None)
        rim = RIM_HEIGHT * CRATER_DEPTH * size * np.exp(-(((away - 1) / RIM_WIDTH) ** 2))
        relief += bowl + rim
    return directions * SEMI_AXES * (1 + relief)[:, None], faces


def _directions(random: np.random.Generator, count: int) -> np.ndarray:
    """Random unit vectors (count, 3)."""
    vectors = random.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _sizes(random: np.random.Generator, limits: tuple[float, float], count: int) -> np.ndarray:
    """Random sizes between two limits: many small ones, few large ones."""
    small, large = limits
    return small * (large / small) ** random.uniform(size=count) ** 2


def report(body: Body, faces: int, density: float) -> str:
    """What the mesh says of the asteroid."""
    moments, axes = principal_frame(body.inertia)
    semi_axes = equivalent_semi_axes(body.mass, moments)
    volume = float(body.mass) / density
    radius = (3 * volume / (4 * math.pi)) ** (1 / 3)
    lines = [
        f"facets                         {faces}",
        f"mass                           {body.mass:.6g} kg",
        f"radius of a sphere as large    {radius:.6g} m",
        f"centre of mass                 ({body.centre[0]:.4g}, {body.centre[1]:.4g}, {body.centre[2]:.4g}) m",
        "",
        f"{'axis':10}{'moment (kg m2)':>16}{'I/(M R^2)':>12}{'semi-axis (m)':>15}   direction",
    ]
    for name, moment, axis, semi in zip(("smallest", "middle", "largest"), moments, axes, semi_axes, strict=True):
        direction = ", ".join(f"{part:+.4f}" for part in axis)
        lines.append(f"{name:10}{moment:16.6e}{moment / (body.mass * radius**2):12.5f}{semi:15.2f}   ({direction})")
    tilt = math.degrees(math.acos(min(1.0, abs(axes[2, 2]))))
    return "\n".join([
        *lines,
        "",
        f"It settles about the axis of the largest moment, {tilt:.2f} degrees from z. Spin about the smallest is",
        "stable only while nothing dissipates, and about the middle one never. Semi-axes are those of the homogeneous",
        "ellipsoid with the same mass and moments.",
    ])  # fmt: skip


def picture(vertices: np.ndarray, faces: np.ndarray, body: Body) -> Figure:
    """The asteroid with its principal axes, at a slant and from the pole that it settles about."""
    moments, axes = principal_frame(body.inertia)
    places = (vertices - body.centre) @ axes.T  # in its own principal axes
    azimuth, elevation = VIEW
    to_eye = [math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)]
    right = [-math.sin(azimuth), math.cos(azimuth), 0.0]
    slanted = np.array([right, np.cross(to_eye, right), to_eye])
    with style.styled():
        figure = Figure(figsize=(11.5, 5.4), layout="constrained")
        figure.suptitle(
            f"Asteroid of {len(faces)} facets, {style.number(float(body.mass))} kg",
            x=0.012, ha="left", fontsize=13, fontweight="bold", color=style.INK,
        )  # fmt: skip
        left, pole = figure.subplots(1, 2)
        reach = 1.42 * abs(places).max()
        for panel, view in ((left, slanted), (pole, np.eye(3))):
            _rock(panel, places, faces, view)
            _axes(panel, places, view)
            panel.set(xlim=(-reach, reach), ylim=(-0.84 * reach, 0.84 * reach), aspect="equal")
            panel.set_axis_off()
        left.set_title("Principal axes; it settles about that of the largest moment", loc="left")
        pole.set_title("From that pole, with the ellipsoid of the same mass and moments", loc="left")
        a, b, _ = equivalent_semi_axes(body.mass, moments)
        pole.add_patch(
            Ellipse((0, 0), 2 * a, 2 * b, fill=False, color=style.BLUE, linewidth=1.6, linestyle="--", zorder=5)
        )
        bar = 10.0 ** math.floor(math.log10(0.5 * reach))
        low = -0.8 * reach
        left.plot(
            [-0.95 * reach, -0.95 * reach + bar], [low, low], color=style.INK, linewidth=2.5, solid_capstyle="butt"
        )
        left.annotate(f"{bar:g} m", (-0.95 * reach + bar, low), (6, 0), textcoords="offset points", va="center")
        return figure


def _rock(panel, places: np.ndarray, faces: np.ndarray, view: np.ndarray) -> None:
    """The faces that look at the eye, farthest first, lit by the sun."""
    corners = (places @ view.T)[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    front = normals[:, 2] > 0
    order = np.argsort(corners[front].mean(1)[:, 2])
    light = np.clip(normals[front] @ (LIGHT / np.linalg.norm(LIGHT)), 0, None)
    colours = ROCK(0.10 + 0.86 * light[order])
    panel.add_collection(
        PolyCollection(corners[front][order, :, :2], facecolors=colours, edgecolors=colours, linewidths=0.3, zorder=3)
    )


def _axes(panel, places: np.ndarray, view: np.ndarray) -> None:
    """The ends of the axes that stand out of the rock, hidden where they are behind it."""
    distances = np.linalg.norm(places, axis=1)
    for k, colour in enumerate(AXIS_COLOURS):
        for sign in (1.0, -1.0):
            direction = sign * np.eye(3)[k]
            surface = distances[np.argmax(places @ direction / distances)]
            ends = np.outer([surface, surface + 0.38 * abs(places).max()], direction) @ view.T
            if abs(ends[1] - ends[0])[:2].max() < 0.02 * surface:
                continue  # seen end on
            towards_the_eye = direction @ view[2] >= 0
            panel.plot(
                *ends[:, :2].T, color=colour, linewidth=3.4 if k == 2 else 2.2, zorder=4 if towards_the_eye else 2
            )
            if sign > 0:
                name = f"$I_{k + 1}$" + (", stable" if k == 2 else "")
                outwards = ends[1, :2] / np.linalg.norm(ends[1, :2])
                panel.annotate(
                    name, ends[1, :2], 13 * outwards, textcoords="offset points", color=colour, fontsize=11, zorder=6,
                    ha="center", va="center",
                    path_effects=[withStroke(linewidth=2.5, foreground="white")],
                )  # fmt: skip


def main() -> None:
    """Make or read the mesh, print what it weighs, and save the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", type=Path, help="a closed mesh to read instead (STL, OBJ, PLY, OFF); needs trimesh")
    parser.add_argument("--scale", type=float, default=1.0, help="metres in a unit of length of that mesh (default: 1)")
    parser.add_argument("--density", type=float, default=DENSITY, help=f"in kg/m^3 (default: {DENSITY:g})")
    parser.add_argument("--subdivisions", type=int, default=SUBDIVISIONS, choices=range(8), help="20 * 4^n facets")
    parser.add_argument("--seed", type=int, default=SEED, help="of the hills and craters")
    parser.add_argument("--output", type=Path, help="a PNG to write")
    chosen = parser.parse_args()
    try:
        vertices, faces = read_mesh(chosen.mesh) if chosen.mesh else asteroid(chosen.subdivisions, chosen.seed)
        vertices = vertices * chosen.scale
        body = mesh_body(vertices, faces, density=chosen.density)
    except (AstroinertiaError, ValueError) as wrong:
        parser.error(str(wrong))
    print(report(body, len(faces), chosen.density))
    if chosen.output:
        print(f"picture: {style.save(picture(vertices, faces, body), chosen.output)}")


if __name__ == "__main__":
    main()
