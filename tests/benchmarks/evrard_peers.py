"""Evrard's collapse here and with SWIFT: what an error of the energies' peaks costs in time, one thread each.

    python tests/benchmarks/evrard_peers.py --swift src/swift        # built as standard_swift.py says

Both begin from the same particles and go to t = 1.2. Peaks are parabolas through the three largest of values that are
0.01 apart, beside a converged calculation with spherical shells (tests/reference/evrard.json). Times are of the
processor, of the steps and what they write; here programs are compiled before, and records are made.
"""

import argparse
import json
import resource
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from fair_times import machine, processor_clock, rows_of
from standard_swift import REACH, UNITS, write_start

from astroinertia.build.assemble import prepare
from astroinertia.scene import load
from astroinertia.test_problems.matter import Matter

HERE = Path(__file__).parent
SIMS = HERE.parent.parent / "sims"
STORE = HERE / "results" / "evrard_peers"
REFERENCE = HERE.parent / "reference" / "evrard.json"
END, EVERY = 1.2, 0.01
SIDE = 20.0  # of SWIFT's box, in whose middle the cloud is
NEIGHBOURS = 60.0
VARIANTS = {
    "here": (),
    "whole stress": ('effects.viscosity.stress="whole"', "effects.viscosity.alpha_max=1.0"),
}
WANTED = (0.1, 0.05, 0.03)  # errors of the kinetic peak
# Time integration and gravity as in SWIFT's own example of this problem; softened over a tenth of its spacing.
PARAMETERS = (
    UNITS
    + """\
TimeIntegration:
  time_begin: 0.
  time_end: {end}
  dt_min: 1e-9
  dt_max: 1e-2
Snapshots:
  basename: flow
  time_first: 0.
  delta_time: {end}
Statistics:
  delta_time: {every}
SPH:
  resolution_eta: {eta}
  CFL_condition: 0.1
Gravity:
  eta: 0.025
  MAC: adaptive
  theta_cr: 0.7
  epsilon_fmm: 0.001
  max_physical_baryon_softening: {softening}
InitialConditions:
  file_name: start.hdf5
  periodic: 0
PhysicalConstants:
  G: 1.
"""
)


def errors_of(time: np.ndarray, kinetic: np.ndarray, internal: np.ndarray) -> dict[str, float]:
    """Relative errors of the peaks of both energies."""
    exact = json.loads(REFERENCE.read_text())["value"]
    found = {}
    for name, values, key in (("kinetic", kinetic, "K_max"), ("internal", internal, "U_max")):
        top = int(np.clip(np.argmax(values), 1, len(values) - 2))
        a, b, _ = np.polyfit(time[top - 1 : top + 2] - time[top], values[top - 1 : top + 2], 2)
        found[name] = float((values[top] - b**2 / (4 * a)) / float(exact[key].partition(" at t=")[0]) - 1)
    return found


def measured(particles: int, *settings: str) -> dict[str, Any]:
    """A run here."""
    scene = load.load_file(SIMS / "evrard.toml", [f"body.particles={particles}", f"time.end={END}", *settings])
    first, body = (prepare(scene).evolution for _ in range(2))
    first.advance(END)  # compiles, and so does a record
    first.record(None)
    records, begun = [body.record(None)], processor_clock()
    for k in range(1, round(END / EVERY) + 1):
        while body.time < k * EVERY * (1 - 1e-12):
            body.advance(k * EVERY)
        records.append(body.record(records[0]["potential_energy"]))
    seconds = processor_clock() - begun
    series = (np.array([record[name] for record in records]) for name in ("time", "kinetic_energy", "internal_energy"))
    return {"seconds": round(seconds, 2), "steps": body.steps, **errors_of(*series)}


