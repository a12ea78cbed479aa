"""What limits each pass of the numba engine over neighbours: time, memory traffic and arithmetic for each particle.

    python tests/benchmarks/pass_limits.py --particles 100000

The Evrard set (rho ~ 1/r) at the shipped defaults: Wendland C2 with its recommended eta, smoothing tolerance 1e-8, h
from a guess off by half a per cent, viscosity with switch and reconstruction. One thread, processor time, best of many.
Candidates are what a leaf's list holds, pairs what is within reach of a particle. Bytes are those of the tables of
sources that leaves read, and operations those in the text of the loop over pairs, each counted as one (a square root or
a division, too). The table is printed and written to tests/benchmarks/results/.
"""

import argparse
import os
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.effects.catalogue import build
from astroinertia.engines.numba_cpu import Engine
from astroinertia.engines.numba_modules import neighbour_pass
from astroinertia.sph.density import density
from astroinertia.sph.kernels import KERNELS
from tests.benchmarks.pair_throughput import RESULTS, best_time, named_fields, power_law_sphere

KERNEL, TOLERANCE = "wendland_c2", 1e-8
COLUMNS = ("pass", "ns", "candidates", "pairs", "kB read", "GB/s", "operations a pair", "G operations/s")
PROFILE = """
Shares of the time, by sampling the processor's place in the compiled code (mixed precision): density: 30 % search of
the candidates (latency of compaction: one vector of sixteen in some eight cycles), 45 % sums over the listed (three
evaluations, arithmetic), 15 % reading sources. Gradients: 18 % copying sources to the leaf's table (bytes, out of the
second-level cache), 20 % search, 16 % taking it apart (shuffles, one a cycle), 30 % pairs (registers: 26 sums and
what belongs to the target do not fit in 32), 10 % adding up lanes. Forces: 19 % copying, 15 % search, 20 % shuffles,
40 % pairs (arithmetic: three divisions of sixteen cycles each in some 190 instructions). In float64 twice as many
vectors do the same, and the leaf's table (candidates times 192 bytes) is larger than the first-level cache: half of the
time of a force pass is taking it apart. No pass is limited by main memory: sources are read again some 15 times, out of
the caches.
"""


def operations(text: str, entry: str) -> int:
    """Arithmetic operations in the text of the loop over pairs, those of the functions that it calls included."""
    functions = {part.split("(")[0]: part for part in re.split(r"\ndef ", text)[1:]}

    def count(body: str, seen: tuple[str, ...]) -> int:
        lines = [line for line in body.splitlines() if not line.lstrip().startswith(("@", "#"))]
        found = sum(len(re.findall(r"(?<![e\[(,=]) [-+*/<>] |[-+*]= ", line)) for line in lines)
        for name in re.findall(r"(\w+)\(", "\n".join(lines)):
            if name in ("maximum", "minimum", "where", "abs", "larger_of", "sqrt"):
                found += 1
            elif name in functions and name not in seen:
                found += count(functions[name].split("\n", 1)[1], (*seen, name))
        return found

    loop = functions[entry].split("for j in range(")[1]
    return count(loop[: loop.index("np.float64(")], (entry,))


def measure(precision: str, particles: int, repeats: int) -> list[tuple]:
    """Rows of the table for one precision."""
    engine, eta = Engine(precision, threads=1), KERNELS[KERNEL].eta
    position, mass = power_law_sphere(particles), np.full(particles, 1.0 / particles)
    length = np.full(particles, 2.0 * particles ** (-1 / 3))
    for _ in range(2):  # a run sorts by the smoothing lengths that it has found
        order, arrangement = engine.arrange(position, length)
        position = position[order]
        length = density(
            engine, arrangement, KERNEL, position, mass, length[order], eta, TOLERANCE, True
        ).smoothing_length
    guess = length * (1.0 + 0.005 * np.random.default_rng(4).normal(size=particles))
    listed = engine.listed(arrangement, KERNEL, position, guess)
    velocity = np.random.default_rng(3).normal(size=(particles, 3))
    known = {"mass": mass, "position": position, "velocity": velocity, "smoothing_length": length}
    effects = [build(kind) for kind in ("pressure", "viscosity", "gravity")]
    assert listed.lists is not None
    lists = listed.lists.count
    candidates = float(lists.sum()) / len(lists)
    some = range(0, particles, max(1, particles // 500))
    reaches = (2.0 * np.maximum(length, length[k]) for k in some)
    apart = (np.linalg.norm(position - position[k], axis=1) for k in some)
    pairs = float(np.mean([np.sum(r < reach) for r, reach in zip(apart, reaches, strict=True)]))
    leaf = particles / len(lists)

    def row(name: str, run: Callable[[], Any], each: float, counted: float, work: int) -> tuple:
        ns = 1e9 * best_time(run, repeats, time.process_time) / particles
        read = candidates / leaf * each
        return name, ns, candidates, counted, read / 1e3, read / ns, work, work * counted / ns

    rows = [
        row("lists", lambda: engine.listed(arrangement, KERNEL, position, guess), 40.0, np.nan, 0),
        row(
            "density",
            lambda: density(engine, listed, KERNEL, position, mass, guess, eta, TOLERANCE, True),
            32.0,
            neighbours(eta),
            3 * 13 + 8,
        ),
    ]
    for name in ("gradient_terms", "neighbour_terms"):
        terms = sum((getattr(effect, name) for effect in effects), ())
        made = neighbour_pass(KERNEL, terms, precision, False)
        entry = next(n for n in vars(made.module) if n.startswith("neighbour_leaf"))
        work = operations(Path(str(made.module.__file__)).read_text(encoding="utf-8"), entry)
        fields = named_fields(terms, known)
        label = {"gradient_terms": "gradients", "neighbour_terms": "forces"}[name]
        rows.append(
            row(
                label,
                lambda terms=terms, fields=fields: engine.neighbour_sums(listed, KERNEL, terms, fields),
                8.0 * made.width,
                pairs,
                work,
            )
        )
    return rows


def neighbours(eta: float) -> float:
    """Particles within the support, the particle itself included."""
    return 4.0 / 3.0 * np.pi * (KERNELS[KERNEL].support * eta) ** 3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=20)
    chosen = parser.parse_args()
    lines = []
    for precision in ("mixed", "float64"):
        load = f"load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown load"
        lines += [f"# numba_cpu, {precision}, {chosen.particles} particles: for each particle, on one core, {load}", ""]
        lines += ["| " + " | ".join(COLUMNS) + " |", "|---" * len(COLUMNS) + "|"]
        for name, *values in measure(precision, chosen.particles, chosen.repeats):
            lines.append(f"| {name} | " + " | ".join("" if np.isnan(v) else f"{v:.3g}" for v in values) + " |")
        lines.append("")
    text = "\n".join(lines) + PROFILE
    print(text)
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / "pass_limits_numba_cpu.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
