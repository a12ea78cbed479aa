"""Bodies that move their limbs: a skater, a diver, a falling cat, a rope walker's pole and a runner's leg.

    python sims/everyday/limbs.py --output limbs.png

Nothing turns the first three from outside: their angular momentum is kept. The skater and the diver have some, and turn
faster as limbs come in. The cat has none; it bends in the middle, turns its two halves against the bend and lands on
its feet. A pole slows the fall of a rope walker, and a bent leg swings with less than half the moment of inertia.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import cumulative_simpson
from scipy.optimize import brentq

from astroinertia.inertia import shapes
from astroinertia.inertia.jointed import Limb, free_turning, posture
from astroinertia.inertia.rolling import STANDARD_GRAVITY
from astroinertia.plots import style

ARM = shapes.rod(4.0, 0.7)
THIGH, SHANK = shapes.cylinder(10.0, 0.07, 0.42), shapes.cylinder(5.0, 0.05, 0.48)


def skater() -> list[Limb]:
    """A trunk along z, and arms that hang down when their joints are at 0."""
    trunk = Limb(shapes.cylinder(48.0, 0.14, 1.6))
    arms = [
        Limb(ARM.translated((side * 0.2, 0, 0.2)), (side * 0.2, 0, 0.55), (0, -side, 0), parent=0) for side in (-1, 1)
    ]
    return [trunk, *arms]


def diver() -> list[Limb]:
    """Trunk, both thighs and both shanks in a plane, straight when the joints are at 0."""
    trunk = Limb(shapes.cylinder(40.0, 0.14, 0.85))
    thighs = Limb((THIGH + THIGH).translated((0, 0, -0.635)), (0, 0, -0.425), (0, 1, 0), parent=0)
    shanks = Limb((SHANK + SHANK).translated((0, 0, -1.085)), (0, 0, -0.845), (0, 1, 0), parent=1)
    return [trunk, thighs, shanks]


def cat(bend: float) -> list[Limb]:
    """A waist without mass and two halves, bent from a straight line by `bend`, that turn about their own lengths."""
    half, length = shapes.cylinder(1.8, 0.06, 0.25), 0.125
    waist = Limb(shapes.solid_sphere(1e-9, 0.01))
    halves = []
    for side in (-1, 1):
        way = np.array([side * np.cos(bend / 2), 0.0, -np.sin(bend / 2)])
        turn = np.array([[way[2], 0, way[0]], [0, 1, 0], [-way[0], 0, way[2]]])  # z to the way of the half
        halves.append(Limb(half.rotated(turn).translated(length * way), axis=tuple(way), parent=0))
    return [waist, *halves]


def smooth(time: float, start: float, end: float) -> tuple[float, float]:
    """A step from 0 to 1 between two times, and its rate."""
    share = np.clip((time - start) / (end - start), 0.0, 1.0)
    return share**2 * (3 - 2 * share), 6 * share * (1 - share) / (end - start)


def arms_in(time: float) -> tuple[np.ndarray, np.ndarray]:
    """The skater's joints: arms from level to 8 degrees from the body, between 1 and 2 s."""
    value, rate = smooth(time, 1.0, 2.0)
    level, low = np.radians(90), np.radians(8)
    return np.array([0, 1, 1]) * (level + (low - level) * value), np.array([0, 1, 1]) * (low - level) * rate


def tuck(time: float) -> tuple[np.ndarray, np.ndarray]:
    """The diver's joints: into a tuck at 0.3 s and out of it from 1.1 s."""
    (into, faster), (out, slower) = smooth(time, 0.3, 0.5), smooth(time, 1.1, 1.3)
    joints = np.array([0.0, np.radians(-125), np.radians(130)])
    return joints * (into - out), joints * (faster - slower)


def righting(time: float) -> tuple[np.ndarray, np.ndarray]:
    """The cat's joints: both halves turn once about their own lengths, the same way along the spine, in 0.5 s."""
    value, rate = smooth(time, 0.0, 0.5)
    along = 2 * np.pi * np.array([0, -1, 1])
    return value * along, rate * along


def moved(limbs: list[Limb], joints: Callable, times: np.ndarray, axis: int, momentum: float) -> dict[str, np.ndarray]:
    """Moment and angular velocity about one axis and by how much the trunk has turned about it, at the times."""
    vector = momentum * np.eye(3)[axis]
    _, rates = free_turning(limbs, joints, times, vector)
    moments = np.array([posture(limbs, *joints(time)).whole.inertia[axis, axis] for time in times])
    return {"time": times, "moment": moments, "rate": rates[:, axis], "angle": cumulative_simpson(
        rates[:, axis], x=times, initial=0)}  # fmt: skip


