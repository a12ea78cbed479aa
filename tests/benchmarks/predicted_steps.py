"""Steps and their processor time against what is predicted without a pilot, for the scenes of particles in sims/.

    NUMBA_NUM_THREADS=1 python tests/benchmarks/predicted_steps.py --keep

Run it twice: individual steps compile some of their loops later than in the first steps.

Every scene is run in memory with few particles, on the default path, until its end or until it has taken so much
processor time; one that is cut short is compared with what was predicted up to there. Counts of steps do not depend on
the machine; processor times are those of the steps alone, without what is compiled in the first two and without
records. Before and after each scene the cloud that `calibrate` times takes some steps: what those take over what is
predicted for them is the machine's pace at that time, with which predictions are multiplied.
"""

import argparse
import json
import time
from pathlib import Path
from typing import Any

import jax
import numpy as np
from fair_times import RESULTS, machine as machine_in_words, publish, rows_of

from astroinertia.build.assemble import outputs_of, prepare
from astroinertia.costs import machine
from astroinertia.costs.evaluations import SHARES, evaluation
from astroinertia.costs.prediction import predict
from astroinertia.costs.probe_scenes import CLOUD
from astroinertia.errors import AstroinertiaError
from astroinertia.scene import load
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene

SIMS = Path(__file__).parents[2] / "sims"
KEPT = RESULTS / "predicted_steps.json"
FIRST = 2  # steps in which loops are compiled
OF_CLOUD = 400, 30  # particles, and steps of theirs that give the machine's pace
WITHIN = 1.5
NOTE = """\
Ratios are taken over predicted, which is multiplied with the pace of the machine at that time. A scene without a
prediction has none for its steps beforehand: a pilot run counts them (`plan --pilot`). Rows without a pace were
measured on a quiet machine, before few particles had programs of their own.

"""


def fewer(scene: Scene, particles: int) -> Scene:
    """The scene with so many particles in all, if it has more."""
    assert scene.particles is not None
    share = min(1.0, particles / scene.particles)

    def of(body: Any) -> Any:
        return body.model_copy(update={"particles": max(16, round(body.particles * share))})

    return scene.model_copy(update={"body": of(scene.body), "bodies": tuple(map(of, scene.bodies))})


def followed(scene: Scene, longest: float) -> tuple[int, float, float]:
    """Steps, the share of the time that they have covered, and the processor time of a step."""
    with jax.enable_x64(True):
        body: Any = prepare(scene).evolution
        outputs = outputs_of(scene, code_units(scene))
        end, every = outputs.end, outputs.series_every if outputs.align else None
        begun = time.process_time()
        since = begun
        while body.time < end * (1.0 - 1e-14) and time.process_time() - since < longest:
            passed = 0 if every is None else int(body.time / every * (1.0 + 1e-12)) + 1
            body.advance(end if every is None else min(end, passed * every))
            if body.steps == FIRST:
                begun = time.process_time()
    taken = time.process_time() - begun
    return body.steps, min(1.0, float(body.time / end)), taken / max(1, body.steps - FIRST)


def pace() -> float:
    """What steps of a cloud take now over what they are predicted to take, by processor time."""
    particles, steps = OF_CLOUD
    scene = load.loads(CLOUD, [f"body.particles={particles}", "numerics.precision=float64"])
    with jax.enable_x64(True):
        body: Any = prepare(scene).evolution
        for _ in range(FIRST):
            body.advance(body.end)
        begun = time.process_time()
        for _ in range(steps):
            body.advance(body.end)
    taken = (time.process_time() - begun) / steps
    return taken / sum(cost.processor for cost in evaluation(scene, particles, machine.current()).values())


def row_of(name: str, particles: int, longest: float) -> dict[str, Any] | None:
    """The row of a scene; None for one without particles, and for one whose particles are not known beforehand."""
    scene = load.load_file(SIMS / f"{name}.toml")
    if scene.model != "sph" or scene.particles is None or scene.numerics.engine != "numba_cpu":
        return None
    before = pace()
    steps, reached, once = followed(fewer(scene, particles), longest)
    beside = 0.5 * (before + pace())
    return {"particles": particles, "steps": steps, "reached": reached, "step_seconds": once, "pace": beside}


