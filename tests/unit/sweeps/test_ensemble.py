"""Sweeps as they are run: members, failures, interruptions, workers that are killed, and the one dataset of all."""

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import astroinertia
from astroinertia.cli import main as cli, stop as cli_stop, sweep as cli_sweep
from astroinertia.cli.main import main
from astroinertia.errors import ArchiveError, RunInterrupted, SceneError
from astroinertia.models.scaling.evolution import Scaling
from astroinertia.plots import ladder, pictures
from astroinertia.process import interrupts
from astroinertia.run import loop
from astroinertia.scene.sweep import member
from astroinertia.storage.archive import Archive, locked
from astroinertia.sweeps import cluster as clusters, combined, ensemble, folder, members, workers
from astroinertia.units import SOLAR_MASS
from tests.left_behind import Left
from tests.small_sweep import GRID, SCENE, made
from tests.stepped_clock import moved_by_steps

OF_THE_CLOCK = ["wall_time", "measured_wall_time", "measured_memory"]


def same(one, other):
    xr.testing.assert_identical(one.drop_vars(OF_THE_CLOCK), other.drop_vars(OF_THE_CLOCK))


@pytest.fixture(scope="module")
def grid(tmp_path_factory):
    """A grid run one after another: its folder and what was reported on the way."""
    place, standings = tmp_path_factory.mktemp("sweep") / "grid", []
    ensemble.run_sweep(made(), place, listener=standings.append)
    return place, standings


@pytest.fixture(scope="module")
def cluster():
    """A cluster of one worker on this machine, which tests reach by its address as one elsewhere."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0", memory_limit=0, silence_logs=50
    ) as started:
        yield started


@pytest.mark.slow
def test_parameters_are_dimensions_and_members_are_runs_by_themselves(grid, tmp_path):
    place, standings = grid
    found = astroinertia.open(place)
    np.testing.assert_allclose(found["body_mass"], [SOLAR_MASS, 2 * SOLAR_MASS], rtol=1e-15)
    assert found["body_mass"].units == "kg" and found["body_rotation_period"].units == "s"
    assert found["measured_memory"].units == "byte"  # as UDUNITS has it
    assert found["inertia_tensor"].dims == ("body_mass", "body_rotation_period", "time", "i", "j")
    assert found["time"].values == pytest.approx([0.0, 0.1, 0.2])
    assert found["inertia_tensor"].attrs["units"] == "kg m2"
    assert found["member"].values.tolist() == [[0, 1], [2, 3]]
    alone = astroinertia.open(astroinertia.run_scene(made().scene(2), tmp_path / "alone"))
    part = found.isel(body_mass=1, body_rotation_period=0)
    for name in alone.data_vars:
        if name not in OF_THE_CLOCK:
            np.testing.assert_array_equal(part[name].values, alone[name].values, err_msg=str(name))
    assert [(each.done, each.failed, each.members) for each in standings] == [(k, 0, 4) for k in range(5)]
    assert set(found.to_dataframe().index.names) >= {"body_mass", "body_rotation_period", "time"}


@pytest.mark.slow
def test_values_that_go_up_and_down_are_sorted_and_members_keep_their_numbers(tmp_path, capsys):
    text = '"body.mass" = ["2 Msun", "1 Msun", "3 Msun"]\n"body.rotation.period" = ["20 s", "10 s"]'
    place = tmp_path / "sorted"
    ensemble.run_sweep(made(text), place)
    found = astroinertia.open(place)
    np.testing.assert_allclose(found["body_mass"] / SOLAR_MASS, [1.0, 2.0, 3.0])
    assert found["body_rotation_period"].values.tolist() == [20.0, 10.0]
    assert found["member"].values.tolist() == [[2, 3], [0, 1], [4, 5]]
    np.testing.assert_allclose(found["mass"].isel(time=0, body_rotation_period=0), found["body_mass"])
    near = found["inertia_tensor"].sel(body_mass=1.1 * SOLAR_MASS, method="nearest").sel(body_rotation_period=10.0)
    alone = astroinertia.open(place / member(3))
    np.testing.assert_array_equal(near, alone["inertia_tensor"])
    rows = cli_sweep.summary(place)
    for number in range(6):
        end = astroinertia.open(place / member(number))["inertia_tensor"].sel(i="z", j="z").values[-1]
        assert f"{end:.6g}" in next(row for row in rows if row.startswith(member(number)))


@pytest.mark.slow
def test_members_that_are_over_before_their_end_are_named(tmp_path):
    """Where the sweep is shown, too, for what they ended with is not of the others' time."""
    place, why = tmp_path / "early", "member-0000: time.max_steps is reached, after 1 steps"
    ensemble.run_sweep(made('"time.max_steps" = [1, 100]'), place)
    assert astroinertia.open(place).attrs["ended_early"] == why
    rows = cli_sweep.summary(place)
    assert rows[-2:] == ["over before their end:", why]
    assert "I_zz (kg m2)  mean angular velocity (rad s-1)" in rows[1]


