"""A rolling race: which of a block on ice, a ball, a cylinder, a tube and a hoop reaches the foot of an incline first.

    python sims/rolling_race.py --incline 10 --distance 2 --output rolling_race.png

The order depends on I/(m R^2) alone, not on mass or size: the bodies here are of many sizes. Expected at any incline:
the block, which slides without friction and does not turn, then solid ball, capsule, solid cylinder, thin ball, thick
tube, hoop, and last the spool that rolls on its thin hub.
"""

import argparse
import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from astroinertia.inertia import shapes
from astroinertia.inertia.rolling import Finish, least_friction, rolling_coefficient, rolling_race
from astroinertia.plots import style

# Mass in kg and sizes in m, and the radius on which each rolls.
RUNNERS = {
    "solid ball": (shapes.solid_sphere(mass=4.0, radius=0.05), 0.05),
    "capsule": (shapes.capsule(mass=0.3, radius=0.02, length=0.06), 0.02),
    "solid cylinder": (shapes.cylinder(mass=1.0, radius=0.08, height=0.1), 0.08),
    "thin ball": (shapes.spherical_shell(mass=0.4, radius=0.11), 0.11),
    "thick tube": (shapes.thick_cylinder(mass=2.0, outer_radius=0.06, inner_radius=0.045, height=0.2), 0.06),
    "hoop": (shapes.hoop(mass=0.7, radius=0.3), 0.3),
    "spool on its hub": (
        shapes.thick_cylinder(mass=0.5, outer_radius=0.05, inner_radius=0.03, height=0.04)
        + shapes.cylinder(mass=0.5, radius=0.03, height=0.1),
        0.03,
    ),
}
BLOCK = "block on ice"  # nothing of its energy goes into turning: its I/(m R^2) is 0
GHOSTS = (0.25, 0.5, 0.75)  # of the winner's time, at which its and the others' places are drawn, too


def table(finishes: list[Finish], incline: float) -> str:
    """The ranking as text."""
    lines = [f"{'':3}{'body':18}{'I/(m R^2)':>10}{'time (s)':>10}{'speed (m/s)':>13}{'needs friction of':>19}"]
    for place, each in enumerate(finishes, 1):
        friction = float(least_friction(each.coefficient, incline))
        lines.append(
            f"{place:<3}{each.name:18}{each.coefficient:10.4f}{each.time:10.4f}{each.speed:13.4f}{friction:19.3f}"
        )
    return "\n".join(lines)


def picture(finishes: list[Finish], distance: float, incline: float) -> Figure:
    """Where each is when the first arrives, and into what the energy of the fall has gone."""
    with style.styled():
        figure = Figure(figsize=(11.0, 5.6), layout="constrained")
        figure.suptitle(
            f"Rolling race: {distance:g} m down an incline of {math.degrees(incline):g}°",
            x=0.012, ha="left", fontsize=13, fontweight="bold", color=style.INK,
        )  # fmt: skip
        lanes, shares = figure.subplots(1, 2, width_ratios=[3.2, 1.3], sharey=True)
        rows = np.arange(len(finishes))[::-1]
        _lanes(lanes, finishes, rows, distance)
        rolling = np.array([each.coefficient / (1 + each.coefficient) for each in finishes])
        shares.barh(rows, 100 * (1 - rolling), height=0.5, color=style.BLUE, label="motion")
        shares.barh(rows, 100 * rolling, left=100 * (1 - rolling), height=0.5, color=style.ORANGE, label="spin")
        shares.set(xlim=(0, 100), xlabel="share of the kinetic energy (%)")
        shares.set_title("Where the energy goes")
        shares.grid(False, axis="y")
        shares.tick_params(axis="y", length=0)
        shares.legend(loc="upper left", bbox_to_anchor=(0.0, -0.13), ncols=2, borderaxespad=0)
        return figure


def _lanes(axes, finishes: list[Finish], rows: np.ndarray, distance: float) -> None:
    first = finishes[0].time
    size = 0.36  # of the discs, in rows; true sizes would be too small to see, and do not matter
    axes.set(xlim=(-0.03 * distance, 1.16 * distance), ylim=(-0.6, len(rows) - 0.4))
    axes.set_yticks(rows, [f"{each.name}\n$I/(mR^2)$ = {each.coefficient:.3f}" for each in finishes])
    axes.tick_params(axis="y", length=0)
    axes.grid(False, axis="y")
    axes.axvline(distance, color=style.VERMILLION, linewidth=1.6, zorder=1)
    for row, each in zip(rows, finishes, strict=True):
        axes.axhline(row - size, color=style.PALE, linewidth=1, zorder=0.5)
        for share in (*GHOSTS, 1.0):
            place = distance * (share * first / each.time) ** 2
            _mark(
                axes,
                place,
                row,
                size,
                None if each.name == BLOCK else place / distance,
                alpha=1.0 if share == 1.0 else 0.25,
            )
        axes.annotate(
            f"{each.time:.3f} s", (1.155 * distance, row), ha="right", va="center", fontsize=10,
            fontweight="bold" if each is finishes[0] else "normal", color=style.INK,
        )  # fmt: skip
    axes.set_xlabel("distance down the incline (m)")
    axes.set_title("When the first arrives, and at a quarter, half and three quarters of its time")


def _mark(axes, x: float, row: float, size: float, turned: float | None, alpha: float) -> None:
    """A round disc in axes whose two scales differ, with a line that shows its turns; a square if it slides."""
    figure = axes.get_figure()
    height = figure.get_size_inches()[1]
    # Points per row, as the layout will have them within a few per cent; markers are round by nature.
    points = 2 * size * 0.77 * height * 72 / np.ptp(axes.get_ylim())
    shape = "s" if turned is None else "o"
    axes.plot(
        x,
        row,
        shape,
        markersize=points,
        color=style.SKY,
        markeredgecolor=style.BLUE,
        alpha=alpha,
        zorder=2,
        linestyle="",
    )
    if turned is None:
        return
    axes.plot(
        x, row, marker=(2, 0, -360.0 * 2 * turned), markersize=points, markeredgecolor=style.INK, alpha=alpha, zorder=3
    )


def main() -> None:
    """Run the race, print the ranking and save the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--incline", type=float, default=10.0, help="in degrees (default: 10)")
    parser.add_argument("--distance", type=float, default=2.0, help="in metres (default: 2)")
    parser.add_argument("--output", type=Path, help="a PNG to write")
    chosen = parser.parse_args()
    if not 0 < chosen.incline < 90 or not 0 < chosen.distance < math.inf:
        parser.error("the incline must be between 0 and 90 degrees, and the distance above 0")
    incline = math.radians(chosen.incline)
    coefficients = {BLOCK: 0.0} | {
        name: float(rolling_coefficient(body, radius)) for name, (body, radius) in RUNNERS.items()
    }
    finishes = rolling_race(coefficients, chosen.distance, incline)
    print(table(finishes, incline))
    if chosen.output:
        print(f"picture: {style.save(picture(finishes, chosen.distance, incline), chosen.output)}")


if __name__ == "__main__":
    main()