def with_prediction(name: str, row: dict[str, Any]) -> dict[str, Any]:
    """A row with the steps that are predicted now, and what they take."""
    scene = fewer(load.load_file(SIMS / f"{name}.toml"), row["particles"])
    prediction = predict(scene, machine.current())
    if prediction is None:
        return row
    done = float(np.interp(row["reached"], np.linspace(0.0, 1.0, SHARES + 1), prediction.done))
    processor = sum(cost.processor for part, cost in prediction.parts.items() if part.startswith("steps"))
    processor *= row.get("pace", 1.0)
    return row | {"predicted": prediction.steps * done, "predicted_seconds": processor * done}


def of_a_step(row: dict[str, Any]) -> float:
    """Seconds of a step over their prediction."""
    return row["step_seconds"] * row["predicted"] / row["predicted_seconds"]


def pace_of(row: dict[str, Any]) -> str:
    """The machine's pace beside a row; empty in rows of before, which are of a quiet machine."""
    return f"{row['pace']:.2f}" if "pace" in row else ""


def cells_of(name: str, row: dict[str, Any]) -> list[Any]:
    """A row of the table."""
    start = [name, row["particles"], f"{100 * row['reached']:.0f} %"]
    seconds = row["steps"] * row["step_seconds"]
    if "predicted" not in row:
        return [*start, "", row["steps"], "", "", f"{seconds:.2g}", "", "", pace_of(row)]
    return [
        *start, f"{row['predicted']:.0f}", row["steps"], f"{row['steps'] / row['predicted']:.2f}",
        f"{row['predicted_seconds']:.2g}", f"{seconds:.2g}", f"{seconds / row['predicted_seconds']:.2f}",
        f"{of_a_step(row):.2f}", pace_of(row),
    ]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[""], help="parts of names")
    parser.add_argument("--particles", type=int, default=500)
    parser.add_argument("--longest", type=float, default=60.0, help="seconds of processor time of a scene's steps")
    parser.add_argument(
        "--predict-only", action="store_true", help="run nothing: the rows kept before, predicted again"
    )
    parser.add_argument("--keep", action="store_true", help="write the table, with the rows kept before")
    chosen = parser.parse_args()
    rows = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    for name in sorted(path.stem for path in SIMS.glob("*.toml")):
        if chosen.predict_only or not any(word in name for word in chosen.only):
            continue
        try:
            row = row_of(name, chosen.particles, chosen.longest)
        except AstroinertiaError as error:  # so few particles do not make this body
            print(name, error, flush=True)
            continue
        if row is not None:
            rows[name] = row
            print(*cells_of(name, with_prediction(name, row)), flush=True)
            if chosen.keep:
                KEPT.write_text(json.dumps(rows, indent=1) + "\n")
    head = [
        "scene",
        "particles",
        "of its time",
        "predicted steps",
        "steps",
        "ratio",
        "predicted (s)",
        "taken (s)",
        "ratio",
        "ratio, of a step",
        "pace",
    ]
    rows = {name: with_prediction(name, row) for name, row in sorted(rows.items())}
    predictable = [row for row in rows.values() if "predicted" in row]
    counts = [row["steps"] / row["predicted"] for row in predictable]
    once = [of_a_step(row) for row in predictable]
    whole = [count * seconds for count, seconds in zip(counts, once, strict=True)]
    good, quick, both = (sum(1.0 / WITHIN <= ratio <= WITHIN for ratio in ratios) for ratios in (counts, once, whole))
    count = (
        f"Of {len(rows)} scenes, steps of {good}, seconds of a step of {quick}, and of all steps of {both} are within"
    )
    count += f" a factor of {WITHIN};"
    known = "calibrated" if machine.current().calibrated else "by the figures that are shipped"
    text = "# Steps against their predictions\n\n" + NOTE + rows_of(head, [cells_of(*item) for item in rows.items()])
    text += f"\n{count} {len(rows) - len(predictable)} have no prediction.\n"
    publish("predicted_steps", f"{text}\n{machine_in_words()}; costs {known}.\n", chosen.keep)


if __name__ == "__main__":
    main()
