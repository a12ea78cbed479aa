"""A flywheel smooths the torque of an engine: how much its speed swings, against the wheel's moment of inertia.

    python sims/everyday/flywheel.py --cylinders 1 --output flywheel.png

A four-stroke engine turns its crank by a burst of pressure every second turn and takes torque back in between. A steady
load is driven with the mean of it; the wheel stores what is left over. The swing of the speed is (work to spare)/(I
w^2).
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import brentq

from astroinertia.inertia import shapes
from astroinertia.inertia.rolling import flywheel_rates
from astroinertia.plots import style

AREA, CRANK, ROD, COMPRESSION = 0.005, 0.04, 0.14, 9.0  # piston in m^2, throw and rod in m, ratio of volumes
PEAK, GAMMA, OUTSIDE = 5e6, 1.3, 1e5  # Pa after ignition, of the gas, of the air
ANGLES = np.linspace(0.0, 4 * np.pi, 1441)


def engine_torque(cylinders: int) -> np.ndarray:
    """The torque of the gas (N m) over two turns, of cylinders that fire one after another."""
    total = np.zeros_like(ANGLES)
    for cylinder in range(cylinders):
        angle = (ANGLES - 4 * np.pi * cylinder / cylinders) % (4 * np.pi)  # 0: ignition, at the top
        total += _one_cylinder(angle)
    return total


def _one_cylinder(angle: np.ndarray) -> np.ndarray:
    lean = np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)
    fallen = CRANK * (1 - np.cos(angle)) + ROD - lean
    lever = CRANK * np.sin(angle) * (1 + CRANK * np.cos(angle) / lean)  # the derivative of it
    volume = fallen + 2 * CRANK / (COMPRESSION - 1)
    least, most = volume.min(), volume.max()
    burning, compressing = angle < np.pi, angle >= 3 * np.pi
    pressure = np.select(
        [burning, compressing],
        [PEAK * (least / volume) ** GAMMA - OUTSIDE, OUTSIDE * ((most / volume) ** GAMMA - 1)],
        0.0,
    )
    return AREA * pressure * lever


def swing(torque: np.ndarray, moment: float, rate: float) -> tuple[np.ndarray, float]:
    """Angular velocities over the cycle, whose mean is `rate`, and (greatest - least)/mean."""
    start = brentq(lambda first: flywheel_rates(torque, ANGLES, moment, first).mean() - rate, 0.5 * rate, 1.5 * rate)
    rates = flywheel_rates(torque, ANGLES, moment, start)
    return rates, float(np.ptp(rates) / rate)


def picture(torque: np.ndarray, wheels: dict[float, np.ndarray], curve: tuple[np.ndarray, np.ndarray]) -> Figure:
    """The torque, the speed with small and large wheels, and the swing against the moment of inertia."""
    with style.styled():
        figure = style.page("A flywheel between an engine and its load", (11.0, 4.2))
        drive, speed, size = figure.subplots(1, 3)
        turns = ANGLES / (2 * np.pi)
        drive.plot(turns, torque, color=style.VERMILLION, label="of the gas")
        drive.axhline(np.trapezoid(torque, ANGLES) / ANGLES[-1], color=style.INK, linestyle="--", label="of the load")
        drive.set(xlabel="turns of the crank", ylabel="torque (N m)", xlim=(0, 2))
        _legend_above(drive)
        for (moment, rates), colour in zip(wheels.items(), (style.ORANGE, style.BLUE, style.GREEN), strict=True):
            speed.plot(turns, rates * 60 / (2 * np.pi), color=colour, label=f"{moment:g} kg m²")
        speed.set(xlabel="turns of the crank", ylabel="turns a minute", xlim=(0, 2))
        _legend_above(speed)
        size.loglog(*curve, color=style.BLUE)
        size.set(xlabel="I (kg m²)", ylabel="(greatest - least) / mean speed")
        return figure


def _legend_above(axes: Axes) -> None:
    """A legend that hides no curve."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.35 * (high - low))
    axes.legend(loc="upper right")


def main() -> None:
    """Compute the swing for several wheels, say which is needed for a hundredth, and save the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cylinders", type=int, default=1, choices=(1, 2, 4), help="of the engine (default: 1)")
    parser.add_argument("--speed", type=float, default=1500.0, help="turns a minute in the mean (default: 1500)")
    parser.add_argument("--output", type=Path, help="a PNG to write")
    chosen = parser.parse_args()
    if not 600 <= chosen.speed <= 6000:
        parser.error("the speed must be between 600 and 6000 turns a minute")
    torque, rate = engine_torque(chosen.cylinders), chosen.speed * 2 * np.pi / 60
    moments = np.geomspace(0.3, 30.0, 60)
    swings = np.array([swing(torque, moment, rate)[1] for moment in moments])
    wheels = {moment: swing(torque, moment, rate)[0] for moment in (0.3, 1.0, 5.0)}
    for moment in wheels:
        print(f"I = {moment:3g} kg m2: the speed swings by {100 * swing(torque, moment, rate)[1]:.3f} %")
    work = np.ptp(0.5 * moments[-1] * flywheel_rates(torque, ANGLES, moments[-1], rate) ** 2)
    needed = work / (0.01 * rate**2)
    mass = needed / (0.5 * 0.2**2)
    kept = shapes.cylinder(mass, 0.2, mass / (7800 * np.pi * 0.2**2)).moment((0, 0, 1))
    print(f"for 1 % with {work:.1f} J to store: {needed:.3f} kg m2, a steel disc of 40 cm and {mass:.1f} kg")
    print(f"that disc, by its shape: {kept:.3f} kg m2; it swings by {100 * swing(torque, kept, rate)[1]:.3f} %")
    if chosen.output:
        print(f"picture: {style.save(picture(torque, wheels, (moments, swings)), chosen.output)}")


if __name__ == "__main__":
    main()
