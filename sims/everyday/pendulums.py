"""A physical pendulum, Kater's reversible one, and the sweet spot of a bat: all three are I/(m h).

    python sims/everyday/pendulums.py --output pendulums.png

A bar with a sliding bob swings on either of two knife edges. Its period depends on where the edge is, and is the same
at two distances from the centre of mass whose sum is the length of the simple pendulum; where the bob makes the two
periods equal, gravity follows from that length alone. A bat that is hit at the same distance from the hand does not
sting it.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq

from astroinertia.inertia import shapes
from astroinertia.inertia.body import Body
from astroinertia.inertia.pivoted import kater_gravity, pendulum_length, pendulum_period, pivot_impulse
from astroinertia.plots import style

EDGES = (0.5, -0.5)  # m, places of the knife edges on the bar, which is 1.6 m long
GRIP = 0.15  # m from the knob of the bat, where the hands turn it


def kater_bar(place: float) -> Body:
    """A steel bar along z with a fixed bob at its lower end and one that slides, in kg and m."""
    bar = shapes.box(1.2, 0.03, 0.005, 1.6)
    bob = shapes.cylinder(1.4, 0.05, 0.02)
    return bar + bob.translated((0.0, 0.0, -0.65)) + bob.translated((0.0, 0.0, place))


def arms(bar: Body) -> tuple[float, float]:
    """How far the centre of mass is from either edge."""
    return EDGES[0] - bar.centre[2], bar.centre[2] - EDGES[1]


def periods(bar: Body) -> tuple[float, float]:
    """The two periods, of small swings."""
    return tuple(float(pendulum_period(bar, (0.0, 0.0, edge))) for edge in EDGES)


def bat() -> Body:
    """A wooden bat of 0.9 kg and 84 cm along z, its knob at z = 0: a handle, a taper and a barrel."""
    density = 0.9 / (np.pi * (0.0125**2 * 0.34 + (0.0125**2 + 0.0125 * 0.033 + 0.033**2) / 3 * 0.25 + 0.033**2 * 0.25))
    handle = shapes.cylinder(density * np.pi * 0.0125**2 * 0.34, 0.0125, 0.34).translated((0.0, 0.0, 0.17))
    # A frustum has its centre of mass at the origin: its narrow end, which is up, is turned down.
    cone = shapes.frustum(density * np.pi * (0.0125**2 + 0.0125 * 0.033 + 0.033**2) / 3 * 0.25, 0.033, 0.0125, 0.25)
    high = 0.25 * (0.033**2 + 2 * 0.033 * 0.0125 + 3 * 0.0125**2) / (0.033**2 + 0.033 * 0.0125 + 0.0125**2) / 4
    taper = cone.translated((0.0, 0.0, 0.34 + 0.25 - high))
    barrel = shapes.cylinder(density * np.pi * 0.033**2 * 0.25, 0.033, 0.25).translated((0.0, 0.0, 0.715))
    return handle + taper + barrel


def picture(place: float) -> Figure:
    """Periods against the edge and the amplitude, Kater's bob, and the share of a blow that the hands feel."""
    with style.styled():
        figure = style.page("Pendulums, and what they have in common with a bat", (11.0, 7.2))
        (edge, swing), (bob, blow) = figure.subplots(2, 2)
        bar = kater_bar(place)
        distance = np.linspace(0.05, 1.2, 200)
        above = bar.centre + distance[:, None] * np.array([0.0, 0.0, 1.0])
        edge.plot(distance, [pendulum_period(bar, pivot) for pivot in above], color=style.BLUE)
        for arm in arms(bar):
            edge.plot(arm, pendulum_period(bar, bar.centre + np.array([0, 0, arm])), "o", color=style.VERMILLION)
        edge.set(xlabel="edge to centre of mass (m)", ylabel="period (s)", ylim=(1.5, 4.0))
        edge.set_title("The same period at two distances")
        angle = np.linspace(0, 179, 180)
        slow = pendulum_period(bar, (0, 0, EDGES[0]), amplitude=np.radians(angle)) / periods(bar)[0]
        swing.plot(angle, slow, color=style.BLUE, label="exact")
        swing.plot(angle, 1 + np.radians(angle) ** 2 / 16, color=style.ORANGE, linestyle="--", label="1 + a²/16")
        swing.set(xlabel="amplitude a (°)", ylabel="period / that of small swings", ylim=(0.95, 3), xlim=(0, 180))
        swing.set_title("Large swings are slower")
        swing.legend()
        places = np.linspace(-0.2, 0.45, 200)
        both = np.array([periods(kater_bar(where)) for where in places])
        bob.plot(places, both[:, 0], color=style.BLUE, label="upper edge")
        bob.plot(places, both[:, 1], color=style.ORANGE, label="lower edge")
        bob.plot(place, periods(bar)[0], "o", color=style.VERMILLION)
        bob.set(xlabel="place of the sliding bob (m)", ylabel="period (s)")
        bob.set_title("Kater: equal periods give gravity")
        bob.legend()
        wood, hand = bat(), np.array([0.0, 0.0, GRIP])
        reach = np.linspace(0.0, 0.84 - GRIP, 100)
        blow.plot(100 * (reach + GRIP), 100 * pivot_impulse(wood, hand, reach), color=style.BLUE)
        sweet = 100 * (GRIP + float(pendulum_length(wood, hand)))
        blow.axhline(0, color=style.GREY, linewidth=0.8)
        blow.plot(sweet, 0, "o", color=style.VERMILLION)
        blow.annotate(f"{sweet:.1f} cm", (sweet, 0), xytext=(-8, 8), textcoords="offset points", ha="right")
        blow.set(xlabel="where the ball hits, from the knob (cm)", ylabel="hands push (% of the blow)")
        blow.set_title("A bat's centre of percussion")
        return figure


def main() -> None:
    """Adjust the pendulum, print what follows, and save the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, help="a PNG to write")
    chosen = parser.parse_args()
    place = brentq(lambda where: np.subtract(*periods(kater_bar(where))), 0.1, 0.45, xtol=1e-13)
    bar = kater_bar(place)
    (upper, lower), length = periods(bar), float(pendulum_length(bar, (0.0, 0.0, EDGES[0])))
    print(f"bob at {place:.4f} m: periods of {upper:.6f} and {lower:.6f} s, simple pendulum of {length:.6f} m")
    print(f"gravity from them: {kater_gravity(upper, lower, *arms(bar)):.6f} m/s2")
    rough = kater_bar(place + 0.01)
    print(f"with the bob 1 cm off, by Bessel's formula: {kater_gravity(*periods(rough), *arms(rough)):.6f} m/s2")
    wood, hand = bat(), np.array([0.0, 0.0, GRIP])
    print(f"bat of {wood.mass:.2f} kg: sweet spot {100 * (GRIP + pendulum_length(wood, hand)):.2f} cm from the knob")
    if chosen.output:
        print(f"picture: {style.save(picture(place), chosen.output)}")


if __name__ == "__main__":
    main()
