"""A function that a run calls: when, with what, and that it changes nothing; how it stops the run, or fails."""

import re
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from astropy import units as u

import astroinertia
from astroinertia import dataset
from astroinertia.effects.particle_names import CENTRE_VELOCITY
from astroinertia.errors import AbsentError, RunInterrupted, SceneError
from astroinertia.run import loop
from tests.sims import SIMS

RADIUS = 7e8
STAR = {
    "name": "star",
    "body": {"kind": "uniform", "mass": 1 * u.Msun, "radius": RADIUS * u.m, "particles": 100, "relax": False},
    "equation_of_state": {"kind": "ideal"},
    "effects": ["gravity", "pressure"],
    "regions": {"core": {"innermost_mass": 0.5 * u.Msun}},
    "numerics": {"max_timestep": "1 min"},
    "time": {"end": "4 h", "max_steps": 20},
    "output": {"series_steps": 5, "checkpoint_seconds": 0},
}
MOMENTS = ["1 kg m2", "2 kg m2", "3 kg m2"]
TOP = {
    "name": "top",
    "model": "rigid",
    "body": {"kind": "rigid", "mass": "1 kg", "moments": MOMENTS, "rotation": {"rate": "1 rad/s", "axis": [1, 0, 1]}},
    "effects": [],
    "numerics": {"integrator": "splitting"},
    "time": "10 s",
    "output": {"series_every": "2 s"},
}
PULSAR = astroinertia.load(SIMS / "core_to_pulsar_scaling.toml", ["output.series_every=10 ms"])


def same_bits(one: Path, other: Path) -> None:
    """Series and particles are the same, but for what a clock says."""
    for opener in (dataset.open, dataset.open_snapshots):
        first, second = opener(one), opener(other)
        if first is None or second is None:
            assert first is second is None
            continue
        xr.testing.assert_equal(
            first.drop_vars("wall_time", errors="ignore"), second.drop_vars("wall_time", errors="ignore")
        )
        first.close()
        second.close()


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return astroinertia.run_scene(STAR, tmp_path_factory.mktemp("plain") / "run")