def landing_bend() -> float:
    """The bend with which one turn of the halves turns the cat by 180 degrees: halves are round, so h/I is steady."""

    def missing(bend: float) -> float:
        turning = posture(cat(bend), np.zeros(3), np.array([0, -2 * np.pi, 2 * np.pi]))
        return abs(turning.relative_momentum[0] / turning.whole.inertia[0, 0]) - np.pi

    return brentq(missing, 0.5, 2.5)


def fall_time(pole: float) -> float:
    """sqrt(I/(m g h)) of a walker on a rope with a pole of so many kg, 9 m long, at the height of the hands."""
    walker = shapes.cylinder(65.0, 0.15, 1.7).translated((0, 0, 0.95))
    body = walker + shapes.rod(pole, 9.0).rotated(np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])).translated((0, 0, 1.0))
    return float(np.sqrt(body.moment((0, 1, 0), (0, 0, 0)) / (body.mass * STANDARD_GRAVITY * body.centre[2])))


def leg(knee: float) -> float:
    """The moment of inertia (kg m2) of a leg about the hip, with the knee bent by an angle in degrees."""
    limbs = [
        Limb(THIGH.translated((0, 0, -0.21))),
        Limb(SHANK.translated((0, 0, -0.66)), (0, 0, -0.42), (0, 1, 0), parent=0),
    ]
    return float(posture(limbs, [0, np.radians(knee)]).whole.moment((0, 1, 0), (0, 0, 0)))


def picture(skating: dict, diving: dict, falling: dict) -> Figure:
    """Moments and rates against time of the three that are free; fall times and leg against pole and knee."""
    with style.styled():
        figure = style.page("Limbs that move change the spin", (11.0, 7.0))
        panels = figure.subplots(2, 3)
        for axes, of, title in ((panels[0, 0], skating, "A skater"), (panels[0, 1], diving, "A diver")):
            axes.plot(of["time"], of["rate"] / of["rate"][0], color=style.BLUE, label="spin of the trunk")
            axes.plot(of["time"], of["moment"] / of["moment"][0], color=style.VERMILLION, label="moment of inertia")
            axes.set(xlabel="time (s)", ylabel="over that at the start", title=title)
            axes.legend()
        cat_axes, turns, pole, knee = panels[0, 2], panels[1, 0], panels[1, 1], panels[1, 2]
        cat_axes.plot(falling["time"], np.degrees(abs(falling["angle"])), color=style.BLUE)
        cat_axes.set(xlabel="time (s)", ylabel="turned (°)", title="A cat, without angular momentum")
        turns.plot(diving["time"], diving["angle"] / (2 * np.pi), color=style.BLUE)
        turns.set(xlabel="time (s)", ylabel="somersaults", title="The diver's turns")
        masses = np.linspace(0.01, 20, 100)
        pole.plot(masses, [fall_time(mass) for mass in masses], color=style.BLUE)
        pole.set(xlabel="mass of a pole of 9 m (kg)", ylabel="time of an e-fold (s)", title="A rope walker's fall")
        angles = np.linspace(0, 140, 100)
        knee.plot(angles, [leg(angle) for angle in angles], color=style.BLUE)
        knee.set(
            xlabel="bend of the knee (°)", ylabel="I about the hip (kg m²)", title="A runner's leg", ylim=(0, None)
        )
        return figure


def main() -> None:
    """Move the limbs, print what they do, and save the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, help="a PNG to write")
    chosen = parser.parse_args()
    skating = moved(skater(), arms_in, np.linspace(0, 3, 151), 2, 15.0)
    diving = moved(diver(), tuck, np.linspace(0, 1.5, 151), 1, 60.0)
    bend = landing_bend()
    falling = moved(cat(bend), righting, np.linspace(0, 0.5, 101), 0, 0.0)
    for name, of in (("skater", skating), ("diver", diving)):
        print(
            f"{name}: {of['moment'].max():.3f} to {of['moment'].min():.3f} kg m2, "
            f"{of['rate'][0]:.3f} rad/s at first, {of['rate'].max():.3f} at most"
        )
    print(f"diver: {diving['angle'][-1] / (2 * np.pi):.3f} turns, straight {diving['rate'][0] * 1.5 / (2 * np.pi):.3f}")
    print(
        f"cat: bent by {np.degrees(bend):.2f} degrees it turns by {np.degrees(abs(falling['angle'][-1])):.2f} degrees"
    )
    print(f"rope walker: {fall_time(1e-9):.3f} s an e-fold, {fall_time(12.0):.3f} s with a pole of 12 kg")
    print(f"runner's leg: {leg(0):.3f} kg m2 straight, {leg(110):.3f} with the knee bent by 110 degrees")
    if chosen.output:
        print(f"picture: {style.save(picture(skating, diving, falling), chosen.output)}")


if __name__ == "__main__":
    main()
