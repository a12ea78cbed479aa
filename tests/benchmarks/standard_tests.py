"""Hydrodynamics on the problems that trusted codes are tested on: errors, orders of convergence, and SWIFT beside them.

    python tests/benchmarks/standard_tests.py [--problems sod gresho] [--particles 1000] [--swift PROGRAM]

Each row is kept in results/standard_tests.json as soon as it is measured and is not measured again; the table and the
picture are then made of all rows there are. Scenes are those of sims/, with one set of options for all of them. With
--swift the same particles are given to SWIFT (standard_swift.py), with the same kernel and number of neighbours.
"""

import argparse
import json
import tempfile
import time
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from astroinertia.build.assemble import prepare
from astroinertia.models.sph.evolution import Particles
from astroinertia.scene import load
from astroinertia.scene.schema import Scene
from astroinertia.test_problems import kelvin_helmholtz, keplerian_disc
from astroinertia.test_problems.matter import Standard, l1_errors, standard

HERE = Path(__file__).parent
SIMS = HERE.parent.parent / "sims"
RESULTS = HERE / "results" / "standard_tests"
# The figure that each problem is judged by: of the flow's L1 errors, or of its own measure.
HEADLINE = {
    "sod": "density",
    "strong_tube": "density",
    "sedov": "density",
    "noh": "density",
    "gresho": "velocity",
    "kelvin_helmholtz": "amplitude",
    "square": "velocity",
    "keplerian_disc": "angular_momentum",
}
# Three resolutions of each; of the disc fewer, whose two orbits are a thousand steps and more.
PARTICLES = dict.fromkeys(HEADLINE, (1000, 3000, 10_000)) | {"keplerian_disc": (500, 1000, 2000)}
# What is measured: the scenes as they are, and with these settings.
KERNEL, WHOLE = 'effects.pressure.gradients="kernel"', 'effects.viscosity.stress="whole"'
OTHERS = 'effects.viscosity.limiter="guarded_reconstruction"', 'effects.conduction.limiter="none"'
VARIANTS: dict[str, tuple[str, ...]] = {
    "here": (),
    "guarded": OTHERS,
    "whole": (WHOLE, *OTHERS),
    "kernel": (KERNEL, *OTHERS),
    "plain": (KERNEL, WHOLE, *OTHERS),
}
ROOM = {"sedov": 9.0}  # reaches of the kernel that SWIFT's box must have: those of the blown-out middle are wide


def scene_of(problem: str, particles: int, *settings: str) -> Scene:
    """The scene of sims/ with so many particles."""
    return load.load_file(SIMS / f"{problem}.toml", [f"body.particles={particles}", *settings])


def lengths_of(scene: Scene) -> np.ndarray:
    """Of the box; infinite without one."""
    return np.full(3, np.inf) if scene.box is None else np.array(scene.box.lengths)


def errors_of(problem: str, scene: Scene, flows: list[Any]) -> dict[str, float]:
    """Errors of flows (time, position, velocity, density, pressure, mass, in one order) from the first to the last."""
    chosen, lengths, gamma = standard(problem), lengths_of(scene), scene.equation_of_state.gamma  # type: ignore
    first, last = flows[0], flows[-1]
    if problem == "kelvin_helmholtz":
        times = np.array([flow.time for flow in flows])
        sizes = [kelvin_helmholtz.amplitude(f.position, f.velocity, f.mass / f.density) for f in flows]
        exact = kelvin_helmholtz.exact_amplitude(times, gamma)
        return {"amplitude": float(np.abs(sizes - exact).mean() / exact.max())}
    if problem == "keplerian_disc":
        before, after = (keplerian_disc.angular_momentum(flow.position, flow.velocity) for flow in (first, last))
        return {"angular_momentum": float(np.mean(np.abs(after - before) / before))}
    exact = exact_of(chosen, last, lengths, gamma)
    return l1_errors(last, exact, chosen.compared(last.position, last.time, lengths))


def exact_of(chosen: Standard, flow: Any, lengths: np.ndarray, gamma: float) -> Any:
    """The exact flow where the particles are."""
    assert chosen.exact is not None
    return chosen.exact(flow.position, flow.time, lengths, gamma)


