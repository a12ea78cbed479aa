"""What an interpreter finds that has made nothing but what a scene calls for: run by `audit.absence.audited`.

Reads {"scene": TOML text, "origin": folder, "overrides": [...], "leave_out": kind or null, "steps": number} from its
input and writes what it found as JSON.
"""

import gc
import hashlib
import json
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import jax
import numpy as np

from astroinertia.audit import operations, programs
from astroinertia.build.assemble import prepare
from astroinertia.engines.numba_cache import kernel_directory
from astroinertia.scene import load
from astroinertia.scene.schema import Scene

ENOUGH = 128  # particles: how many there are changes no operation


def counts(scene: Scene) -> dict[str, Any]:
    """Operations, arrays and objects of each effect in one step of the scene."""
    scene = scene.with_bodies(lambda body: {"particles": ENOUGH, "relax": False})  # few, and not settled
    with jax.enable_x64(True):
        prepared = prepare(scene)
        evolution = prepared.evolution
        evolution.advance(1e-3 * prepared.outputs.end)
    texts = generated()
    owners = {entry.made.__module__: kind for kind, entry in scene.entries.items()}
    objects = Counter(map(type, gc.get_objects()))  # what tracing makes is not the scene's
    program = programs.traced(scene, evolution)
    return {
        "objects": {kind: objects[entry.made] for kind, entry in scene.entries.items()},
        "generated": sorted(texts),
        "compiled": operations.added(operations.of_text(text, owners) for text in texts.values()),
        "traced": {} if program is None else dict(operations.of_trace(program)),
        "program": ""
        if program is None
        else hashlib.sha256(program.pretty_print(name_stack=True).encode()).hexdigest(),
        "arrays": arrays(evolution) if scene.model == "sph" else {},
    }


def generated() -> dict[str, str]:
    """{name: text} of the modules that the numba engine has made and loaded."""
    folder = kernel_directory()
    files = {name: getattr(module, "__file__", None) for name, module in list(sys.modules.items())}
    return {name: Path(file).read_text() for name, file in files.items() if file and Path(file).parent == folder}


def arrays(evolution: Any) -> dict[str, int]:
    """{effect: arrays that a state of particles holds for it}: sums, gradients, memories, points beside the fluid."""
    state, problem = evolution.state, evolution.problem
    fluid = state.rates.fluid
    counts: dict[str, int] = {}
    for group in (fluid.sums, fluid.gradients or {}, state.points):
        for kind, held in group.items():
            counts[kind] = counts.get(kind, 0) + len(jax.tree.leaves(held))
    owners = {name: effect.kind for effect in problem.effects for name in effect.initial_memory(np, fluid)}
    for name in fluid.memory:
        kind = owners.get(name, operations.COMMON)
        counts[kind] = counts.get(kind, 0) + 1
    return counts


def timed(scene: Scene, leave_out: str | None, steps: int) -> dict[str, Any]:
    """Seconds of a step of the scene, or of it without an effect: the median of several."""
    if leave_out is not None:
        scene = scene.model_copy(update={"effects": {k: v for k, v in scene.effects.items() if k != leave_out}})
    with jax.enable_x64(True):
        evolution = prepare(scene).evolution
        spent = []
        for _ in range(steps + 1):
            begun = time.perf_counter()
            evolution.advance(float("inf"))
            spent.append(time.perf_counter() - begun)
    return {"seconds": float(np.median(spent[1:]))}


def main() -> None:
    """Answer what the input asks."""
    question = json.loads(sys.stdin.read())
    scene = load.loads(question["scene"], question["overrides"], question["origin"])
    answer = timed(scene, question["leave_out"], question["steps"]) if question["steps"] else counts(scene)
    sys.stdout.write(json.dumps(answer) + "\n")


if __name__ == "__main__":
    main()
