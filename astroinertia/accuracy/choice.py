"""`accuracy = 1e-3`: the rung of the ladder of models and the settings that have it, for the least time.

Pilot runs tell what each source of error contributes; the search for particles is in choice_particles, that for the
other models in choice_smooth. Sources are balanced: none is made much smaller than the others. Where the time allowed
does not suffice, the cost is reported. Tests: tests/unit/accuracy/test_choice.py; tests/benchmarks/delivered.py
compares what was asked with what was delivered, on scenes with exact answers.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from astroinertia.accuracy import choice_particles, choice_smooth
from astroinertia.accuracy.knobs import MODEL, knobs, overridden
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.pilots import Listener, OutOfReach, Pilots, Settings, seconds_of
from astroinertia.accuracy.selected_observables import default_names, parsed
from astroinertia.build.assemble import prepare
from astroinertia.costs import reference
from astroinertia.costs.machine import SHIPPED_MACHINE
from astroinertia.errors import NumericalError, SceneError
from astroinertia.process.words import duration
from astroinertia.scene.schema import Scene

DEFAULT_MINUTES = 60.0
OF_RUNG = 4  # runs of a cheaper model that is not exact, to find its settings and its answer
GIVEN = 'settings="given"'
"""What is set in a scene whose settings are chosen, so that they stay."""


class UnreachableAccuracy(SceneError):
    """The accuracy asked for is out of reach of the time that is allowed; the sentence has the cost."""


@dataclass(frozen=True)
class Choice:
    """A scene with the settings that were chosen for it.

    scene: as it is to be run; settings: the chosen ones, with the errors expected of each source; pilots: those that
    they were found by, and what these took.
    """

    scene: Scene
    settings: Settings
    pilots: Pilots


def pilots_beside(folder: Path) -> Path:
    """Where the pilots of a run are kept: beside its folder.

    >>> print(pilots_beside(Path("runs/star")).name)
    star-pilots
    """
    return folder.with_name(f"{folder.name}-pilots")


def choose(
    scene: Scene, folder: Path, minutes: float = DEFAULT_MINUTES, listener: Listener = lambda text: None
) -> Choice:
    """The cheapest settings that have the accuracy a scene asks for, by pilot runs kept below `folder`.

    minutes: of wall time that the run itself may take. listener: is called with a line before each pilot. The model is
    chosen, too, unless the scene names one. SceneError where a scene asks for no accuracy or has nothing to choose, and
    UnreachableAccuracy, with the cost, where it takes longer.

    >>> from astroinertia.scene import load
    >>> scene = load.load_file("sims/tennis_racket.toml", ["accuracy=1e-6", "time.end='1 s'"])
    >>> choice = choose(scene, Path("runs/racket-pilots"))
    >>> print(choice.settings.error < 1e-6)
    True
    """
    if scene.accuracy is None:
        raise SceneError("accuracy is not asked for: write accuracy = 1e-3, or another number, into the scene.")
    observables = tuple(parsed(name, scene.observables) for name in (scene.judged_by or default_names(scene)))
    pilots = Pilots(scene, observables, folder, listener)
    seconds = 60.0 * minutes
    if scene.model == "scaling":
        raise SceneError('the model scaling has nothing to choose: its answers are closed forms; settings = "given".')
    settings = _by_rungs(pilots, scene.accuracy, seconds)
    if isinstance(settings, OutOfReach):
        raise UnreachableAccuracy(f"accuracy {scene.accuracy:g} is out of reach: {settings.sentence}.")
    chosen = overridden(scene, (*settings.overrides, GIVEN))
    names = ", ".join(observable.name for observable in observables)
    sources = ", ".join(f"{source} {error:.1e}" for source, error in settings.errors.items())
    record = {
        "accuracy": f"{scene.accuracy:g} of {names} at the end; expected {settings.error:.1e} ({sources}), "
        f"stated {settings.bar:.1e}",
        **({"stated": sentence} if (sentence := _stated(settings, scene.accuracy)) else {}),
        **{f"why {number}": reason for number, reason in enumerate(settings.reasons, 1)},
        "price": f"{duration(settings.seconds)} for the run, {duration(pilots.spent)} for pilots and what they "
        f"compile; of evaluations {settings.work:.2g} and {pilots.work:.2g}{_processor(settings, pilots)}",
    }
    chosen = chosen.model_copy(update={"choice": record})
    return Choice(chosen, settings, pilots)


def price_before(scene: Scene) -> str:
    """What the pilots take that a choice begins with, in words; empty where that is not known.

    >>> from astroinertia.scene import load
    >>> scene = load.load_file("sims/tennis_racket.toml", ["accuracy=1e-6"])
    >>> print(price_before(scene).split(",")[0])
    2 pilots before the run
    """
    if scene.model == "sph":
        first = choice_particles.first(scene)
        limit = "; more of them as long as all take no more processor time than the run"
    else:
        first = choice_smooth.first(scene)
        limit = "; more of them as long as all take no more steps than the run"
    times, compiling = zip(*map(seconds_of, first), strict=True)
    if not all(times):
        return ""
    return f"{len(first)} pilots before the run, of about {duration(sum(times) + max(compiling))} in all{limit}"


def _processor(settings: Settings, pilots: Pilots) -> str:
    """Processor time of a run of particles and of its pilots, in words."""
    if not settings.processor:
        return ""
    return (
        f"; of processor time of {SHIPPED_MACHINE}, compiled, {duration(settings.processor)} with its start "
        f"and {duration(pilots.processor)}"
    )


def _stated(settings: Settings, accuracy: float) -> str:
    """Why a larger error is stated than was asked for; empty where it is not larger."""
    if settings.bar <= accuracy:
        return ""
    return (
        f"{settings.bar:.1e} is stated, more than the {accuracy:g} asked for: settings are chosen by the error that is "
        f"expected, {settings.error:.1e}, and twice that is stated, for estimates are as often too small as too large; "
        f"accuracy = {accuracy**2 / settings.bar:.2g} has {accuracy:g} stated"
    )


def _by_rungs(pilots: Pilots, accuracy: float, seconds: float) -> Settings | OutOfReach:
    """The cheapest rung that is known to have the accuracy: one that is exact, or agrees with particles."""
    scene = pilots.scene
    if scene.model != "sph":
        _announce(pilots, scene)
        return choice_smooth.search(pilots, accuracy, seconds)
    untried: list[tuple[str, Scene]] = []
    for rung in _free_rungs(scene):
        of_rung = overridden(scene, (f"model='{rung}'",))
        try:
            exact = _is_exact(of_rung)
        except (SceneError, NumericalError):
            continue
        if not exact:
            untried.append((rung, of_rung))
            continue
        if rung != "scaling":
            _announce(pilots, of_rung)
        if (settings := _of_rung(pilots, rung, of_rung, accuracy, seconds)) is not None:
            return settings
    simpler: list[tuple[str, Measured, Settings]] = []

    def agreeing(limit: Measured, error: float, affords: Callable[[float], bool]) -> Settings | None:
        while untried and affords(price := reference.without_particles(untried[0][1], OF_RUNG)):
            rung, of_rung = untried.pop(0)
            pilots.processor += price
            settings = _of_rung(pilots, rung, of_rung, accuracy, seconds)
            if settings is not None:
                simpler.append((rung, pilots.run(f"model {rung}", settings.overrides), settings))
        for rung, measured, settings in simpler:
            apart = pilots.apart(measured, limit) + error
            if apart <= accuracy:
                why = f"model {rung}: it agrees with what particles tend to, to {apart:.1e} with what is unsure of that"
                return replace(settings, errors={"model": apart}, reasons=(why, *settings.reasons))
        return None

    _announce(pilots, scene)
    return choice_particles.search(pilots, accuracy, seconds, agreeing)


def _announce(pilots: Pilots, scene: Scene) -> None:
    if before := price_before(scene):
        pilots.listener(before)


def _free_rungs(scene: Scene) -> tuple[str, ...]:
    """The rungs below particles that may be chosen: none where the scene names its model."""
    if "model" in scene.model_fields_set:
        return ()
    ladder = next((knob for knob in knobs(scene) if knob.name == MODEL), None)
    return () if ladder is None else tuple(str(value) for value in ladder.values if value != scene.model)


def _is_exact(scene: Scene) -> bool:
    """Whether a model says of itself that it is exact for this body, and the fluid stays so.

    A homogeneous gas under its own gravity is not stable: its fluid leaves the ellipsoids in a free-fall time.
    """
    unstable = scene.has_equilibrium and getattr(scene.equation_of_state, "kind", "") == "ideal"
    return not unstable and prepare(scene).evolution.approximation.startswith("exact")


def _of_rung(pilots: Pilots, rung: str, scene: Scene, accuracy: float, seconds: float) -> Settings | None:
    setting = f"model='{rung}'"
    if rung == "scaling":
        measured = pilots.run(f"model {rung}", (setting,))
        if measured.failure:
            return None
        return Settings((setting,), {MODEL: rung}, {}, measured.wall_time, ("closed form",))
    inner = Pilots(scene, pilots.observables, pilots.folder, pilots.listener)
    settings = choice_smooth.search(inner, 0.1 * accuracy, seconds)
    pilots.spent, pilots.work, pilots.predicted = (
        pilots.spent + inner.spent, pilots.work + inner.work, pilots.predicted + inner.predicted
    )  # fmt: skip
    if isinstance(settings, OutOfReach):
        return None
    return replace(
        settings, overrides=(setting, *settings.overrides), chosen={MODEL: rung, **settings.chosen},
        reasons=(f"model {rung}", *settings.reasons),
    )  # fmt: skip