@pytest.mark.slow
def test_members_are_a_tree(grid):
    place, _ = grid
    tree = astroinertia.open_sweep(place)
    assert list(tree.children) == [member(number) for number in range(4)]
    assert tree["body_rotation_period"].values.tolist() == [10.0, 20.0, 10.0, 20.0]
    np.testing.assert_array_equal(
        tree["member-0003"]["inertia_tensor"], astroinertia.open(place)["inertia_tensor"].isel(body_mass=1)[1]
    )


@pytest.mark.slow
def test_workers_give_the_same_to_the_bit_and_killed_ones_are_replaced(grid, cluster, tmp_path):
    """They ask no scheduler for the files of their members: xarray's locks took longer than cheap members."""
    (worker,) = cluster.workers.values()
    first = worker.pid

    def kill_at_second(standing):
        if standing.done == 1:
            os.kill(first, signal.SIGKILL)

    found = ensemble.run_sweep(made(), tmp_path / "sweep", cluster=cluster.scheduler_address, listener=kill_at_second)
    assert not found.failures and worker.pid != first
    same(astroinertia.open(tmp_path / "sweep"), astroinertia.open(grid[0]))
    asked = [str(name) for name in cluster.scheduler.extensions["semaphores"].max_leases]
    assert not [name for name in asked if ".nc" in name]


def processes_below(parent):
    """Numbers of the processes that a process has started, and they in turn, with their command lines."""
    found = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            if int(stat.read_text().rpartition(")")[2].split()[1]) == parent:
                number = int(stat.parent.name)
                found |= {number: (stat.parent / "cmdline").read_text(), **processes_below(number)}
    return found


def open_ports(process):
    """Sockets of a process on which others can reach it."""
    listening = set()
    for table in ("tcp", "tcp6", "udp", "udp6"):
        rows = [line.split() for line in Path("/proc/net", table).read_text().splitlines()[1:]]
        listening |= {f"socket:[{row[9]}]" for row in rows if row[3] == "0A" or table.startswith("udp")}
    found = set()
    for each in Path(f"/proc/{process}/fd").iterdir():
        with suppress(OSError):  # closed meanwhile
            found.add(str(each.readlink()))
    return found & listening


@pytest.mark.full
@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="only Linux lists sockets there")
def test_workers_open_no_port_and_a_killed_one_loses_nothing(grid, tmp_path):
    before, others, seen = open_ports(os.getpid()), processes_below(os.getpid()), []  # a cluster of other tests, too

    def look(standing):
        if standing.done == 1:
            below = {number: line for number, line in processes_below(os.getpid()).items() if number not in others}
            seen.extend(number for number, command in below.items() if "astroinertia.sweeps.worker" in command)
            assert open_ports(os.getpid()) == before
            assert not any(open_ports(number) for number in below)
            os.kill(seen[0], signal.SIGKILL)

    found = ensemble.run_sweep(made(), tmp_path / "sweep", workers=2, listener=look)
    assert len(seen) == 2 and not found.failures
    same(astroinertia.open(tmp_path / "sweep"), astroinertia.open(grid[0]))
    assert not set(seen) & set(processes_below(os.getpid()))


