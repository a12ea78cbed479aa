"""Runs of the scenes of particles in sims/ against what is predicted without a pilot: steps, their processor time, and
that of the whole run, with all that a first run compiles.

    NUMBA_NUM_THREADS=1 python tests/benchmarks/predicted_steps.py --keep

Every scene is run with few particles, on the default path, in a process of its own whose caches are empty. Counts of
steps do not depend on the machine. Processor times of steps are those of the steps alone, without what is compiled in
them and without records; the whole run's is that of its process, imports included. Before and after each scene the
cloud that `calibrate` times takes some steps: what those take over what is predicted for them is the machine's pace at
that time, with which predictions are multiplied.
"""

import argparse
import gc
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import jax
from fair_times import RESULTS, machine as machine_in_words, publish, rows_of
from first_runs import CACHES, Compiled
from numba.core import event

from astroinertia.build.assemble import prepare
from astroinertia.costs import machine
from astroinertia.costs.evaluations import evaluation
from astroinertia.costs.prediction import predict
from astroinertia.costs.probe_scenes import CLOUD
from astroinertia.models.sph.evolution import Particles
from astroinertia.run.loop import run_scene
from astroinertia.scene import load
from astroinertia.scene.schema import Scene

SIMS = Path(__file__).parents[2] / "sims"
KEPT = RESULTS / "predicted_steps.json"
FIRST = 2  # steps in which loops are compiled
OF_CLOUD = 400, 30  # particles, and steps of theirs that give the machine's pace
WITHIN = 1.5
NOTE = """\
Ratios are taken over predicted, which is multiplied with the pace of the machine at that time. Times are of the
processor, of one thread. Every run is a first one, with empty caches.

"""


def fewer(scene: Scene, particles: int) -> Scene:
    """The scene with so many particles in all, if it has more."""
    assert scene.particles is not None
    share = min(1.0, particles / scene.particles)

    def of(body: Any) -> Any:
        return body.model_copy(update={"particles": max(16, round(body.particles * share))})

    return scene.model_copy(update={"body": of(scene.body), "bodies": tuple(map(of, scene.bodies))})


def followed(name: str, particles: int) -> dict[str, float]:
    """Run a scene in this process, whose caches are empty: steps, the processor time of a step, and that of all."""
    scene = fewer(load.load_file(SIMS / f"{name}.toml"), particles)
    compiled = Compiled()
    event.register("numba:compile", compiled)
    collected = [0.0]  # seconds in which Python looked at all that was imported, within a step or elsewhere

    def collecting(phase: str, _: dict[str, int]) -> None:
        collected[0] += time.process_time() * (-1.0 if phase == "start" else 1.0)

    gc.callbacks.append(collecting)
    taken: list[float] = []
    advance = Particles.advance

    def timed(body: Particles, *towards: float) -> None:
        aside, begun = compiled.seconds + collected[0], time.process_time()
        advance(body, *towards)
        taken.append(time.process_time() - begun - (compiled.seconds + collected[0] - aside))

    Particles.advance = timed  # type: ignore[method-assign]
    with tempfile.TemporaryDirectory() as folder:
        run_scene(scene, Path(folder, "run"))
    once = sum(taken[FIRST:]) / max(1, len(taken) - FIRST)
    return {"steps": len(taken), "step_seconds": once, "compiling": compiled.seconds, "seconds": time.process_time()}


@contextmanager
def empty_caches() -> Iterator[dict[str, str]]:
    """The environment of a process whose caches are empty."""
    with tempfile.TemporaryDirectory() as folder:
        yield os.environ | {key: str(Path(folder, place)) for key, place in CACHES.items()}


