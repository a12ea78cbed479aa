"""What accuracy costs along the whole ladder of models: the collapse of sims/pulsar_collapse.toml, error against time.

    python tests/benchmarks/ladder.py --folder runs/ladder --keep

The scene to 70 ms, before its bounce, from its polytrope as it stands (a body that is settled first is another one with
each number of particles). Runs that are in the folder already are not repeated. The reference is Richardson's
extrapolation of the particles, with the order that they show; beside it stands a fluid in spherical shells, which
shares nothing with particles, and whose rotation acts by its mean over each sphere.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np
from fair_times import machine, publish, rows_of
from scipy.integrate import solve_ivp

from astroinertia.accuracy import convergence, measuring
from astroinertia.accuracy.knobs import MODEL, Setting
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.observables import Observable, parsed, relative_error
from astroinertia.accuracy.table import duration
from astroinertia.build import prepare
from astroinertia.plots import style
from astroinertia.scene import load
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene
from astroinertia.start.fluids import equation_of_state
from astroinertia.start.spheres import sphere

ROOT = Path(__file__).parents[2]
PICTURE = ROOT / "data" / "pictures" / "ladder.png"
OVERRIDES = ("body.relax=false", "time.end='70 ms'")
CLOSED_FORM = "equation_of_state={kind='polytropic', gamma=1.3333333333333333}"
JUDGED = (parsed("inertia_tensor z z"), parsed("angular_velocity z"))
MEAN_MOMENT = (parsed("inertia_tensor x x"), parsed("inertia_tensor y y"), parsed("inertia_tensor z z"))
OBSERVABLES = tuple(dict.fromkeys((*JUDGED, *MEAN_MOMENT)))
ROUNDS = 7  # of a model without particles, of which the shortest counts
AT_ONCE = 300  # evaluations of a closed form that are timed together
COLOURS = {"scaling": style.ORANGE, "ellipsoid": style.VERMILLION, "sph": style.BLUE}
MARKERS = {"scaling": "D", "ellipsoid": "s", "sph": "o"}
TITLES = ("moment of inertia $I_{zz}$", "angular velocity")


@dataclass(frozen=True)
class Rung:
    """One way to answer the scene: its model, what it is called, beside the others of its model, and overrides."""

    model: str
    label: str
    overrides: tuple[str, ...]
    particles: int = 0

    @property
    def setting(self) -> Setting:
        """The same as the tradeoff names it."""
        return Setting(MODEL, f"{self.model} {self.label}", (f"model='{self.model}'", *self.overrides))


class Answer(NamedTuple):
    """A rung with what it gave, and the processor and wall time of its steps in seconds."""

    rung: Rung
    found: Measured
    cpu_time: float
    wall_time: float


class Limit(NamedTuple):
    """What particles converge to, (K,), its relative uncertainty, the order with its own, and the law's factor."""

    values: np.ndarray
    uncertainty: float
    law: convergence.PowerLaw


def rungs(particles: list[int], tolerances: list[float]) -> list[Rung]:
    """The ladder from its cheapest rung."""
    return [
        Rung("scaling", "closed form, exponent 4/3", (CLOSED_FORM,)),
        Rung("scaling", "one zone", ()),
        *(Rung("ellipsoid", f"tolerance {each:g}", (f"numerics.tolerance={each!r}",)) for each in tolerances),
        *(Rung("sph", f"N = {each:,}", (f"body.particles={each}",), each) for each in particles),
    ]


def answered(scene: Scene, rung: Rung, folder: Path) -> Answer:
    """A rung run and timed; a run of particles that the folder has is taken from there."""
    chosen = measuring.scene_of(scene, rung.setting, OBSERVABLES)
    place = measuring.folder_of(folder, chosen, rung.setting)
    found = measuring.stored(place, OBSERVABLES) or measuring.measure(chosen, OBSERVABLES, place)
    if found.failure:
        raise SystemExit(f"{rung.setting.value}: {found.failure}")
    if rung.model == "sph":
        return Answer(rung, found, found.cpu_time, found.step_time)
    return Answer(rung, found, *repeated(chosen))


def repeated(scene: Scene) -> tuple[float, float]:
    """The shortest processor and wall time of going from the start to the end, for a model without particles."""
    with jax.enable_x64(True):
        prepared = prepare(scene)
        body, end = prepared.evolution, prepared.outputs.end
        at_start, count = started_again(scene, body)
        times = []
        for _ in range(ROUNDS + 1):  # the first compiles
            body = at_start()
            cpu, wall = time.process_time(), time.perf_counter()
            for _ in range(count):
                body.advance(end)
            times.append(((time.process_time() - cpu) / count, (time.perf_counter() - wall) / count))
    return min(cpu for cpu, _ in times[1:]), min(wall for _, wall in times[1:])


