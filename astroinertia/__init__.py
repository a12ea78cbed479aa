"""Rotating, self-gravitating fluid bodies and the evolution of their inertia tensor.

    astroinertia.Scene(body=..., effects=[...], time=...)  a scene from Python, validated as a file is
    astroinertia.run_scene(scene, folder, effects=[...])  run a Scene, a scene file or a dict, with effects of your own
                                           (and matter=..., observables=[...] and an initial body, body=...)
    astroinertia.resume(folder)            continue an interrupted run, or a finished one to a later end
    astroinertia.branch(run, folder, at)   start a run from a state of another one, with other effects or settings
    astroinertia.gradient(scene, of, by)   how a number of a run depends on keys of its scene, by differentiation
    astroinertia.load(path, settings)      a scene from a TOML file, validated
    astroinertia.open(path)                the headline series of a run, an xarray Dataset with the accessor `.inertia`
    astroinertia.open_tree(path)           the same with the snapshots, an xarray DataTree
    astroinertia.open_sweep(path)          all members of a sweep, an xarray DataTree; open(path): in one Dataset

Every dataset of xarray has the accessor `.inertia`, however it was opened. Nothing else is set, and nothing imported,
until one of these is used.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ContextDecorator, suppress
from os import PathLike, fspath
from pathlib import Path
from threading import RLock
from typing import TYPE_CHECKING, Any

from astroinertia.process.imports import once_imported

if TYPE_CHECKING:
    import xarray as xr

    from astroinertia.effects import Effect
    from astroinertia.initial import Body
    from astroinertia.matter import Matter
    from astroinertia.observables import Observable
    from astroinertia.run.loop import Listener
    from astroinertia.run.state import RunState
    from astroinertia.scene.schema import Scene

    Function = Callable[[Any], Any]

Settings = Sequence[str] | Mapping[str, Any]

__all__ = ["Scene", "branch", "gradient", "load", "open", "open_sweep", "open_tree", "resume", "run_scene"]


class _OneAtATime(ContextDecorator):
    """Runs of several threads, one after another: the libraries that write files and compile are not made for more."""

    def __init__(self) -> None:
        self._lock = RLock()

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *error: object) -> None:
        self._lock.release()


_one_at_a_time = _OneAtATime()


def _register_accessor() -> None:
    """Give `.inertia` to datasets and trees of xarray, whose module is imported where it is first asked for."""
    import xarray as xr

    def inertia(opened: "xr.Dataset | xr.DataTree") -> Any:
        """The inertia tensor of a dataset and what follows from it: astroinertia.dataset.accessor."""
        from astroinertia.dataset.accessor import InertiaAccessor

        return InertiaAccessor(opened)

    xr.register_dataset_accessor("inertia")(inertia)
    xr.register_datatree_accessor("inertia")(inertia)


def _give_numba_a_place() -> None:
    """Have numba keep what it compiles where it may write."""
    from astroinertia.engines.numba_place import give_a_place

    give_a_place()


once_imported("xarray", _register_accessor)
once_imported("numba", _give_numba_a_place)


def __getattr__(name: str) -> Any:
    if name != "Scene":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from astroinertia.scene.schema import Scene

    return Scene


def __dir__() -> list[str]:
    return __all__  # what Tab offers


def load(path: str | PathLike[str], settings: Settings = ()) -> "Scene":
    """The scene in a TOML file, with settings put in; SceneError says what is wrong.

    settings: {"key.path": value}, or "key.path=value" texts.

    >>> scene = load("sims/crab_pulsar.toml", {"time.end": "10 yr"})
    >>> print(scene.model, list(scene.effects))
    scaling ['gravity', 'pressure', 'dipole_braking']
    """
    from astroinertia.process import requirements

    requirements.check()
    from astroinertia.scene.from_python import settings_of
    from astroinertia.scene.load import load_file

    return load_file(path, settings_of(settings))


@_one_at_a_time
def run_scene(
    scene: "Scene | Mapping[str, Any] | str | PathLike[str]",
    folder: str | PathLike[str],
    listener: "Listener | None" = None,
    workers: int = 1,
    cluster: str | None = None,
    effects: "Sequence[Effect | type[Effect] | Function]" = (),
    matter: "Matter | type[Matter] | None" = None,
    observables: "Sequence[Observable | type[Observable]]" = (),
    body: "Body | type[Body] | None" = None,
    callback: "Callable[[RunState], Any] | None" = None,
    every: Any = None,
    progress: bool | None = None,
) -> Path:
    """Run a scene (a Scene, a file, or a dict as Scene takes it) in a new folder; returns its netCDF file.

    Where the scene asks for an accuracy, pilot runs in a folder beside choose its settings first. A file with [sweep]
    runs its members in `workers` processes (more than one need a script that is guarded by
    `if __name__ == "__main__"`) or on a cluster of dask; finished members in the folder are kept.

    effects: of your own (astroinertia.effects), which act besides those that the scene lists. Their numbers are in SI
    (in code units where the scene is), or text with a unit. The class of an effect stands for what the scene lists by
    its kind. A plain function serves, too: it takes a state in SI (FluidState or RigidState of astroinertia.effects),
    and returns the accelerations (N, 3) of particles or the torque (3,) on a rigid body. SceneError names an effect
    that is not as it must be. matter: an equation of state of your own (astroinertia.matter) in place of the scene's,
    or the class of the one that the scene names by its kind. observables: of your own (astroinertia.observables), or
    their classes, recorded besides. body: an initial body of your own (astroinertia.initial), or its class, in place of
    the scene's; what does not depend on the kind of the scene's [body] stays.

    callback: a function that gets the state (run.state.RunState: time, positions, inertia_tensor,
    ledger_closure and so on, in SI with units) at the start, at the end, and at each record of the series, or `every`
    so often: a time, such as "2 min" or 2 * u.min, or a whole number of steps. It comes at the first step at or past
    each (of models without particles at the first record), and changes nothing in the run. Where it returns
    False the run is saved and stopped, up to 15 steps later, its folder is returned, and `resume` goes on; what it
    raises comes out when the run is saved.

    progress: whether to show how far the run is; by default on a terminal and in a notebook, unless there is a
    listener.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     print(run_scene("sims/core_to_pulsar_scaling.toml", folder + "/run").name)
    core_to_pulsar_scaling.nc
    """
    _get_ready()
    from astroinertia.accuracy import running
    from astroinertia.process.arguments import refuse_wrong
    from astroinertia.run.loop import refuse_before
    from astroinertia.run.meter import preparing, watched
    from astroinertia.scene import load as scenes, sweep as sweeps
    from astroinertia.scene.own import given_from_python
    from astroinertia.scene.schema import Scene

    place = _path("folder", folder)
    refuse_wrong(listener, workers, cluster, effects, observables)
    own = given_from_python(effects, matter, observables, body)
    if not own and not isinstance(scene, Scene) and (sweep := sweeps.of(scene)) is not None:
        from astroinertia.sweeps.ensemble import run_sweep

        _refuse_of_one_run(callback, every)
        with watched(progress, listener, "members are at work") as meter:
            return run_sweep(sweep, place, workers, cluster, listener=meter and meter.tell_members).file
    chosen = scenes.with_effects(scene, own) if isinstance(scene, Scene) else scenes.of(scene, own)
    called = running.callback_of(callback, every, chosen)
    with watched(progress, listener, preparing(chosen)) as meter:
        if chosen.wants_choice:
            refuse_before(chosen, place)
            from astroinertia.accuracy.choice import choose, pilots_beside

            chosen = choose(chosen, pilots_beside(place)).scene
        return running.unless_stopped(
            place, lambda: running.run_scene(chosen, place, _both(listener, meter), callback=called)
        )


@_one_at_a_time
def resume(
    folder: str | PathLike[str], listener: "Listener | None" = None, workers: int = 1, cluster: str | None = None,
    effects: "Sequence[Effect | type[Effect] | Function]" = (), matter: "Matter | type[Matter] | None" = None,
    observables: "Sequence[Observable | type[Observable]]" = (), body: "Body | type[Body] | None" = None,
    callback: "Callable[[RunState], Any] | None" = None, every: Any = None, progress: bool | None = None,
    settings: Settings = (),
) -> Path:  # fmt: skip
    """Go on with an interrupted run or sweep; returns its netCDF file.

    effects, matter, observables, body: those that the run was given, or their classes; ArchiveError names what is
    missing. callback, every, progress: as of run_scene, and no part of the run: other ones will do, or none. settings,
    as of load: those with which a run goes on, also one that has ended: a later end, other outputs. SceneError names
    what else there is.

    >>> print(resume("runs/star").name)  # finished: it has nothing to do, and tells where the result is
    one_star_three_models.nc
    """
    _get_ready()
    from astroinertia.accuracy import running
    from astroinertia.process.arguments import refuse_wrong
    from astroinertia.run.meter import watched
    from astroinertia.scene.from_python import settings_of
    from astroinertia.scene.own import given_from_python
    from astroinertia.storage.archive import SWEEP

    place, settings = _path("folder", folder), settings_of(settings)
    refuse_wrong(listener, workers, cluster, effects, observables)
    own = given_from_python(effects, matter, observables, body)
    if (place / SWEEP).exists():
        from astroinertia.errors import SceneError
        from astroinertia.sweeps.ensemble import resume as go_on_with_members

        if own:
            raise SceneError("a sweep takes what is built in or installed, and nothing of your own from Python.")
        _refuse_of_one_run(callback, every)
        if settings:
            raise SceneError("a sweep goes on as it began: settings are for a run.")
        with watched(progress, listener, "members are at work") as meter:
            return go_on_with_members(place, workers, cluster, listener=meter and meter.tell_members).file
    with watched(progress, listener, "the run is read") as meter:
        return running.unless_stopped(
            place,
            lambda: running.resume(
                place, _both(listener, meter), effects=own, callback=callback, every=every, settings=settings
            ),
        )


@_one_at_a_time
def branch(
    run: str | PathLike[str], folder: str | PathLike[str], at: Any = None, settings: Settings = (),
    listener: "Listener | None" = None, effects: "Sequence[Effect | type[Effect] | Function]" = (),
    matter: "Matter | type[Matter] | None" = None, observables: "Sequence[Observable | type[Observable]]" = (),
    body: "Body | type[Body] | None" = None, callback: "Callable[[RunState], Any] | None" = None, every: Any = None,
    progress: bool | None = None,
) -> Path:  # fmt: skip
    """Start a run from a state of another one in a new folder, with settings changed; returns its netCDF file.

    at: when it begins: text with a unit, a quantity, or a number in SI, in code units where the scene is; without it,
    at the last state that the run has. settings: as of load. effects, observables: new ones, and those that the run was
    given, as matter and body. callback, every, progress: as of run_scene. `history` and `branched_from` of the dataset
    say where it comes from. SceneError says what cannot be changed.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ds = open(branch("runs/star", folder + "/branch", "12 min", {"time.end": "15 min"}))
    >>> print(ds.attrs["history"].split(", with ")[-1])
    time.end="15 min"
    """
    _get_ready()
    from astroinertia.accuracy import running
    from astroinertia.process.arguments import refuse_wrong
    from astroinertia.run.branch import branch as start
    from astroinertia.run.meter import watched
    from astroinertia.scene.from_python import settings_of
    from astroinertia.scene.own import given_from_python

    source, place, settings = _path("run", run), _path("folder", folder), settings_of(settings)
    refuse_wrong(listener, 1, None, effects, observables)
    own = given_from_python(effects, matter, observables, body)
    with watched(progress, listener) as meter:
        hears = _both(listener, meter)
        return running.unless_stopped(
            place, lambda: start(source, place, at, settings, own, hears, callback=callback, every=every)
        )


@_one_at_a_time
def gradient(scene: "Scene | Mapping[str, Any] | str | PathLike[str]", of: str, by: Sequence[str]) -> "xr.Dataset":
    """The derivatives of a number of a run by keys of its scene; of particles, with the engine xla in float64.

    of: a series of the dataset, its labels, and when: "inertia_tensor.zz@end", "angular_velocity.z @ 20 ms",
    "mean_radius"; without a time, at the end. by: keys that the scene sets to a number or a quantity. The body is built
    beside each key's value, and the linearised equations, differentiated by JAX, carry the differences along the run
    (engines.variational); nothing is written. The result has `value`, in the units of the series, and, along
    `parameter`, `gradient`, in these per unit of the key as the scene writes it, and `gradient_error`, with the
    coordinates `parameter_value` and `parameter_unit`. SceneError where the scene or a key cannot be differentiated,
    NumericalError where the run cannot go on. Checked by tests/unit/sweeps/test_gradient.py.

    >>> answer = gradient("sims/core_to_pulsar_scaling.toml", "angular_velocity.z@end", ["body.rotation.period"])
    >>> spin, slope = float(answer.value), float(answer.gradient[0])  # rad/s, and rad/s per second of the period
    >>> print(round(slope * 30.0 / spin, 9), answer.parameter_unit.values)
    -1.0 ['s']
    """
    _get_ready()
    from astroinertia.process.arguments import refuse_wrong_names
    from astroinertia.scene import load as scenes
    from astroinertia.scene.schema import Scene
    from astroinertia.sweeps import gradient as gradients

    refuse_wrong_names(of, by)
    return gradients.gradient(scene if isinstance(scene, Scene) else scenes.of(scene), of, by)


def _get_ready() -> None:
    """Refuse versions that will not do, and keep compiled programs apart by processor."""
    from astroinertia.process import kept_programs, requirements

    requirements.check()
    kept_programs.keep_apart()


def _path(name: str, value: Any, what: str = "a folder") -> Path:
    if not isinstance(value, str | PathLike):
        from astroinertia.errors import SceneError

        raise SceneError(f"{name} must be the path of {what}, not {value!r:.60}.")
    if not fspath(value) or "\0" in str(fspath(value)):
        from astroinertia.errors import SceneError

        raise SceneError(f"{name} must be the path of {what}, and {value!r:.60} is none.")
    path = Path(value)
    with suppress(RuntimeError):  # where ~ is nobody's home
        path = path.expanduser()
    try:
        path.exists()
    except OSError as error:
        from astroinertia.errors import SceneError

        raise SceneError(f"{name} {value!r:.60} cannot be looked at: {error.strerror or error}.") from None
    return path


def _refuse_of_one_run(callback: Any, every: Any) -> None:
    if callback is not None or every is not None:
        from astroinertia.errors import SceneError

        raise SceneError("callback and every are for one run, not for a sweep of several.")


def _both(listener: "Listener | None", meter: Any) -> "Listener | None":
    """What hears how a run goes: the user's own, and what shows it."""
    if listener is None or meter is None:
        return listener if meter is None else meter.tell

    def tell(progress: Any) -> None:
        meter.tell(progress)
        listener(progress)

    return tell


