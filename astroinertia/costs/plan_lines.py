"""The costs in a plan: lines with a name, a value and why."""

from collections.abc import Mapping

from astroinertia.costs.experience import few
from astroinertia.costs.machine import SHIPPED_MACHINE
from astroinertia.costs.piloted import PILOT
from astroinertia.costs.prediction import PREPARATION, Prediction
from astroinertia.costs.processes import NETWORK
from astroinertia.process.words import duration, size
from astroinertia.scene.plan import Line, code_units
from astroinertia.scene.schema import Scene

STEP = "steps: "
LONG = 20.0  # seconds, from which on a pilot pays
MULTIPLIED = 2.0  # times the work of steps, from which on a plan says that outputs ask for them
SMALL = 0.005  # share of the run time that is not worth a word


def lines(scene: Scene, cost: Prediction | None) -> tuple[Line, ...]:
    """The section of a plan."""
    if cost is None:
        return (Line("wall time", "not known", _unknown(scene)),)
    machine = (
        "of this machine, calibrated"
        if cost.calibrated
        else f"of {SHIPPED_MACHINE}; astroinertia calibrate measures this one"
    )
    estimated = not cost.steps_by.startswith(PILOT) and scene.model == "sph"
    by = f"{cost.steps_by}; --pilot counts them" if estimated and cost.wall_time > LONG else cost.steps_by
    section = [Line("wall time", duration(cost.wall_time), machine)]
    if cost.steps:
        section.append(Line("steps", f"about {cost.steps:.3g}", by))
    first = {name: float(code_units(scene).to_si(limit, "time")) for name, limit in cost.first.items()}
    shown = [f"{name} {scene.shown(float(f'{s:.2g}'), 'time')}" for name, s in first.items() if s < scene.time.end]
    if shown:
        section.append(Line("time step at first", ", ".join(shown), "at most by each criterion; shocks shorten it"))
    if cost.received:
        each = f"{size(cost.received)} an evaluation of all particles"
        section.append(Line("sent to each process", each, f"taken to arrive at {8e-9 * NETWORK:.0f} Gbit/s"))
    if cost.for_outputs > MULTIPLIED:
        often = f"{cost.for_outputs:.2g} times the work of the steps that the particles need by themselves"
        section.append(Line("outputs", often, "to meet their times: record less often, or set [output] align = false"))
    whole = max(cost.wall_time, 1e-300)
    for name, part in cost.parts.items():
        if name in PREPARATION:
            section.append(Line(name, duration(part.wall), f"{part.wall / whole:.0%} of the time"))
    shares = {name: part.wall / whole for name, part in cost.parts.items() if name not in PREPARATION}
    spent = [f"{name.removeprefix(STEP)} {share:.0%}" for name, share in shares.items() if share >= SMALL]
    if spent:
        section.append(Line("the rest", ", ".join(spent), "of the time"))
    of = "of each process, which holds all particles" if cost.received else "of the process, at most"
    section.append(Line("memory", size(cost.memory), of))
    section.append(Line("files", size(cost.files), "in the run's folder"))
    return tuple(section)


def of_error_bars(main: Scene, runs: Mapping[str, tuple[Scene, Prediction | None]]) -> Line:
    """The line of a plan on companion runs, by their names: what they take in the process of the scene's own run.

    Programs are those of that run, but for particles that are few, where its own are not, or the other way round.
    """
    why = f"of companion runs for error bars: {', '.join(runs)}"
    taken, compiled = 0.0, {few(main)}
    for scene, cost in runs.values():
        if cost is None:
            return Line("error bars", "wall time not known", why)
        taken += cost.again.wall
        if few(scene) not in compiled:
            taken += cost.compiling.wall
            compiled.add(few(scene))
    return Line("error bars", f"{duration(taken)} more", why)


def of_pilots(price: str) -> Line:
    """The line of a plan on the pilots that a choice of settings takes, by what they are said to take."""
    return Line("pilots", price or "wall time not known", "none of particles where a cheaper model is exact")


def _unknown(scene: Scene) -> str:
    if scene.numerics.engine != "numba_cpu":
        return f"the engine {scene.numerics.engine} is not calibrated"
    if scene.particles is None:
        return "how many steps the particles of a table take is not estimated"
    return "nothing is known of its flow; --pilot counts its steps"