def started_again(scene: Scene, body: Any) -> tuple[Callable[[], Any], int]:
    """What gives the body at its start, and how many times it can go to the end from there."""
    if hasattr(body, "resume"):
        start = body.arrays()

        def resumed() -> Any:
            body.resume(start)
            return body

        return resumed, 1
    if body.law is not None:
        return lambda: body, AT_ONCE  # a closed form remembers nothing
    return lambda: prepare(scene).evolution, 1  # one zone is integrated once and then known


def limit(answers: list[Answer], observables: tuple[Observable, ...]) -> Limit:
    """Richardson's limit of the particles' observables, each over its own size, with the order fitted to all runs.

    The uncertainty is the larger of what the order's standard error makes, and of what the finest run has changed.
    """
    ladder = sorted((each for each in answers if each.rung.particles), key=lambda each: each.rung.particles)
    steps = np.array([each.rung.particles ** (-1 / 3) for each in ladder])
    values = np.array([[each.found.values[one.name][0] for one in observables] for each in ladder])

    def fitted(count: int, change: float = 0.0) -> tuple[np.ndarray, convergence.PowerLaw]:
        law = convergence.self_convergence(steps[:count], values[:count], float(np.linalg.norm(values[count - 1])))
        spread = 0.0 if np.isnan(law.uncertainty) else law.uncertainty
        found = convergence.extrapolated(steps[:count], values[:count], law.order + change * spread)
        if found is None:
            raise SystemExit("the particles do not converge: no limit can be told.")
        return found, law

    best, law = fitted(len(ladder))
    others = [fitted(len(ladder), change)[0] for change in (-1.0, 1.0)] + [fitted(len(ladder) - 1)[0]]
    return Limit(best, max(relative_error(each, best) for each in others), law)


def shells_moment(scene: Scene, zones: int) -> float:
    """The mean moment of inertia (kg m2) at the end of the scene's fluid in so many spherical shells, before any shock.

    Edges r of fixed enclosed mass, r'' = -4 pi r^2 dP/dm - G m/r^2 + (2/3) l^2/r^3 with l = Omega_0 r_0^2 of the
    equator: the centrifugal force's mean over the sphere.
    """
    with jax.enable_x64(True):
        units = code_units(scene)
        ball = sphere(scene, units)
        fluid = equation_of_state(scene, units, ball)
        spin = prepare(load.loads(load.resolved_text(scene), ("model='scaling'",), scene.origin)).evolution.body
    rate = float(np.linalg.norm(spin.angular_momentum)) / (2 / 3 * float(np.trace(spin.second_moment)))
    # Nearly even in radius: a centre has m ~ r^3, the surface of this polytrope 1 - m ~ (R - r)^4.
    share = 1 - (1 - np.linspace(0, 1, zones + 1) ** 3) ** 4
    start = np.asarray(ball.profile.radius(share)) * ball.radius
    start[0] = 0.0
    enclosed, mass = share * ball.mass, np.diff(share) * ball.mass
    around = np.append(0.5 * (mass[1:] + mass[:-1]), 0.5 * mass[-1])

    def slope(_: float, state: np.ndarray) -> np.ndarray:
        r, v = np.concatenate([[0.0], state[:zones]]), state[zones:]
        density = mass / (4 * np.pi / 3 * np.diff(r**3))
        pressure = np.append(fluid.pressure(np, density, np.zeros(zones)), 0.0)
        outer = r[1:]
        push = -4 * np.pi * outer**2 * np.diff(pressure) / around - enclosed[1:] / outer**2
        return np.concatenate([v, push + 2 / 3 * (rate * start[1:] ** 2) ** 2 / outer**3])

    state = np.concatenate([start[1:], np.zeros(zones)])
    end = units.to_code(scene.time.end, "time")
    moved = solve_ivp(slope, (0.0, end), state, "DOP853", rtol=1e-8, atol=1e-10).y[:zones, -1]

    # Of the exact sphere, times what the same sum over shells says that the collapse has changed.
    def moment(r: np.ndarray) -> float:
        edges = np.concatenate([[0.0], r])
        return float(mass @ ((edges[1:] ** 5 - edges[:-1] ** 5) / (edges[1:] ** 3 - edges[:-1] ** 3)))

    exact = 2 / 3 * float(np.trace(spin.second_moment))
    return float(units.to_si(exact * moment(moved) / moment(start[1:]), "moment_of_inertia"))