@pytest.mark.full
def test_a_member_whose_worker_is_killed_each_time_is_given_up_and_the_others_are_not(tmp_path, monkeypatch):
    monkeypatch.setattr(workers, "TRIES", 1)

    def kill(standing):
        if standing.done == 0:
            threading.Thread(target=kill_one).start()

    def kill_one():
        end = time.monotonic() + 60.0
        while time.monotonic() < end:
            for number, command in processes_below(os.getpid()).items():
                if "astroinertia.sweeps.worker" in command:
                    os.kill(number, signal.SIGKILL)
                    return

    found = ensemble.run_sweep(made(), tmp_path / "sweep", workers=2, listener=kill)
    ((number, failure),) = found.failures.items()
    assert "was ended from outside again and again" in failure.sentence and not failure.lasting
    assert folder.waiting(tmp_path / "sweep", 4) == [number]


@pytest.mark.slow
def test_an_interrupted_sweep_goes_on_where_it_was(grid, tmp_path, monkeypatch):
    save, saved = Archive.write_checkpoint, []

    def stop(archive, arrays, scalars):
        save(archive, arrays, scalars)
        saved.append(archive.folder.name)
        if saved.count(member(2)) == 2:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(Archive, "write_checkpoint", stop)
    with pytest.raises(RunInterrupted, match=r"2 of 4 members done and member-0002 at 100.0%, and is saved in .*run"):
        ensemble.run_sweep(made(), tmp_path / "run")
    monkeypatch.undo()
    with pytest.raises(ArchiveError, match="not finished; resume it"):
        astroinertia.open(tmp_path / "run")
    assert not (tmp_path / "run" / folder.SESSION).exists()
    before = folder.finished(tmp_path / "run", 0).stat().st_mtime_ns
    standings = []
    ensemble.run_sweep(made(), tmp_path / "run", listener=standings.append)  # the same call goes on
    assert [each.done for each in standings] == [2, 3, 4]
    assert folder.finished(tmp_path / "run", 0).stat().st_mtime_ns == before
    same(astroinertia.open(tmp_path / "run"), astroinertia.open(grid[0]))


def same_numbers(one, other):
    """Of sweeps whose texts differ."""
    for name in other.data_vars:
        if name not in OF_THE_CLOCK:
            np.testing.assert_array_equal(one[name].values, other[name].values, err_msg=str(name))


@pytest.fixture
def slow(monkeypatch):
    """The clock by which sweeps are stopped: each step of a member takes 10 s."""
    return moved_by_steps(monkeypatch, Scaling, (loop, members, ensemble, workers, clusters, cli, cli_stop, interrupts))


