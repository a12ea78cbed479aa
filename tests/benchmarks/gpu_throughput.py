"""Particle updates per second of the xla engine's whole step, and what they take of memory, on a GPU or on a CPU.

    python tests/benchmarks/gpu_throughput.py --particles 100000 1000000 10000000

Evrard's sphere: density with smoothing lengths, pressure, viscosity, gravity by multipoles, ledger and time step. Where
JAX finds a GPU it runs there, else on the CPU, for which 10,000 particles are plenty. Steps are timed between sorts,
and sorting with its lists by itself; particles are sorted as often as in a run. The share of the arithmetic is that of
the pairs and the expansions that the lists hold, counted as written, against --peak. On a CPU the memory is that of the
whole process, its compiler included, and means little below a million particles.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from astroinertia.costs.machine import peak_memory
from astroinertia.effects.catalogue import build
from astroinertia.engines.xla import Engine
from astroinertia.gravity.expansions import harmonic
from astroinertia.matter.gases import Ideal
from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.sorting import rearranged, stale
from astroinertia.models.sph.state import Problem
from astroinertia.models.sph.step import step
from astroinertia.sph.kernels import KERNELS

KERNEL = "wendland_c2"
KINDS = ("gravity", "pressure", "viscosity")
FLOPS_OF_NEAR_PAIR = 20.0  # difference, distance, clamp, root, two products, four sums


def evrard(particles: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Masses (N,) and positions (N, 3) of the unit sphere with rho ~ 1/r, at random."""
    random = np.random.default_rng(seed)
    direction = random.normal(size=(particles, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    return np.full(particles, 1.0 / particles), direction * np.sqrt(random.uniform(size=particles))[:, None]


def problem_of(precision: str, force_error: float) -> Problem:
    """What a step computes: the shipped defaults with gravity by multipoles."""
    options: dict[str, dict[str, Any]] = {"gravity": {"method": "multipole", "force_error": force_error}}
    return Problem(
        effects=tuple(build(kind, options.get(kind, {})) for kind in KINDS),
        equation_of_state=Ideal(5.0 / 3.0),
        eta=KERNELS[KERNEL].eta,
        courant=0.3,
        acceleration_factor=0.25,
        energy_factor=0.25,
        max_timestep=1.0,
        engine=Engine(precision=precision),  # type: ignore[arg-type]
        kernel=KERNEL,
        smoothing_tolerance=1e-8 if precision == "float64" else 1e-5,
    )


def held_bytes() -> float:
    """The most memory that has been held: on the device where it says so, else by the process."""
    statistics = jax.devices()[0].memory_stats() or {}
    if "peak_bytes_in_use" in statistics:
        return float(statistics["peak_bytes_in_use"])
    return peak_memory()


def flops_of_gravity(lists: Any) -> float:
    """Operations of multipole gravity, by what its lists hold."""
    nodes, (leaves, leaf) = lists.first.shape[0], lists.slots.shape
    order = lists.order
    pairs = float((np.asarray(lists.near.source) < leaves).sum()) * leaf * leaf
    expansions = float((np.asarray(lists.local.source) < nodes).sum())
    # A multiplication and an addition for every moment that a coefficient takes, and three operations a derivative.
    degrees = [sum(a) + sum(b) for a in harmonic(order) for b in harmonic(order) if sum(a) != 1]
    each = 2.0 * sum(degree <= order for degree in degrees) + 3.0 * sum(len(harmonic(n)) for n in range(order + 1))
    return FLOPS_OF_NEAR_PAIR * pairs + each * expansions


def measure(
    particles: int, precision: str, force_error: float, steps: int, clock: Callable[[], float]
) -> dict[str, float]:
    """Seconds of the first state and step, which compile, of a step, of sorting, of gravity; bytes, and operations."""
    mass, position = evrard(particles)
    problem = problem_of(precision, force_error)
    before, begin = held_bytes(), clock()
    state, arrangement = initial_state(
        problem, mass, position, np.zeros_like(position), internal_energy=np.full(particles, 0.05)
    )
    first_state = clock() - begin
    state, arrangement = rearranged(problem, state)
    ready = clock()

    def advanced(arrangement: Any, state: Any) -> Any:
        return jax.block_until_ready(step(problem, arrangement, state, state.rates.timestep))

    state, times, sorts = advanced(arrangement, state), [], 0
    first_step = clock() - ready
    for _ in range(steps):
        if stale(problem, arrangement, state):  # as in a run: lists that do not hold cost a pass over all pairs
            state, arrangement = rearranged(problem, state)
            sorts += 1
        begin = clock()
        state = advanced(arrangement, state)
        times.append(clock() - begin)
    effect, own, fluid = problem.effects[0], arrangement.own["gravity"], state.rates.fluid
    gravity = jax.jit(lambda own, fluid: effect.own_sums(problem.engine, arrangement.pairs, own, fluid, {}, False))
    jax.block_until_ready(gravity(own, fluid))
    begin = clock()
    jax.block_until_ready(gravity(own, fluid))
    alone = clock() - begin
    peak = held_bytes()
    begin = clock()
    jax.block_until_ready(rearranged(problem, state))
    sorting = clock() - begin
    return {
        "first state": first_state,
        "first step": first_step,
        "step": min(times),
        "sorting": sorting,
        "sorts": max(sorts / steps, 1.0 / STEPS_BETWEEN_SORTS),
        "gravity": alone,
        "bytes": (peak - before) / particles,
        "operations": flops_of_gravity(own),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", nargs="+", type=int, default=None)
    parser.add_argument("--precision", nargs="+", choices=("float64", "mixed"), default=["mixed"])
    parser.add_argument("--force-error", type=float, default=2e-4)
    parser.add_argument("--steps", type=int, default=5)
    parser.add_argument("--peak", type=float, default=67e12, help="operations per second of the device (H200, float32)")
    parser.add_argument("--processor-time", action="store_true", help="of all threads, where others use the CPU, too")
    chosen = parser.parse_args()
    clock = time.process_time if chosen.processor_time else time.perf_counter
    jax.config.update("jax_enable_x64", True)
    on_cpu = jax.default_backend() == "cpu"
    numbers = chosen.particles or ([3_000] if on_cpu else [100_000, 1_000_000, 10_000_000])
    kind = "processor time" if chosen.processor_time else "wall time"
    print(f"{jax.devices()[0].device_kind}, {kind}, force error {chosen.force_error:g}")
    print(
        "| particles | precision | first state, s | first step, s | step, s | sorting, s | sorts a step "
        "| updates/s | gravity, s | share of peak | bytes a particle |"
    )
    print("|---" * 11 + "|")
    for precision in chosen.precision:
        for particles in numbers:
            found = measure(particles, precision, chosen.force_error, chosen.steps, clock)
            whole = found["step"] + found["sorting"] * found["sorts"]
            share = found["operations"] / found["gravity"] / chosen.peak
            print(
                f"| {particles} | {precision} | {found['first state']:.3g} | {found['first step']:.3g} "
                f"| {found['step']:.3g} | {found['sorting']:.3g} "
                f"| {found['sorts']:.2f} | {particles / whole:.3g} "
                f"| {found['gravity']:.3g} | {share:.2%} | {found['bytes']:.0f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