def errors(answers: list[Answer], one: Observable, reference: Limit) -> np.ndarray:
    """Relative errors (A,) of all answers."""
    return np.array([relative_error(np.array(each.found.values[one.name]), reference.values) for each in answers])


def picture(answers: list[Answer], references: list[Limit]) -> None:
    """Error against processor time, a panel an observable, a colour and a marker a model."""
    with style.styled():
        figure = style.page("Collapse of a stellar core, by every model: error against time", (11.0, 5.2))
        panels = figure.subplots(1, len(JUDGED), sharey=True)
        for panel, one, title, reference in zip(panels, JUDGED, TITLES, references, strict=True):
            drawn(panel, answers, errors(answers, one, reference), reference)
            panel.set_title(title)
        panels[0].set_ylabel("relative error at 70 ms")
        style.save(figure, PICTURE)


def drawn(panel: Any, answers: list[Answer], found: np.ndarray, reference: Limit) -> None:
    seconds = np.array([each.cpu_time for each in answers])
    panel.set(xscale="log", yscale="log", xlabel="processor time of the steps (s)")
    panel.axhspan(1e-5, reference.uncertainty, color=style.PALE, alpha=0.6, zorder=0.2)
    for model, colour in COLOURS.items():
        own = np.array([each.rung.model == model for each in answers])
        line = "-" if model == "sph" else ""
        panel.plot(seconds[own], found[own], line, marker=MARKERS[model], color=colour, markersize=7,
                   markeredgecolor="white", label=model, zorder=3)  # fmt: skip
    panel.set_xlim(seconds.min() / 3, seconds.max() * 8)


def row(answer: Answer, told: list[np.ndarray], number: int) -> list[object]:
    found = answer.found
    moment, rate = (found.values[one.name][0] for one in JUDGED)
    return [
        answer.rung.model, answer.rung.label, duration(answer.cpu_time), duration(answer.wall_time),
        found.steps if answer.rung.particles else "", f"{moment:.5g}", f"{rate:.5g}",
        *(f"{100 * each[number]:.2f} %" for each in told),
    ]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=Path("runs/ladder"))
    parser.add_argument("--particles", nargs="+", type=int, default=[300, 1000, 3000, 10_000, 30_000, 100_000])
    parser.add_argument("--tolerances", nargs="+", type=float, default=[1e-4, 1e-7, 1e-10])
    parser.add_argument("--keep", action="store_true", help="write the table and the picture")
    chosen = parser.parse_args()
    scene = load.load_file(ROOT / "sims" / "pulsar_collapse.toml", list(OVERRIDES))
    answers = []
    for rung in rungs(chosen.particles, chosen.tolerances):
        answers.append(answered(scene, rung, chosen.folder))
        print(f"{rung.setting.value}: {duration(answers[-1].cpu_time)}", flush=True)
    references = [limit(answers, (one,)) for one in JUDGED]
    told = [errors(answers, one, reference) for one, reference in zip(JUDGED, references, strict=True)]
    head = ["model", "how", "processor time", "wall time", "steps", "I_zz (kg m2)", "omega (rad/s)", "error of I_zz",
            "of omega"]  # fmt: skip
    text = (
        f"# The collapse of a core by every model, error against time\n\n{machine()}; times are of the steps.\n\n"
        f"`sims/pulsar_collapse.toml` with {' and '.join(f'`{each}`' for each in OVERRIDES)}.\n\n"
        + rows_of(head, [row(answer, told, number) for number, answer in enumerate(answers)])
        + "\n"
    )
    for one, reference in zip(JUDGED, references, strict=True):
        law = reference.law
        text += (
            f"- {one.name}: the particles converge to {reference.values[0]:.6g}, known to "
            f"{100 * reference.uncertainty:.2g} %, with the order {law.order:.2f} ± {law.uncertainty:.2f} in N^(-1/3)\n"
        )
    mean = limit(answers, MEAN_MOMENT)
    shells = [shells_moment(scene, zones) for zones in (200, 400)]
    of_particles = float(mean.values.mean())
    text += (
        f"- mean of the three moments: {of_particles:.6g} by the particles, {shells[0]:.6g} and {shells[1]:.6g} by 200 "
        f"and 400 spherical shells, {100 * (shells[1] / of_particles - 1):+.2f} %\n"
    )
    publish("ladder", text, chosen.keep)
    if chosen.keep:
        picture(answers, references)


if __name__ == "__main__":
    main()