@pytest.fixture(scope="module")
def seen(plain: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[list[Any], Path]:
    """States of every third step, whose arrays the callback spoils once it has them."""
    states = []

    def look(state: Any) -> None:
        states.append((state, state.positions, state.inertia_tensor))
        for values in (*state._series.values(), *state._particles.values()):
            if values.ndim:
                values *= 2.0 if values.dtype.kind == "f" else 1

    return states, astroinertia.run_scene(STAR, tmp_path_factory.mktemp("seen") / "run", callback=look, every=3)


def test_a_callback_changes_no_bit_of_a_run(plain: Path, seen: tuple[list[Any], Path]) -> None:
    same_bits(plain, seen[1])


def test_steps_are_counted_from_the_start_and_the_end_is_seen(seen: tuple[list[Any], Path]) -> None:
    assert [state.step for state, *_ in seen[0]] == [*range(0, 20, 3), 20]


def test_what_is_seen_is_what_is_recorded(plain: Path, seen: tuple[list[Any], Path]) -> None:
    series, snapshots = dataset.open(plain), dataset.open_snapshots(plain)
    assert snapshots is not None
    state, positions, inertia = seen[0][0]
    np.testing.assert_array_equal(positions.to_value("m"), snapshots["position"].isel(snapshot_time=0).values)
    at_end = seen[0][-1]
    np.testing.assert_array_equal(at_end[2].to_value("kg m2"), series["inertia_tensor"].isel(time=-1).values)
    assert at_end[0].time == series["time"].values[-1] * u.s and inertia.unit == u.kg * u.m**2
    fifteenth = next(inertia for state, _, inertia in seen[0] if state.step == 15)
    at_15 = series["inertia_tensor"].isel(time=list(series["step"].values).index(15)).values
    np.testing.assert_array_equal(fifteenth.to_value("kg m2"), at_15)
    assert state.model == "sph" and state.effects == ("gravity", "pressure")
    snapshots.close()


def test_what_a_run_tells_of_its_matter_is_in_units(tmp_path: Path) -> None:
    reported: list[Any] = []
    scene = {**STAR, "numerics": {}, "time": {"end": "4 h", "max_steps": 5}}
    series = dataset.open(astroinertia.run_scene(scene, tmp_path / "run", reported.append)).isel(time=-1)
    assert reported[-1].density_unit == "kg m-3"
    assert reported[-1].density_max == pytest.approx(float(series["density_max"]), rel=1e-9)
    said = re.fullmatch(r"\w+ at radius (\S+) (\S+), density (\S+) kg m-3", reported[-1].limited_by)
    assert said is not None and said[2] == "km"
    radius = (float(said[1]) * u.Unit(said[2])).to_value("m")
    assert radius == pytest.approx(float(series["timestep_limit_radius"]), rel=6e-3)
    assert float(said[3]) == pytest.approx(float(series["timestep_limit_density"]), rel=6e-3)


def test_quantities_have_units_and_what_follows_is_there(tmp_path: Path) -> None:
    states: list[Any] = []
    astroinertia.run_scene({**STAR, "time": {"end": "4 h", "max_steps": 1}}, tmp_path / "run", callback=states.append)
    first, last = states
    assert first.masses.sum().to_value("Msun") == pytest.approx(1.0)
    assert first.mass.to_value("Msun") == pytest.approx(1.0)
    assert first.velocities.shape == (100, 3) and abs(first.velocities).max() == 0.0 * u.m / u.s
    assert first.densities.unit == u.kg / u.m**3 and first.smoothing_lengths.min() > 0.0 * u.m
    assert last.ledger_closure.unit == u.dimensionless_unscaled and last.ledger_closure < 1e-13
    assert last.virial_tensor.shape == (2, 3, 3) and last.virial_tensor.unit == u.J
    assert last.principal_moments.shape == (3,) and last.total_energy.unit == u.J
    assert {"time", "positions", "inertia_tensor", "angular_velocity"} <= set(dir(first))
    with pytest.raises(AbsentError, match=r"this state has no attitude: only a rigid body has axes of its own\."):
        _ = first.attitude
    with pytest.raises(AbsentError, match=r"a state has no 'mas'; did you mean 'mass'\?"):
        _ = first.mas
    assert repr(first) == "RunState(time=0 s, step=0, model='sph', 100 particles)"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "every"), [pytest.param(TOP, None, marks=pytest.mark.full), (TOP, "4 s"), (PULSAR, None)]
)
def test_models_without_particles_are_seen_at_their_records(scene: Any, every: Any, tmp_path: Path) -> None:
    states: list[Any] = []
    file = astroinertia.run_scene(scene, tmp_path / "seen", callback=states.append, every=every)
    same_bits(file, astroinertia.run_scene(scene, tmp_path / "plain"))
    times = dataset.open(file)["time"].values
    expected = times if every is None else [0.0, 4.0, 8.0, 10.0]
    assert [state.time.to_value("s") for state in states] == pytest.approx(list(expected))
    with pytest.raises(AbsentError, match=f"no positions: the model {states[0].model} has no particles"):
        _ = states[0].positions
    assert not hasattr(states[0], "densities") and hasattr(states[0], "angular_momentum")


