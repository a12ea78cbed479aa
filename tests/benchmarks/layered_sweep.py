"""A sweep of 1e5 two-layer bodies: moment ratio, Love number k_2, J2 and flattening of each, and their gradients.

    python tests/benchmarks/layered_sweep.py
    python tests/benchmarks/layered_sweep.py --members 1000000 --keep

Core radius, core density and rotation are drawn at random; compiled time and the first call's (which compiles) are
printed, with the largest departure of the sweep from the closed form. With `--keep` the table goes to
tests/benchmarks/results/layered_sweep.md.
"""

import argparse
import os
import platform
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.bodies.clairaut import hydrostatic_figure
from astroinertia.bodies.layered import constant_layers

RESULTS = Path(__file__).parent / "results"


def quantities(parameters):
    """(moment ratio, k_2, J2, flattening) of one body of unit radius and mantle density."""
    core, density, rate = parameters
    body = constant_layers(jnp.stack([core, jnp.ones_like(core)]), jnp.stack([density, jnp.ones_like(density)]))
    figure = hydrostatic_figure(body, rate)
    return jnp.stack([body.moment_ratio, figure.love_number, figure.j2, figure.flattening])


def closed_form(parameters):
    """The moment ratio and k_2 of two constant layers, written out."""
    x, ratio, _ = parameters.T
    mean = 1 + (ratio - 1) * x**3
    inner = 3 * (ratio - 1) / (5 * ratio)
    outside, inside = 1 - inner, inner * x**5
    surface = 3 / (5 * mean) * (outside + inside)
    return np.stack([0.4 * (1 + (ratio - 1) * x**5) / mean, (inside + surface) / (outside - surface)], axis=1)


def main() -> None:
    """Time the sweep and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--members", type=int, default=100_000)
    parser.add_argument("--keep", action="store_true", help="write the table to tests/benchmarks/results")
    options = parser.parse_args()
    random = np.random.default_rng(1)
    drawn = random.uniform([0.05, 1.0, 0.01], [0.95, 5.0, 0.1], size=(options.members, 3))
    rows = ["| | first call (s) | next call (s) |", "|---|---|---|"]
    with jax.enable_x64(True):
        sweep = jax.jit(jax.vmap(quantities))
        for name, function in (
            ("quantities", sweep),
            ("and their gradients", jax.jit(jax.vmap(jax.jacrev(quantities)))),
        ):
            took = []
            for _ in range(2):
                begin = time.perf_counter()
                function(drawn).block_until_ready()
                took.append(time.perf_counter() - begin)
            rows.append(f"| {name} | {took[0]:.2f} | {took[1]:.3f} |")
        found = np.asarray(sweep(drawn))
    worst = np.abs(found[:, :2] / closed_form(drawn) - 1).max()
    machine = f"{os.cpu_count()} cores, {platform.machine()}, jax {jax.__version__}"
    text = f"# {options.members} two-layer bodies\n\n{machine}; worst departure from the closed form {worst:.0e}.\n\n"
    text += "\n".join(rows) + "\n"
    print(text)
    if options.keep:
        (RESULTS / "layered_sweep.md").write_text(text)


if __name__ == "__main__":
    main()
