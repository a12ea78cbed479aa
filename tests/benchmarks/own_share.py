"""What a density of fourth order has too much of the particle itself (sph.kernels.Kernel.own_share): a table to copy.

Measured where it is needed, in fluid that has come to rest under its own pressure. A cube of a glass, repeated on all
sides, settles as bodies do (models.sph.relaxation), and the mean density of its particles is compared with mass over
volume. The glass itself, which repulsion alone has made, has more: by 0.0012 with the quintic kernel on 113 neighbours,
by 0.013 with Wendland C2 on 74. Settled bodies come out too small by as much, however many particles they have. Cubic
and quartic particles pair. Run it again where a kernel or the descent changes:

    python -m tests.benchmarks.own_share [kernel ...]
"""

import sys
from dataclasses import replace
from functools import cache

import numpy as np

from astroinertia.effects import catalogue
from astroinertia.engines import numba_cpu, periodic
from astroinertia.matter import gases
from astroinertia.models.sph.evaluate import evaluated
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.sorting import rearranged, stale
from astroinertia.models.sph.state import Problem, State
from astroinertia.sph import profiles
from astroinertia.sph.fourth_order import smoothed
from astroinertia.sph.kernels import KERNELS, OWN_SHARE_NEIGHBOURS, eta_for_neighbours
from astroinertia.sph.placement import place

PARTICLES = 2700  # of the sphere that the cube is cut from: some 900 in the cube
HALF = 0.54  # side of the cube over the diameter of the sphere
STEPS = 1000  # at a step half as long as bodies take, which settle in 300 to 600
COURANT = 0.25  # of h/c: with 0.55 Wendland C2 does not come to rest
AT_REST = 2e-3  # rms acceleration in units of c^2 over the spacing: of settled bodies it is less
INERTIA = 0.9


@cache
def cube(seed: int) -> np.ndarray:
    """Positions (N, 3) in a cube of side N^(1/3) around the origin, cut out of a glass."""
    points = place(profiles.uniform(), PARTICLES, seed=seed)
    inside = points[np.abs(points).max(axis=1) < HALF]
    return inside * (len(inside) ** (1 / 3) / (2 * HALF))


def settled(kernel: str, neighbours: float, seed: int = 7, steps: int = STEPS) -> State:
    """Gas of density 1 and of one entropy in a repeating cube, after so many steps of the descent in energy."""
    position = cube(seed)
    count = len(position)
    side = count ** (1 / 3)
    shape, eta = KERNELS[kernel], eta_for_neighbours(KERNELS[kernel], neighbours)
    problem = Problem(
        effects=(catalogue.build("pressure", {"order": "fourth"}),),
        equation_of_state=gases.ideal(5 / 3),
        eta=eta,
        engine=periodic.Engine(numba_cpu.Engine(), (side, side, side), shape.support),
        kernel=kernel,
        smoothing_tolerance=1e-6,
        courant=0.3, acceleration_factor=0.25, energy_factor=0.25, max_timestep=1.0,
    )  # fmt: skip
    state, arrangement = initial_state(problem, np.ones(count), position, 0 * position, np.ones(count))
    move, since = np.zeros_like(position), 0
    for _ in range(steps):
        if stale(problem, arrangement, state):
            before = np.asarray(state.identity)
            state, arrangement = rearranged(problem, state)
            back = np.argsort(before)
            move = move[back[np.asarray(state.identity)]]
        force, fluid = np.asarray(state.rates.total), state.rates.fluid
        if np.sum(move * force) < 0:
            move, since = np.zeros_like(move), 0
        since += 1
        time = COURANT * np.asarray(fluid.smoothing_length) / np.asarray(fluid.sound_speed)
        move = min(since / (since + 3), INERTIA) * move + (time**2)[:, None] * force
        length = np.linalg.norm(move, axis=1)
        move = move * np.minimum(1.0, 0.15 / np.maximum(length, 1e-300))[:, None]
        state = evaluated(problem, arrangement, replace(state, position=state.position + move), np.float64(0.0))
    return state


def needed_share(state: State) -> float:
    """The share with which the mean density of settled gas of density 1 is right; ValueError where it moves."""
    fluid = state.rates.fluid
    left = np.sqrt(np.square(state.rates.total).mean()) / np.square(fluid.sound_speed).mean()
    if not left < AT_REST:
        raise ValueError(f"the gas has not settled: accelerations are {left:.2g} c^2 over the spacing")
    (kernels,) = smoothed(np, fluid.density, fluid.contrast)
    return float(((2.5 - 1.5 * fluid.grad_h) * kernels).mean()) - 1.0


def main(names: list[str]) -> None:
    """Print a row a kernel."""
    for name in names or list(KERNELS):
        shares = [needed_share(settled(name, n)) for n in OWN_SHARE_NEIGHBOURS]
        print(f"{name:12}", *(f"{value:8.4f}" for value in shares), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
