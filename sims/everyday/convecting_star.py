"""A convecting star: what is left of its flow when drift and rotation are taken out.

    python sims/everyday/convecting_star.py --output convecting_star.png

A star turns, drifts, and overturns in rolls that keep its density. Its angular momentum and its inertia tensor give one
angular velocity, that of Tisserand's axes; the residual flow has no momentum and no angular momentum, and its energy is
all that is not drift or rotation: the three add up. So convection is seen, however fast the star turns.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from astroinertia.inertia.spin import angular_momentum, angular_velocity, residual_flow, rotational_energy
from astroinertia.inertia.tensor import inertia_tensor
from astroinertia.plots import style

SPIN, DRIFT, OVERTURN = np.array([0.0, 0.3, 1.0]), np.array([5.0, -2.0, 1.0]), 0.2


def star(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Equal masses (N,) and places (N, 3) of a ball of radius 1 whose density falls as 1 - r^2."""
    rng = np.random.default_rng(seed)
    places = np.empty((0, 3))
    while len(places) < count:
        tried = rng.uniform(-1, 1, (4 * count, 3))
        square = np.sum(tried**2, axis=1)
        places = np.concatenate([places, tried[rng.uniform(size=len(tried)) < 1 - square]])
    return np.full(count, 1 / count), places[:count]


def rolls(places: np.ndarray) -> np.ndarray:
    """A flow with div(rho v) = 0 that stays inside the surface: rho v = curl(psi e_phi/R) with psi = rho^2 R^2 z.

    Two rings of rolls round the axis: outwards along it in either half, back along the surface and the equator.
    """
    x, y, z = places.T
    radius, square = np.hypot(x, y), np.sum(places**2, axis=1)
    density = 1 - square
    along_z = 2 * density * (-2 * z) * radius**2 * z + density**2 * radius**2
    along_r = 2 * density * (-2 * radius) * radius**2 * z + 2 * density**2 * radius * z
    outwards, upwards = -along_z / (density * radius), along_r / (density * radius)
    return np.stack([outwards * x / radius, outwards * y / radius, upwards], -1)


def energies(masses: np.ndarray, places: np.ndarray, velocities: np.ndarray) -> dict[str, float]:
    """The kinetic energies of drift, rotation and what is left, and of all."""
    drift = masses @ velocities / masses.sum()
    inertia = inertia_tensor(masses, places)
    momentum = angular_momentum(masses, places, velocities)
    left = residual_flow(masses, places, velocities)
    return {
        "drift": 0.5 * masses.sum() * float(drift @ drift),
        "rotation": float(rotational_energy(inertia, angular_momentum=momentum)),
        "residual": 0.5 * float(masses @ np.sum(left**2, axis=1)),
        "all": 0.5 * float(masses @ np.sum(velocities**2, axis=1)),
    }


def picture(masses: np.ndarray, places: np.ndarray, velocities: np.ndarray) -> Figure:
    """The flow in a slice through the axis: as it is without the drift, and without the rotation, too."""
    left = residual_flow(masses, places, velocities)
    still = velocities - masses @ velocities / masses.sum()
    edges = np.linspace(-1, 1, 17)
    middle = 0.5 * (edges[1:] + edges[:-1])
    # All meridians are alike: distance from the axis, height, and the part of the flow along either.
    radius = np.hypot(*places[:, :2].T)
    around = places[:, :2] / radius[:, None]
    with style.styled():
        figure = style.page("A star that turns and convects", (11.0, 4.6))
        across, meridian, shares = figure.subplots(1, 3)
        thin = abs(places[:, 2]) < 0.15
        dots = across.scatter(*places[thin, :2].T, c=np.linalg.norm(still[thin], axis=1), s=3, cmap="viridis")
        across.set(aspect="equal", xlabel="x", ylabel="y", title="Equator, drift taken out")
        figure.colorbar(dots, ax=across, label="speed", location="bottom", shrink=0.8)
        outwards = np.sum(left[:, :2] * around, axis=1)
        where = [np.histogram2d(radius, places[:, 2], bins=[edges[8:], edges], weights=w)[0]
                 for w in (masses, masses * outwards, masses * left[:, 2])]  # fmt: skip
        full = where[0] > 0
        mean = [np.where(full, part / np.where(full, where[0], 1), np.nan).T for part in where[1:]]
        meridian.quiver(*np.meshgrid(middle[8:], middle), *mean, color=style.BLUE, width=0.006)
        rim = np.linspace(-np.pi / 2, np.pi / 2, 100)
        meridian.plot(np.cos(rim), np.sin(rim), color=style.GREY, linewidth=1)
        meridian.set(aspect="equal", xlabel="distance from the axis", ylabel="z", title="Meridian, rotation taken out")
        parts = energies(masses, places, velocities)
        names = ["drift", "rotation", "residual"]
        shares.bar(names, [parts[name] for name in names], color=[style.GREY, style.ORANGE, style.BLUE])
        shares.set(yscale="log", ylabel="kinetic energy", title="They add up to all")
        return figure


def main() -> None:
    """Make the star, take its flow apart, print what there is, and save the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, default=100_000, help="how many (default: 100,000)")
    parser.add_argument("--seed", type=int, default=1, help="of their places (default: 1)")
    parser.add_argument("--output", type=Path, help="a PNG to write")
    chosen = parser.parse_args()
    if not 100 <= chosen.particles <= 5_000_000:
        parser.error("the particles must be between 100 and 5 million")
    masses, places = star(chosen.particles, chosen.seed)
    velocities = DRIFT + np.cross(SPIN, places) + OVERTURN * rolls(places)
    spin = angular_velocity(inertia_tensor(masses, places), angular_momentum(masses, places, velocities))
    left = residual_flow(masses, places, velocities)
    parts = energies(masses, places, velocities)
    print("angular velocity " + " ".join(f"{one:.4f}" for one in spin) + ", put in " + " ".join(f"{w:g}" for w in SPIN))
    momentum, turning = masses @ left, angular_momentum(masses, places, left)
    print(f"residual flow: momentum {np.linalg.norm(momentum):.0e}, angular momentum {np.linalg.norm(turning):.0e}")
    print(", ".join(f"{name} {energy:.5f}" for name, energy in parts.items()))
    rest = parts["all"] - parts["drift"] - parts["rotation"] - parts["residual"]
    print(f"sum of the three less all: {rest / parts['all']:.0e}")
    if chosen.output:
        print(f"picture: {style.save(picture(masses, places, velocities), chosen.output)}")


if __name__ == "__main__":
    main()
