"""Error bars hold: of made-up series whose errors are known, of runs with exact answers, after interruptions."""

import copy
import re
import shutil

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import astroinertia
from astroinertia.accuracy import companion_runs as companions
from astroinertia.accuracy.companion_runs import CompanionRun, companion_runs
from astroinertia.accuracy.error_bars import (
    HEADLINE,
    LEAST_SHARE,
    SAFETY_OF_THREE,
    at_end,
    at_times,
    error_bars,
    largest_lately,
    measured_order,
    with_error_bars,
)
from astroinertia.accuracy.exact import exact
from astroinertia.accuracy.running import BESIDE_CHOICE, FOLDER
from astroinertia.accuracy.selected_observables import parsed, relative_error, value
from astroinertia.cli.main import main
from astroinertia.errors import NumericalError, RunInterrupted, SceneError
from astroinertia.plots import summary, write_all
from astroinertia.plots.energy import energy_figure
from astroinertia.plots.error_bars import error_bars_figure, error_of, shade
from astroinertia.plots.moments import inertia_figure
from astroinertia.plots.spin import spin_figure
from astroinertia.run import loop as runs
from astroinertia.scene import load
from astroinertia.scene.plan import smoothing
from tests.tradeoff_scenes import CASES, SIMS
from tests.unit.plots.test_plots import assert_legible

BY_NAME = {case.name: case for case in CASES}
BARS = "output.error_bars=true"
TIMES = np.linspace(0.0, 4.0, 81)


def made_up(step, order, times=TIMES, error=None):
    """Series with an error step^order E(t): I_xx and I_zz grow, I_yy is 0 throughout, the mean radius crosses it."""
    shape = np.sin(3.0 * times) * np.exp(0.2 * times) if error is None else error(times)
    size = 0.01 * step**order
    inertia = np.zeros((len(times), 3, 3))
    inertia[:, 0, 0], inertia[:, 2, 2] = 2.0 + times + size * shape, 3.0 + times**2 - 2.0 * size * shape
    moments = np.sort(np.diagonal(inertia, axis1=1, axis2=2), axis=1)
    units = {"units": "1", "long_name": "made up"}
    return xr.Dataset(
        {
            "inertia_tensor": (("time", "i", "j"), inertia, units),
            "principal_moments": (("time", "principal"), moments, units),
            "mean_radius": ("time", 1.0 + size * shape, units),
            "density_max": ("time", np.full(len(times), np.nan), units),
            "step": ("time", np.arange(len(times), dtype=float), units),
        },
        coords={"time": times, "i": ["x", "y", "z"], "j": ["x", "y", "z"], "principal": [1, 2, 3]},
    )


def companion(name, step, source="particles", against="", theory=2.0, scatter=True):
    return CompanionRun(name, source, against, step, theory, scatter, None)


def three(order, steps=(1.5, 2.25), **more):
    return [(companion(f"c{step}", step), made_up(step, order, **more)) for step in steps]


@pytest.mark.parametrize("order", [0.7, 1.0, 1.5, 2.0, 2.8])
def test_three_runs_tell_the_order_and_the_bar_is_the_error_times_its_safety(order):
    main = made_up(1.0, order)
    bars = error_bars(main, three(order))
    true = abs(0.01 * np.sin(3.0 * TIMES) * np.exp(0.2 * TIMES))
    least = LEAST_SHARE * SAFETY_OF_THREE * largest_lately(TIMES, true)
    # An order above theory's is taken for theory's, which makes the bar too large, never too small.
    safety = SAFETY_OF_THREE * (1.5**order - 1.0) / (1.5 ** min(order, 2.0) - 1.0)
    bar = bars["mean_radius"].values
    clear = true > 0.2 * largest_lately(TIMES, true)
    assert bar[clear] == pytest.approx(safety * true[clear], rel=1e-6)
    assert (bar >= np.maximum(true, least) * (1 - 1e-9)).all()
    assert bars["inertia_tensor"].sel(i="z", j="z").values[clear] == pytest.approx(2 * safety * true[clear], rel=1e-6)


