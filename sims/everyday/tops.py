"""A top that sleeps, and one that friction makes rise.

    python sims/everyday/tops.py --output tops.png

On a sharp point, an upright top stays up by spin alone if it turns faster than 2 sqrt(A m g l)/C; one that is slower
leans over at the least touch, and comes back. A round peg slides on the table, and friction, which only takes energy,
lifts the axis until the top sleeps. Jellett's constant L.(l a + R z), with the axis a, is kept whatever the friction
is; friction is in proportion to the sliding speed here (Bou-Rabee, Marsden & Romero 2004, SIAM Journal on Applied
Dynamical Systems 3, 352).
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

from astroinertia.inertia import shapes
from astroinertia.inertia.body import Body
from astroinertia.inertia.rolling import STANDARD_GRAVITY
from astroinertia.plots import style
from astroinertia.rotation import heavy_top

PEG = 0.006  # m, radius of the peg's round end, whose centre is the origin of the top
GRIP = 0.3  # friction as a share of the normal force for a sliding speed of 1 m/s
START, SPIN = np.radians(25.0), 200.0  # tilt at the start, and the spin in rad/s


def top() -> Body:
    """A wooden disc on a stick along z, in kg and m; the centre of curvature of the peg is at the origin."""
    disc = shapes.cylinder(0.05, 0.03, 0.01).translated((0.0, 0.0, 0.025))
    return disc + shapes.cylinder(0.005, 0.003, 0.05).translated((0.0, 0.0, 0.025))


def slept(body: Body, factor: float, times: np.ndarray) -> np.ndarray:
    """Tilts (degrees) on a sharp point, from 1 degree, with a spin of so many times the least that sleeps."""
    inertia = body.about((0.0, 0.0, 0.0))
    torque = body.mass * STANDARD_GRAVITY * body.centre[2]
    spin = factor * heavy_top.least_sleeping_spin(inertia[0, 0], inertia[2, 2], torque)
    moving = heavy_top.heavy_top(inertia[0, 0], inertia[2, 2], torque, np.radians(1.0), (0.0, 0.0, spin))
    return np.degrees(heavy_top.tilt(moving, times))


def risen(body: Body, times: np.ndarray) -> dict[str, np.ndarray]:
    """Tilt, spin, energy and Jellett's constant of a top on a round peg on a rough table, at the times.

    The state is the axis a, the velocity u of the centre of mass over the table, and L about it. The peg stays on the
    table: its height is R + l cos(tilt), so the normal force follows from the acceleration of the tilt.
    """
    across, along = body.inertia[0, 0], body.inertia[2, 2]
    mass, arm = float(body.mass), float(body.centre[2])
    up = np.array([0.0, 0.0, 1.0])

    def turned_by(vector: np.ndarray, axis: np.ndarray) -> np.ndarray:
        return vector / across + (1 / along - 1 / across) * (vector @ axis) * axis

    def rate(_: float, state: np.ndarray) -> np.ndarray:
        axis, velocity, momentum = state[:3], np.append(state[3:5], 0.0), state[5:8]
        axis = axis / np.linalg.norm(axis)
        spin, contact = turned_by(momentum, axis), -arm * axis - PEG * up
        turning = np.cross(spin, axis)
        sliding = velocity + arm * turning[2] * up + np.cross(spin, contact)
        sliding[2] = 0.0
        grip = -GRIP * sliding
        # N: m (d2z/dt2 + g), where d2z/dt2 = l d2a_z/dt2 depends on the torque, which is linear in N.
        torque = np.cross(contact, up + grip)
        free = (1 / along - 1 / across) * ((momentum @ turning) * axis + (momentum @ axis) * turning)
        steady = np.cross(free, axis) + np.cross(spin, turning)
        gain = np.cross(turned_by(torque, axis), axis)[2]
        normal = mass * (STANDARD_GRAVITY + arm * steady[2]) / (1 - mass * arm * gain)
        if normal <= 0:
            raise ValueError("the top leaves the table: it spins or nods too fast")
        return np.concatenate([turning, normal * grip[:2] / mass, normal * torque])

    axis = np.array([np.sin(START), 0.0, np.cos(START)])
    # In steady precession at first, about the centre of mass, as on a smooth table: no nutation but what friction
    # makes.
    slow = min(heavy_top.steady_precession_rates(across, along, mass * STANDARD_GRAVITY * arm, START, SPIN), key=abs)
    side = np.array([-np.cos(START), 0.0, np.sin(START)])
    begin = np.concatenate([axis, [0.0, 0.0], along * SPIN * axis + across * slow * np.sin(START) * side])
    path = solve_ivp(rate, (0.0, times[-1]), begin, "DOP853", times, rtol=1e-9, atol=1e-10).y
    axes, momenta = path[:3].T, path[5:8].T
    spins = momenta / across + (1 / along - 1 / across) * np.sum(momenta * axes, 1)[:, None] * axes
    climbing = arm * np.cross(spins, axes)[:, 2]
    kinetic = 0.5 * np.sum(spins * momenta, 1) + 0.5 * mass * (np.sum(path[3:5] ** 2, 0) + climbing**2)
    return {
        "time": times,
        "tilt": np.degrees(np.arccos(np.clip(axes[:, 2], -1, 1))),
        "spin": np.sum(spins * axes, 1),
        "energy": kinetic + mass * STANDARD_GRAVITY * arm * axes[:, 2],
        "jellett": np.sum(momenta * (arm * axes + PEG * up), 1),
    }


def picture(body: Body, upright: dict[float, np.ndarray], times: np.ndarray, rising: dict[str, np.ndarray]) -> Figure:
    """Tilts of tops on a point, and tilt, spin and energy of one on a peg."""
    with style.styled():
        figure = style.page("Tops: upright on a point, and rising on a peg", (11.0, 4.2))
        point, peg, lost = figure.subplots(1, 3)
        for (factor, tilt), colour in zip(upright.items(), (style.VERMILLION, style.ORANGE, style.BLUE), strict=True):
            point.plot(times, tilt, color=colour, label=f"{factor:g} of the least spin")
        point.set(xlabel="time (s)", ylabel="tilt (°)", title="On a sharp point, touched by 1°", ylim=(0, 75))
        point.legend(loc="upper right")
        peg.plot(rising["time"], rising["tilt"], color=style.BLUE)
        peg.set(xlabel="time (s)", ylabel="tilt (°)", title="On a round peg", ylim=(0, None))
        lost.plot(rising["time"], 100 * (rising["energy"] / rising["energy"][0] - 1), color=style.BLUE, label="energy")
        lost.plot(rising["time"], 100 * (rising["spin"] / rising["spin"][0] - 1), color=style.ORANGE, label="spin")
        kept = 100 * (rising["jellett"] / rising["jellett"][0] - 1)
        lost.plot(rising["time"], kept, color=style.INK, linestyle="--", label="Jellett's constant")
        lost.set(xlabel="time (s)", ylabel="change (%)", title="What friction takes", ylim=(None, 1.2))
        lost.legend(loc="upper right")
        return figure


def main() -> None:
    """Spin the tops, print what they do, and save the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=4.0, help="how long the top rises (default: 4)")
    parser.add_argument("--output", type=Path, help="a PNG to write")
    chosen = parser.parse_args()
    if not 0 < chosen.seconds <= 60:
        parser.error("the seconds must be above 0, and at most 60")
    body, times = top(), np.linspace(0, 1.5, 600)
    upright = {factor: slept(body, factor, times) for factor in (0.9, 0.97, 1.05)}
    for factor, tilt in upright.items():
        print(f"on a point with {factor:g} of the least spin: from 1 degree to {tilt.max():.2f} degrees")
    rising = risen(body, np.linspace(0, chosen.seconds, 400))
    print(f"on a peg: from {rising['tilt'][0]:.2f} to {rising['tilt'][-1]:.2f} degrees in {chosen.seconds:g} s")
    print(f"energy {100 * (rising['energy'][-1] / rising['energy'][0] - 1):+.2f} %, at most gained between records "
          f"{max(np.diff(rising['energy']).max(), 0) / rising['energy'][0]:.0e}")  # fmt: skip
    print(f"Jellett's constant kept to {np.ptp(rising['jellett']) / rising['jellett'][0]:.0e}")
    if chosen.output:
        print(f"picture: {style.save(picture(body, upright, times, rising), chosen.output)}")


if __name__ == "__main__":
    main()