@pytest.mark.parametrize("every", ["1 s", 1.9 * u.s])
def test_times_between_the_records_of_a_run_without_particles_are_refused(every: Any, tmp_path: Path) -> None:
    with pytest.raises(
        SceneError, match="every: a run of the model rigid is seen at its records, 2 s apart: give no shorter"
    ):
        astroinertia.run_scene(TOP, tmp_path / "run", callback=print, every=every)
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
def test_times_are_met_at_the_first_step_past_each(tmp_path: Path) -> None:
    times = []
    scene = {**STAR, "output": {"series_steps": 1}}
    every = 3 * u.min
    file = astroinertia.run_scene(scene, tmp_path / "run", callback=lambda state: times.append(state.time), every=every)
    steps = dataset.open(file)["time"].values
    passed = np.floor(steps / 180.0 * (1.0 + 1e-12))
    expected = [0.0, *steps[1:][np.diff(passed) > 0]]
    seconds = [time.to_value("s") for time in times]
    assert len(expected) > 5
    assert seconds == pytest.approx([*expected, *([steps[-1]] if expected[-1] != steps[-1] else [])], rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("scene", [STAR, TOP], ids=["sph", "rigid"])
def test_a_run_that_its_callback_stops_is_saved_and_goes_on(scene: Any, tmp_path: Path, plain: Path) -> None:
    steps = []

    def stop(state: Any) -> bool:
        steps.append(state.step)
        return len(steps) < 4

    folder = tmp_path / "run"
    assert astroinertia.run_scene(scene, folder, callback=stop) == folder
    assert len(steps) == 4
    unfinished = astroinertia.open(folder)
    assert unfinished.step.values[:4].tolist() == steps and not list(folder.glob("*.nc"))
    more: list[Any] = []
    file = astroinertia.resume(folder, callback=more.append)
    assert file.suffix == ".nc" and more[0].step > unfinished.step.values[-1]
    same_bits(file, plain if scene is STAR else astroinertia.run_scene(scene, tmp_path / "plain"))


@pytest.mark.full
def test_what_a_callback_raises_comes_out_once_the_run_is_saved(tmp_path: Path, plain: Path) -> None:
    def fail(state: Any) -> None:
        if state.step >= 10:
            raise ZeroDivisionError("of mine")

    with pytest.raises(ZeroDivisionError, match="of mine"):
        astroinertia.run_scene(STAR, tmp_path / "run", callback=fail)
    assert astroinertia.open(tmp_path / "run").step.values[-1] >= 10
    same_bits(astroinertia.resume(tmp_path / "run"), plain)


@pytest.mark.full
def test_a_callback_at_the_end_has_nothing_to_stop_but_may_fail(tmp_path: Path) -> None:
    file = astroinertia.run_scene(TOP, tmp_path / "run", callback=lambda state: state.time < 10 * u.s)
    assert file.suffix == ".nc"

    def fail(state: Any) -> None:
        assert state.time < 10 * u.s, "at the end"

    with pytest.raises(AssertionError, match="at the end"):
        astroinertia.run_scene(TOP, tmp_path / "other", callback=fail)
    same_bits(astroinertia.resume(tmp_path / "other"), file)


def test_other_stops_are_not_those_of_the_callback(tmp_path: Path) -> None:
    def stop(progress: Any) -> None:
        raise RunInterrupted(tmp_path, progress.time, progress.end, "Ctrl-C")

    with pytest.raises(RunInterrupted, match="stopped by Ctrl-C"):
        astroinertia.run_scene(TOP, tmp_path / "run", stop, callback=lambda state: None)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"callback": 3}, "callback must be a function of the state, not something of the type int."),
        ({"every": 3}, "every says when the callback is called, but no callback is given."),
        ({"callback": print, "every": 0}, "every must be at least 1 step, not 0."),
        ({"callback": print, "every": "2"}, "every: '2' is not a number and a unit"),
        ({"callback": print, "every": 2.5}, "every: must have a unit"),
        ({"callback": print, "every": 2 * u.m}, "every: '2.0 m' is not a time"),
        ({"callback": print, "every": -2 * u.s}, "every: must be positive"),
        ({"callback": print, "every": [1, 2] * u.s}, "every: must be a single quantity, not a list: "),
        ({"callback": print, "every": True}, "every: must be a number, not true."),
        ({"callback": print, "every": object()}, "every: must be a time or a number of steps, not something of"),
        ({"progress": "yes"}, "progress must be True, False or None, not 'yes'."),
    ],
)
def test_wrong_callbacks_are_refused_before_anything_is_done(options: Any, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError) as caught:
        astroinertia.run_scene(TOP, tmp_path / "run", **options)
    assert str(caught.value).startswith(sentence)
    assert not (tmp_path / "run").exists()


def test_a_sweep_has_no_callback(tmp_path: Path) -> None:
    sweep = {**TOP, "sweep": {"body.mass": ["1 kg", "2 kg"]}}
    with pytest.raises(SceneError, match="for one run, not for a sweep"):
        astroinertia.run_scene(sweep, tmp_path / "run", callback=print)


@pytest.mark.slow
def test_a_run_shows_nothing_by_itself_where_there_is_no_terminal(tmp_path: Path, capfd: pytest.CaptureFixture) -> None:
    astroinertia.run_scene(TOP, tmp_path / "quiet")
    assert capfd.readouterr() == ("", "")
    heard: list[Any] = []
    astroinertia.run_scene(TOP, tmp_path / "shown", heard.append, progress=True)
    out, err = capfd.readouterr()
    assert out == "" and "100.0%" in err and heard[-1].time == heard[-1].end
    astroinertia.run_scene({**TOP, "sweep": {"body.mass": ["1 kg", "2 kg"]}}, tmp_path / "members", progress=True)
    assert "2 of 2 members" in capfd.readouterr().err