def measured_with_swift(particles: int, program: Path) -> dict[str, Any]:
    """A run of SWIFT from the same particles."""
    state = prepare(load.load_file(SIMS / "evrard.toml", [f"body.particles={particles}"])).evolution.state
    count = len(state.mass)
    matter = Matter(state.mass, state.position, state.velocity, np.full(count, 0.05))
    eta = (NEIGHBOURS * 3.0 / (4.0 * np.pi)) ** (1 / 3) / REACH
    spacing = (4.0 * np.pi / 3.0 / count) ** (1 / 3)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_start(folder / "start.hdf5", state.position + SIDE / 2, matter, 1, np.full(3, SIDE), eta * spacing)
        given = {"end": END, "every": EVERY, "eta": eta, "softening": 0.1 * spacing}
        (folder / "flow.yml").write_text(PARAMETERS.format(**given))
        command = [str(program.absolute()), "--hydro", "--self-gravity", "--limiter", "--threads=1", "flow.yml"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode != 0:
            raise RuntimeError(f"SWIFT says: {done.stdout[-500:]} {done.stderr[-500:]}")
        heads = next(line for line in (folder / "statistics.txt").read_text().splitlines() if "Kin. Energy" in line)
        names = [part.strip() for part in heads.lstrip("#").split("  ") if part.strip()]
        table = np.loadtxt(folder / "statistics.txt")
    columns = [names.index(name) for name in ("Time", "Kin. Energy", "Int. Energy")]
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"seconds": round(seconds, 2), **errors_of(*table[:, columns].T)}


def time_for(rows: list[dict[str, Any]], error: float) -> tuple[float, bool]:
    """Seconds at which a power law between neighbouring runs has that error of the kinetic peak, and whether it is
    beyond the runs.
    """
    seconds, errors = (np.log([abs(row[name]) for row in rows]) for name in ("seconds", "kinetic"))
    k = int(np.clip(np.searchsorted(-errors, -np.log(error)), 1, len(rows) - 1))
    slope = (seconds[k] - seconds[k - 1]) / (errors[k] - errors[k - 1])
    return float(np.exp(seconds[k] + slope * (np.log(error) - errors[k]))), not errors[-1] <= np.log(error) <= errors[0]


def table(rows: dict[str, dict[str, Any]]) -> str:
    """All runs, and the times at which errors are reached."""
    by_code: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    for key, row in rows.items():
        code, _, particles = key.partition("/")
        by_code.setdefault(code, []).append((int(particles), row))
    runs = {code: [row for _, row in sorted(found, key=lambda one: one[0])] for code, found in by_code.items()}
    cells = [
        [code, size, f"{row['seconds']:.3g}", *(f"{100 * row[name]:+.1f} %" for name in ("kinetic", "internal"))]
        for code, found in by_code.items()
        for size, row in sorted(found, key=lambda one: one[0])
    ]
    times = []
    for error in WANTED:
        found = [time_for(ordered, error) for ordered in runs.values()]
        times.append([f"{100 * error:g} %", *(f"{spent:.3g}{' *' if beyond else ''}" for spent, beyond in found)])
    heads = ["error of the kinetic peak", *(f"{code} (s)" for code in runs)]
    words = __doc__.strip().split("\n\n")
    return "\n".join([
        f"# {words[0]}\n\n{words[2]}\n",
        f"SWIFT: scheme SPHENIX, quartic spline with {NEIGHBOURS:g} neighbours. {machine()}.\n",
        rows_of(["code", "particles", "processor time (s)", "kinetic peak", "thermal peak"], cells),
        rows_of(heads, times),
        "\\* extrapolated from two runs.\n",
    ])  # fmt: skip


def main() -> None:
    """Measure what is missing, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, nargs="*", default=[500, 1000, 3000, 10_000])
    parser.add_argument("--swift", type=Path, help="program swift")
    options = parser.parse_args()
    store = STORE.with_suffix(".json")
    rows = json.loads(store.read_text()) if store.exists() else {}
    for particles in options.particles:
        jobs: dict[str, Any] = {who: lambda n=particles, s=given: measured(n, *s) for who, given in VARIANTS.items()}
        if options.swift:
            jobs["SWIFT"] = lambda n=particles: measured_with_swift(n, options.swift)
        for who, job in jobs.items():
            if (key := f"{who}/{particles}") not in rows:
                rows[key] = job()
                store.write_text(json.dumps(rows, indent=1) + "\n")
                print(key, rows[key], flush=True)
    STORE.with_suffix(".md").write_text(table(rows))


if __name__ == "__main__":
    main()