class Flow:
    """Particles in the order in which they were placed."""

    def __init__(self, body: Particles) -> None:
        order, fluid = np.argsort(body.state.identity), body.state.rates.fluid
        self.time = body.time
        self.position, self.velocity, self.mass = (
            getattr(body.state, name)[order] for name in ("position", "velocity", "mass")
        )
        self.density, self.pressure = fluid.density[order], fluid.pressure[order]


def evolved(scene: Scene, moments: int = 20) -> tuple[list[Flow], Particles]:
    """Flows at so many equal intervals, the first at time 0."""
    body = prepare(scene).evolution
    assert isinstance(body, Particles)
    flows, end = [Flow(body)], body.end
    for k in range(1, moments + 1):
        while body.time < k * end / moments * (1 - 1e-12):
            body.advance(k * end / moments)
        flows.append(Flow(body))
    return flows, body


def measured(problem: str, particles: int, *settings: str) -> dict[str, Any]:
    """Errors of a run here, the number of particles that its lattices have, and its seconds."""
    scene, start = scene_of(problem, particles, *settings), time.perf_counter()
    flows, body = evolved(scene, 20 if problem == "kelvin_helmholtz" else 1)
    seconds = round(time.perf_counter() - start, 1)
    return {
        "particles": len(flows[0].mass), "steps": body.steps, "seconds": seconds, **errors_of(problem, scene, flows)
    }  # fmt: skip


def measured_with_swift(problem: str, particles: int, program: Path) -> dict[str, Any]:
    """The same of SWIFT, from the same particles."""
    import standard_swift

    scene, lengths = scene_of(problem, particles), lengths_of(scene_of(problem, particles))
    matter = standard(problem).place(particles, lengths, scene.equation_of_state.gamma)  # type: ignore[union-attr]
    end, start = scene.time.end, time.perf_counter()
    every = end / 20 if problem == "kelvin_helmholtz" else end
    with tempfile.TemporaryDirectory() as folder:
        flows = standard_swift.run(
            program, Path(folder), matter, lengths, scene.numerics.neighbours or 60.0, end, every,
            problem == "keplerian_disc", ROOM.get(problem, 3.5),
        )  # fmt: skip
    seconds = round(time.perf_counter() - start, 1)
    return {"particles": len(matter.mass), "seconds": seconds, **errors_of(problem, scene, flows)}


HEADING = """# Standard tests of hydrodynamics

L1 errors, mean |f - f_exact| over the largest |f_exact|; of kelvin_helmholtz that of the mode's amplitude at 20 times
up to t = 1.5, against collocation in the plane; of keplerian_disc the mean relative change of particles' angular
momenta in two orbits. Quartic spline with 60 neighbours and viscosity with a constant alpha of 1 for all of them.
"here" is the scenes as they are in sims/: gradients = "integral" of the pressure, stress = "trace_free" and limiter =
"reconstruction" of the viscosity, limiter = "shear" of the conduction. "guarded" has limiter = "guarded_reconstruction"
of the viscosity and limiter = "none" of the conduction in place of these, "whole" the whole stress besides, "kernel"
the kernel's gradients besides, "plain" all of that.

SWIFT: commit 8a8f0d794, scheme SPHENIX (density and energy, with conduction of its own), quartic spline with 60
neighbours, its examples' Courant number, measured here from the same particles (standard_swift.py). In bold what a
problem is judged by. In Noh's problem SWIFT's gas does not come to rest behind a shock with so few particles, as its
velocities tell.
"""


NAMES = (
    "problem", "figure", "particles", *(name for who in VARIANTS for name in (f"L1 {who}", "order")), "L1 SWIFT",
    *(f"{who} / SWIFT" for who in VARIANTS),
)  # fmt: skip


