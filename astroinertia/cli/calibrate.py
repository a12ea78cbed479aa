"""The command `calibrate`, and what `plan` and `run` say of costs. Printing is left to main.py."""

import math
from collections.abc import Mapping
from dataclasses import replace
from numbers import Real
from typing import TYPE_CHECKING, Any

from astroinertia.cli.parser import Add, Options, Say
from astroinertia.errors import SceneError

if TYPE_CHECKING:
    from astroinertia.scene.plan import Plan
    from astroinertia.scene.schema import Scene

HELP = """\
The command measures how long passes over pairs, gravity, time steps, records, files and the start of a run take, in a
minute on a quiet machine, and keeps that in the user's cache ($ASTROINERTIA_CACHE). Plans and runs then give wall
times of this machine; until then they give those of a 2-core x86-64 machine. Other versions, or another machine, call
for another calibration.

example: astroinertia calibrate
         astroinertia plan star.toml
         astroinertia plan star.toml --pilot
         astroinertia plan star.toml --processes 4
"""


def add_plan_arguments(add: Add) -> None:
    """Add what `plan` may do to know costs better."""
    add("--pilot", action="store_true",
        help="count the steps by a run with few particles, of about 20 s at most; runs and plans of the scene know it "
        "from then on")  # fmt: skip
    add("--processes", type=int, default=1, metavar="N",
        help="say what a run of particles takes that mpirun -n N shares out over machines like this one")  # fmt: skip


def report(say: Say) -> str:
    """Measure the machine; what the command prints at the end."""
    from astroinertia.costs import calibration, machine

    measured = calibration.calibrate(lambda text, share: say(f"{100.0 * share:3.0f}%  {text}"))
    step = sum(measured.seconds[f"float64.{name}"].wall for name in ("density", "gradients", "forces", "multipole"))
    lines = [
        f"machine: {measured.description['processor']}, {measured.description['cores']} cores",
        f"start of a run: {measured.seconds['start'].wall:.2g} s",
        f"a step of a million particles under gravity, pressure and viscosity: "
        f"{1e6 * (step + measured.seconds['rest'].wall):.2g} s",
        f"kept in {machine.cache_directory() / machine.FILE}",
    ]
    return "\n".join(lines)


def refuse_processes(options: Options, scene: "Scene | None") -> None:
    """SceneError where --processes says what cannot be; scene: None of a sweep."""
    if options.processes < 1:
        raise SceneError(f"--processes {options.processes}: the number of processes is at least 1.")
    if options.processes == 1:
        return
    if scene is None:
        raise SceneError("--processes is for one run; a sweep shares its members out by --workers.")
    if scene.model != "sph" or scene.numerics.engine != "numba_cpu":
        raise SceneError("--processes is for a run of particles with the engine numba_cpu, whose sums they share out.")


def refuse_pilot(options: Options, scene: "Scene") -> None:
    """SceneError where a pilot is asked for and has nothing to find out."""
    if options.pilot and scene.model != "sph" and not scene.wants_choice:
        raise SceneError(
            "--pilot counts the steps of particles, or chooses the settings for an accuracy: the model "
            f"{scene.model} has no particles, and the scene asks for no accuracy."
        )


def with_cost(plan: "Plan", scene: "Scene", options: Options, say: Say) -> "Plan":
    """The plan with what the run will take; with --pilot a run with few particles counts its steps first."""
    from astroinertia.costs import machine, plan_lines
    from astroinertia.costs.prediction import predict

    if options.pilot and scene.model == "sph":
        from astroinertia.costs import pilot

        say(f"a pilot run with few particles, {pilot.LONGEST:.0f} s at most after its preparation ...")
        if pilot.run(scene) is None:
            say("it could not be run: the steps are estimated")
    if scene.model == "scaling" and scene.equation_of_state is not None:
        import jax

        from astroinertia.build.assemble import prepare

        with jax.enable_x64(True):
            prepare(scene)  # refuses a pulsation that cannot be followed to the end
    speeds = machine.current()
    lines = plan_lines.lines(scene, predict(scene, speeds, options.processes))
    if scene.output.error_bars:
        from astroinertia.accuracy.companion_runs import companion_runs

        runs = companion_runs(scene)
        costs = {run.name: (run.scene, predict(run.scene, speeds, options.processes)) for run in runs}
        lines = (*lines, plan_lines.of_error_bars(scene, costs))
    if scene.wants_choice:
        from astroinertia.accuracy.choice import price_before

        lines = (*lines, plan_lines.of_pilots(price_before(scene)))
    return replace(plan, sections={**plan.sections, "cost": lines})


def compared(attrs: Mapping[str, Any]) -> str:
    """What a run took, and what had been predicted."""
    taken, predicted, bars = (_seconds(attrs, f"{kind}_wall_time") for kind in ("measured", "predicted", "error_bars"))
    if not math.isfinite(taken):
        return ""
    said = f"took {taken:.3g} s" + (f", predicted {predicted:.3g} s" if math.isfinite(predicted) else "")
    return f"{said}; {bars:.3g} s more for error bars" if math.isfinite(bars) else said


def _seconds(attrs: Mapping[str, Any], name: str) -> float:
    """A time that a run kept; NaN where it is no number, as in a manifest that was changed by hand."""
    value = attrs.get(name)
    return float(value) if isinstance(value, Real) and not isinstance(value, bool) else math.nan
