"""Evrard's collapse here, with SWIFT and with Phantom: what errors of the peaks cost in time, one thread each.

    python tests/benchmarks/evrard_peers.py --swift src/swift --phantom bin/phantom     # built as evrard_codes.py says

All begin from the same particles and go to t = 1.2. Peaks are parabolas through the three largest of values that are
0.01 apart, beside a converged calculation with spherical shells (tests/reference/evrard.json). Times are of the
processor, of the steps and what they write; here programs are compiled before, and records are made.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from evrard_codes import NEIGHBOURS, SIMS, Length, Ran, run_phantom, run_swift, start
from fair_times import machine, rows_of

from astroinertia.build.assemble import prepare
from astroinertia.engines.threads import available_threads
from astroinertia.scene import load
from astroinertia.test_problems.matter import Matter

HERE = Path(__file__).parent
STORE = HERE / "results" / "evrard_peers"
REFERENCE = HERE.parent / "reference" / "evrard.json"
END, EVERY = 1.2, 0.01
VARIANTS = {
    "here": (),
    "here, whole stress": ('effects.viscosity.stress="whole"', "effects.viscosity.alpha_max=1.0"),
}
WANTED = (0.1, 0.05, 0.03)  # errors of the kinetic peak


def errors_of(times: np.ndarray, kinetic: np.ndarray, internal: np.ndarray) -> dict[str, float]:
    """Relative errors of the peaks of both energies."""
    exact = json.loads(REFERENCE.read_text())["value"]
    found = {}
    for name, values, key in (("kinetic", kinetic, "K_max"), ("internal", internal, "U_max")):
        top = int(np.clip(np.argmax(values), 1, len(values) - 2))
        a, b, _ = np.polyfit(times[top - 1 : top + 2] - times[top], values[top - 1 : top + 2], 2)
        found[name] = float((values[top] - b**2 / (4 * a)) / float(exact[key].partition(" at t=")[0]) - 1)
    return found


def measured(particles: int, *settings: str) -> dict[str, Any]:
    """A run here."""
    scene = load.load_file(SIMS / "evrard.toml", [f"body.particles={particles}", f"time.end={END}", *settings])
    first, body = (prepare(scene).evolution for _ in range(2))
    first.advance(END)  # compiles, and so does a record
    first.record(None)
    records, begun = [body.record(None)], time.process_time()
    for k in range(1, round(END / EVERY) + 1):
        while body.time < k * EVERY * (1 - 1e-12):
            body.advance(k * EVERY)
        records.append(body.record(records[0]["potential_energy"]))
    seconds = time.process_time() - begun
    series = (np.array([record[name] for record in records]) for name in ("time", "kinetic_energy", "internal_energy"))
    return {"seconds": round(seconds, 2), "steps": body.steps, **errors_of(*series)}


def measured_with(run: Callable[[Path, Matter, Length], Ran], program: Path, particles: int) -> dict[str, Any]:
    """A run of another code from the same particles, of whose series those nearest to our times count."""
    ran = run(program, start(particles), Length(END, EVERY))
    times = np.arange(round(END / EVERY) + 1) * EVERY
    nearest = np.abs(ran.series[:, 0] - times[:, None]).argmin(axis=1)
    return {"seconds": round(ran.processor, 2), **errors_of(*ran.series[nearest].T)}


def time_for(rows: list[dict[str, Any]], error: float) -> tuple[float, bool]:
    """Seconds at which a power law between neighbouring runs has that error of the kinetic peak, and whether it is
    beyond the runs.
    """
    seconds, errors = (np.log([abs(row[name]) for row in rows]) for name in ("seconds", "kinetic"))
    k = int(np.clip(np.searchsorted(-errors, -np.log(error)), 1, len(rows) - 1))
    slope = (seconds[k] - seconds[k - 1]) / (errors[k] - errors[k - 1])
    return float(np.exp(seconds[k] + slope * (np.log(error) - errors[k]))), not errors[-1] <= np.log(error) <= errors[0]


def by_code(rows: dict[str, dict[str, Any]]) -> dict[str, dict[int, dict[str, Any]]]:
    """The runs of each code by their particles, from the fewest to the most."""
    found: dict[str, dict[int, dict[str, Any]]] = {}
    for key in sorted(rows, key=lambda key: int(key.partition("/")[2])):
        code, _, particles = key.partition("/")
        found.setdefault(code, {})[int(particles)] = rows[key]
    return found


def picture(rows: dict[str, dict[str, Any]], path: Path) -> None:
    """The errors of both peaks against processor time, with the number of particles at each run."""
    figure, panels = plt.subplots(1, 2, figsize=(10, 4.2), sharex=True, sharey=True, layout="constrained")
    for panel, (name, title) in zip(
        panels, (("kinetic", "kinetic energy"), ("internal", "thermal energy")), strict=True
    ):
        for code, runs in by_code(rows).items():
            seconds, errors = zip(*((row["seconds"], 100 * abs(row[name])) for row in runs.values()), strict=True)
            panel.loglog(seconds, errors, "o-", markersize=4, label=code)
            for particles, *place in zip(runs, seconds, errors, strict=True):
                panel.annotate(f"{particles}", place, (4, 3), textcoords="offset points", fontsize=6)
        panel.set(title=f"peak of the {title}", xlabel="processor time (s)")
        panel.xaxis.set_major_formatter("{x:g}")
        panel.set_yticks((2, 5, 10, 20, 50), ("2", "5", "10", "20", "50"))
        panel.set_yticks((), minor=True)
        panel.margins(x=0.12)
        panel.grid(alpha=0.3, which="both")
    panels[0].set_ylabel("error (%)")
    panels[0].legend(fontsize=8)
    figure.savefig(path, dpi=90)
    plt.close(figure)


def table(rows: dict[str, dict[str, Any]]) -> str:
    """All runs, and the times at which errors are reached."""
    runs = by_code(rows)
    cells = [
        [code, size, f"{row['seconds']:.3g}", *(f"{100 * row[name]:+.1f} %" for name in ("kinetic", "internal"))]
        for code, found in runs.items()
        for size, row in found.items()
    ]
    times = []
    for error in WANTED:
        found = [time_for(list(of_code.values()), error) for of_code in runs.values()]
        times.append([f"{100 * error:g} %", *(f"{spent:.3g}{' *' if beyond else ''}" for spent, beyond in found)])
    heads = ["error of the kinetic peak", *(f"{code} (s)" for code in runs)]
    words = __doc__.strip().split("\n\n")
    return "\n".join([
        f"# {words[0]}\n\n{words[2]}\n",
        f"SWIFT: scheme SPHENIX, quartic spline with {NEIGHBOURS:g} neighbours. Phantom: its defaults, with individual "
        f"steps. {machine()}.\n",
        rows_of(["code", "particles", "processor time (s)", "kinetic peak", "thermal peak"], cells),
        rows_of(heads, times),
        "\\* extrapolated from two runs.\n",
    ])  # fmt: skip


def main() -> None:
    """Measure what is missing, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, nargs="*", default=[500, 1000, 3000, 10_000])
    parser.add_argument("--swift", type=Path, help="program swift")
    parser.add_argument("--phantom", type=Path, help="program phantom")
    options = parser.parse_args()
    if available_threads() != 1:  # Numba takes their number when it is imported
        alone = subprocess.run([sys.executable, *sys.argv], env=os.environ | {"NUMBA_NUM_THREADS": "1"}, check=False)
        sys.exit(alone.returncode)
    store = STORE.with_suffix(".json")
    rows = json.loads(store.read_text()) if store.exists() else {}
    for particles in options.particles:
        jobs: dict[str, Any] = {who: lambda n=particles, s=given: measured(n, *s) for who, given in VARIANTS.items()}
        for who, run, program in (("SWIFT", run_swift, options.swift), ("Phantom", run_phantom, options.phantom)):
            if program:
                jobs[who] = lambda n=particles, r=run, p=program: measured_with(r, p, n)
        for who, job in jobs.items():
            if (key := f"{who}/{particles}") not in rows:
                rows[key] = job()
                store.write_text(json.dumps(rows, indent=1) + "\n")
                print(key, rows[key], flush=True)
    STORE.with_suffix(".md").write_text(table(rows))
    picture(rows, STORE.with_suffix(".png"))


if __name__ == "__main__":
    main()