@pytest.mark.slow
def test_a_sweep_is_stopped_in_time_with_its_member_saved_and_goes_on(grid, tmp_path, monkeypatch, slow, capsys):
    """Members take two steps of 10 s each: the third is under way when the next step would be too late."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "core.toml").write_text(SCENE.replace("{sweep}", GRID).replace("0.0\n", "1000.0\n"))
    assert main(["run", "core.toml", "--workers", "1", "--max-wall", "1 min"]) == 130
    printed = capsys.readouterr().err
    how_far = "with 2 of 4 members done and member-0002 at 50.0%, and is saved in"
    assert printed.startswith(f"astroinertia: the sweep was stopped by its limit of wall time {how_far}")
    assert printed.endswith("go on with: astroinertia resume runs/core\n") and slow.now <= 1060.0
    place = tmp_path / "runs" / "core"
    assert folder.waiting(place, 4) == [2, 3] and not (place / member(3)).exists()
    with Archive.open(place / member(2)) as under_way:
        assert under_way.read_checkpoint()[1]["series"] == 2  # saved where it was, not where it began
    assert main(["resume", "runs/core", "--workers", "1", "--max-wall", "1 h"]) == 0
    same_numbers(astroinertia.open(place), astroinertia.open(grid[0]))


def test_no_member_is_begun_once_the_time_is_over(tmp_path, slow):
    with pytest.raises(RunInterrupted, match=r"limit of wall time with 0 of 4 members done, and is"):
        ensemble.run_sweep(made(), tmp_path / "run", deadline=slow.now)
    assert not (tmp_path / "run" / member(0)).exists()


def test_a_clock_that_is_set_meanwhile_changes_no_limit(tmp_path, monkeypatch, slow):
    """The time of day is no measure of time: here it stands still."""
    monkeypatch.setattr(slow, "time", lambda: 0.0)
    with pytest.raises(RunInterrupted, match=r"limit of wall time with 2 of 4 members done and member-0002"):
        ensemble.run_sweep(made(), tmp_path / "run", deadline=slow.now + 59.0)


@pytest.mark.full
def test_workers_are_not_waited_for_when_the_time_is_over(cluster, tmp_path):
    """They may be compiling, or not have begun; nothing of what they save is lost."""
    begun = time.monotonic()
    with pytest.raises(RunInterrupted, match="limit of wall time"):
        ensemble.run_sweep(
            made('"body.exponent" = [0.5, 1.0]'),
            tmp_path / "run",
            cluster=cluster.scheduler_address,
            deadline=begun + ensemble.SECONDS_TO_CLOSE + 0.5,
        )
    assert not (tmp_path / "run" / folder.SESSION).exists()
    assert not ensemble.resume(tmp_path / "run").failures


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGUSR1])
def test_a_signal_saves_the_member_under_way(tmp_path, monkeypatch, number):
    """And once more, as `timeout` sends them."""
    advance, steps = Scaling.advance, []

    def signalled(*arguments):
        steps.append(advance(*arguments))
        if len(steps) == 3:
            os.kill(os.getpid(), number)
            os.kill(os.getpid(), number)

    monkeypatch.setattr(Scaling, "advance", signalled)
    how_far = "with 1 of 4 members done and member-0001 at 50.0%"
    with pytest.raises(RunInterrupted, match=rf"stopped by {signal.Signals(number).name} {how_far}"):
        ensemble.run_sweep(made(), tmp_path / "run")
    with Archive.open(tmp_path / "run" / member(1)) as under_way:
        assert under_way.read_checkpoint()[1]["series"] == 2


@pytest.mark.full
def test_a_command_that_is_ended_while_the_sweeps_file_is_written_leaves_none_by_half(grid, tmp_path, monkeypatch):
    write, left = xr.Dataset.to_netcdf, Left(tmp_path / "run", tmp_path / "left")

    def signalled(self, path, **options):
        write(self, path, **options)
        if path.name.startswith("core.nc") and path.parent == tmp_path / "run":
            left.at(signal.SIGTERM)

    shutil.copytree(grid[0], tmp_path / "run")
    (tmp_path / "run" / "core.nc").unlink()  # all members are done
    monkeypatch.setattr(xr.Dataset, "to_netcdf", signalled)
    with interrupts.watched(left.end):
        ensemble.resume(tmp_path / "run")
    monkeypatch.undo()
    ((ended, folder),) = left.ends
    assert "stopped by SIGTERM with 4 of 4 members done, and is saved in" in str(ended.said) and ended.saved
    assert not (folder / "core.nc").exists()
    ensemble.resume(folder)
    same(astroinertia.open(folder), astroinertia.open(grid[0]))


def test_a_member_ends_when_its_sweep_is_over(tmp_path, monkeypatch):
    monkeypatch.setattr(members, "SECONDS_BETWEEN_LOOKS", 0.0)
    folder.describe(made(), tmp_path)
    (tmp_path / folder.SESSION).write_text("another")
    with pytest.raises(RunInterrupted):
        members.carry_out(members.Task(str(tmp_path), 0, "mine", 1.0))
    assert folder.finished(tmp_path, 0) is None and folder.failure(tmp_path, 0) is None


@pytest.mark.slow
def test_a_member_waits_for_a_worker_that_still_holds_it(tmp_path, monkeypatch):
    folder.describe(made(), tmp_path)
    (tmp_path / folder.SESSION).write_text("mine")
    (tmp_path / member(0)).mkdir()
    lock = locked(tmp_path / member(0))
    monkeypatch.setattr(members, "PATIENCE", 0.0)
    task = members.Task(str(tmp_path), 0, "mine", 1.0)
    refused = members.carry_out(task).failure
    assert refused is not None and "another process is writing" in refused.sentence and not refused.lasting
    monkeypatch.setattr(members, "PATIENCE", 30.0)
    threading.Timer(0.5, lock.close).start()
    assert members.carry_out(task).failure is None
    assert folder.finished(tmp_path, 0) and folder.failure(tmp_path, 0) is None


@pytest.mark.full
def test_a_member_that_ends_before_others_is_nan_from_there_on(tmp_path):
    text = 'members = [{"time.end" = "0.2 s", "body.mass" = "1 Msun"}, {"time.end" = "0.4 s", "body.mass" = "2 Msun"}]'
    ensemble.run_sweep(made(text), tmp_path / "run")
    found = astroinertia.open(tmp_path / "run")
    assert found["mass"].dims == ("member", "time") and "interpolated" not in found.attrs
    np.testing.assert_allclose(found["time"], [0, 0.1, 0.2, 0.3, 0.4], atol=1e-15)
    assert found["time_end"].values.tolist() == [0.2, 0.4] and found["time_end"].dims == ("member",)
    assert np.isnan(found["mass"][0, 3:]).all() and np.isfinite(found["mass"][1]).all()
    end = combined.at_end(found)["mass"]
    np.testing.assert_allclose(end, [SOLAR_MASS, 2 * SOLAR_MASS], rtol=1e-12)
    np.testing.assert_allclose(end["time"], [0.2, 0.4], rtol=1e-12)
    for number in range(2):
        alone = astroinertia.open(folder.finished(tmp_path / "run", number))
        one = found.isel(member=number, time=slice(0, alone.sizes["time"]))
        np.testing.assert_array_equal(one["inertia_tensor"], alone["inertia_tensor"])
        np.testing.assert_array_equal(found.isel(member=number).inertia.spin_rate(), alone.inertia.spin_rate())


@pytest.mark.full
def test_members_of_other_cadences_are_on_common_times_and_the_file_says_so(tmp_path):
    text = '"output.series_every" = ["0.05 s", "0.1 s"]'
    ensemble.run_sweep(made(text, ["body.change.times=['0.15 s']"]), tmp_path / "run")
    found = astroinertia.open(tmp_path / "run")
    np.testing.assert_allclose(found["time"], [0, 0.05, 0.1, 0.15, 0.2], atol=1e-15)
    assert found.attrs["interpolated"].startswith("recorded at other times: members 1; ")
    fine, coarse = (astroinertia.open(folder.finished(tmp_path / "run", number)) for number in range(2))
    np.testing.assert_array_equal(found["inertia_tensor"][0], fine["inertia_tensor"])
    own = coarse["inertia_tensor"].values
    np.testing.assert_array_equal(found["inertia_tensor"][1, ::2], own)
    np.testing.assert_allclose(found["inertia_tensor"][1, 1::2], 0.5 * (own[1:] + own[:-1]), rtol=1e-14)


@pytest.mark.slow
def test_the_lines_of_the_readme_work_on_a_sweep(grid):
    ds = astroinertia.open(grid[0])
    dims = ("body_mass", "body_rotation_period", "time")
    moment = ds.inertia_tensor.sel(i="z", j="z")  # of a model that has no other
    assert moment.dims == dims and moment.isel(body_mass=0).plot() is not None
    assert ds.inertia.acceleration_shares().dims == (*dims, "share", "i", "j")
    assert ds.inertia.spin_scaling("radius").dims == dims
    assert ds.rotational_to_gravitational.isel(time=-1).round(4).to_pandas().shape == (2, 2)
    assert ds.isel(body_mass=1, body_rotation_period=0).inertia.plot_spin() is not None


@pytest.mark.slow
def test_commands_on_a_sweep_take_a_member_or_say_how_to_name_one(grid, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "600")
    monkeypatch.setattr(pictures, "FIGURES", {"inertia": pictures.FIGURES["inertia"]})  # one picture is as good as all
    place = str(tmp_path / "sweep")
    shutil.copytree(grid[0], place)
    for command in ("movie", "report", "view"):
        for result in (place, f"{place}/core.nc"):
            assert main([command, result]) == 2
            said = capsys.readouterr().err
            assert f"holds a sweep of 4 members, of which `{command}` takes one: add --member N (0 to 3)" in said
            assert f"such as {place}/member-0000" in said
        assert main([command, place, "--member", "4"]) == 2
        assert "--member must be the number of a member" in capsys.readouterr().err
        assert main([command, f"{place}/member-0001", "--member", "1"]) == 2
        assert "--member is for the result of a sweep" in capsys.readouterr().err
    assert main(["report", place, "--member", "2"]) == 0
    assert (tmp_path / "sweep" / "member-0002" / "report.html").exists()
    assert main(["view", place, "--member", "1", "--output", str(tmp_path / "view.html")]) == 0
    assert "<canvas" in (tmp_path / "view.html").read_text()
    assert main(["movie", place, "--member", "0", "--every", "8", "--output", str(tmp_path / "film.gif")]) == 0
    assert (tmp_path / "film.gif").read_bytes().startswith(b"GIF89a")
    assert main(["show", f"{place}/core.nc"]) == 0
    assert "member-0003" in capsys.readouterr().out
    assert main(["show", place, "--member", "3", "--output", str(tmp_path)]) == 0
    assert "moment of inertia" in capsys.readouterr().out and list(tmp_path.glob("*.png"))
    alone = shutil.copy(f"{place}/core.nc", tmp_path / "alone.nc")
    assert main(["view", str(alone)]) == 2
    assert "is of a sweep" in capsys.readouterr().err


@pytest.mark.full
def test_members_of_a_sweep_are_compared_with_each_other(grid, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["compare", str(grid[0]), "--quantity", "mean_angular_velocity"]) == 0
    printed = capsys.readouterr().out
    own = [f"mass = {mass} Msun, period = {period} s" for mass in (1, 2) for period in (10, 20)]
    assert all(settings in printed for settings in own) and (tmp_path / "compare.png").exists()
    monkeypatch.setattr(ladder, "MOST_RUNS", 3)  # of more members, some that are spread evenly
    assert main(["compare", str(grid[0])]) == 0
    assert "of 4 runs these are compared: member-0000, member-0002, member-0003;" in capsys.readouterr().out
    assert main(["compare", str(grid[0]), "--against", f"{grid[0]}/member-0001"]) == 0
    assert "of 4 runs these are compared: member-0000, member-0001, member-0002;" in capsys.readouterr().out


@pytest.mark.full
def test_models_with_other_effects_are_lined_up_by_name(tmp_path):
    ensemble.run_sweep(made("effects = [{gravity = {}}, {gravity = {}, pressure = {}}]"), tmp_path / "run")
    found = astroinertia.open(tmp_path / "run")
    assert sorted(found["effect"].values) == ["gravity", "pressure", "rigidity"]
    alone = [astroinertia.open(folder.finished(tmp_path / "run", number)) for number in range(2)]
    for number, each in enumerate(alone):
        for effect in each["effect"].values:
            np.testing.assert_array_equal(
                found["work"].isel(scene_effects=number).sel(effect=effect), each["work"].sel(effect=effect)
            )
    assert np.isnan(found["work"].isel(scene_effects=0).sel(effect="pressure")).all()


def test_the_result_is_the_file_that_the_folder_names(grid, tmp_path):
    place = tmp_path / "sweep"
    shutil.copytree(grid[0], place)
    shutil.copy(place / member(0) / "core.nc", place / "a_copy.nc")  # comes before it in the alphabet
    same(astroinertia.open(place), astroinertia.open(grid[0]))
    (place / "core.nc").unlink()
    with pytest.raises(ArchiveError, match="not finished; resume it"):
        astroinertia.open(place)
    (place / "sweep.json").write_text("{}")
    with pytest.raises(ArchiveError, match="does not name its sweep"):
        astroinertia.open(place)


def test_folders_are_not_mixed_up(grid, tmp_path, capsys):
    place, _ = grid
    (tmp_path / "other.toml").write_text(SCENE.replace("{sweep}", '"body.exponent" = [0.5, 1.0]'))
    assert main(["run", str(tmp_path / "other.toml"), "--output", str(place)]) == 2
    printed = capsys.readouterr()
    assert not printed.out and "already holds another sweep" in printed.err
    with pytest.raises(ArchiveError, match="already holds another sweep"):
        ensemble.run_sweep(made('"body.exponent" = [0.5, 1.0]'), place)
    with pytest.raises(ArchiveError, match="already holds a sweep"):
        astroinertia.run_scene(made().scene(0), place)
    with locked(place), pytest.raises(ArchiveError, match="another process"):
        ensemble.resume(place)
    (tmp_path / "sweep.json").write_text('{"format": "astroinertia-sweep", "version": 1}')
    with pytest.raises(ArchiveError, match="damaged"):
        folder.read(tmp_path)
    with pytest.raises(SceneError, match="'nowhere' is no address of a cluster"):
        ensemble.run_sweep(made(), tmp_path / "run", cluster="nowhere")
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("damaged", "left"),
    [(["core.nc"], []), (["member-0001/core.nc", "core.nc"], [1]), (["member-0002/core.nc"], [2])],
)
def test_files_that_a_disk_has_damaged_are_written_again(grid, tmp_path, damaged, left):
    place = shutil.copytree(grid[0], tmp_path / "sweep")
    for name in damaged:
        content = bytearray((place / name).read_bytes())
        content[len(content) // 2] ^= 1
        (place / name).write_bytes(content)
    assert ensemble.left(made(), place) == left
    ensemble.resume(place)
    xr.testing.assert_equal(
        astroinertia.open(place).drop_vars(OF_THE_CLOCK), astroinertia.open(grid[0]).drop_vars(OF_THE_CLOCK)
    )
    for number in range(4):
        assert astroinertia.open(place / member(number)).sizes["time"] > 1


@pytest.mark.slow
def test_a_sweep_is_shown_by_a_process_that_does_nothing_else(grid):
    command = [sys.executable, "-m", "astroinertia", "show", str(grid[0])]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "member-0003" in done.stdout


def test_the_spin_of_members_is_that_about_their_angular_momentum(grid, monkeypatch):
    data = astroinertia.open(grid[0])
    aside = data.assign(angular_velocity=data["angular_velocity"] + xr.DataArray([0.5, 0.0, 0.0], dims="i"))
    monkeypatch.setattr(astroinertia.dataset, "open", lambda _: aside)
    spins = data.inertia.spin_rate().isel(time=-1).values.ravel()
    for row, spin in zip(cli_sweep.summary(grid[0])[2:], spins, strict=True):
        assert f"{spin:.6g}" in row.split()


@pytest.mark.slow
def test_the_command_line_runs_plans_and_shows_sweeps(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    (tmp_path / "core.toml").write_text(SCENE.replace("{sweep}", '"body.exponent" = [0.5, 2.6]'))
    assert main(["plan", "core.toml"]) == 0
    printed = capsys.readouterr().out
    assert (
        "members" in printed and "0.5, 2.6" in printed and "time of all" in printed and "one after another" in printed
    )
    assert main(["run", "core.toml", "--workers", "1"]) == 1
    printed = capsys.readouterr().out
    assert "one after another" in printed
    assert "2 of 2 members" in printed and "core.nc" in printed
    assert "member-0001  body.exponent = 2.6  [body] has an infinite gravitational energy" in printed
    assert main(["show", "runs/core"]) == 0
    shown = capsys.readouterr().out.splitlines()
    assert shown[1].split()[:2] == ["member", "body.exponent"] and shown[2].split()[:2] == ["member-0000", "0.5"]
    assert main(["resume", "runs/core"]) == 1
    assert "2 of them done before" in capsys.readouterr().out
    (tmp_path / "one.toml").write_text(SCENE.replace("[sweep]\n{sweep}\n", ""))
    assert main(["run", "one.toml", "--workers", "2"]) == 2
    assert "--workers is for a scene with [sweep]" in capsys.readouterr().err
    assert main(["resume", "nowhere", "--workers", "2"]) == 2
    assert "nowhere holds no run" in capsys.readouterr().err
    assert main(["resume", "runs/core/member-0000", "--workers", "2"]) == 2
    assert "--workers is for a scene with [sweep]" in capsys.readouterr().err
    assert main(["tradeoff", "core.toml"]) == 2
    assert "[sweep] makes several runs" in capsys.readouterr().err


def test_there_are_no_more_workers_than_cores_that_the_process_may_use(monkeypatch):
    for bound, usual in (({1}, 1), ({0, 3}, 2), (set(range(8)), 3)):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, bound=bound: bound, raising=False)
        assert ensemble.usual_workers([None] * 3) == usual
