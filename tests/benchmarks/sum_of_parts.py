"""Whether a scene with k effects takes no longer than the sum of its parts.

    python tests/benchmarks/sum_of_parts.py --keep

All variants of a scene (with each effect by itself, with all, and the base: a field of no force, for no scene is
without an effect) take steps of one length in turn, in one process, so that whatever else the machine does falls on all
alike; processor time of all threads, the median of steps. The part of an effect is what it adds to the least scene that
it can stand in: the base, or the pressure that viscosity and conduction go with. Where effects share work the whole
takes less than the base and all parts together. Scenes that are in the folder already are not measured again.
"""

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np
from fair_times import machine, publish, rows_of

from astroinertia.build.assemble import prepare
from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.models.protocol import Evolution
from astroinertia.scene import load
from astroinertia.scene.schema import Scene

SIMS = Path(__file__).parents[2] / "sims"
COMMON = ("body.relax=false", "numerics.precision='mixed'", "numerics.timesteps='global'")
BASE = {"external_field": {"uniform": (0.0, 0.0, 0.0)}}  # a scene has an effect at least: the cheapest, of no force
_OF_STEP = 0.25  # of the first step of the whole scene, which all variants take: none has to shorten it


@dataclass(frozen=True)
class Case:
    """A scene of sims/ and what is changed in it."""

    name: str
    overrides: tuple[str, ...] = ()


CASES = (
    Case("evrard"),
    Case("jacobi_by_viscosity"),
    Case("made_to_order"),
    Case(
        "contracting_star",  # an energy and a spin of its own, for what stands without gravity
        ("body.specific_internal_energy='3e9 m2/s2'", "body.rotation={law='rigid', rate='2e-8 rad/s'}"),
    ),
    Case("roche_limit"),
    Case("keplerian_disc"),
)


def scene_of(case: Case, particles: int) -> Scene:
    """The scene with so many particles, global steps and pair sums in float32."""
    scene = load.load_file(SIMS / f"{case.name}.toml", [f"body.particles={particles}"])
    relaxed = [each for each in COMMON if not (each.startswith("body.relax") and not hasattr(scene.body, "relax"))]
    return load.load_file(SIMS / f"{case.name}.toml", [f"body.particles={particles}", *relaxed, *case.overrides])


def with_effects(scene: Scene, kinds: Sequence[str], timestep: float | None = None) -> Evolution:
    """The scene with these effects alone, under way; timestep in the scene's unit of time."""
    effects = {kind: options for kind, options in scene.effects.items() if kind in kinds} or BASE
    numerics = scene.numerics
    if timestep is not None:
        numerics = numerics.model_copy(update={"max_timestep": timestep})
    return prepare(scene.model_copy(update={"effects": effects, "numerics": numerics})).evolution


def parts(kinds: Sequence[str]) -> dict[str, tuple[tuple[str, ...], tuple[str, ...]]]:
    """{effect: (the least scene that it can stand in, the same without it)}."""
    least = {kind: tuple(each for each in kinds if each in (kind, *CATALOGUE[kind].needs)) for kind in kinds}
    return {kind: (whole, tuple(each for each in whole if each != kind)) for kind, whole in least.items()}


def first_step(scene: Scene) -> float:
    """The length of the whole scene's first step, in the scene's unit of time."""
    prepared = prepare(scene)
    prepared.evolution.advance(float("inf"))
    return prepared.evolution.time / prepared.outputs.end * scene.time.end


def step_times(scene: Scene, variants: Sequence[tuple[str, ...]], steps: int) -> dict[tuple[str, ...], float]:
    """Processor seconds of a step of each variant, the median of so many that all take in turn."""
    length = _OF_STEP * first_step(scene)
    bodies = {kinds: with_effects(scene, kinds, length) for kinds in variants}
    spent: dict[tuple[str, ...], list[float]] = {kinds: [] for kinds in variants}
    for number in range(steps + 1):  # the first compiles
        for kinds, body in bodies.items():
            begun = time.process_time()
            body.advance(float("inf"))
            if number:
                spent[kinds].append(time.process_time() - begun)
    return {kinds: float(np.median(each)) for kinds, each in spent.items()}


def measured(case: Case, particles: int, steps: int) -> dict[str, Any]:
    """What a step takes, in seconds: the base, what each effect adds, all together."""
    scene = scene_of(case, particles)
    kinds = tuple(scene.effects)
    share = parts(kinds)
    variants = list(dict.fromkeys([(), *(each for pair in share.values() for each in pair), kinds]))
    with jax.enable_x64(True):
        times = step_times(scene, variants, steps)
    added = {kind: times[whole] - times[rest] for kind, (whole, rest) in share.items()}
    return {"particles": scene.particles, "base": times[()], "added": added, "whole": times[kinds]}


def row(name: str, found: dict[str, Any]) -> list[object]:
    """A row of the table."""
    total = found["base"] + sum(found["added"].values())
    added = ", ".join(f"{kind} {1e3 * seconds:.1f}" for kind, seconds in found["added"].items())
    times = (f"{1e3 * seconds:.1f}" for seconds in (total, found["whole"]))
    return [name, found["particles"], f"{1e3 * found['base']:.1f}", added, *times, f"{found['whole'] / total:.2f}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, default=4000)
    parser.add_argument("--steps", type=int, default=24)
    parser.add_argument("--folder", type=Path, default=Path("runs/sum_of_parts"))
    parser.add_argument("--only", nargs="+", default=[case.name for case in CASES])
    parser.add_argument("--keep", action="store_true", help="write the table")
    chosen = parser.parse_args()
    rows = []
    for case in CASES:
        place = chosen.folder / f"{case.name}-{chosen.particles}-{chosen.steps}.json"
        if case.name in chosen.only and not place.exists():
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(json.dumps(measured(case, chosen.particles, chosen.steps)))
        if place.exists():
            rows.append(row(case.name, json.loads(place.read_text())))
    head = ["scene", "particles", "base", "each effect by itself, less the base", "sum", "all together", "ratio"]
    text = (
        f"# A step with several effects against the sum of its parts\n\n{machine()}; processor time of a step in ms, "
        f"the median of {chosen.steps} that all variants take in turn, engine numba_cpu, precision mixed.\n\n"
        + rows_of(head, rows)
        + "\nBase: the particles in a field of no force, for a scene has one effect at least; it is in no other "
        "variant, so that the sum is too small by what it costs, if anything. Viscosity and conduction stand beside "
        "pressure, and count what they add to it.\n"
    )
    publish("sum_of_parts", text, chosen.keep)


if __name__ == "__main__":
    main()