def in_a_process(name: str, particles: int) -> dict[str, float]:
    """The same in a process of its own; nothing where the run does not end well."""
    with empty_caches() as environment:
        command = [sys.executable, __file__, "--follow", name, "--particles", str(particles)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        print(name, done.stderr.strip().rpartition("\n")[2], file=sys.stderr, flush=True)
        return {}
    return json.loads(done.stdout.splitlines()[-1])


def cloud() -> Scene:
    """The cloud that gives the machine's pace."""
    return load.loads(CLOUD, [f"body.particles={OF_CLOUD[0]}", "numerics.precision=float64"])


def of_cloud() -> float:
    """The processor time of one of its steps now."""
    scene, steps = cloud(), OF_CLOUD[1]
    with jax.enable_x64(True):
        body: Any = prepare(scene).evolution
        for _ in range(FIRST):
            body.advance(body.end)
        begun = time.process_time()
        for _ in range(steps):
            body.advance(body.end)
    return (time.process_time() - begun) / steps


def pace(row: dict[str, Any]) -> float:
    """What the cloud's steps took beside a row, over what they are predicted to take."""
    costs = evaluation(cloud(), OF_CLOUD[0], machine.current())
    return row["cloud_seconds"] / sum(cost.processor for cost in costs.values())


def row_of(name: str, particles: int) -> dict[str, Any] | None:
    """The row of a scene; None for one without particles, and for one whose particles are not known beforehand."""
    scene = load.load_file(SIMS / f"{name}.toml")
    if scene.model != "sph" or scene.particles is None or scene.numerics.engine != "numba_cpu":
        return None
    before = of_cloud()
    found = in_a_process(name, particles)
    beside = 0.5 * (before + of_cloud())
    return {"particles": particles, **found, "cloud_seconds": beside} if found else None


def with_prediction(name: str, row: dict[str, Any]) -> dict[str, Any]:
    """A row with what is predicted now: steps, what they take, and the whole run."""
    scene = fewer(load.load_file(SIMS / f"{name}.toml"), row["particles"])
    known = machine.current()
    kept = os.environ.copy()
    with empty_caches() as environment:
        os.environ.update(environment)
        try:
            prediction = predict(scene, known)
        finally:
            os.environ.clear()
            os.environ.update(kept)
    if prediction is None:
        return row
    beside = pace(row)
    of_steps = beside * sum(cost.processor for part, cost in prediction.parts.items() if part.startswith("steps"))
    return row | {
        "predicted": prediction.steps, "predicted_steps_seconds": of_steps,
        "predicted_seconds": beside * prediction.time.processor, "pace": beside,
    }  # fmt: skip


def ratios_of(row: dict[str, Any]) -> tuple[float, float, float, float]:
    """Of steps, a step's time, that of all steps and that of the run, over their predictions."""
    count = row["steps"] / row["predicted"]
    steps = row["steps"] * row["step_seconds"] / row["predicted_steps_seconds"]
    return count, steps / count, steps, row.get("seconds", math.nan) / row["predicted_seconds"]


def cells_of(name: str, row: dict[str, Any]) -> list[Any]:
    """A row of the table."""
    seconds = row["steps"] * row["step_seconds"]
    run = f"{row['seconds']:.3g}" if "seconds" in row else ""
    if "predicted" not in row:
        return [name, row["particles"], "", row["steps"], "", "", "", f"{seconds:.2g}", "", "", run, "", ""]
    count, once, steps, whole = ratios_of(row)
    return [
        name, row["particles"], f"{row['predicted']:.0f}", row["steps"], f"{count:.2f}", f"{once:.2f}",
        f"{row['predicted_steps_seconds']:.2g}", f"{seconds:.2g}", f"{steps:.2f}",
        f"{row['predicted_seconds']:.3g}", run, f"{whole:.2f}" if run else "", f"{row['pace']:.2f}",
    ]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[""], help="parts of names")
    parser.add_argument("--particles", type=int, default=500)
    parser.add_argument("--follow", help="run this scene here, and say what it took")
    parser.add_argument(
        "--predict-only", action="store_true", help="run nothing: the rows kept before, predicted again"
    )
    parser.add_argument("--keep", action="store_true", help="write the table, with the rows kept before")
    chosen = parser.parse_args()
    if chosen.follow:
        print(json.dumps(followed(chosen.follow, chosen.particles)))
        return
    rows = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    for name in sorted(path.stem for path in SIMS.glob("*.toml") if "[sweep" not in path.read_text()):
        if chosen.predict_only or not any(word in name for word in chosen.only):
            continue
        row = row_of(name, chosen.particles)
        if row is not None:
            rows[name] = row
            print(*cells_of(name, with_prediction(name, row)), flush=True)
            if chosen.keep:
                KEPT.write_text(json.dumps(rows, indent=1) + "\n")
    head = [
        "scene", "particles", "predicted steps", "steps", "ratio", "ratio, of a step", "steps predicted (s)",
        "steps (s)", "ratio", "run predicted (s)", "run (s)", "ratio", "pace",
    ]  # fmt: skip
    rows = {name: with_prediction(name, row) for name, row in sorted(rows.items())}
    predictable = [row for row in rows.values() if "predicted" in row]
    each = zip(*(ratios_of(row) for row in predictable), strict=True)
    good = [sum(1.0 / WITHIN <= ratio <= WITHIN for ratio in ratios) for ratios in each]
    known = "calibrated" if machine.current().calibrated else "by the figures that are shipped"
    text = "# Runs against their predictions\n\n" + NOTE + rows_of(head, [cells_of(*item) for item in rows.items()])
    text += (
        f"\nOf {len(rows)} scenes, steps of {good[0]}, seconds of a step of {good[1]}, of all steps of {good[2]} and of"
        f" the whole run of {good[3]} are within a factor of {WITHIN};"
        f" {len(rows) - len(predictable)} have no prediction.\n"
    )
    publish("predicted_steps", f"{text}\n{machine_in_words()}; costs {known}.\n", chosen.keep)


if __name__ == "__main__":
    main()
