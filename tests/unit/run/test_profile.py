"""The parts of a run: what they are, that they add up to its time, and that nothing of it changes what is run."""

import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr

from astroinertia import dataset, plots
from astroinertia.cli import main
from astroinertia.cli.main import BAD_INPUT, GOOD
from astroinertia.engines.numba_cpu import Engine
from astroinertia.ledger.moments import Ledgers
from astroinertia.process import activity
from astroinertia.run import loop
from astroinertia.run.profile import Profile
from astroinertia.scene import load

PASSES = {"density", "gradients", "forces", "gravity", "viscosity", "ledger", "sorting", "rest of steps"}
OTHERS = {"start", "preparing", "records", "writing", "between parts"}
SETTINGS = ("body.particles=300", "body.relax=false", "time.max_steps=40", "output.series_every='0.1 ms'")


def arguments(scene, *settings):
    return [f"sims/{scene}.toml", *(word for setting in settings for word in ("--set", setting))]


def profile_of(attrs):
    return dict(zip(attrs["profile_parts"].split(", "), np.atleast_1d(attrs["profile_wall_time"]), strict=True))


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A run with a profile, and the same without."""
    folder = tmp_path_factory.mktemp("runs")
    for name, more in (("with", ["--profile"]), ("without", [])):
        given = [*arguments("pulsar_collapse", *SETTINGS), *more, "--output", str(folder / name)]
        assert main.main(["run", *given]) == GOOD
    return folder


def test_parts_add_up_to_the_time_of_the_run(runs):
    attrs = dataset.open(runs / "with").attrs
    parts = profile_of(attrs)
    assert PASSES | OTHERS <= parts.keys() <= PASSES | OTHERS | {"compiling"}
    assert sum(parts.values()) == pytest.approx(attrs["measured_wall_time"], rel=0.05)
    assert min(parts.values()) > 0.0
    assert attrs["profile_threads"] == Engine().workers
    used = dict(zip(parts, attrs["profile_processor_time"], strict=True))
    assert min(used.values()) >= 0.0 and sum(used.values()) > 0.2 * sum(parts.values())
    # Processor time, for another program's work takes time between parts, too.
    assert used["between parts"] < 0.1 * sum(used.values())


@pytest.mark.slow
def test_a_profile_changes_no_bit_of_the_run(runs):
    one, other = dataset.open(runs / "with"), dataset.open(runs / "without")
    xr.testing.assert_identical(one.drop_vars("wall_time").drop_attrs(), other.drop_vars("wall_time").drop_attrs())
    particles = [dataset.open_snapshots(runs / name).drop_attrs() for name in ("with", "without")]
    xr.testing.assert_identical(*particles)
    assert not any(name.startswith("profile") for name in other.attrs)


def test_show_prints_the_table_of_a_run_that_has_one(runs):
    text = plots.summary(dataset.open(runs / "with"))
    table = text[text.index("\npart") :].strip().split("\n\n")[0].splitlines()
    assert table[0].split() == ["part", "s", "share", "processor", "s", "idle"]
    assert {row[:20].strip() for row in table[1:-1]} >= PASSES | OTHERS | {"all"}
    assert "100.0%" in table[-2]
    assert "processor s" not in plots.summary(dataset.open(runs / "without"))


@pytest.mark.full
def test_what_is_watched_is_as_it_was_afterwards(tmp_path):
    before = dict(vars(Engine)), dict(vars(Ledgers))
    scene = load.load_file("sims/pulsar_collapse.toml", SETTINGS[:2] + ("time.max_steps=2",))
    with Profile() as profile:
        loop.run_scene(scene, tmp_path / "run", profile=profile)
        assert dict(vars(Engine)) != before[0]
    assert (dict(vars(Engine)), dict(vars(Ledgers))) == before


def test_what_is_compiled_within_another_is_counted_once_and_nothing_is_heard_afterwards():
    with Profile() as profile:
        begun = time.perf_counter()
        activity.begin("compiling a pass")
        for act in (activity.begin, activity.end, activity.end):
            time.sleep(0.01)
            act("compiling a pass")
        passed = time.perf_counter() - begun
    counted = profile.watch.seconds["compiling"].wall
    assert 0.03 <= counted <= passed
    activity.begin("compiling a pass")
    activity.end("compiling a pass")
    assert profile.watch.seconds["compiling"].wall == counted and not activity.listeners


@pytest.mark.full(inputs=["sims/tennis_racket.toml", "sims/riemann_ellipsoid.toml"])
def test_models_without_particles_have_steps_and_records(tmp_path):
    for name, settings in (("tennis_racket", ["time.end='100 s'"]), ("riemann_ellipsoid", ["time.max_steps=5"])):
        with Profile() as profile:
            file = loop.run_scene(load.load_file(f"sims/{name}.toml", settings), tmp_path / name, profile=profile)
        parts = profile_of(xr.open_dataset(file).attrs)
        assert {"preparing", "rest of steps", "writing"} <= parts.keys() <= OTHERS | {"rest of steps", "compiling"}


@pytest.mark.slow
def test_a_run_without_a_profile_imports_nothing_of_it(tmp_path):
    lines = "import sys; from astroinertia.cli.main import main; main(sys.argv[1:]); "
    lines += "assert 'astroinertia.run.loop' in sys.modules; print('astroinertia.run.profile' in sys.modules)"
    given = ["run", *arguments("tennis_racket", "time.end='10 s'"), "--output", str(tmp_path / "run")]
    done = subprocess.run([sys.executable, "-c", lines, *given], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "False"


@pytest.mark.slow
def test_a_run_with_a_profile_that_lost_its_file_gets_it_again(tmp_path):
    """As where the disk was full when it was to be written: the last checkpoint has what was measured."""
    run = tmp_path / "run"
    given = ["sims/core_to_pulsar_scaling.toml", "--set", "time.end='20 ms'", "--profile", "--output", str(run)]
    assert main.main(["run", *given]) == GOOD
    file = run / "core_to_pulsar_scaling.nc"
    before = xr.load_dataset(file)
    file.unlink()
    assert main.main(["resume", str(run)]) == GOOD
    xr.testing.assert_identical(xr.load_dataset(file), before)


def test_a_sweep_has_no_profile(tmp_path, capsys):
    assert main.main(["run", "sims/pulsar_births.toml", "--profile", "--output", str(tmp_path / "sweep")]) == BAD_INPUT
    assert "--profile is for one run" in capsys.readouterr().err
    assert not (tmp_path / "sweep").exists()
