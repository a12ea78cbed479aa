"""Companion runs: a scene with one source of error made coarser, or finer, by a known ratio of its step.

What two runs that differ in one knob differ by is that knob's error, and how much of it a run has follows from the
ratio of the steps (accuracy.error_bars). What few neighbours do, the noise of sums over them, is seen where neighbours
and particles are twice as many and the smoothing length is the same. Tests: tests/unit/accuracy/test_error_bars.py.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from astroinertia.accuracy.knobs import Knob, knobs, overridden, shown
from astroinertia.errors import SceneError
from astroinertia.scene.plan import RECORDS, cadence, records, smoothing
from astroinertia.scene.schema import MOST_RECORDS, Scene

PARTICLES, NEIGHBOURS = "particles", "neighbours"
_RATIO = 3.0  # in the number of particles from one run to the next
_LEAST_RATIO = 2.0  # from which on three of them tell an order
_NEIGHBOURHOODS = 2.0  # in a body of the coarsest run: with fewer particles no sphere of neighbours fits into it
_MORE_NEIGHBOURS = 2.0  # and particles
# Of the noise in the inverse of the number of neighbours: between 1/2 of particles in disorder and 1 (Zhu, Hernquist &
# Li 2015, ApJ 800, 6). Where two runs alone tell of an error half of this is taken (error_bars).
_NOISE_ORDER = 1.0
_MOST_STEPS = 10**12  # that a scene may allow
_FINER = {"tolerance": 0.1, "steps_per_rotation": 0.5}  # of the step, in runs that cost so little
_COARSER = {"timestep_factor": 2.0, "force_error": 10.0}


@dataclass(frozen=True)
class CompanionRun:
    """A run beside that of a scene, and what it tells of.

    source: the knob in which alone it differs from the companion run named `against`, or from the scene's own run where
    that is empty. step: of that knob, over that of the other's; order: of the error in the step, by theory. scatter:
    whether the error is also one of a random arrangement, and no smooth function of the step alone.
    """

    name: str
    source: str
    against: str
    step: float
    order: float
    scatter: bool
    scene: Scene = field(compare=False)


def companion_runs(scene: Scene) -> tuple[CompanionRun, ...]:
    """The companion runs that tell the error bars of a scene, the ones with more particles first.

    Without particles there is one, and it is finer: it costs as little as the run itself, and its difference from it is
    the error of the run, of whatever order. Particles have coarser ones, at about half of the run's particles times
    steps: two with fewer particles, which also tell the order, and beside the one with the fewest one with longer
    steps, one with coarser gravity, and one with twice the neighbours and particles. A run with too few particles for
    that has one with more. SceneError for a scene whose resolution no knob sets.

    >>> from astroinertia.scene import load
    >>> scene = load.load_file("sims/evrard.toml", ["body.particles=9000"])
    >>> print([run.name for run in companion_runs(scene)])
    ['particles-3000', 'particles-1000', 'timestep_factor-2', 'force_error-0.002', 'neighbours-89.2']
    """
    all_knobs = knobs(scene)
    if not all_knobs or all_knobs[0].step is None:
        raise SceneError(f"the model {scene.model} has no error bars: its answers are closed forms.")
    if scene.model != "sph":
        return (_finer(scene, all_knobs[0]),)
    if all_knobs[0].name != PARTICLES:
        raise SceneError("error bars need a number of particles that can be turned; a table has its own.")
    return tuple(_of_particles(scene, {knob.name: knob for knob in all_knobs}))


def _finer(scene: Scene, knob: Knob) -> CompanionRun:
    """One with a smaller step, and twice as many records: these models shorten steps to meet each of them."""
    assert knob.step is not None
    quiet, every = ["output.error_bars=false", *_as_far(scene)], cadence(scene).series_every
    if every is not None and records(scene.time.end, 0.5 * every) <= MOST_RECORDS:
        quiet.append(f"output.series_every={scene.time_setting(0.5 * every)}")
    for ratio in (_FINER[knob.name], 1.0 / _FINER[knob.name]):
        value = float(f"{knob.value_at(ratio * knob.step(knob.default)):.12g}")
        try:
            turned = overridden(scene, (*quiet, *knob.overrides(value)))
        except SceneError:  # at the end of what the knob allows, it can only be coarser
            continue
        return _run(knob, value, "", turned)
    raise SceneError(f"error bars need {knob.name.replace('_', ' ')} that can be changed.")


def _as_far(scene: Scene) -> tuple[str, ...]:
    """Steps enough to come as far as a run that ends after a number of them: shorter ones are at most twice as many."""
    most = scene.time.max_steps
    return () if most is None else (f"time.max_steps={min(2 * most, _MOST_STEPS)}",)


def _of_particles(scene: Scene, by_name: dict[str, Knob]) -> Iterator[CompanionRun]:
    quiet = [
        "output.error_bars=false",
        *_as_far(scene),
        "output.align=false",  # their steps are to differ, whatever is recorded
        f"output.snapshot_every={scene.time_setting(scene.time.end)}",
    ]
    every = cadence(scene).series_every
    if every is not None:  # often enough to be interpolated, however seldom the run itself is recorded
        quiet.append(f"output.series_every={scene.time_setting(min(every, scene.time.end / RECORDS))}")
    still = overridden(scene, tuple(quiet))
    knob, coarsest, name = by_name[PARTICLES], still, ""
    assert knob.step is not None
    own, steps = round(knob.step(knob.default) ** -3.0), {knob.step(knob.default)}  # lattices have numbers of their own
    for count in _numbers(own, _fewest(scene)):
        if knob.step(count) in steps:
            continue
        steps.add(knob.step(count))
        turned = overridden(still, knob.overrides(count))
        companion = _run(knob, count, "", turned)
        yield companion
        if count < float(knob.default):
            coarsest, name = turned, companion.name
    for knob_name, ratio in _COARSER.items():
        if knob_name not in by_name:
            continue
        knob = by_name[knob_name]
        wanted = ratio * float(knob.default)
        value = wanted if wanted <= max(map(float, knob.values)) else float(knob.default) / ratio
        yield _run(knob, value, name, overridden(coarsest, knob.overrides(value)))
    yield from _with_more_neighbours(coarsest, name)


def _with_more_neighbours(coarsest: Scene, name: str) -> Iterator[CompanionRun]:
    """Of the same smoothing length; none where so many neighbours are not allowed."""
    by_name = {knob.name: knob for knob in knobs(coarsest)}
    particles, neighbours = by_name[PARTICLES], by_name[NEIGHBOURS]
    number = float(f"{_MORE_NEIGHBOURS * float(neighbours.default):.3g}")
    more = (*particles.overrides(round(_MORE_NEIGHBOURS * float(particles.default))), *neighbours.overrides(number))
    try:
        turned = overridden(coarsest, more)
    except SceneError:
        return
    step = 1.0 / _MORE_NEIGHBOURS
    yield CompanionRun(f"{NEIGHBOURS}-{shown(number)}", NEIGHBOURS, name, step, _NOISE_ORDER, True, turned)


def _fewest(scene: Scene) -> float:
    """The smallest number of particles of all bodies, with which the smallest body still has neighbourhoods in it."""
    bodies: tuple[Any, ...] = scene.bodies or (scene.body,)
    counts = [body.particles for body in bodies]
    return _NEIGHBOURHOODS * smoothing(scene)[1] * sum(counts) / min(counts)


def _numbers(count: float, fewest: float) -> tuple[float, ...]:
    """The numbers of particles of the companion runs, beside `count`."""
    ratio = min(_RATIO, (count / fewest) ** 0.5)
    if ratio < _LEAST_RATIO:
        return (round(_RATIO * count),)
    return round(count / ratio), round(count / ratio**2)


def _run(knob: Knob, value: float, against: str, turned: Scene) -> CompanionRun:
    assert knob.step is not None and knob.order is not None
    step = knob.step(value) / knob.step(knob.default)
    name = f"{knob.name}-{shown(value)}"
    return CompanionRun(name, knob.name, against, step, knob.order, turned.model == "sph", turned)
