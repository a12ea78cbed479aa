"""How often errors of particle runs are within their bars: random runs with exact answers.

    python tests/benchmarks/error_bars.py [--runs 45] [--seed 1]

Each run is of a family with an exact answer (expanding Dyson ellipsoids, cold spheroids, toy stars), with random axes,
spins, numbers of particles and neighbours, kernels and ends. Bars at the end are compared with errors, with the
companion run of more neighbours and, from the same runs, without it. Each run is kept in results/error_bars.json as
soon as it is finished and is not run again.
"""

import argparse
import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import astroinertia
from astroinertia.accuracy.companion_runs import NEIGHBOURS, companion_runs
from astroinertia.accuracy.error_bars import at_end, with_error_bars
from astroinertia.accuracy.exact import exact
from astroinertia.accuracy.running import FOLDER
from astroinertia.accuracy.selected_observables import parsed, relative_error, value
from astroinertia.errors import AstroinertiaError
from astroinertia.scene import load
from astroinertia.scene.schema import Scene

HERE = Path(__file__).parent
SIMS = HERE.parent.parent / "sims"
RESULTS = HERE / "results" / "error_bars"
JUDGED = {"inertia_tensor x x": (0, 0), "inertia_tensor z z": (2, 2), "angular_velocity": ()}
TOY_STAR = """
name = "toy_star"
units = "code"
[body]
kind = "dyson"
gamma = 2.0
mass = 1.0
radius = 1.0
relax = false
[equation_of_state]
kind = "ideal"
gamma = 2.0
[effects.pressure]
[effects.external_field]
quadratic = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
[time]
end = 3.0
"""


def drawn(random: np.random.Generator) -> tuple[str, list[str]]:
    """The family of a scene and its settings."""
    family = str(random.choice(["dyson", "cold_spheroid", "toy_star"]))
    settings = [f"body.particles={random.integers(300, 1500)}", f"body.seed={random.integers(1, 1000)}"]
    a, b = random.uniform(0.85, 1.15, 2)
    if random.uniform() < 0.5:
        settings.append(f"numerics.kernel={random.choice(['quartic', 'wendland_c2', 'wendland_c4', 'quintic'])}")
    else:
        settings.append(f"numerics.neighbours={random.uniform(50.0, 130.0):.3g}")
    if family == "dyson":
        settings += [f"time.end={random.uniform(0.5, 2.0):.3g}", f"body.axes=[{a:.4f}, {b:.4f}, 1.0]"]
    elif family == "cold_spheroid":
        settings.append(f"time.end={random.uniform(0.5, 0.9):.3g}")
    else:
        entropy = float(0.25 * 8.0 * np.pi * round(a, 4) * round(b, 4) / 15.0)
        settings += [
            f"time.end={random.uniform(1.0, 6.0):.3g}", f"body.axes=[{a:.4f}, {b:.4f}, 1.0]",
            f"body.entropy={entropy!r}", f"body.rotation={{rate={random.uniform(0.1, 0.5):.3g}}}",
        ]  # fmt: skip
    return family, settings


def scene_of(family: str, settings: list[str]) -> Scene:
    """The scene of a family with settings."""
    name = {"dyson": "dyson_ellipsoid"}.get(family, family)
    text = TOY_STAR if family == "toy_star" else (SIMS / f"{name}.toml").read_text()
    return load.loads(text, settings)


def bars(dataset: xr.Dataset) -> dict[str, float]:
    """The bars at the end of what is judged, relative."""
    return {name: at_end(dataset, parsed(name)) for name in JUDGED}


def measured(family: str, settings: list[str]) -> list[dict[str, Any]]:
    """A row for each thing that is judged: its true error, and its bars with and without more neighbours."""
    scene = scene_of(family, settings)
    answer = exact(scene)
    assert answer is not None, (family, settings)
    asked = scene_of(family, [*settings, "output.error_bars=true"])
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "run"
        whole = astroinertia.open(astroinertia.run_scene(asked, folder))
        companions = companion_runs(asked)
        outcomes = [(run, astroinertia.open(folder / FOLDER / run.name)) for run in companions]
        less = with_error_bars(whole, [pair for pair in outcomes if pair[0].source != NEIGHBOURS])
        now, before, rows = bars(whole), bars(less), []
        for name, label in JUDGED.items():
            observable = parsed(name)
            if observable.variable not in answer.values:
                continue
            truth = np.atleast_1d(answer.values[observable.variable][label]).ravel()
            if not np.linalg.norm(truth) > 0.0:
                continue
            error = relative_error(value(whole, observable), truth)
            rows.append({"quantity": name, "error": error, "bar": now[name], "without": before[name]})
    return rows


def figures(rows: list[Mapping[str, Any]], which: str) -> str:
    """How many errors are within their bars, and the median of bar over error."""
    ratios = np.array([row[which] / row["error"] for row in rows])
    return f"{100.0 * (ratios >= 1.0).mean():.1f} % | {np.median(ratios):.2f} | {np.quantile(ratios, 0.05):.2f}"


def main() -> None:
    """Measure what is missing, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=45)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    store = RESULTS.with_suffix(".json")
    done = json.loads(store.read_text()) if store.exists() else {}
    for number in range(options.runs):
        key = f"{options.seed}/{number}"
        if key in done:
            continue
        family, settings = drawn(np.random.default_rng((options.seed, number)))
        try:
            rows = measured(family, settings)
        except AstroinertiaError as refused:
            print(key, family, settings, refused, flush=True)
            rows = []
        done[key] = {"family": family, "settings": settings, "rows": rows}
        store.write_text(json.dumps(done, indent=1) + "\n")
        print(key, family, *(f"{row['error']:.1e} {row['without']:.1e} {row['bar']:.1e}" for row in rows), flush=True)
    RESULTS.with_suffix(".md").write_text(table(done))


def table(done: Mapping[str, Any]) -> str:
    """Every family, and all of them."""
    lines = [
        "# Errors of particle runs and their bars", "",
        "Bars at the end of random runs with exact answers, of I_xx, I_zz and, where they turn, the angular velocity",
        "(error_bars.py). `without`: the companion run with more neighbours is left out, of the same runs.",
        "2 cores of an AMD EPYC with AVX-512.", "",
        "| family | runs | errors | within the bar | median of bar over error | lowest twentieth | without: within | "
        "median | lowest twentieth |", "|---" * 9 + "|",
    ]  # fmt: skip
    runs = [run for run in done.values() if run["rows"]]
    for family in (*sorted({run["family"] for run in runs}), "all"):
        mine = [run for run in runs if family in (run["family"], "all")]
        rows = [row for run in mine for row in run["rows"]]
        lines.append(f"| {family} | {len(mine)} | {len(rows)} | {figures(rows, 'bar')} | {figures(rows, 'without')} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