def seen_by_both(scene: dict[str, Any], force: Any, folder: Path) -> tuple[dict[float, Any], list[Any]]:
    """States that a function of a force is given, the first at each time, and those of a callback."""
    of_force: dict[float, Any] = {}

    def nothing(state: Any) -> Any:
        of_force.setdefault(state.time, state)
        return force(state)

    of_callback: list[Any] = []
    astroinertia.run_scene(scene, folder / "run", effects=[nothing], callback=of_callback.append, every=1)
    return of_force, of_callback


@pytest.mark.slow
def test_a_force_and_a_callback_see_particles_by_the_same_names(tmp_path: Path) -> None:
    scene = {**STAR, "time": {"end": "4 h", "max_steps": 1}}
    of_force, of_callback = seen_by_both(scene, lambda state: 0.0 * state.velocities, tmp_path)
    force, callback = of_force[0.0], of_callback[0]
    names = {field.name for field in fields(force)}
    assert names - set(dir(callback)) == {"sound_speeds"}
    for name in sorted(names - {"sound_speeds"}):
        theirs = np.atleast_1d(getattr(callback, name).si.value)
        ours = np.atleast_1d(getattr(force, name))
        assert ours.shape == theirs.shape, name
        scale = {"centre_of_mass": RADIUS, CENTRE_VELOCITY: 1e5}.get(name, abs(theirs).max())
        # rows are in no fixed order
        assert np.sort(ours, axis=0) == pytest.approx(np.sort(theirs, axis=0), rel=1e-9, abs=1e-9 * scale), name
    with pytest.raises(AbsentError, match="a state has no 'velocity', but time, masses, positions, velocities, "):
        _ = force.velocity


@pytest.mark.full
def test_a_torque_and_a_callback_see_a_body_by_the_same_names(tmp_path: Path) -> None:
    of_force, of_callback = seen_by_both({**TOP, "time": "0.1 s"}, lambda state: 0.0 * state.angular_momentum, tmp_path)
    force, callback = of_force[0.0], of_callback[0]
    for name in (field.name for field in fields(force)):
        assert np.asarray(getattr(force, name)) == pytest.approx(getattr(callback, name).si.value, abs=1e-14), name
    with pytest.raises(AbsentError, match="a state has no 'positions', but time, mass, attitude, "):
        _ = force.positions


def test_the_velocity_of_the_centre_is_momentum_over_mass(tmp_path: Path) -> None:
    scene = {**STAR, "body": {**STAR["body"], "velocity": [3 * u.km / u.s, 0 * u.km / u.s, 0 * u.km / u.s]}}
    states: list[Any] = []
    astroinertia.run_scene({**scene, "time": {"end": "4 h", "max_steps": 1}}, tmp_path / "run", callback=states.append)
    assert states[0].centre_of_mass_velocity.to_value("km/s") == pytest.approx([3.0, 0.0, 0.0], abs=1e-9)


class Clock:
    """Goes on by a little whenever it is looked at."""

    def __init__(self) -> None:
        self.now = 0.0

    def monotonic(self) -> float:
        self.now += 0.02
        return self.now


@pytest.mark.slow
@pytest.mark.parametrize(
    ("takes", "shortest", "longest", "steps"),
    [
        (0.0, 0.2, 0.5, 40),
        pytest.param(0.05, 1.0, 1.6, 80, marks=pytest.mark.full),
        pytest.param(100.0, 5.0, 5.2, 200, marks=pytest.mark.full),
    ],  # seconds of one word, and between two
)
def test_what_a_run_says_takes_little_of_its_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, takes: float, shortest: float, longest: float, steps: int
) -> None:
    clock, said = Clock(), []

    def listener(_: Any) -> None:
        said.append(clock.now)
        clock.now += takes

    monkeypatch.setattr(loop, "clock", clock)
    scene = {**STAR, "time": {"end": "4 h", "max_steps": steps}, "output": {"checkpoint_seconds": 1e6}}
    astroinertia.run_scene(scene, tmp_path / "run", listener)
    pauses = np.diff(said)[:-1] - takes  # the last word comes at the end, whenever that is
    assert len(pauses) > 1 and pauses.min() >= shortest - 0.1 and pauses.max() <= longest