@pytest.mark.parametrize(
    ("step", "theory", "most"), [(3 ** (1 / 3), 2.0, 4.0), (3 ** (-1 / 3), 2.0, 3.0), (0.1, 1.0, 2.0), (0.5, 8.0, 1.5)]
)
@pytest.mark.parametrize("share", [0.6, 1.0, 1.3])
def test_one_companion_run_coarser_or_finer_bounds_an_error_of_nearly_the_order_of_theory(step, theory, most, share):
    found = [(companion("c", step, theory=theory, scatter=False), made_up(step, share * theory))]
    bars = error_bars(made_up(1.0, share * theory), found)
    ratio = bars["mean_radius"].values[1:] / abs(0.01 * np.sin(3.0 * TIMES) * np.exp(0.2 * TIMES))[1:]
    assert (ratio > 1.0).all()
    if share == 1.0:
        assert np.median(ratio) < most


def test_a_difference_that_crosses_zero_is_no_bar_of_zero():
    crossing = np.pi / 3.0  # sin(3 t) there
    times = np.sort(np.append(TIMES, crossing))
    here = int(np.searchsorted(times, crossing))
    bars = error_bars(made_up(1.0, 2.0, times), three(2.0, times=times))
    lately = 0.01 * np.exp(0.2 * 0.55)  # its size at the last maximum, or less
    assert bars["mean_radius"].values[here] > LEAST_SHARE * SAFETY_OF_THREE * lately * 0.9


def test_every_component_of_a_tensor_has_a_bar_also_where_it_vanishes():
    bars = error_bars(made_up(1.0, 2.0), three(2.0))["inertia_tensor"]
    assert (bars.values[1:] > 0.0).all()
    late = bars.isel(time=slice(20, None))
    assert (late.sel(i="y", j="y") <= late.sel(i="z", j="z") * (1 + 1e-9)).all()
    assert bars.dims == ("time", "i", "j")


def test_scatter_tells_no_order():
    random = np.random.default_rng(1)
    first, second = random.normal(size=(2, 200))
    assert measured_order((1.0, 1.5, 2.25), first, second, 2.0) is None
    assert measured_order((1.0, 1.5, 2.25), first, 1.5**1.3 * first, 2.0) == pytest.approx(1.3)
    assert measured_order((1.0, 1.5, 2.25), first, 9.0 * first, 2.0) == 2.0
    assert measured_order((1.0, 1.5, 2.25), first, 0.5 * first, 2.0) == 0.5


def test_sources_of_error_add_up():
    main, both = made_up(1.0, 2.0), three(2.0)
    slow = companion("slow", 2.0, "timestep_factor", "c2.25")
    # Its difference is from the companion run that it shares all else with, not from the run.
    both.append((slow, made_up(2.25, 2.0).assign(mean_radius=lambda data: data["mean_radius"] + 0.03)))
    alone, more = error_bars(main, both[:2])["mean_radius"], error_bars(main, both)["mean_radius"]
    assert (more - alone).values == pytest.approx(np.full(len(TIMES), 1.25 * 0.03 / (2.0 - 1.0)), rel=1e-9)


def test_moments_that_two_runs_number_differently_are_compared_by_size():
    main = made_up(1.0, 2.0)
    swapped = [(run, data.isel(principal=[0, 2, 1]).assign_coords(principal=[1, 2, 3])) for run, data in three(2.0)]
    straight, other = (error_bars(main, found)["principal_moments"] for found in (three(2.0), swapped))
    xr.testing.assert_allclose(straight, other)
    turned = main.assign(principal_moments=main["principal_moments"].copy(data=main["principal_moments"][:, ::-1]))
    assert error_bars(turned, three(2.0))["principal_moments"].values == pytest.approx(straight.values[:, ::-1])


def test_records_at_other_times_are_interpolated_and_the_same_ones_taken_as_they_are():
    known = np.linspace(0.0, 1.0, 41) ** 1.3
    values = np.stack([np.cos(5 * known), known**3], axis=1)
    times = np.linspace(0.0, 1.0, 77)
    found = at_times(times, known, values)
    assert found == pytest.approx(np.stack([np.cos(5 * times), times**3], axis=1), abs=2e-5)
    assert (at_times(known[[3, 9]], known, values) == values[[3, 9]]).all()
    assert np.isnan(at_times(np.array([1.1]), known, values)).all()
    assert (at_times(known[:2], known[:2], values[:2]) == values[:2]).all()  # a start and an end alone
    squares = at_times(np.linspace(0.0, 2.0, 9), np.arange(3.0), np.arange(3.0) ** 2)  # of a run of two steps
    assert squares == pytest.approx(np.linspace(0.0, 2.0, 9) ** 2, abs=1e-15)