def open(path: str | PathLike[str], chunks: "Mapping[str, int] | None" = None) -> "xr.Dataset":
    """The headline series of a netCDF file or a run folder, with the accessor `.inertia`; with chunks, for dask.

    What the run does not have is left out, and `.inertia.absent` says why; in the file itself it is NaN.

    >>> momentum = open("runs/star").angular_momentum.sel(i="z")
    >>> print(bool(abs(momentum / momentum[0] - 1).max() < 1e-12))  # it stays
    True
    """
    from astroinertia import dataset
    from astroinertia.dataset.absent import without_absent

    return without_absent(dataset.open(_path("path", path, "a netCDF file or a run folder"), chunks=chunks))


def open_tree(path: str | PathLike[str], chunks: "Mapping[str, int] | None" = None) -> "xr.DataTree":
    """Headline series and, in the group `snapshots`, the particles; with chunks ({} for those of the file), by dask.

    >>> print(open_tree("runs/star")["snapshots"].sizes["particle"])
    100
    """
    from astroinertia import dataset
    from astroinertia.dataset.absent import without_absent

    tree = dataset.open_tree(_path("path", path, "a netCDF file or a run folder"), chunks=chunks)
    tree.dataset = without_absent(tree.to_dataset())
    return tree


def open_sweep(path: str | PathLike[str]) -> "xr.DataTree":
    """The members of a sweep, each with its snapshots, and at the root the parameters of each; `path` is its folder.

    >>> print(open_sweep("runs/sweep").sizes["member"])
    2
    """
    from astroinertia.dataset.absent import without_absent
    from astroinertia.sweeps.combined import open_members

    return open_members(_path("path", path, "the folder of a sweep")).map_over_datasets(without_absent)
