"""What a density of fourth order has too much of the particle itself (sph.kernels.Kernel.own_share): a table to copy.

Glasses of uniform density, 20,000 particles each, away from their surface; the mean of five and its scatter. Run it
again where the glass or a kernel changes:

    python -m tests.benchmarks.own_share
"""

import numpy as np

from astroinertia.engines.numba_cpu import Engine
from astroinertia.sph import profiles
from astroinertia.sph.density import density
from astroinertia.sph.kernels import KERNELS, OWN_SHARE_NEIGHBOURS, eta_for_neighbours
from astroinertia.sph.placement import place

PARTICLES = 20_000
INSIDE = 0.6  # of the radius


def needed_share(kernel: str, neighbours: float, position: np.ndarray) -> float:
    """The share with which the mean density of a glass (N, 3) of the unit sphere, unit mass, is right."""
    eta = eta_for_neighbours(KERNELS[kernel], neighbours)
    mass, guess = np.full(len(position), 1.0 / len(position)), np.full(len(position), 0.1)
    engine = Engine()
    order, arrangement = engine.arrange(position, guess)
    solved = density(engine, arrangement, kernel, position[order], mass, guess, eta, 1e-10, False)
    inside = np.linalg.norm(position[order], axis=1) < INSIDE
    exact = 3.0 / (4.0 * np.pi)
    return float(((2.5 - 1.5 * solved.grad_h) * solved.density)[inside].mean() / exact) - 1.0


def main() -> None:
    """Print a row a kernel."""
    glasses = [place(profiles.uniform(), PARTICLES, seed=seed) for seed in range(5)]
    for name in KERNELS:
        shares = np.array([[needed_share(name, n, glass) for n in OWN_SHARE_NEIGHBOURS] for glass in glasses])
        print(f"{name:12}", *(f"{value:9.5f}" for value in shares.mean(axis=0)), "  scatter", shares.std(axis=0).max())


if __name__ == "__main__":
    main()