def test_a_bar_remembers_half_of_the_time():
    sizes = np.array([0.0, 5.0, 1.0, 1.0, 1.0, 2.0])
    assert largest_lately(np.arange(6.0), sizes).tolist() == [0.0, 5.0, 5.0, 1.0, 1.0, 2.0]


def test_the_bar_at_the_end_is_held_against_a_relative_error():
    found = with_error_bars(made_up(1.0, 2.0), three(2.0))
    zz = parsed("inertia_tensor z z")
    expected = float(found["inertia_tensor_error"][-1, 2, 2] / found["inertia_tensor"][-1, 2, 2])
    assert at_end(found, zz) == pytest.approx(expected, rel=1e-9)
    whole = np.linalg.norm(found["inertia_tensor_error"][-1]) / np.linalg.norm(found["inertia_tensor"][-1])
    assert at_end(found, parsed("inertia_tensor")) == pytest.approx(whole, rel=1e-9)
    for name in ("frequency of inertia_tensor z z", "mode_amplitude 2"):
        with pytest.raises(SceneError, match="no error bar"):
            at_end(found, parsed(name))


def test_variables_point_to_their_bars_and_what_a_run_lacks_has_none():
    found = with_error_bars(made_up(1.0, 2.0), three(2.0))
    assert found["mean_radius"].attrs["ancillary_variables"] == "mean_radius_error"
    assert "order 2.00, measured by three runs" in found["mean_radius_error"].attrs["comment"]
    assert found["mean_radius_error"].attrs["units"] == "1"
    assert "density_max_error" not in found


def test_a_companion_run_that_failed_leaves_no_bar_but_a_reason():
    found = error_bars(made_up(1.0, 2.0), [*three(2.0)[:1], (companion("c2.25", 2.25), "it blew up")])
    assert np.isnan(found["mean_radius"].values).all()
    assert found["mean_radius"].attrs["reason"] == "the companion run c2.25 failed: it blew up"


def numbers(scene):
    return {run.name: (run.against, run.scene.particles) for run in companion_runs(scene)}


def test_particles_have_two_runs_with_fewer_of_them_and_one_with_longer_steps():
    scene = BY_NAME["dyson"].scene("body.particles=2700")
    first, second, slow, _ = companion_runs(scene)
    assert [run.scene.particles for run in (first, second, slow)] == [900, 300, 300]
    assert (first.step, second.step) == pytest.approx((3 ** (1 / 3), 9 ** (1 / 3)))
    assert slow.against == second.name and slow.step == 2.0
    assert slow.scene.numerics.courant == 2.0 * scene.numerics.courant
    assert not any(run.scene.output.error_bars for run in (first, second, slow))


@pytest.mark.parametrize("settings", [(), ("numerics.eta=1.1",), ("numerics.neighbours='rising'",)])
def test_one_run_has_twice_the_neighbours_and_particles_at_one_smoothing_length(settings):
    scene = BY_NAME["dyson"].scene("body.particles=18000", *settings)
    noisy = companion_runs(scene)[-1]
    coarsest = next(run for run in companion_runs(scene) if run.name == noisy.against)
    assert (noisy.source, noisy.step, coarsest.scene.particles) == ("neighbours", 0.5, 2000)
    lengths = [
        smoothing(run.scene)[0] * (run.scene.body.mass / run.scene.particles) ** (1 / 3) for run in (noisy, coarsest)
    ]
    assert noisy.scene.particles == 4000
    assert lengths[0] == pytest.approx(lengths[1], rel=2e-3)
    most = BY_NAME["dyson"].scene("body.particles=20000", "numerics.neighbours=600")
    assert "neighbours" not in {run.source for run in companion_runs(most)}, "1200 are not allowed"


def test_few_particles_have_a_run_with_more_and_some_in_between_smaller_ratios():
    assert numbers(BY_NAME["toy_star"].scene("body.particles=200"))["particles-600"] == ("", 600)
    counts = [run.scene.particles for run in companion_runs(BY_NAME["dyson"].scene("body.particles=600"))]
    assert 600 > counts[0] > counts[1] > 100
    assert counts[1] / counts[0] == pytest.approx(counts[0] / 600, rel=0.01)


