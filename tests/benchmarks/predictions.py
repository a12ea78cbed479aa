"""What runs take against what was predicted: wall and processor time, steps, memory and files, for all models.

    astroinertia calibrate && python tests/benchmarks/predictions.py --keep

Each scene is predicted, with and without a pilot run, and then run by the command in a process of its own. Other work
on the machine lengthens wall times only, and those of the calibration and of the run not alike: the ratio of processor
times, which is free of that but for the caches that are shared, stands beside. A scene whose loops had to be compiled
says so.
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import netCDF4
from fair_times import RESULTS, machine as machine_in_words, publish, rows_of

from astroinertia.costs import course, machine, pilot
from astroinertia.costs.prediction import predict
from astroinertia.scene import load

SIMS = Path(__file__).parents[2] / "sims"
NOTE = """\
Ratios are measured over predicted. Where the last column tells of a load, the ratio of processor times is the one to
trust: other jobs lengthen wall times of the calibration and of the run by different amounts. A pilot run counted the
steps of particles before. Programs of JAX came from its cache on disk where $JAX_COMPILATION_CACHE_DIR named one, in
the calibration as in the runs. Steps of smooth models and the share of neighbours in a pass were fitted to some of
these runs.

"""
KEPT = RESULTS / "predictions.json"  # rows so far, so that scenes can be run a few at a time
CASES = {
    "core_to_pulsar_scaling": ("core_to_pulsar_scaling",),
    "riemann_ellipsoid": ("riemann_ellipsoid",),
    "maclaurin_to_jacobi": ("maclaurin_to_jacobi",),
    "tennis_racket": ("tennis_racket",),
    "hyperion": ("hyperion",),
    "earth_precession": ("earth_precession",),
    "dyson_ellipsoid": ("dyson_ellipsoid", "body.particles=2500"),
    "free_expansion": ("free_expansion", "body.particles=3000"),
    "cold_spheroid": ("cold_spheroid", "body.particles=1500"),
    "evrard": ("evrard", "body.particles=1000"),
    "evrard, individual steps": ("evrard", "body.particles=1000", 'numerics.timesteps="individual"'),
    "rotating_star": ("rotating_star", "body.particles=1000"),
    "static_star": ("static_star", "body.particles=1000", "time.end=5.0"),
    "made_to_order": ("made_to_order", "body.particles=1000"),
    "sod": ("sod", "body.particles=5000"),
    "noh": ("noh", "body.particles=4000"),
}


def case(name: str, settings: tuple[str, ...], with_pilot: bool) -> list[object]:
    """Predict a scene, run it, and give its row."""
    file = SIMS / f"{settings[0]}.toml"
    scene = load.load_file(file, settings[1:])
    estimate = course.counted(scene) if scene.model == "sph" else None
    guess = None if estimate is None else estimate.steps
    if with_pilot and scene.model == "sph":
        pilot.run(scene)
    found = predict(scene, machine.current())
    assert found is not None, name
    overrides = [part for setting in settings[1:] for part in ("--set", setting)]
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "astroinertia", "run", str(file), *overrides, "--output", f"{folder}/run"]
        before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
        processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        run = Path(folder) / "run"
        files = sum(path.stat().st_size for path in run.iterdir())
        with netCDF4.Dataset(next(run.glob("*.nc"))) as data:
            steps = float(data["step"][-1]) if "step" in data.variables else 0.0
            memory = float(data.measured_memory)
    expected = found.time
    row = [
        name, scene.model, f"{expected.wall:.3g}", f"{wall:.3g}", f"{wall / expected.wall:.2f}",
        f"{expected.processor:.3g}", f"{processor:.3g}", f"{processor / expected.processor:.2f}",
        f"{found.steps:.0f}", f"{steps:.0f}", "" if guess is None else f"{guess:.0f}",
        f"{found.memory / 1e6:.0f}", f"{memory / 1e6:.0f}", f"{memory / found.memory:.2f}",
        f"{found.files / 1e6:.2f}", f"{files / 1e6:.2f}", "compiled" if "compiling" in found.parts else "",
    ]  # fmt: skip
    print(
        row, {name: (round(part.wall, 2), round(part.processor, 2)) for name, part in found.parts.items()}, flush=True
    )
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=list(CASES), help="words of names")
    parser.add_argument("--without-pilot", action="store_true", help="estimated steps")
    parser.add_argument("--keep", action="store_true", help="write the table, with the rows kept before")
    chosen = parser.parse_args()
    names = [name for name in CASES if any(word in name for word in chosen.only)]
    known = "calibrated" if machine.current().calibrated else "not calibrated"
    machine_line = f"{machine_in_words()}; {known}"
    rows = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    for name in names:
        rows[name] = [*case(name, CASES[name], not chosen.without_pilot), machine_line]
        if chosen.keep:
            KEPT.write_text(json.dumps(rows, indent=1) + "\n")
    head = [
        "scene", "model", "predicted (s)", "wall (s)", "ratio", "predicted processor (s)", "processor (s)", "ratio",
        "predicted steps", "steps", "estimate without pilot", "predicted memory (MB)", "memory (MB)", "ratio",
        "predicted files (MB)", "files (MB)", "", "machine",
    ]  # fmt: skip
    text = "# Runs against their predictions\n\n" + NOTE + rows_of(head, list(rows.values()))
    publish("predictions", text, chosen.keep)


if __name__ == "__main__":
    main()
