"""A wheel is balanced: weights in two planes bring its bearing forces to zero, and real weights nearly so.

The wheel of a car, with a valve, a heavy spot in the tyre, a weld and a bore in the rim, none of them in the middle of
its width. Its static unbalance shakes the axle and its products of inertia I_xz and I_yz make it wobble; I_xy does not
matter. Two corrections, one at each edge of the rim, undo both exactly. A workshop has clips of a few sizes and places
to put them: of all the ways to use those the best is found.

At 1000 revolutions a minute the wheel as it stands pulls on its bearings with 109 and 9 N that turn with it; with the
exact corrections, 14 g and 63 g, with less than 1e-12 N; with four clips of the usual sizes with 7 and 10 N. A picture
is saved of the wheel before and with the clips.
"""

import argparse
from pathlib import Path

import numpy as np

from astroinertia.inertia import balancing
from astroinertia.inertia.body import Body
from astroinertia.inertia.solids import thick_cylinder
from astroinertia.plots import style
from astroinertia.plots.balance import balance_figure

EDGES = (-0.09, 0.09)  # m along the axle, from the middle of the rim
BEARINGS = (0.06, 0.14)  # both on the inner side
RIM = 0.20  # radius where weights are fixed
PLACES = 10  # round each edge
MOST = 4  # clips
CLIPS = (0.005, 0.01, 0.015, 0.02, 0.03, 0.04, 0.06)  # kg
PARTS = {  # mass in kg, radius in m, angle in degrees, place along the axle in m
    "valve": (0.035, 0.21, 0.0, -0.07),
    "heavy spot of the tyre": (0.060, 0.31, 140.0, 0.05),
    "weld": (0.020, 0.19, 250.0, 0.02),
    "bore": (-0.030, 0.15, 80.0, -0.02),
}


def point(mass: float, radius: float, angle: float, place: float) -> Body:
    """A small mass at a radius, an angle (radians) and a place along the axle; negative: taken away."""
    return Body(np.asarray(mass), np.array([radius * np.cos(angle), radius * np.sin(angle), place]), np.zeros((3, 3)))


def wheel() -> Body:
    """The wheel before it is balanced, in kg and m, its axle along z."""
    body = thick_cylinder(18.0, 0.32, 0.17, 0.2)
    for mass, radius, angle, place in PARTS.values():
        body = body + point(mass, radius, np.radians(angle), place)
    return body


def exact(body: Body, remove: bool) -> tuple[Body, list[str]]:
    """The wheel with a correction at each edge, added or taken away; and what was done."""
    correction = balancing.two_plane_correction(*balancing.unbalance_of_body(body), EDGES)
    masses, angles = balancing.correction_masses(correction, np.full(2, RIM), remove=remove)
    done = []
    for mass, angle, edge in zip(masses, angles, EDGES, strict=True):
        body = body + point(-mass if remove else mass, RIM, angle, edge)
        done.append(f"{1000 * mass:.2f} g {'off' if remove else 'on'} at {np.degrees(angle) % 360:.1f} degrees")
    return body, done


def clipped(body: Body) -> tuple[Body, list[str]]:
    """The wheel with the few clips that do best, and where they are."""
    angles = np.tile(2 * np.pi * np.arange(PLACES) / PLACES, 2)
    places = np.repeat(EDGES, PLACES)
    best = balancing.best_holes(
        *balancing.unbalance_of_body(body), EDGES, np.full(2 * PLACES, RIM), angles, places, CLIPS, MOST
    )
    done = []
    for edge in EDGES:
        used = [k for k in np.flatnonzero(best.mass) if places[k] == edge]
        done.append(
            ", ".join(f"{1000 * best.mass[k]:g} g at {np.degrees(angles[k]):g} degrees" for k in used) or "none"
        )
    for mass, angle, place in zip(best.mass, angles, places, strict=True):
        if mass:
            body = body + point(mass, RIM, angle, place)
    return body, done


def figures(body: Body, rate: float) -> dict[str, float]:
    """What a table has of a wheel: products of inertia, eccentricity and bearing forces."""
    inertia = body.about(np.zeros(3))
    forces = np.linalg.norm(balancing.bearing_forces(*balancing.unbalance_of_body(body), rate, BEARINGS), axis=1)
    return {
        "I_xz (kg m2)": inertia[0, 2],
        "I_yz (kg m2)": inertia[1, 2],
        "I_xy (kg m2), harmless": inertia[0, 1],
        "centre off the axle (mm)": 1000 * float(np.hypot(*body.centre[:2])),
        "force on the inner bearing (N)": forces[1],
        "force on the outer bearing (N)": forces[0],
    }


def main() -> None:
    """Balance the wheel, print the figures, save the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speed", type=float, default=1000.0, help="revolutions a minute (default: 1000)")
    parser.add_argument("--remove", action="store_true", help="take mass away instead of adding it")
    parser.add_argument("--output", type=Path, default=Path("balanced_wheel.png"), help="where the picture goes")
    options = parser.parse_args()
    rate = 2 * np.pi * options.speed / 60
    before = wheel()
    balanced, cut = exact(before, options.remove)
    practical, clips = clipped(before)
    columns = [figures(body, rate) for body in (before, balanced, practical)]
    print(f"{f'at {options.speed:g} revolutions a minute':34}{'before':>12}{'corrected':>12}{'with clips':>12}")
    for name in columns[0]:
        print(f"{name:34}" + "".join(f"{column[name]:12.3g}" for column in columns))
    for name, done in (("corrections", cut), ("clips", clips)):
        for edge, what in zip(EDGES, done, strict=True):
            print(f"{name} at {1000 * edge:+.0f} mm: {what}")
    print(f"picture: {style.save(balance_figure(before, practical, name='wheel'), options.output)}")


if __name__ == "__main__":
    main()