def test_several_bodies_keep_their_shares_and_the_smallest_sets_how_few_there_can_be():
    impact = load.load_file(SIMS / "giant_impact.toml", [])
    assert [[body.particles for body in run.scene.bodies] for run in companion_runs(impact)[:1]] == [[2610, 390]]
    larger = load.load_file(SIMS / "giant_impact.toml", ["bodies.0.particles=8700", "bodies.1.particles=1300"])
    counts = np.array([[body.particles for body in run.scene.bodies] for run in companion_runs(larger)[:2]])
    assert counts[:, 1] / counts[:, 0] == pytest.approx(13 / 87, rel=0.01)
    assert counts[1, 1] == pytest.approx(2 * smoothing(larger)[1], abs=1)


def test_coarser_gravity_is_a_run_where_gravity_is_by_multipoles():
    far = BY_NAME["cold_spheroid"].scene("body.particles=50000", "effects.gravity.method='multipole'")
    run = companion_runs(far)[-2]
    assert (run.source, run.against, run.step) == ("force_error", "particles-5556", pytest.approx(10.0))
    assert run.scene.effects["gravity"]["method"] == "multipole"
    near = companion_runs(BY_NAME["cold_spheroid"].scene())
    assert "force_error" not in {each.source for each in near}


def test_models_without_particles_have_a_finer_run_that_is_recorded_twice_as_often():
    (run,) = companion_runs(BY_NAME["riemann"].scene("numerics.tolerance=1e-6"))
    assert run.scene.numerics.tolerance == 1e-7 and run.step == pytest.approx(0.1)
    assert run.scene.output.series_every == 0.5 * BY_NAME["riemann"].scene().output.series_every
    (run,) = companion_runs(BY_NAME["rigid_top"].scene())
    assert run.scene.numerics.steps_per_rotation == 80.0 and run.order == 4.0
    (run,) = companion_runs(BY_NAME["riemann"].scene("numerics.tolerance=1e-14"))
    assert run.scene.numerics.tolerance == 1e-13  # there is no finer one


SCALING = """
name = "closed"
model = "scaling"
units = "code"
[body]
kind = "uniform"
mass = 1.0
radius = 1.0
[effects]
[time]
end = 1.0
"""


def test_a_scene_without_a_resolution_is_refused_before_it_is_run(tmp_path):
    with pytest.raises(SceneError, match="closed forms"):
        astroinertia.run_scene(load.loads(SCALING, [BARS]), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def judged(case, *settings, folder):
    scene = case.scene(BARS, *settings)
    data = astroinertia.open(astroinertia.run_scene(scene, folder))
    known = exact(case.scene(*settings))
    for name, label in (("inertia_tensor z z", (2, 2)), ("angular_velocity", ())):
        observable = parsed(name)
        truth = np.atleast_1d(known.values[observable.variable][label]).ravel()
        yield at_end(data, observable), relative_error(value(data, observable), truth)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("rigid_top", ("time.end='1 s'", "output.series_every='0.2 s'", "numerics.steps_per_rotation=20")),
        pytest.param("rigid_top", ("time.end='1 s'", "numerics.integrator='adaptive'", "numerics.tolerance=1e-7",
                       "output.series_every='0.5 s'"), marks=pytest.mark.full),
        pytest.param("riemann", ("time.end=12", "output.series_every=6", "numerics.tolerance=1e-5"),
                     marks=pytest.mark.full),
        pytest.param("maclaurin", ("time.end=5", "output.series_every=2.5", "numerics.tolerance=1e-8"),
                     marks=pytest.mark.full),
    ],
)  # fmt: skip
def test_the_error_of_a_run_without_particles_is_within_its_bar(name, settings, tmp_path):
    for bar, true in judged(BY_NAME[name], *settings, folder=tmp_path / "run"):
        assert true < bar < 5.0 * max(true, 1e-14)


@pytest.mark.slow
def test_a_run_that_ends_after_a_number_of_steps_has_bars_to_its_end(tmp_path):
    """Its finer companion run ended after as many, at half the time, and the bars of the other half were nan."""
    scene = BY_NAME["rigid_top"].scene("time.end='1 s'", "output.series_every='0.02 s'", "time.max_steps=20", BARS)
    data = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run"))
    assert data["time"][-1] < 0.9
    assert np.isfinite(data["attitude_error"].values).all()
    assert companion_runs(BY_NAME["dyson"].scene("time.max_steps=1000000000000"))  # no more than a scene may allow


