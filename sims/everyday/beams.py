"""Second moments of area and the deflection of beams: why an I-beam is used on edge.

    python sims/everyday/beams.py --length 2 --load 500 --output beams.png

A plate whose mass is its area has the second moments of area of a section as its second moments of mass, parallel axes
and holes included. Beams of equal area, clamped at one end and loaded at the other, sag by F L^3/(3 E J); along a
direction between the principal axes of the section they sag sideways, too.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from scipy.integrate import solve_bvp

from astroinertia.inertia import shapes
from astroinertia.inertia.tensor import second_moment_from_inertia
from astroinertia.plots import style

STEEL = 210e9  # Pa
AREA = 0.0012  # m^2, of every section


def rectangle(width: float, height: float) -> np.ndarray:
    """Corners (4, 2) round the origin."""
    return 0.5 * np.array([[-width, -height], [width, -height], [width, height], [-width, height]])


def sections() -> dict[str, np.ndarray]:
    """Outlines of equal area in m, x across and y up."""
    flange, web, thick = 0.06, 0.08, 0.006
    i_beam = np.array([
        [-flange / 2, -web / 2 - thick], [flange / 2, -web / 2 - thick], [flange / 2, -web / 2], [thick / 2, -web / 2],
        [thick / 2, web / 2], [flange / 2, web / 2], [flange / 2, web / 2 + thick], [-flange / 2, web / 2 + thick],
        [-flange / 2, web / 2], [-thick / 2, web / 2], [-thick / 2, -web / 2], [-flange / 2, -web / 2],
    ])  # fmt: skip
    leg = 0.09
    angle = np.array([[0, 0], [leg, 0], [leg, 0.008], [0.008, 0.008], [0.008, leg], [0, leg]])
    circle = np.linspace(0, 2 * np.pi, 361)[:-1]
    shapes_ = {
        "flat bar": rectangle(0.06, 0.02),
        "round bar": np.stack([np.cos(circle), np.sin(circle)], -1),
        "on edge": rectangle(0.02, 0.06),
        "angle": angle,
        "I-beam": i_beam,
    }
    return {name: _of_area(outline) for name, outline in shapes_.items()}


def _of_area(outline: np.ndarray) -> np.ndarray:
    x, y = outline.T
    area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    return outline * np.sqrt(AREA / area)


def area_moments(outline: np.ndarray) -> np.ndarray:
    """The tensor (2, 2) of second moments of area about the centroid: integrals of x x, x y and y y, in m^4."""
    plate = shapes.polygon_plate(AREA, outline)  # a mass of 1 kg/m^2
    return second_moment_from_inertia(plate.inertia)[:2, :2]


def tip(moments: np.ndarray, length: float, load: float) -> np.ndarray:
    """Where the loaded end goes (2,): the curvature along a direction is set by the tensor's inverse."""
    return np.linalg.solve(moments, np.array([0.0, -load])) * length**3 / (3 * STEEL)


def bent(moments: np.ndarray, length: float, load: float) -> np.ndarray:
    """The same, from the curve of the beam itself: u'' = bending moment/(E J), u = u' = 0 at the clamp."""
    curvature = np.linalg.solve(moments, np.array([0.0, -load])) / STEEL

    def slopes(z: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.concatenate([u[2:], curvature[:, None] * (length - z)])

    solved = solve_bvp(
        slopes, lambda start, _: start, np.linspace(0, length, 11), np.zeros((4, 11)), tol=1e-10, bc_jac=None
    )
    return solved.y[:2, -1]


def picture(moments: dict[str, np.ndarray], length: float, load: float) -> Figure:
    """The sections, and the curves of their beams."""
    with style.styled():
        figure = style.page(
            f"Beams of steel, {1e4 * AREA:g} cm² and {length:g} m, with {load:g} N at the end", (11.0, 5.4)
        )
        top, bottom = figure.subfigures(2, 1, height_ratios=[1, 1.5])
        outlines = sections()
        colours = (style.ORANGE, style.SKY, style.GREEN, style.PURPLE, style.BLUE)
        axes = bottom.subplots()
        z = np.linspace(0, length, 100)
        for panel, (name, outline), colour in zip(
            top.subplots(1, len(outlines)), outlines.items(), colours, strict=True
        ):
            centred = 100 * (outline - shapes.polygon_plate(AREA, outline).centre[:2])
            panel.add_patch(PathPatch(Outline(np.concatenate([centred, centred[:1]])), color=colour))
            panel.set(xlim=(-6, 6), ylim=(-6, 6), aspect="equal", title=f"{name}: {1e8 * moments[name][1, 1]:.2f} cm⁴")
            panel.axis("off")
            sag = tip(moments[name], length, load)[1]
            shape = (3 * length * z**2 - z**3) / (2 * length**3)
            axes.plot(z, 1000 * sag * shape, color=colour, label=f"{name}, {-1000 * sag:.1f} mm")
        axes.set(xlabel="from the clamp (m)", ylabel="deflection (mm)", xlim=(0, length))
        axes.legend()
        return figure


def main() -> None:
    """Print the table of the sections and save the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--length", type=float, default=2.0, help="in metres (default: 2)")
    parser.add_argument("--load", type=float, default=500.0, help="in newtons (default: 500)")
    parser.add_argument("--output", type=Path, help="a PNG to write")
    chosen = parser.parse_args()
    if chosen.length <= 0 or chosen.load <= 0:
        parser.error("the length and the load must be above 0")
    moments = {name: area_moments(outline) for name, outline in sections().items()}
    print(f"{'section':12}{'J (cm4)':>10}{'product':>10}{'down (mm)':>12}{'sideways':>10}{'by the curve':>14}")
    for name, tensor in moments.items():
        sideways, down = 1000 * tip(tensor, chosen.length, chosen.load)
        curve = 1000 * bent(tensor, chosen.length, chosen.load)[1]
        moment, product = 1e8 * tensor[1, 1], 1e8 * tensor[0, 1] + 0.0
        print(f"{name:12}{moment:10.3f}{product:10.3f}{-down:12.3f}{sideways:10.3f}{-curve:14.3f}")
    if chosen.output:
        print(f"picture: {style.save(picture(moments, chosen.length, chosen.load), chosen.output)}")


if __name__ == "__main__":
    main()
