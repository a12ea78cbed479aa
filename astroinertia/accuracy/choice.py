"""`accuracy = 1e-3`: the rung of the ladder of models and the settings that have it, for the least time.

Pilot runs tell what each source of error contributes; the search for particles is in choice_particles, that for the
other models in choice_smooth. Sources are balanced: none is made much smaller than the others. Where the time allowed
does not suffice, the cost is reported. Tests: tests/unit/accuracy/test_choice.py; tests/benchmarks/delivered.py
compares what was asked with what was delivered, on scenes with exact answers.
"""

from dataclasses import dataclass
from pathlib import Path

from astroinertia.accuracy import choice_particles, choice_smooth, measuring
from astroinertia.accuracy.knobs import MODEL, knobs, with_overrides
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.observables import default_names, parsed
from astroinertia.accuracy.pilots import Found, Listener, OutOfReach, Pilots
from astroinertia.accuracy.words import duration
from astroinertia.build.assemble import prepare
from astroinertia.errors import NumericalError, SceneError
from astroinertia.process.renamed import renamed_keyword
from astroinertia.scene.schema import Scene

DEFAULT_MINUTES = 60.0
GIVEN = 'settings="given"'
"""What is set in a scene whose settings are chosen, so that they stay."""


class UnreachableAccuracy(SceneError):
    """The accuracy asked for is out of reach of the time that is allowed; the sentence has the cost."""


@dataclass(frozen=True)
class Choice:
    """A scene with the settings that were chosen for it.

    scene: as it is to be run; found: what was chosen, with the errors expected of each source; pilot_seconds: of wall
    time that finding it took.
    """

    scene: Scene
    found: Found
    pilot_seconds: float


def pilots_beside(folder: Path) -> Path:
    """Where the pilots of a run are kept: beside its folder.

    >>> print(pilots_beside(Path("runs/star")).name)
    star-pilots
    """
    return folder.with_name(f"{folder.name}-pilots")


@renamed_keyword("told", "listener")
def choose(
    scene: Scene, folder: Path, minutes: float = DEFAULT_MINUTES, listener: Listener = lambda text: None
) -> Choice:
    """The cheapest settings that have the accuracy a scene asks for, by pilot runs kept below `folder`.

    minutes: of wall time that the run itself may take. listener: is called with a line before each pilot. The model is
    chosen, too, unless the scene names one. SceneError where a scene asks for no accuracy or has nothing to choose, and
    UnreachableAccuracy, with the cost, where it takes longer.

    >>> from astroinertia.scene import load
    >>> scene = load.load_file("sims/tennis_racket.toml", ["accuracy=1e-6", "time.end='1 s'"])
    >>> found = choose(scene, Path("runs/racket-pilots"))
    >>> print(found.found.error < 1e-6)
    True
    """
    if scene.accuracy is None:
        raise SceneError("accuracy is not asked for: write accuracy = 1e-3, or another number, into the scene.")
    asked = tuple(parsed(name, scene.observables) for name in (scene.judged_by or default_names(scene)))
    pilots = Pilots(scene, asked, folder, listener)
    seconds = 60.0 * minutes
    if scene.model == "scaling":
        raise SceneError('the model scaling has nothing to choose: its answers are closed forms; settings = "given".')
    found = _by_rungs(pilots, scene.accuracy, seconds)
    if isinstance(found, OutOfReach):
        raise UnreachableAccuracy(f"accuracy {scene.accuracy:g} is out of reach: {found.sentence}.")
    chosen = with_overrides(scene, (*found.overrides, GIVEN))
    names = ", ".join(each.name for each in asked)
    sources = ", ".join(f"{source} {error:.1e}" for source, error in found.errors.items())
    record = {
        "accuracy": f"{scene.accuracy:g} of {names} at the end; expected {found.error:.1e} ({sources}), "
        f"stated {found.bar:.1e}",
        **{f"why {number}": reason for number, reason in enumerate(found.reasons, 1)},
        "price": f"{duration(found.seconds)} for the run, {duration(pilots.spent)} for pilots",
    }
    return Choice(chosen.model_copy(update={"choice": record}), found, pilots.spent)