@pytest.mark.slow
def test_bars_that_end_before_their_run_say_where_and_why(tmp_path, monkeypatch):
    """As those of a gas that the sinks of a companion run have accreted sooner."""
    monkeypatch.setattr(companions, "_as_far", lambda scene: ("time.max_steps=12",))
    scene = BY_NAME["rigid_top"].scene("time.end='1 s'", "output.series_every='0.1 s'", BARS)
    data = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run"))
    ended = astroinertia.open(next((tmp_path / "run" / FOLDER).iterdir()))
    known = np.isfinite(data["angular_velocity_error"].values).all(axis=1)
    assert known.tolist() == (data["time"] <= ended["time"][-1]).values.tolist() and known.any() and not known.all()
    assert data.attrs["error_bars_comment"] == (
        f"no error bars after time {float(ended['time'][-1]):.6g} s, where the companion run steps per rotation 80 is "
        f"over: {ended.attrs['ended_early']}"
    )


@pytest.mark.full
def test_how_a_rigid_body_stands_and_turns_has_bars_that_hold(tmp_path):
    def run(name, *settings):
        settings = ("time.end='1 s'", "output.series_every='0.2 s'", *settings)
        return astroinertia.open(astroinertia.run_scene(BY_NAME["rigid_top"].scene(*settings), tmp_path / name))

    coarse = run("coarse", BARS, "numerics.steps_per_rotation=20")
    fine = run("fine", "numerics.steps_per_rotation=320")
    for name in ("obliquity", "precession_rate", "wobble_angle", "angular_speed"):
        bar, true = coarse[f"{name}_error"], abs(coarse[name] - fine[name])
        assert bar.attrs["units"] == coarse[name].attrs["units"]
        assert (true[1:] <= bar[1:]).all()
        assert (bar[1:] <= 5.0 * true.max() + 1e-12 * abs(fine[name]).max()).all()


@pytest.mark.slow
@pytest.mark.parametrize("count", [150, pytest.param(600, marks=pytest.mark.full)])
def test_the_error_of_a_particle_run_is_within_its_bar(count, tmp_path):
    settings = (f"body.particles={count}", "time.end=0.4", "output.series_every=0.1")
    for bar, true in judged(BY_NAME["dyson"], *settings, folder=tmp_path / "run"):
        assert 1e-4 < true < bar < 6.0 * true


TOP = BY_NAME["rigid_top"].scene("time.end='1 s'", "output.series_every='0.1 s'", BARS)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return astroinertia.run_scene(TOP, tmp_path_factory.mktemp("runs") / "whole")


@pytest.mark.slow
def test_a_companion_run_that_was_interrupted_is_gone_on_with_and_the_finished_run_stays(tmp_path, whole):
    def interrupt(progress):
        if progress.part:
            raise RunInterrupted(tmp_path, 0.0, 1.0)

    with pytest.raises(RunInterrupted) as stopped:
        astroinertia.run_scene(TOP, tmp_path / "run", interrupt)
    assert stopped.value.folder == tmp_path / "run"
    assert re.fullmatch(
        r"the run itself is done; what its error bars come from was stopped by request at 0\.0% of companion run "
        rf"1 of 1 \(steps per rotation 80\), and is saved in {tmp_path}/run",
        str(stopped.value),
    )
    assert str(copy.copy(stopped.value)) == str(stopped.value)
    assert not list((tmp_path / "run").glob("*.nc"))
    saves = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "run").glob("segment*")}
    parts = []
    resumed = astroinertia.open(astroinertia.resume(tmp_path / "run", lambda progress: parts.append(progress.part)))
    whole = astroinertia.open(whole)
    assert {path.name: path.stat().st_mtime_ns for path in (tmp_path / "run").glob("segment*")} == saves
    assert "companion run 1 of 1, steps per rotation 80" in parts
    for name in ("attitude", "attitude_error", "angular_velocity_error"):
        assert (resumed[name].values == whole[name].values).all()
    assert whole.attrs["error_bars_wall_time"] > 0.0


def test_a_finished_companion_run_is_not_run_again(tmp_path, monkeypatch, whole):
    before = astroinertia.open(whole)
    shutil.copytree(whole.parent, tmp_path / "run")
    (tmp_path / "run" / whole.name).unlink()

    def again(*_, **__):
        raise AssertionError("it is finished")

    monkeypatch.setattr(runs, "run_scene", again)
    xr.testing.assert_identical(astroinertia.open(astroinertia.resume(tmp_path / "run")), before)


