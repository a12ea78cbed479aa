"""A galaxy by its inertia tensor: a disc, a bulge and a bar, from particles, within one radius after another.

    python sims/everyday/galaxy.py --stars 200000 --output galaxy.png

The disc is exponential in radius and sech^2 in height, the bulge a Plummer sphere without its outermost tenth, the bar
a homogeneous ellipsoid at an angle. Closed forms give the tensor of each, and parts add. Within a radius the tensor
shows the axis ratio and the angle of the bar, which fade further out, where the disc takes over.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from astroinertia.inertia.principal import principal_frame
from astroinertia.inertia.spin import angular_momentum, angular_velocity
from astroinertia.inertia.tensor import inertia_tensor, second_moment_from_inertia
from astroinertia.plots import style

DISC, BULGE, BAR = 0.7, 0.15, 0.15  # shares of the mass, which is 1
LENGTH, HEIGHT = 1.0, 0.15  # of the disc
SCALE, INSIDE = 0.25, 0.9  # of the bulge, and the share of Plummer's sphere that it is
ROUND = 0.97  # b/a above which the long axis is where chance has it
SEMI_AXES, ANGLE = (1.5, 0.5, 0.3), np.radians(35.0)  # of the bar


def stars(count: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Masses (N,), places (N, 3) and velocities (N, 3), with a flat curve of rotation of the disc of speed 1."""
    rng = np.random.default_rng(seed)
    numbers = [round(share * count) for share in (DISC, BULGE, BAR)]
    radius, turn = LENGTH * rng.gamma(2.0, size=numbers[0]), rng.uniform(0, 2 * np.pi, numbers[0])
    height = HEIGHT * np.arctanh(rng.uniform(-1, 1, numbers[0]))
    disc = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], -1)
    flow = np.stack([-np.sin(turn), np.cos(turn), np.zeros_like(turn)], -1)
    share = INSIDE * rng.uniform(size=numbers[1])
    bulge = _directions(rng, numbers[1]) * (SCALE / np.sqrt(share ** (-2 / 3) - 1))[:, None]
    bar = _directions(rng, numbers[2]) * np.cbrt(rng.uniform(size=numbers[2]))[:, None] * np.array(SEMI_AXES)
    bar = bar @ _turn(ANGLE).T
    masses = np.concatenate([np.full(n, share / n) for n, share in zip(numbers, (DISC, BULGE, BAR), strict=True)])
    places = np.concatenate([disc, bulge, bar])
    return masses, places, np.concatenate([flow, np.zeros_like(bulge), np.zeros_like(bar)])


def _directions(rng: np.random.Generator, count: int) -> np.ndarray:
    vectors = rng.standard_normal((count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _turn(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])


def exact() -> np.ndarray:
    """The second moment (3, 3) of the whole, part by part in closed form.

    Of the disc <x^2> = 3 L^2 and <z^2> = pi^2 H^2/12; of a share s of Plummer's sphere <r^2> is an integral, by
    quadrature.
    """
    disc = DISC * np.diag([3 * LENGTH**2, 3 * LENGTH**2, np.pi**2 * HEIGHT**2 / 12])
    nodes, weights = np.polynomial.legendre.leggauss(200)
    share = INSIDE * 0.5 * (nodes + 1)
    bulge = BULGE * np.eye(3) * SCALE**2 / 3 * np.sum(0.5 * weights / (share ** (-2 / 3) - 1))
    bar = BAR * _turn(ANGLE) @ np.diag(np.square(SEMI_AXES)) @ _turn(ANGLE).T / 5
    return disc + bulge + bar


def within(masses: np.ndarray, places: np.ndarray, radius: float) -> tuple[float, float, float]:
    """Axis ratios b/a and c/a of the second moment of what is within a radius, and the angle of its long axis."""
    inside = np.linalg.norm(places, axis=1) < radius
    inertia = inertia_tensor(masses[inside], places[inside], np.zeros(3))
    moments, axes = principal_frame(inertia)
    squares = 0.5 * moments.sum() - moments  # in the order a, b, c
    ratios = np.sqrt(squares / squares[0])
    return float(ratios[1]), float(ratios[2]), float(np.degrees(np.arctan2(axes[0, 1], axes[0, 0])) % 180)


def picture(masses: np.ndarray, places: np.ndarray) -> Figure:
    """The galaxy from above, and its axes within one radius after another."""
    with style.styled():
        figure = style.page("A galaxy by its inertia tensor", (11.0, 4.2))
        above, ratios, angles = figure.subplots(1, 3)
        counts, x, y = np.histogram2d(*places[:, :2].T, bins=200, range=[[-5, 5]] * 2, weights=masses)
        above.pcolormesh(
            x, y, np.log10(np.maximum(counts.T, counts[counts > 0].min())), cmap="inferno", rasterized=True
        )
        above.set(aspect="equal", xlabel="x (scale lengths)", ylabel="y (scale lengths)", title="From above")
        radii = np.geomspace(0.2, 6.0, 40)
        of_all = np.array([within(masses, places, radius) for radius in radii])
        ratios.semilogx(radii, of_all[:, 0], color=style.BLUE, label="b/a")
        ratios.semilogx(radii, of_all[:, 1], color=style.ORANGE, label="c/a")
        ratios.set(xlabel="within a radius of (scale lengths)", ylabel="ratio of axes", ylim=(0, 1.02), title="Shape")
        ratios.legend()
        long = of_all[:, 0] < ROUND
        angles.semilogx(radii[long], of_all[long, 2], color=style.BLUE, label=f"where b/a < {ROUND:g}")
        angles.axhline(np.degrees(ANGLE), color=style.INK, linestyle="--", label="of the bar")
        angles.set(xlabel="within a radius of (scale lengths)", ylabel="angle of the long axis (°)", ylim=(0, 180))
        angles.set_xlim(ratios.get_xlim())
        for axes in (ratios, angles):
            style.plain_log(axes.xaxis, radii[0], radii[-1])
        angles.set_title("Direction")
        angles.legend()
        return figure


def main() -> None:
    """Place the stars, compare their tensor with the closed form, and save the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stars", type=int, default=200_000, help="how many (default: 200,000)")
    parser.add_argument("--seed", type=int, default=1, help="of their places (default: 1)")
    parser.add_argument("--output", type=Path, help="a PNG to write")
    chosen = parser.parse_args()
    if not 1000 <= chosen.stars <= 10_000_000:
        parser.error("the stars must be between 1000 and 10 million")
    masses, places, velocities = stars(chosen.stars, chosen.seed)
    inertia = inertia_tensor(masses, places, np.zeros(3))
    second, wanted = second_moment_from_inertia(inertia), exact()
    print(f"{'second moment':16}{'xx':>10}{'yy':>10}{'zz':>10}{'xy':>10}")
    for name, tensor in (("of the stars", second), ("closed form", wanted)):
        print(f"{name:16}" + "".join(f"{tensor[i, k]:10.4f}" for i, k in ((0, 0), (1, 1), (2, 2), (0, 1))))
    minor, thin, angle = within(masses, places, 1.0)
    print(f"within 1 scale length: b/a {minor:.3f}, c/a {thin:.3f}, long axis at {angle:.1f} degrees")
    spin = angular_velocity(inertia, angular_momentum(masses, places, velocities))
    whole = DISC * 2 * LENGTH / (wanted[0, 0] + wanted[1, 1])  # L of the disc, which alone turns, over I of all
    print(f"mean angular velocity {spin[2]:.4f}, in closed form {whole:.4f}")
    if chosen.output:
        print(f"picture: {style.save(picture(masses, places), chosen.output)}")


if __name__ == "__main__":
    main()
