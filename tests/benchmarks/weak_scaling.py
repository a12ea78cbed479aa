"""Passes of the xla engine on 1, 2, 4 and 8 virtual devices with a fixed number of particles each, and a plan to 1e9.

    python tests/benchmarks/weak_scaling.py --particles 2000 --keep

Evrard's cloud, float64. What a device receives is read off the compiled program: the arrays of all its collectives. The
devices are virtual: they share the cores of this machine, so that processor time and the work of each device are shown,
and wall time says nothing about real ones. The plan to 1e9 particles is in scaling_plan.py.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from fair_times import machine, publish, rows_of
from scaling_plan import plan

COUNTS = (1, 2, 4, 8)
FORCE_ERROR = 1e-3
BYTES = {"f64": 8, "s64": 8, "f32": 4, "s32": 4, "u32": 4, "pred": 1}
COLLECTIVE = re.compile(r"= (.*?) (all-reduce|all-gather|reduce-scatter|collective-permute|all-to-all)(?:-start)?\(")
SHAPE = re.compile(r"(\w+)\[([\d,]*)\]")


def received(program: str) -> tuple[int, list[str]]:
    """Bytes of the results of all collectives in a compiled program, each counted once, and their names."""
    found = COLLECTIVE.findall(program)
    shapes = [shape for result, _ in found for shape in SHAPE.findall(result)]
    size = sum(BYTES[kind] * int(np.prod([int(n) for n in dims.split(",") if n])) for kind, dims in shapes)
    return size, sorted({name for _, name in found})


def pairs_of_tiles(tiles: Any, particles: int, devices: int) -> list[int]:
    """Pairs in the lists of neighbours by device: chunk c belongs to device c mod D (engines.devices)."""
    used = int(tiles.used)
    targets = (np.asarray(tiles.slots) < particles).sum(axis=1)[np.asarray(tiles.leaf)[:used]]
    sources = (np.asarray(tiles.sources)[:used] < particles).sum(axis=2)
    return shared((targets * sources).sum(axis=1), devices)


def pairs_of_leaves(lists: Any, particles: int, devices: int) -> list[int]:
    """Pairs of gravity's near field by device."""
    used, held = int(lists.near.used), np.append((np.asarray(lists.slots) < particles).sum(axis=1), 0)
    return shared(
        (held[np.asarray(lists.near.target)[:used]] * held[np.asarray(lists.near.source)[:used]]).sum(axis=1), devices
    )


def expansions_of(lists: Any, devices: int) -> list[int]:
    """Nodes taken as wholes by device."""
    used = int(lists.local.used)
    return shared((np.asarray(lists.local.source)[:used] < len(lists.first)).sum(axis=(1, 2)), devices)


def shared(chunks: np.ndarray, devices: int) -> list[int]:
    """Work of each device, from that of the chunks."""
    return [int(chunks[device::devices].sum()) for device in range(devices)]


