"""What accuracy costs along the whole ladder of models: the collapse of sims/pulsar_collapse.toml, error against time.

    python tests/benchmarks/ladder.py --folder runs/ladder --particles 300 1000 3000 10000 30000 100000 --keep

The scene to 70 ms, before its bounce, from its polytrope as it stands (a body that is settled first is another one with
each number of particles). Runs that are in the folder already are not repeated. The reference shares nothing with
particles: the same fluid in spherical shells, on which the rotation acts by its mean over the sphere. What it leaves
out is the flattening, 1 % of the moment, which is taken from the finest particles.
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
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from scipy.integrate import solve_ivp

from astroinertia.accuracy import convergence, measuring
from astroinertia.accuracy.knobs import MODEL, Setting
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.selected_observables import parsed
from astroinertia.build.assemble import prepare
from astroinertia.build.fluids import equation_of_state
from astroinertia.build.spheres import sphere
from astroinertia.plots import style
from astroinertia.process.words import duration
from astroinertia.scene import load
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene

ROOT = Path(__file__).parents[2]
PICTURE = ROOT / "data" / "pictures" / "ladder.png"
OVERRIDES = ("body.relax=false", "time.end='70 ms'")
CLOSED_FORM = "equation_of_state={kind='polytropic', gamma=1.3333333333333333}"
JUDGED = (parsed("inertia_tensor z z"), parsed("angular_velocity z"))
MOMENTS = (parsed("inertia_tensor x x"), parsed("inertia_tensor y y"), parsed("inertia_tensor z z"))
OBSERVABLES = tuple(dict.fromkeys((*JUDGED, *MOMENTS)))
SHELLS = (200, 400)
ROUNDS = 7  # of a model without particles, of which the shortest counts
AT_ONCE = 300  # evaluations of a closed form that are timed together
LOOK = {"scaling": ("D", style.ORANGE), "ellipsoid": ("s", style.VERMILLION), "sph": ("o", style.BLUE)}


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


class Reference(NamedTuple):
    """I_zz and angular velocity at the end, in the dataset's units, their relative uncertainty, and what they rest on.

    mean_moments: of two numbers of shells, and extrapolated with their order, 2; flattening: I_zz over it, less 1.
    """

    values: np.ndarray
    uncertainty: float
    mean_moments: tuple[float, float, float]
    flattening: float


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


def particles_of(answers: list[Answer]) -> list[Answer]:
    """Those of particles, the fewest first."""
    return sorted((each for each in answers if each.rung.particles), key=lambda each: each.rung.particles)


def steps_of(ladder: list[Answer]) -> np.ndarray:
    """N^(-1/3), (A,)."""
    return np.array([each.rung.particles ** (-1 / 3) for each in ladder])


def mean_moment(answer: Answer) -> float:
    """A third of the trace of the inertia tensor."""
    return float(np.mean([answer.found.values[one.name][0] for one in MOMENTS]))


def reference_of(scene: Scene, answers: list[Answer]) -> Reference:
    """The best that is known: shells for the mean moment, the finest particles for the flattening, L for the spin.

    The uncertainty adds up what the last doubling of the shells and the last step in particles changed, and the square
    of the flattening, for shells know the rotation to first order.
    """
    coarse, fine = (shells_moment(scene, zones) for zones in SHELLS)
    mean = fine + (fine - coarse) / 3
    before, last = (each.found.values["inertia_tensor z z"][0] / mean_moment(each) for each in
                    particles_of(answers)[-2:])  # fmt: skip
    moment = mean * last
    # Every model has the same L, which scaling laws have in closed form.
    exact = next(each.found.values for each in answers if each.rung.model == "scaling")
    momentum = exact["inertia_tensor z z"][0] * exact["angular_velocity z"][0]
    uncertainty = abs(mean / fine - 1) + abs(last / before - 1) + (last - 1) ** 2
    return Reference(np.array([moment, momentum / moment]), uncertainty, (coarse, fine, mean), last - 1)


def extrapolated(answers: list[Answer]) -> tuple[float, float, convergence.PowerLaw]:
    """The mean moment to which particles converge by themselves, its relative uncertainty, and the law of their errors.

    Richardson's extrapolation with the order that they show; the uncertainty is what the order's own one makes.
    """
    ladder = particles_of(answers)
    steps, values = steps_of(ladder), np.array([[mean_moment(each)] for each in ladder])
    law = convergence.self_convergence(steps, values, float(values[-1, 0]))
    found = [
        convergence.extrapolated(steps, values, law.order + change * law.uncertainty) for change in (0.0, -1.0, 1.0)
    ]
    best, *others = [float("nan") if each is None else float(each[0]) for each in found]
    return best, max(abs(each / best - 1) for each in others), law


def shells_moment(scene: Scene, zones: int) -> float:
    """The mean moment of inertia (kg m2) at the end of the scene's fluid in so many spherical shells, before any shock.

    Edges r of fixed enclosed mass, r'' = -4 pi r^2 dP/dm - G m/r^2 + (2/3) l^2/r^3 with l = Omega_0 r_0^2 of the
    equator: the centrifugal force's mean over the sphere.
    """
    with jax.enable_x64(True):
        units = code_units(scene)
        ball = sphere(scene, units)
        fluid = equation_of_state(scene, units, ball)
        one_zone: Any = prepare(load.loads(scene.to_toml(), ("model='scaling'",), scene.origin)).evolution
        spin = one_zone.body
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


def errors(answers: list[Answer], reference: Reference) -> np.ndarray:
    """Relative errors (A, 2) of I_zz and the angular velocity."""
    found = np.array([[each.found.values[one.name][0] for one in JUDGED] for each in answers])
    return abs(found / reference.values - 1)


def picture(answers: list[Answer], found: np.ndarray, reference: Reference, law: convergence.PowerLaw) -> None:
    """Error against processor time, a colour and marker a model; I_zz filled, the angular velocity open."""
    seconds = np.array([each.cpu_time for each in answers])
    models = np.array([each.rung.model for each in answers])
    with style.styled():
        figure = style.page("A collapsing core by every model: error against time", (9.2, 5.4))
        panel = figure.subplots()
        panel.set(xscale="log", yscale="log", xlabel="processor time of the steps (s)",
                  ylabel="relative error at 70 ms, before the bounce")  # fmt: skip
        for model, (marker, colour) in LOOK.items():
            own = models == model
            panel.plot(
                seconds[own], found[own, 1], marker, color=colour, markersize=12, markerfacecolor="none", zorder=3
            )
            panel.plot(
                seconds[own], found[own, 0], marker, color=colour, markersize=8, markeredgecolor="white", zorder=4
            )
        steps = steps_of(particles_of(answers))
        panel.plot(
            seconds[models == "sph"], [law.at(step) for step in steps], color=style.BLUE, linewidth=1.3, zorder=2
        )
        panel.set_xlim(seconds.min() / 4, seconds.max() * 9)
        panel.set_ylim(0.7 * reference.uncertainty, 0.6)
        panel.axhspan(panel.get_ylim()[0], reference.uncertainty, color=style.PALE, alpha=0.6, zorder=0.2)
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_locator(LogLocator(numticks=20))
            axis.set_minor_formatter(NullFormatter())
        panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g} %"))
        labelled(panel, answers, seconds, found)
        middle = np.flatnonzero(models == "sph")[len(steps) // 2]
        order = f"order {law.order:.2f} ± {law.uncertainty:.2f}\nin $N^{{-1/3}}$"
        beside(panel, (seconds[middle], found[middle].min()), (-92, -24), order, style.BLUE)
        panel.annotate(
            f"the reference is known to {100 * reference.uncertainty:.1g} %", (0.01, reference.uncertainty),
            xycoords=("axes fraction", "data"), xytext=(0, 3), textcoords="offset points", fontsize=9, color=style.GREY,
        )  # fmt: skip
        panel.legend(handles=legend(), loc="lower left", bbox_to_anchor=(0.0, 0.07))
        style.save(figure, PICTURE)


def labelled(panel: Any, answers: list[Answer], seconds: np.ndarray, found: np.ndarray) -> None:
    """What stands beside the points: models by name, particles by their number."""
    for number, answer in enumerate(answers):
        place = seconds[number], found[number].max()
        if answer.rung.model == "sph":
            beside(panel, place, (8, 6), answer.rung.label, style.BLUE)
        if answer.rung.model == "scaling":
            beside(panel, place, (8, 8), f"scaling,\n{answer.rung.label}", LOOK["scaling"][1])
    own = [number for number, answer in enumerate(answers) if answer.rung.model == "ellipsoid"]
    ends = (float(answers[number].rung.label.split()[-1]) for number in (own[0], own[-1]))
    label = "ellipsoid, tolerance\n" + " to ".join(f"$10^{{{np.log10(each):.0f}}}$" for each in ends)
    beside(panel, (seconds[own[0]], found[own[0]].min()), (-4, -34), label, LOOK["ellipsoid"][1])


def beside(panel: Any, place: tuple[Any, Any], offset: tuple[float, float], text: str, colour: str) -> None:
    """A label at so many points from a place."""
    panel.annotate(text, place, xytext=offset, textcoords="offset points", fontsize=9.5, color=colour)


def legend() -> list[Line2D]:
    """A model a line, and what is filled and open."""
    points = [
        Line2D([], [], marker=marker, color=colour, linestyle="", markersize=8, markeredgecolor="white", label=model)
        for model, (marker, colour) in LOOK.items()
    ]
    kinds = [
        Line2D(
            [], [], marker="o", color=style.GREY, linestyle="", markersize=size, markerfacecolor=face, label=quantity
        )
        for face, size, quantity in ((style.GREY, 8, "moment of inertia $I_{zz}$"), ("none", 12, "angular velocity"))
    ]
    return [*points, *kinds]


def row(answer: Answer, own: np.ndarray) -> list[object]:
    """A row of the table; own: the two errors."""
    found = answer.found
    moment, rate = (found.values[one.name][0] for one in JUDGED)
    return [
        answer.rung.model, answer.rung.label, duration(answer.cpu_time), duration(answer.wall_time),
        found.steps if answer.rung.particles else "", f"{moment:.5g}", f"{rate:.5g}",
        *(f"{100 * each:.2f} %" for each in own),
    ]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=Path("runs/ladder"))
    parser.add_argument("--particles", nargs="+", type=int, default=[300, 1000, 3000, 10_000, 30_000])
    parser.add_argument("--tolerances", nargs="+", type=float, default=[1e-4, 1e-7, 1e-10])
    parser.add_argument("--keep", action="store_true", help="write the table and the picture")
    chosen = parser.parse_args()
    scene = load.load_file(ROOT / "sims" / "pulsar_collapse.toml", list(OVERRIDES))
    answers = []
    for rung in rungs(chosen.particles, chosen.tolerances):
        answers.append(answered(scene, rung, chosen.folder))
        print(f"{rung.setting.value}: {duration(answers[-1].cpu_time)}", flush=True)
    reference = reference_of(scene, answers)
    found = errors(answers, reference)
    ladder = np.array([each.rung.model == "sph" for each in answers])
    law = convergence.power_law(steps_of(particles_of(answers)), found[ladder, 0], reference.uncertainty)
    publish("ladder", report(answers, found, reference, law), chosen.keep)
    if chosen.keep:
        picture(answers, found, reference, law)


def report(answers: list[Answer], found: np.ndarray, reference: Reference, law: convergence.PowerLaw) -> str:
    """The table and what stands below it."""
    head = ["model", "how", "processor time", "wall time", "steps", "I_zz (kg m2)", "angular velocity (rad/s)",
            "error of I_zz", "of the angular velocity"]  # fmt: skip
    coarse, fine, mean = reference.mean_moments
    alone, spread, own = extrapolated(answers)
    times = [each.cpu_time for each in answers]
    overrides = " and ".join(f"`{each}`" for each in OVERRIDES)
    return "\n".join([
        "# The collapse of a core by every model, error against time",
        "",
        f"{machine()}; times are of the steps.",
        "",
        f"`sims/pulsar_collapse.toml` with {overrides}; the closed form with `{CLOSED_FORM}`.",
        "",
        rows_of(head, [row(answer, each) for answer, each in zip(answers, found, strict=True)]),
        f"Reference: I_zz = {reference.values[0]:.6g} kg m2, angular velocity {reference.values[1]:.5g} rad/s, known "
        f"to {100 * reference.uncertainty:.2g} %.",
        "",
        f"- Mean moment by {SHELLS[0]} and {SHELLS[1]} spherical shells: {coarse:.6g} and {fine:.6g}, in the limit "
        f"{mean:.6g} kg m2; I_zz is {100 * reference.flattening:.2f} % above it with the finest particles.",
        f"- Particles by themselves: {alone:.6g} kg m2 by Richardson's extrapolation with their order {own.order:.2f} "
        f"± {own.uncertainty:.2f} in N^(-1/3), which makes {100 * spread:.2g} %: {100 * (alone / mean - 1):+.2f} % "
        "from the shells.",
        f"- Error of I_zz with particles: order {law.order:.2f} ± {law.uncertainty:.2f} in N^(-1/3).",
        f"- From the cheapest to the costliest: {np.log10(max(times) / min(times)):.1f} decades of processor time.",
        "",
    ])  # fmt: skip


if __name__ == "__main__":
    main()