def test_a_failing_companion_run_costs_the_bars_and_not_the_run(tmp_path, monkeypatch):
    real = runs.run_scene

    def failing(scene, *others, **named):
        if scene.numerics.steps_per_rotation == 80.0:
            raise NumericalError("it blew up")
        return real(scene, *others, **named)

    monkeypatch.setattr(runs, "run_scene", failing)
    data = astroinertia.open(astroinertia.run_scene(TOP, tmp_path / "run"))
    assert "attitude_error" not in data and "blew up" in data.inertia.absent["attitude_error"]
    why = "no error bars: the companion run steps per rotation 80 failed: it blew up"
    assert data.attrs["error_bars_comment"] == why  # which `run` prints
    assert f"{why}." in summary(data).splitlines()
    assert np.isfinite(data["attitude"].values).all()


def test_a_scene_that_does_not_ask_for_bars_has_none(tmp_path):
    scene = BY_NAME["rigid_top"].scene("time.end='1 s'", "output.series_every='0.1 s'")
    data = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run"))
    assert not {f"{name}_error" for name in HEADLINE} & set(data)
    assert not any("error_bars" in name for name in data.attrs)
    assert not (tmp_path / "run" / FOLDER).exists()
    assert "ancillary_variables" not in data["attitude"].attrs
    assert error_of(data, "inertia_tensor", i="z", j="z") is None


@pytest.mark.slow
def test_the_command_line_asks_for_bars_and_the_plan_tells_what_they_cost(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "dyson.toml").write_text(BY_NAME["dyson"].text)
    arguments = ["dyson.toml", "--set", "body.particles=150", "--set", "time.end=0.1"]
    assert main(["plan", *arguments, "--error-bars"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "error bars" in printed and "more of companion runs" in printed
    assert main(["run", *arguments, "--error-bars", "--output", "run"]) == 0
    data = astroinertia.open(tmp_path / "run")
    said = re.search(r"took (\S+) s, predicted \S+ s; (\S+) s more for error bars", capsys.readouterr().out)
    assert float(said[2]) == pytest.approx(data.attrs["error_bars_wall_time"], rel=0.01)
    assert float(data["inertia_tensor_error"].sel(i="z", j="z")[-1]) > 0.0
    for draw, panel in ((inertia_figure, 0), (spin_figure, 0), (energy_figure, 0)):
        bands = draw(data).axes[panel].collections
        assert bands, draw.__name__
    assert_legible(error_bars_figure(data))
    bars = [name for name in data if str(name).endswith("_error")]
    for size in (0.01, 0.0):  # the same at all times, and none
        same = {name: size * abs(data[name.removesuffix("_error")]) for name in map(str, bars) if name[:-6] in data}
        assert_legible(error_bars_figure(data.assign(same)))
    assert [path.name for path in write_all(data, tmp_path / "pictures", only=["error_bars"])] == ["error_bars.png"]
    assert "error_bars_comment" not in data.attrs  # which is of a choice, below
    assert BESIDE_CHOICE not in summary(data)


@pytest.mark.full
def test_bars_beside_the_error_that_a_choice_states_say_why_they_may_be_larger(tmp_path):
    scene = BY_NAME["dyson"].scene("body.particles=150", "time.end=0.05", BARS)
    chosen = scene.model_copy(update={"choice": {"accuracy": "0.01 of I_zz; stated 1.6e-02"}})
    data = astroinertia.open(astroinertia.run_scene(chosen, tmp_path / "run"))
    assert data.attrs["error_bars_comment"] == BESIDE_CHOICE
    assert f"{BESIDE_CHOICE}." in summary(data).splitlines()


def test_a_band_reaches_from_value_less_bar_to_value_and_bar():
    axes = Figure().subplots()
    shade(axes, TIMES, [(TIMES**2, np.full(len(TIMES), 0.5), "k"), (TIMES, None, "k")])
    (band,) = axes.collections
    corners = band.get_paths()[0].vertices
    end = corners[np.isclose(corners[:, 0], 4.0), 1]
    assert (end.min(), end.max()) == (15.5, 16.5)


def test_the_bar_of_a_length_is_that_of_the_vector():
    data = xr.Dataset(
        {"angular_velocity_error": (("time", "i"), np.array([[3.0, 4.0, 0.0]]))}, coords={"i": list("xyz")}
    )
    assert error_of(data, "angular_velocity", 2.0).tolist() == [2.5]
    assert error_of(data, "angular_velocity", 2.0, i="y").tolist() == [2.0]
