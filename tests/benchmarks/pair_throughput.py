"""Particles per second of the engines' passes, and what each effect adds to them.

    python tests/benchmarks/pair_throughput.py --engine numba_cpu --particles 10000 100000

A sphere with rho ~ 1/r of random points, Wendland C2, h = 1.2 n^(-1/3): 58 neighbours. The table is printed and written
to tests/benchmarks/results/. Times are the best of several repeats, since other work only ever adds to them; on a
machine that others use, --processor-time counts the time that the threads really had.
"""

import argparse
import importlib
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.effects.catalogue import CATALOGUE, build
from astroinertia.engines.terms import Density, PairTerm, argument_names
from astroinertia.engines.threads import available_threads

KERNEL, ETA = "wendland_c2", 1.2
FORCES = ("pressure", "viscosity", "gravity", "conduction")
RESULTS = Path(__file__).parent / "results"


def power_law_sphere(particles: int, seed: int = 1) -> np.ndarray:
    """Random points (N, 3) in the unit sphere with rho ~ 1/r, so that the mass within r grows as r^2."""
    random = np.random.default_rng(seed)
    direction = random.normal(size=(particles, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    return direction * np.sqrt(random.uniform(size=particles))[:, None]


def best_time(function: Callable[[], Any], repeats: int, clock: Callable[[], float]) -> float:
    """Shortest time of a call, after one that compiles."""
    function()
    times = []
    for _ in range(repeats):
        begin = clock()
        function()
        times.append(clock() - begin)
    return min(times)


def processor_clock() -> float:
    """Processor time of all threads, in seconds a core."""
    return time.process_time() / available_threads()


def timed(engine: Any, function: Callable[..., Any]) -> Callable[..., Any]:
    """A pass of an engine as a function of arrays that returns plain containers when it is done."""
    if engine.name != "xla":
        return lambda *arrays: vars_of(function(*arrays))
    import jax

    held: dict[int, Any] = {}  # a run keeps its arrays on the device

    def on_device(array: Any) -> Any:
        if id(array) not in held:
            held[id(array)] = array, jax.device_put(array)
        return held[id(array)][1]

    # The engine compiles by itself.
    return lambda *arrays: jax.block_until_ready(vars_of(function(*(on_device(array) for array in arrays))))


def vars_of(result: Any) -> Any:
    """A result as plain containers."""
    return vars(result) if isinstance(result, Density) else result


def named_fields(terms: tuple[PairTerm, ...], known: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """`known` with positive random numbers for every other field that the terms name: their values cost nothing."""
    random = np.random.default_rng(2)
    fields = dict(known)
    for term in terms:
        for name in argument_names(term.pair):
            stem, _, side = name.rpartition("_")
            if side in ("i", "j") and stem not in ("h", "W", "dW", "phi", "dphi") and stem not in fields:
                fields[stem] = random.uniform(0.5, 1.5, len(known["mass"]))
        for output in term.outputs:
            if output.of and output.of not in fields:
                fields[output.of] = random.normal(size=known["position"].shape)
    return fields


def measure(
    engine_name: str, precision: str, particles: int, repeats: int, clock: Callable[[], float]
) -> list[tuple[str, float, str]]:
    """Rows (what, rate, unit) for one engine, precision and number of particles."""
    engine = importlib.import_module(f"astroinertia.engines.{engine_name}").Engine(precision=precision)
    position = power_law_sphere(particles)
    start = np.full(particles, 2.0 * particles ** (-1 / 3))
    order, arrangement = engine.arrange(position, start)
    rows = [("arrange", particles / best_time(lambda: engine.arrange(position, start), 3, clock), "particles/s")]
    position, mass = position[np.asarray(order)], np.full(particles, 1.0 / particles)
    tolerance = 1e-5 if precision == "mixed" else 1e-10

    def solver(softening: bool) -> Callable[..., Any]:
        return timed(
            engine, lambda x, m, guess: engine.density(arrangement, KERNEL, x, m, guess, ETA, tolerance, softening)
        )

    plain, softened = solver(False), solver(True)
    length = np.asarray(plain(position, mass, start)["smoothing_length"])
    # A run sorts by the smoothing lengths that it has found.
    order, arrangement = engine.arrange(position, length)
    position, length = position[np.asarray(order)], length[np.asarray(order)]
    nearby = length * (1.0 + 0.02 * np.random.default_rng(4).normal(size=particles))
    for what, guess, solve in (
        ("density, h given", length, plain),
        ("density, h from a guess off by 2%", nearby, plain),
        ("density and zeta, h from a guess off by 2%", nearby, softened),
    ):
        seconds = best_time(lambda guess=guess, solve=solve: solve(position, mass, guess), repeats, clock)
        rows.append((what, particles / seconds, "particles/s"))
    velocity = np.random.default_rng(3).normal(size=(particles, 3))
    known = {"mass": mass, "position": position, "velocity": velocity, "smoothing_length": length}
    effects = {kind: build(kind) for kind in FORCES if kind in CATALOGUE}
    terms: tuple[PairTerm, ...] = ()
    plainer = build("viscosity", {"limiter": "balsara"}).neighbour_terms
    passes = [("pressure + viscosity without reconstruction", effects["pressure"].neighbour_terms + plainer)]
    for kind, effect in effects.items():
        terms += effect.neighbour_terms
        passes.append((kind if kind == FORCES[0] else f"+ {kind}", terms))
    for label, some in passes:
        sums = timed(engine, lambda f, some=some: engine.neighbour_sums(arrangement, KERNEL, some, f))
        fields = named_fields(some, known)
        seconds = best_time(lambda sums=sums, fields=fields: sums(fields), repeats, clock)
        rows.append((f"forces: {label}", particles / seconds, "particles/s"))
    gradients = sum((effect.gradient_terms for effect in effects.values()), ())
    for label, some in (("gradients", gradients[:1]), ("gradients with the viscosity switch", gradients)):
        sums = timed(engine, lambda f, some=some: engine.neighbour_sums(arrangement, KERNEL, some, f))
        fields = named_fields(some, known)
        seconds = best_time(lambda sums=sums, fields=fields: sums(fields), repeats, clock)
        rows.append((label, particles / seconds, "particles/s"))
    direct = effects["gravity"].all_pair_terms
    sums = timed(engine, lambda f: engine.all_pair_sums(arrangement, KERNEL, direct, f))
    seconds = best_time(lambda: sums(known), max(1, repeats // 5), clock)
    rows.append(("direct gravity", particles**2 / seconds, "pairs/s"))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--engine", choices=("numba_cpu", "xla"), default="numba_cpu")
    parser.add_argument("--precision", nargs="+", choices=("float64", "mixed"), default=["mixed", "float64"])
    parser.add_argument("--particles", nargs="+", type=int, default=[10_000, 100_000])
    parser.add_argument("--repeats", type=int, default=20)
    parser.add_argument("--processor-time", action="store_true", help="count processor time, not wall time")
    parser.add_argument("--no-file", action="store_true", help="print the table only")
    chosen = parser.parse_args()
    if chosen.engine == "xla":
        import jax

        jax.config.update("jax_enable_x64", True)
    columns = [(n, precision) for n in chosen.particles for precision in chosen.precision]
    clock = processor_clock if chosen.processor_time else time.perf_counter
    tables = [measure(chosen.engine, precision, n, chosen.repeats, clock) for n, precision in columns]
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    kind = "processor time shared by the cores" if chosen.processor_time else "wall time"
    lines = [f"# {chosen.engine}, {available_threads()} cores, load {load}, {kind}: millions per second", ""]
    lines.append("| pass | " + " | ".join(f"{n} {precision}" for n, precision in columns) + " |")
    lines.append("|---" * (len(columns) + 1) + "|")
    for k, (what, _, unit) in enumerate(tables[0]):
        lines.append(f"| {what} ({unit}) | " + " | ".join(f"{table[k][1] / 1e6:.3g}" for table in tables) + " |")
    text = "\n".join(lines) + "\n"
    print(text)
    if not chosen.no_file:
        RESULTS.mkdir(exist_ok=True)
        (RESULTS / f"pair_throughput_{chosen.engine}.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