def table(rows: dict[str, Any]) -> str:
    """Every row, with the order from the row before (error ~ N^(-order/3)) and the ratio to SWIFT at the same N."""
    lines = [HEADING, f"| {' | '.join(NAMES)} |", "|---" * len(NAMES) + "|"]
    for problem, headline in HEADLINE.items():
        runs = {who: _rows(rows, problem, who) for who in (*VARIANTS, "swift")}
        for name in dict.fromkeys(("density", "velocity", "pressure", headline)):
            measured_here = [size for size, row in runs["here"].items() if name in row]
            before: list[dict[str, Any] | None] = [None] * len(VARIANTS)
            for size in measured_here:
                own = [runs[who].get(size) for who in VARIANTS]
                there = runs["swift"].get(size, {}).get(name)
                cells = [problem, f"**{name}**" if name == headline else name, size]
                for now, last in zip(own, before, strict=True):
                    cells.append("" if now is None else f"{now[name]:.4g}")
                    cells.append("" if now is None or last is None else f"{_order(last, now, name):.2f}")
                cells.append("" if there is None else f"{there:.4g}")
                cells += ["" if now is None or there is None else f"{now[name] / there:.2f}" for now in own]
                lines.append(f"| {' | '.join(map(str, cells))} |")
                before = own
    return "\n".join(lines) + "\n"


def _rows(rows: dict[str, Any], problem: str, who: str) -> dict[int, dict[str, Any]]:
    """{particles: row}, from the fewest to the most."""
    found = [row for key, row in rows.items() if key.startswith(f"{problem}/{who}/")]
    return {row["particles"]: row for row in sorted(found, key=lambda row: row["particles"])}


def _order(coarse: dict[str, Any], fine: dict[str, Any], name: str) -> float:
    return float(3.0 * np.log(coarse[name] / fine[name]) / np.log(fine["particles"] / coarse["particles"]))


def picture(rows: dict[str, Any], path: Path) -> None:
    """The headline errors against the number of particles."""
    figure, axes = plt.subplots(2, 4, figsize=(12, 5.5), sharex=True, layout="constrained")
    for axis, (problem, name) in zip(axes.flat, HEADLINE.items(), strict=True):
        for who, mark, label in (
            ("here", "o-", "here"),
            ("guarded", "d-", "here, guarded"),
            ("whole", "^-", "the same, whole stress"),
            ("kernel", "v-", "guarded, kernel's gradients"),
            ("plain", "*-", "all of these"),
            ("swift", "s--", "SWIFT, SPHENIX"),
        ):
            found = _rows(rows, problem, who)
            axis.loglog(list(found), [row[name] for row in found.values()], mark, label=label)
        axis.set_title(f"{problem.replace('_', ' ')}: {name.replace('_', ' ')}", fontsize=9)
        axis.grid(alpha=0.3, which="both")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=6, fontsize=8)
    figure.supxlabel("particles")
    figure.supylabel("L1 error")
    figure.savefig(path, dpi=90)
    plt.close(figure)


def main() -> None:
    """Measure what is missing, and write the table and the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, nargs="*", help="of each problem three numbers by default")
    parser.add_argument("--problems", nargs="*", default=list(HEADLINE), choices=list(HEADLINE))
    parser.add_argument("--swift", type=Path, help="program swift, built as standard_swift.py says")
    options = parser.parse_args()
    store = RESULTS.with_suffix(".json")
    for problem in options.problems:
        for particles in options.particles or PARTICLES[problem]:
            jobs = {
                f"{problem}/{who}/{particles}": lambda p=problem, n=particles, s=settings: measured(p, n, *s)
                for who, settings in VARIANTS.items()
            }
            if options.swift:
                jobs[f"{problem}/swift/{particles}"] = lambda p=problem, n=particles: measured_with_swift(
                    p, n, options.swift
                )
            for key, job in jobs.items():
                rows = json.loads(store.read_text()) if store.exists() else {}
                if key not in rows:
                    row = job()
                    rows = json.loads(store.read_text()) if store.exists() else {}
                    store.write_text(json.dumps({**rows, key: row}, indent=1) + "\n")
                    print(key, row, flush=True)
    rows = json.loads(store.read_text())
    RESULTS.with_suffix(".md").write_text(table(rows))
    picture(rows, RESULTS.with_suffix(".png"))


if __name__ == "__main__":
    main()