def _by_rungs(pilots: Pilots, accuracy: float, seconds: float) -> Found | OutOfReach:
    """The cheapest rung that is known to have the accuracy: one that is exact, or agrees with particles."""
    scene = pilots.scene
    if scene.model != "sph":
        return choice_smooth.search(pilots, accuracy, seconds)
    simpler: list[tuple[str, Measured, Found]] = []
    for rung in _free_rungs(scene):
        of_rung = with_overrides(scene, (f"model='{rung}'",))
        try:
            exact = _is_exact(of_rung)
        except (SceneError, NumericalError):
            continue
        found = _of_rung(pilots, rung, of_rung, accuracy, seconds)
        if found is None:
            continue
        if exact:
            return found
        simpler.append((rung, pilots.run(f"model {rung}", found.overrides), found))

    def agreeing(limit: Measured, error: float) -> Found | None:
        for rung, measured, found in simpler:
            apart = pilots.apart(measured, limit) + error
            if apart <= accuracy:
                why = f"model {rung}: it agrees with what particles tend to, to {apart:.1e} with what is unsure of that"
                return Found(found.overrides, found.chosen, {"model": apart}, found.seconds, (why, *found.reasons))
        return None

    return choice_particles.search(pilots, accuracy, seconds, agreeing)


def _free_rungs(scene: Scene) -> tuple[str, ...]:
    """The rungs below particles that may be chosen: none where the scene names its model."""
    if "model" in scene.model_fields_set:
        return ()
    found = next((knob for knob in knobs(scene) if knob.name == MODEL), None)
    return () if found is None else tuple(str(value) for value in found.values if value != scene.model)


def _is_exact(scene: Scene) -> bool:
    """Whether a model says of itself that it is exact for this body, and the fluid stays so.

    A homogeneous gas under its own gravity is not stable: its fluid leaves the ellipsoids in a free-fall time.
    """
    unstable = {"gravity", "pressure"} <= set(scene.effects) and getattr(scene.equation_of_state, "kind", "") == "ideal"
    return not unstable and prepare(scene).evolution.approximation.startswith("exact")


def _of_rung(pilots: Pilots, rung: str, scene: Scene, accuracy: float, seconds: float) -> Found | None:
    setting = f"model='{rung}'"
    if rung == "scaling":
        measured = pilots.run(f"model {rung}", (setting,))
        if measured.failure:
            return None
        return Found((setting,), {MODEL: rung}, {}, measured.wall_time, ("closed form",))
    inner = Pilots(scene, pilots.observables, pilots.folder, pilots.listener)
    found = choice_smooth.search(inner, 0.1 * accuracy, seconds)
    pilots.spent += inner.spent
    if isinstance(found, OutOfReach):
        return None
    return Found(
        (setting, *found.overrides), {MODEL: rung, **found.chosen}, found.errors, found.seconds,
        (f"model {rung}", *found.reasons),
    )  # fmt: skip


def measured(choice: Choice, folder: Path) -> Measured:
    """What the chosen setting gives and takes, as a tradeoff measures it.

    >>> from astroinertia.scene import load
    >>> scene = load.load_file("sims/tennis_racket.toml", ["accuracy=1e-6", "time.end='1 s'"])
    >>> found = measured(choose(scene, Path("runs/racket-pilots")), Path("runs/racket-pilots"))
    >>> print(sorted(found.values))
    ['angular_velocity', 'attitude 3']
    """
    scene = choice.scene
    asked = tuple(parsed(name, scene.observables) for name in (scene.judged_by or default_names(scene)))
    quiet = measuring.scene_of(scene, measuring.AS_IT_IS, asked)
    place = measuring.folder_of(folder, quiet, measuring.AS_IT_IS)
    return measuring.stored(place, asked) or measuring.measure(quiet, asked, place)
