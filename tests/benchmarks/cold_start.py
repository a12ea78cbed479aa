"""A first run, for which everything is compiled, and the next one, which finds it: processor and wall time.

    python tests/benchmarks/cold_start.py --keep

Both are processes of their own, with caches of their own. `--label` names the column that is written, so that two
versions stand beside each other with their ratio; `--settings` are for `--set`. Other work on the machine adds to all
times: how much is measured by a fixed loop before and after, and stated.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from fair_times import RESULTS, machine, publish, rows_of

SIMS = Path(__file__).parents[2] / "sims"
KEPT = RESULTS / "cold_start.json"
NOTE = """\
Processor time (user and system) and wall time of `astroinertia run` with empty caches, and once more. Programs: what
Python calls of compiled functions. Loop: a fixed amount of work in Python, which says how busy the machine was.

"""
CACHES = {"NUMBA_CACHE_DIR": "numba", "ASTROINERTIA_CACHE": "kernels", "JAX_COMPILATION_CACHE_DIR": "jax"}


def fixed_loop() -> float:
    """Seconds of processor time that some work takes, which is always the same."""
    before, total = time.process_time(), 0
    for k in range(5_000_000):
        total += k
    return time.process_time() - before


def run(scene: str, settings: list[str], folder: Path, output: str) -> tuple[float, float]:
    """Processor and wall seconds of one run with the caches of a folder."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    options = [word for setting in settings for word in ("--set", setting)]
    command = [sys.executable, "-m", "astroinertia", "run", str(SIMS / f"{scene}.toml"), *options]
    environment = os.environ | {name: str(folder / place) for name, place in CACHES.items()}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    subprocess.run([*command, "--output", output], cwd=folder, check=True, env=environment, **quiet)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall


def measured(scene: str, settings: list[str]) -> dict[str, float]:
    """All figures of one column, by the names of their rows."""
    burden = fixed_loop()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        first, next_one = run(scene, settings, folder, "first"), run(scene, settings, folder, "next")
        programs = len(list((folder / "numba").rglob("*.nbi")))
    burden = 0.5 * (burden + fixed_loop())
    return {
        "first run, processor (s)": first[0], "first run, wall (s)": first[1],
        "next run, processor (s)": next_one[0], "next run, wall (s)": next_one[1],
        "compiling, processor (s)": first[0] - next_one[0], "programs": programs, "loop (s)": burden,
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="pulsar_collapse", help="of sims/")
    parser.add_argument("--settings", nargs="*", default=["body.particles=500"])
    parser.add_argument("--label", default="now", help="head of the column")
    parser.add_argument("--keep", action="store_true", help="write the table, with the columns kept before")
    chosen = parser.parse_args()
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    what = f"{chosen.scene}, {', '.join(chosen.settings)}"
    column = {"figures": measured(chosen.scene, chosen.settings), "machine": machine()}
    kept.setdefault(what, {})[chosen.label] = column
    if chosen.keep:
        KEPT.write_text(json.dumps(kept, indent=1) + "\n")
    text = "# First runs, and the next\n\n" + NOTE
    for name, columns in kept.items():
        opening, *others = (each["figures"] for each in columns.values())
        rows = []
        for row in opening:
            last = [f"{others[-1][row] / opening[row]:.2f}"] if others else []
            rows.append([row, *(f"{figures[row]:.3g}" for figures in (opening, *others)), *last])
        text += f"## {name}\n\n" + rows_of(["", *columns, *(["ratio"] if others else [])], rows)
        text += "".join(f"\n{label}: {each['machine']}.\n" for label, each in columns.items()) + "\n"
    publish("cold_start", text.rstrip() + "\n", chosen.keep)


if __name__ == "__main__":
    main()
