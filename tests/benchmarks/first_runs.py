"""First runs of the scenes of particles in sims/, for which everything is compiled: processor time, and how much of it.

    python tests/benchmarks/first_runs.py --keep

Each run is a process of its own with caches of its own, of a few steps with few particles. `--label` names the columns
that are written, so that two versions stand beside each other.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from fair_times import RESULTS, machine, publish, rows_of
from numba.core import event

SIMS = Path(__file__).parents[2] / "sims"
KEPT = RESULTS / "first_runs.json"
CACHES = {"NUMBA_CACHE_DIR": "numba", "ASTROINERTIA_CACHE": "kernels", "JAX_COMPILATION_CACHE_DIR": "jax"}
COMPILED = "/jax/core/compile/backend_compile_duration"
NOTE = """\
Processor time of a process that makes {steps} steps of a scene with {particles} particles (two bodies: as they are)
and empty caches. Compiling: what numba needs of it for its programs, those that Python calls, and the functions that
they are made of. JAX: the clock's time of compiling what it runs. Scenes that cannot be made so small have none.

"""


class Compiled(event.Listener):
    """Counts what numba compiles, and the processor time of that."""

    def __init__(self) -> None:
        self.seconds, self.programs, self.functions, self._depth = 0.0, 0, 0, 0

    def on_start(self, event: Any) -> None:
        """A function is compiled from now on, perhaps for another."""
        if self._depth == 0:
            self.programs += 1
            self.seconds -= time.process_time()
        self.functions += 1
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """It is compiled."""
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.process_time()


def first_run(name: str, particles: int, steps: int) -> dict[str, float]:
    """Make the first run of a scene in this process, whose caches are empty."""
    import jax

    from astroinertia.run.loop import run_scene
    from astroinertia.scene.load import load_file

    jaxed: list[float] = []
    jax.monitoring.register_event_duration_secs_listener(
        lambda what, s, **_: jaxed.append(s) if what == COMPILED else 0
    )
    compiled = Compiled()
    event.register("numba:compile", compiled)
    file = SIMS / f"{name}.toml"
    fewer = [] if load_file(file).bodies else [f"body.particles={particles}"]
    scene = load_file(file, [*fewer, f"time.max_steps={steps}"])
    with tempfile.TemporaryDirectory() as folder:
        run_scene(scene, Path(folder, "run"))
    return {
        "processor": time.process_time(), "compiling": compiled.seconds, "programs": compiled.programs,
        "functions": compiled.functions, "jax": sum(jaxed),
    }  # fmt: skip


def of_particles() -> list[str]:
    """Names of the scenes whose number of particles can be chosen."""
    from astroinertia.scene.load import load_file

    files = [file for file in sorted(SIMS.glob("*.toml")) if "[sweep" not in file.read_text()]
    scenes = {file.stem: load_file(file) for file in files}
    return [name for name, scene in scenes.items() if scene.model == "sph" and scene.particles]


def in_a_process(name: str, particles: int, steps: int) -> dict[str, float]:
    """The figures of a first run in a process of its own; none where the run does not end well."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {key: str(Path(folder, place)) for key, place in CACHES.items()}
        command = [sys.executable, __file__, "--first", name, "--particles", str(particles), "--steps", str(steps)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        print(name, done.stderr.strip().rpartition("\n")[2], file=sys.stderr)
        return {}
    return json.loads(done.stdout.splitlines()[-1])


def table(kept: dict[str, Any], particles: int, steps: int) -> str:
    """The note, a row a scene and columns for each label."""
    text = "# First runs of every scene\n\n" + NOTE.format(particles=particles, steps=steps)
    labels = list(kept)
    columns = {
        "processor": "processor (s)", "compiling": "compiling (s)", "programs": "programs", "functions": "functions",
        "jax": "JAX (s)",
    }  # fmt: skip
    head = [f"{title}, {label}" for title in columns.values() for label in labels]
    names = sorted({name for label in labels for name in kept[label]["scenes"]})
    rows = [
        [name, *(shown(kept[label]["scenes"].get(name, {}).get(key)) for key in columns for label in labels)]
        for name in names
    ]
    both = [name for name in names if all(kept[label]["scenes"].get(name) for label in labels)]
    means = [sum(kept[label]["scenes"][n][key] for n in both) / len(both) for key in columns for label in labels]
    rows.append([f"mean of the {len(both)} that have all", *map(shown, means)])
    machines = "".join(f"\n{label}: {kept[label]['machine']}.\n" for label in labels)
    return text + rows_of(["scene", *head], rows) + machines


def shown(value: float | None) -> str:
    """A number in a cell."""
    return "" if value is None else f"{value:.3g}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", help="make the first run of this scene here, and say what it took")
    parser.add_argument("--only", nargs="+", help="scenes of sims/")
    parser.add_argument("--particles", type=int, default=500)
    parser.add_argument("--steps", type=int, default=3)
    parser.add_argument("--label", default="now", help="of the columns")
    parser.add_argument("--keep", action="store_true", help="write the table, with the columns kept before")
    chosen = parser.parse_args()
    if chosen.first:
        print(json.dumps(first_run(chosen.first, chosen.particles, chosen.steps)))
        return
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    column = kept.setdefault(chosen.label, {"scenes": {}})
    for name in chosen.only or of_particles():
        column["machine"] = machine()
        column["scenes"][name] = in_a_process(name, chosen.particles, chosen.steps)
        print(name, column["scenes"][name], flush=True)
        if chosen.keep:
            KEPT.write_text(json.dumps(kept, indent=1) + "\n")
    publish("first_runs", table(kept, chosen.particles, chosen.steps), chosen.keep)


if __name__ == "__main__":
    main()