def passes(particles: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """{pass: (function, its arrays)} of a cloud, and {pass: its work by device, for a number of devices}."""
    from pair_throughput import named_fields, power_law_sphere

    from astroinertia.effects.catalogue import build
    from astroinertia.engines.xla import Engine
    from astroinertia.gravity import multipole_xla
    from astroinertia.sph.kernels import KERNELS

    kernel = "wendland_c2"
    eta, engine = KERNELS[kernel].eta, Engine()
    position, mass = power_law_sphere(particles), np.full(particles, 1.0 / particles)
    length = np.full(particles, 2.0 * particles ** (-1 / 3))
    for _ in range(2):  # a run sorts by the smoothing lengths that it has found
        order, arrangement = engine.arrange(position, length)
        position = position[order]
        found = engine.density(arrangement, kernel, position, mass, length[order], eta, 1e-8, True)
        length = np.asarray(found.smoothing_length)
    known = {"mass": mass, "position": position, "smoothing_length": length}
    known["velocity"] = np.random.default_rng(3).normal(size=position.shape)
    effects = [build(kind) for kind in ("pressure", "viscosity", "gravity")]
    lists = multipole_xla.lists_for(engine, arrangement, mass, None, FORCE_ERROR)
    made: dict[str, Any] = {
        "density": (
            lambda a, x, m, h: vars(engine.density(a, kernel, x, m, h, eta, 1e-8, True)),
            (arrangement, position, mass, length * (1.0 + 0.005 * np.random.default_rng(4).normal(size=particles))),
        ),
        "gravity": (lambda a, m, x, h: multipole_xla.points("float64", a, m, x, h), (lists, mass, position, length)),
    }
    for name in ("gradients", "forces"):
        kind = {"gradients": "gradient_terms", "forces": "neighbour_terms"}[name]
        terms = sum((getattr(effect, kind) for effect in effects), ())
        made[name] = (
            lambda a, fields, terms=terms: engine.neighbour_sums(a, kernel, terms, fields),
            (arrangement, named_fields(terms, known)),
        )
    work = {name: lambda devices: pairs_of_tiles(arrangement.neighbours, particles, devices) for name in made}
    work["gravity"] = lambda devices: pairs_of_leaves(lists, particles, devices)
    work["expansions"] = lambda devices: expansions_of(lists, devices)
    return made, work


def measured(each: int, devices: int, repeats: int) -> dict[str, dict[str, Any]]:
    """What every pass takes on so many devices, in this process."""
    import jax

    from astroinertia.engines.mesh import shared_out

    found = {}
    made, work = passes(each * devices)
    with shared_out(devices):
        for name, (function, given) in made.items():
            compiled = jax.jit(function).lower(*given).compile()
            program, memory = compiled.as_text(), compiled.memory_analysis()
            given = jax.device_put(given, compiled.input_shardings[0])
            jax.block_until_ready(compiled(*given))
            times = []
            for _ in range(repeats):
                begin = np.array([time.perf_counter(), time.process_time()])
                jax.block_until_ready(compiled(*given))
                times.append(np.array([time.perf_counter(), time.process_time()]) - begin)
            wall, processor = np.min(times, axis=0)
            size, collectives = received(program)
            found[name] = {
                "wall": wall, "processor": processor, "pairs": work[name](devices), "received": size,
                "collectives": collectives, "held": memory.argument_size_in_bytes + memory.temp_size_in_bytes,
            }  # fmt: skip
    found["gravity"]["expansions"] = work["expansions"](devices)
    return found


def by_itself(each: int, repeats: int) -> dict[int, dict[str, dict[str, Any]]]:
    """The same for all COUNTS in a process with eight virtual devices."""
    flags = {"XLA_FLAGS": f"--xla_force_host_platform_device_count={COUNTS[-1]}", "JAX_PLATFORMS": "cpu"}
    command = [sys.executable, str(Path(__file__)), "--particles", str(each), "--repeats", str(repeats), "--here"]
    done = subprocess.run(command, env={**os.environ, **flags}, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    content = json.loads(done.stdout[done.stdout.index("{") :])
    return {int(devices): figures for devices, figures in content.items()}


def uneven(work: list[int]) -> str:
    """The work of the busiest device over the mean."""
    return f"{max(work) / (sum(work) / len(work)):.3f}"


def table(found: dict[int, dict[str, dict[str, Any]]], each: int) -> str:
    """What was measured, a row for each number of devices and pass."""
    rows = []
    for name in ("forces", "gravity"):
        for devices, figures in found.items():
            mine, one = figures[name], found[1][name]
            ratio = mine["processor"] / devices / one["processor"]
            extra = uneven(mine["expansions"]) if "expansions" in mine else ""
            rows.append([
                name, devices, each * devices, f"{np.mean(mine['pairs']) / 1e6:.3f}", uneven(mine["pairs"]), extra,
                f"{mine['processor'] / devices:.3f}", f"{ratio:.2f}", f"{mine['wall']:.3f}",
                f"{mine['received'] / 1e6:.3f}", f"{mine['received'] / (each * devices):.0f}",
                f"{mine['held'] / 1e6:.1f}",
            ])  # fmt: skip
    head = ["pass", "devices", "particles", "million pairs a device", "busiest over mean", "the same, expansions",
            "processor s a device", "over one device", "wall s", "MB received", "bytes a particle",
            "MB held"]  # fmt: skip
    return rows_of(head, rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, default=2000, help="of each device")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--here", action="store_true", help="measure in this process and print JSON")
    parser.add_argument("--keep", action="store_true", help="write the table")
    chosen = parser.parse_args()
    if chosen.here:
        import jax

        with jax.enable_x64(True):
            times = {devices: measured(chosen.particles, devices, chosen.repeats) for devices in COUNTS}
        print(json.dumps(times))
        return
    found = by_itself(chosen.particles, chosen.repeats)
    most = found[COUNTS[-1]]
    particles = chosen.particles * COUNTS[-1]
    text = f"# Weak scaling of the xla engine over devices\n\n{machine()}.\n"
    text += (
        f"{chosen.particles} particles a device, float64. The devices are virtual and share the cores, so that wall "
    )
    text += "time cannot be judged here: processor time of all devices, divided among them, says what each of them "
    text += "would take if work were shared out evenly, and over that of one device what is done on every device "
    text += "alike, for all particles; below 1 it shows costs that do not grow with the pairs, such as chunks of them "
    text += "that are not full, and says that these bodies are too small to judge by. "
    text += "MB received are those of the results of all collectives in the compiled program "
    names = sorted({name for figures in most.values() for name in figures["collectives"]})
    text += f"({', '.join(names)}), each once; held are arguments and temporary arrays.\n\n"
    text += table(found, chosen.particles)
    a_particle = {name: figures["received"] / particles for name, figures in most.items()}
    text += "\nBytes that every device receives a particle in a pass: "
    text += ", ".join(f"{name} {size:.0f}" for name, size in a_particle.items())
    text += " (density: once in its loop and once after it, so that a few passes take less than as often as much).\n\n"
    held = max(figures["held"] for figures in most.values()) / particles
    publish("weak_scaling", text + plan(a_particle, held), chosen.keep)


if __name__ == "__main__":
    main()
