"""Run folders: what survives a crash, a damaged file and a second writer."""

import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from astroinertia.cli.result import must_be_writable
from astroinertia.errors import ArchiveError, ArchiveWarning, SceneError
from astroinertia.storage import manifest
from astroinertia.storage.archive import Archive, refuse_if_taken
from astroinertia.storage.atomic import TEMPORARY, read_arrays, write_arrays
from astroinertia.storage.manifest import COPY, MANIFEST
from tests.hard.malformed_files import rehashed

METADATA = {"name": "star", "scene": "name = 'star'\n", "effects": ["gravity"]}


def record(number: int) -> dict:
    generator = np.random.default_rng(number)
    return {"time": 0.1 * number, "inertia_tensor": generator.normal(size=(3, 3)), "step": number}


def snapshot(number: int) -> dict:
    return {"time": 0.1 * number, "position": np.random.default_rng(number).normal(size=(20, 3))}


def state(number: int) -> dict:
    return {
        "position": np.random.default_rng(1000 + number).normal(size=(50, 3)),
        ".rates['a'].value": np.array(number),
    }


def write_on(archive: Archive, until: int) -> None:
    """Two records a segment, a checkpoint every other segment, as a run does; goes on from the checkpoint."""
    stored = archive.read_checkpoint()
    number = 0 if stored is None else stored[1]["number"]
    while number < until:
        archive.write_segment([record(number), record(number + 1)], [snapshot(number)])
        number += 2
        if number % 4 == 0:
            archive.write_checkpoint(state(number), {"number": number})


def assert_consistent(folder: Path) -> int:
    """The folder opens at its checkpoint with exactly the outputs before it; returns how many those are."""
    with Archive.open(folder) as archive:
        stored = archive.read_checkpoint()
        outputs = 0 if stored is None else stored[1]["number"]
        if stored is not None:
            np.testing.assert_array_equal(stored[0]["position"], state(outputs)["position"])
        series = [part["inertia_tensor"] for part in archive.read_series()]
        expected = [record(number)["inertia_tensor"] for number in range(outputs)]
        np.testing.assert_array_equal(np.concatenate(series) if series else np.empty(0), np.array(expected))
        positions = [part["position"] for part in archive.read_snapshots()]
        expected = [snapshot(number)["position"] for number in range(0, outputs, 2)]
        np.testing.assert_array_equal(np.concatenate(positions) if positions else np.empty(0), np.array(expected))
        listed = {entry["file"] for entry in archive._manifest["segments"]}
    found = {path.name for path in folder.iterdir() if path.name.startswith(("segment", "snapshots"))}
    assert found == listed, "segments are left over or missing"
    assert not list(folder.glob(f"*{TEMPORARY}"))
    return outputs


CRASHER = """
    import os, sys
    sys.path[:0] = sys.argv[1].split(os.pathsep)
    from pathlib import Path
    from test_archive import Archive, METADATA, write_on

    calls, fatal = 0, 0

    def dying(function):
        def call(*arguments, **options):
            global calls
            calls += 1
            if calls == fatal:
                os._exit(9)  # nothing is flushed, no handler runs: to the files it is kill -9
            return function(*arguments, **options)
        return call

    # What a process has written outlives it, synced or not: only that it may die there counts.
    os.replace, os.fsync, os.unlink = dying(os.replace), dying(lambda _: None), dying(os.unlink)
    Path.unlink = dying(Path.unlink)
    for fatal in range(1, 200):
        child = os.fork()
        if child == 0:
            folder = Path(sys.argv[2]) / str(fatal)
            with Archive.create(folder, METADATA) as archive:
                write_on(archive, 6)
            with Archive.open(folder) as archive:
                write_on(archive, 8)
                archive.finish(lambda aside: aside.write_bytes(b"final"))
            os._exit(0)
        if os.waitpid(child, 0)[1] == 0:
            break
    print(fatal - 1)
"""


def run_script(script: str, *arguments: str) -> subprocess.Popen:
    search = os.pathsep.join([str(Path(__file__).parent), str(Path(__file__).parents[3])])
    command = [sys.executable, "-c", textwrap.dedent(script), search, *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.mark.slow
def test_a_crash_at_every_system_call_leaves_a_consistent_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", lambda _: None)  # nothing waits for the disk
    output, errors = run_script(CRASHER, str(tmp_path)).communicate(timeout=120)
    crashes = int(output or -1)
    assert crashes > 40, errors
    reached = set()
    for fatal in range(1, crashes + 1):
        folder = tmp_path / str(fatal)
        if (folder / MANIFEST).exists():
            reached.add(assert_consistent(folder))
            with Archive.open(folder) as archive:
                write_on(archive, 8)
            assert assert_consistent(folder) == 8
        else:  # it died before the run began: the folder can be used
            Archive.create(folder, METADATA).close()
    assert reached == {0, 4, 8}


WRITER = """
    import os, sys
    sys.path[:0] = sys.argv[1].split(os.pathsep)
    from test_archive import Archive, METADATA, MANIFEST, write_on
    from pathlib import Path
    folder = Path(sys.argv[2])
    archive = Archive.open(folder) if (folder / MANIFEST).exists() else Archive.create(folder, METADATA)
    print("writing", flush=True)
    write_on(archive, 10**6)
"""


@pytest.mark.full
def test_kill_9_at_random_instants_leaves_a_consistent_folder_that_goes_on(tmp_path):
    instants, more = random.Random(5), random.Random(6)  # how often a folder is looked at depends on the machine
    outputs = []
    for last in [False] * 7 + [True]:
        writer = run_script(WRITER, str(tmp_path))
        assert writer.stdout is not None
        assert writer.stdout.readline() == "writing\n", writer.communicate()[1]
        begun = newest = newest_checkpoint(tmp_path)
        # What a kill takes back is what the manifest does not list yet: before a second checkpoint, it lists the first.
        enough = math.inf if last else begun + more.randint(0, 8)
        while newest < enough and writer.poll() is None:
            time.sleep(instants.uniform(0.0, 0.005))
            newest = newest_checkpoint(tmp_path)
            if last and enough == math.inf and newest > begun:
                enough = max(newest + 3, 12)  # every third file
        writer.send_signal(signal.SIGKILL)
        writer.communicate()
        outputs.append(assert_consistent(tmp_path))
    assert sorted(outputs) == outputs
    assert outputs[-1] > outputs[-2]
    assert newest_checkpoint(tmp_path) > 6


def newest_checkpoint(folder) -> int:
    """Its number among the files of a run."""
    return max((int(path.stem.split("-")[1]) for path in folder.glob("checkpoint-*.npz")), default=0)


def test_checkpoints_return_every_bit(tmp_path):
    generator = np.random.default_rng(1)
    bits = generator.integers(0, 2**64, 1000, dtype=np.uint64).view(np.float64)  # NaNs with payloads, subnormals
    arrays = {
        "bits": bits,
        "zero": np.array(-0.0),
        "plain.name['x']/y": np.arange(6).reshape(2, 3),
        "single": np.float32([1.1, np.inf]),
        "flags": np.array([True, False]),
        "empty": np.empty((0, 3)),
        "fortran": np.asfortranarray(generator.normal(size=(3, 4))),
    }
    scalars = {"time": 0.1 + 0.2, "step": 2**70, "none": None, "tiny": 5e-324, "nan": float("nan"), "name": "é"}
    with Archive.create(tmp_path, METADATA) as archive:
        archive.write_checkpoint(arrays, {**scalars, "numpy": np.float64(1 / 3)})
    with Archive.open(tmp_path) as archive:
        stored = archive.read_checkpoint()
    assert stored is not None
    for name, array in arrays.items():
        assert stored[0][name].dtype == array.dtype
        assert stored[0][name].shape == array.shape
        assert stored[0][name].tobytes() == array.tobytes(), name
    assert stored[1].pop("numpy") == 1 / 3
    assert np.isnan(stored[1].pop("nan"))
    assert scalars.pop("nan")
    assert stored[1] == scalars


def test_an_array_of_several_names_is_saved_once(tmp_path):
    array = np.random.default_rng(2).normal(size=(1000, 3))
    arrays = {"position": array, "of_fluid": array, "column": array[:, 0], "transposed": array.T, "apart": array.copy()}
    with Archive.create(tmp_path, METADATA) as archive:
        archive.write_checkpoint(arrays, {"number": 1})
        stored, scalars = archive.read_checkpoint()
        ((_, other),) = archive.checkpoints()
    assert scalars == {"number": 1}
    assert list(stored) == list(other) == ["position", "column", "transposed", "apart", "of_fluid"]
    for name, values in arrays.items():
        np.testing.assert_array_equal(stored[name], values)
        np.testing.assert_array_equal(other[name], values)
    (file,) = tmp_path.glob("checkpoint-*")
    assert 3 * array.nbytes < file.stat().st_size < 3.5 * array.nbytes


@pytest.mark.parametrize("shared", [{"position": "nothing"}, {"position": ["other"]}, ["position"], 3])
def test_a_checkpoint_that_names_arrays_that_it_does_not_hold_is_refused(tmp_path, shared):
    with Archive.create(tmp_path, METADATA) as archive:
        archive.write_checkpoint(state(1), {"number": 1})
        entry = archive._manifest["checkpoints"][-1]
        entry["sha256"] = write_arrays(tmp_path / entry["file"], state(1), {"number": 1, "shared": shared})
        with pytest.raises(ArchiveError, match="names an array that it does not hold"):
            archive.read_checkpoint()


def test_the_last_two_checkpoints_are_kept(tmp_path):
    with Archive.create(tmp_path, METADATA) as archive:
        assert archive.read_checkpoint() is None
        for number in range(3):
            archive.write_checkpoint(state(number), {"number": number})
        stored = archive.read_checkpoint()
    assert stored is not None
    assert stored[1] == {"number": 2}
    assert len(list(tmp_path.glob("checkpoint-*"))) == 2


# Of segments and snapshots 1, 2, 4 and 5 and checkpoints 3 and 6, in the order in which they are written.
NEEDED_LAST = ["checkpoint-000006.npz", "segment-000004.npz", "segment-000005.npz", "snapshots-000005.npz"]


@pytest.mark.parametrize("how", ["damaged", "missing"])
@pytest.mark.parametrize("name", [*NEEDED_LAST, "checkpoint-000003.npz"])
def test_a_run_goes_on_from_the_checkpoint_before_the_damage(tmp_path, name, how):
    with Archive.create(tmp_path, METADATA) as archive:
        write_on(archive, 8)
    spoil(tmp_path / name, how)
    assert list(Archive.view(tmp_path).damaged()) == [name]
    with pytest.warns(ArchiveWarning, match=rf"{name} is {how}.* nothing of this is lost"):
        archive = Archive.open(tmp_path)
    assert not archive.lost
    archive.close()
    assert assert_consistent(tmp_path) == (4 if name in NEEDED_LAST else 8)
    with Archive.open(tmp_path) as archive:
        write_on(archive, 16)
    assert assert_consistent(tmp_path) == 16


@pytest.mark.parametrize("how", ["damaged", "missing"])
def test_outputs_older_than_both_checkpoints_are_lost_and_reported(tmp_path, how):
    with Archive.create(tmp_path, METADATA) as archive:
        write_on(archive, 8)
    spoil(tmp_path / "segment-000001.npz", how)
    with pytest.raises(ArchiveError, match=rf"segment-000001\.npz is {how}"):
        list(Archive.view(tmp_path).read_series())
    with pytest.warns(ArchiveWarning, match=rf"segment-000001\.npz is {how}.* This loses 2 of the records"):
        archive = Archive.open(tmp_path)
    with archive:
        (sentence,) = archive.lost
        assert "segment-000001.npz" in sentence
        write_on(archive, 12)
        found = np.concatenate([part["inertia_tensor"] for part in archive.read_series()])
        np.testing.assert_array_equal(found, [record(number)["inertia_tensor"] for number in range(2, 12)])
        assert archive.snapshot_layout()[0] == sum(len(part["time"]) for part in archive.read_snapshots()) == 6


@pytest.mark.parametrize("how", ["damaged", "missing"])
def test_snapshots_are_lost_without_the_records_of_their_time(tmp_path, how):
    with Archive.create(tmp_path, METADATA) as archive:
        write_on(archive, 8)
    spoil(tmp_path / "snapshots-000001.npz", how)
    assert sum(len(part["time"]) for part in Archive.view(tmp_path).read_series()) == 8
    with pytest.raises(ArchiveError, match=rf"snapshots-000001\.npz is {how}"):
        list(Archive.view(tmp_path).read_snapshots())
    with pytest.warns(ArchiveWarning, match=rf"snapshots-000001\.npz is {how}.* This loses 1 of the snapshots"):
        archive = Archive.open(tmp_path)
    with archive:
        write_on(archive, 12)
        assert sum(len(part["time"]) for part in archive.read_series()) == 12
        positions = np.concatenate([part["position"] for part in archive.read_snapshots()])
        np.testing.assert_array_equal(positions, [snapshot(number)["position"] for number in range(2, 12, 2)])


def test_a_run_without_a_checkpoint_that_is_whole_is_refused(tmp_path):
    with Archive.create(tmp_path, METADATA) as archive:
        write_on(archive, 8)
    before = sorted(path.name for path in tmp_path.iterdir())
    for path in tmp_path.glob("checkpoint-*"):
        spoil(path, "damaged")
    with pytest.raises(ArchiveError, match=r"checkpoint-000003\.npz is damaged.*checkpoint-000006\.npz is damaged"):
        Archive.open(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == before
    assert sum(len(part["time"]) for part in Archive.view(tmp_path).read_series()) == 8  # the lock was let go of


def test_a_first_checkpoint_that_is_damaged_means_the_start(tmp_path):
    with Archive.create(tmp_path, METADATA) as archive:
        write_on(archive, 4)
    spoil(tmp_path / "checkpoint-000003.npz", "damaged")
    with pytest.warns(ArchiveWarning, match="checkpoint-000003"):
        Archive.open(tmp_path).close()
    assert assert_consistent(tmp_path) == 0


def spoil(path: Path, how: str) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.unlink() if how == "missing" else path.write_bytes(content)


@pytest.mark.parametrize("name", [MANIFEST, COPY])
@pytest.mark.parametrize("how", ["damaged", "missing"])
def test_one_copy_of_the_manifest_is_enough(tmp_path, name, how):
    with Archive.create(tmp_path, METADATA) as archive:
        write_on(archive, 8)
    spoil(tmp_path / name, how)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert assert_consistent(tmp_path) == 8
    assert any("its copy is used" in str(each.message) for each in caught) == (name == MANIFEST)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        archive = Archive.open(tmp_path)
    with archive:
        write_on(archive, 12)
    assert (tmp_path / MANIFEST).read_bytes() == (tmp_path / COPY).read_bytes()


def test_a_manifest_that_reads_well_and_is_wrong_is_known(tmp_path):
    Archive.create(tmp_path, METADATA).close()
    for name in (MANIFEST, COPY):
        text = (tmp_path / name).read_text()
        (tmp_path / name).write_text(text.replace("name = 'star'", "name = 'stab'"))
    with pytest.raises(ArchiveError, match="damaged"):
        Archive.view(tmp_path)


@pytest.mark.parametrize("content", ["", "{", "[]", '{"format": "other"}', "\x00\xff"])
def test_a_damaged_manifest_is_named(tmp_path, content):
    (tmp_path / MANIFEST).write_text(content)
    for refuse in (Archive.open, Archive.view, lambda folder: Archive.create(folder, METADATA)):
        with pytest.raises(ArchiveError, match=MANIFEST):
            refuse(tmp_path)


@pytest.mark.parametrize("name", ["predicted_steps", "predicted_evolution_time"])
@pytest.mark.parametrize("value", [{}, None, "many"])
def test_what_a_run_was_planned_to_take_is_a_number(tmp_path, name, value):
    with Archive.create(tmp_path, METADATA):
        pass
    content = json.loads((tmp_path / MANIFEST).read_text())
    content["metadata"][name] = value
    rehashed(tmp_path, content)
    with pytest.raises(ArchiveError, match=f"metadata {name}"):
        Archive.open(tmp_path)


def test_a_run_of_the_first_format_goes_on_in_todays(tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(Path(__file__).parents[2] / "data" / "format_1_run", folder)
    with Archive.open(folder) as archive:
        before = archive.read_checkpoint()
        assert before is not None
        archive.write_checkpoint(state(1), {"number": 1})
        assert archive.read_checkpoint() != before
    assert manifest.read(folder)["version"] == manifest.VERSION
    spoil(max(folder.glob("checkpoint-*")), "damaged")
    with pytest.warns(ArchiveWarning, match="checkpoint-000005"):
        archive = Archive.open(folder)
    with archive:
        again = archive.read_checkpoint()
        assert again is not None
        assert again[1] == before[1]
        assert sum(len(part["time"]) for part in archive.read_series()) == 3


READER = """
    import os, sys
    sys.path[:0] = sys.argv[1].split(os.pathsep)
    from test_archive import Archive, METADATA, write_on
    from astroinertia.errors import ArchiveError
    folder = sys.argv[2]
    outputs = lambda: sum(len(part["time"]) for part in Archive.view(folder).read_series())
    outputs()  # imports what another user may not read
    os.setuid(65534)  # root may write everywhere
    for attempt in (lambda: Archive.open(folder), lambda: Archive.create(folder + "/new", METADATA)):
        try:
            attempt()
        except ArchiveError as error:
            print(error)
    print(outputs())
"""


@pytest.mark.skipif(os.getuid() != 0, reason="only the superuser can become a user who may not write")
def test_a_folder_that_must_not_be_written_is_reported_and_can_be_read():
    with tempfile.TemporaryDirectory() as place:  # pytest's own can be looked into by its user only
        Path(place).chmod(0o755)
        folder = Path(place) / "run"
        with Archive.create(folder, METADATA) as archive:
            write_on(archive, 4)
        output, errors = run_script(READER, str(folder)).communicate(timeout=120)
    assert not errors, errors
    first, second, outputs = output.splitlines()
    assert "run cannot be written: Permission denied." in first
    assert "new cannot be made: Permission denied." in second
    assert outputs == "4"


def test_a_newer_format_is_refused(tmp_path):
    Archive.create(tmp_path, METADATA).close()
    manifest.write(tmp_path, {**manifest.read(tmp_path), "version": manifest.VERSION + 1})
    with pytest.raises(ArchiveError, match="newer version"):
        Archive.view(tmp_path)


def test_a_folder_with_another_run_is_refused_and_stays_as_it_was(tmp_path):
    with Archive.create(tmp_path, METADATA) as archive:
        write_on(archive, 4)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(
        ArchiveError, match="already holds the run 'star'; resume it, choose another folder, or remove this one"
    ):
        Archive.create(tmp_path, {**METADATA, "name": "other"})
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_folder_that_netcdf_would_take_for_another_is_refused_before_a_run(tmp_path, monkeypatch):
    for refused in (refuse_if_taken, Archive.create):
        with pytest.raises(ArchiveError, match="has a backslash, which netCDF takes for a slash"):
            refused(tmp_path / r"a\b", METADATA)
    (tmp_path / r"a\b").mkdir(exist_ok=True)
    monkeypatch.chdir(tmp_path / r"a\b")
    with pytest.raises(ArchiveError, match="has a backslash, which netCDF takes for a slash"):
        refuse_if_taken(Path("run"), METADATA)
    with pytest.raises(SceneError, match="has a backslash, which netCDF takes for a slash"):
        must_be_writable(Path("moments.nc"), ".nc")


def test_a_folder_that_netcdf_cannot_open_is_refused_before_a_run(tmp_path):
    named = tmp_path / os.fsdecode(b"caf\xe9")  # as an older system wrote it
    with pytest.raises(ArchiveError, match="has bytes that are no utf-8, which netCDF cannot open"):
        refuse_if_taken(named, METADATA)
    with pytest.raises(SceneError, match="has bytes that are no utf-8, which netCDF cannot open"):
        must_be_writable(named / "moments.nc", ".nc")


def test_a_folder_with_a_result_or_with_orphaned_segments_is_refused(tmp_path):
    (tmp_path / "star.nc").write_text("a result")
    with pytest.raises(ArchiveError, match=r"already holds a result, star\.nc"):
        Archive.create(tmp_path, METADATA)
    with Archive.create(tmp_path / "b", METADATA) as archive:
        write_on(archive, 4)
    (tmp_path / "b" / MANIFEST).unlink()
    with pytest.raises(ArchiveError, match="is gone"):
        Archive.create(tmp_path / "b", METADATA)
    assert len(list((tmp_path / "b").glob("segment-*"))) == 2


def test_two_writers_on_one_folder_are_refused(tmp_path):
    with Archive.create(tmp_path, METADATA) as archive:
        write_on(archive, 4)
        with pytest.raises(ArchiveError, match="another process"):
            Archive.open(tmp_path)
        assert Archive.view(tmp_path).segments == 4  # reading goes on
    writer = run_script(WRITER, str(tmp_path))
    assert writer.stdout is not None
    assert writer.stdout.readline() == "writing\n"
    try:
        with pytest.raises(ArchiveError, match="another process"):
            Archive.open(tmp_path)
    finally:
        writer.kill()
        writer.communicate()
    Archive.open(tmp_path).close()


def test_a_folder_read_only_by_view_or_closed_cannot_be_written(tmp_path):
    archive = Archive.create(tmp_path, METADATA)
    archive.close()
    for closed in (archive, Archive.view(tmp_path)):
        with pytest.raises(ArchiveError, match="reading only"):
            closed.write_segment([record(0)])
        with pytest.raises(ArchiveError, match="reading only"):
            closed.write_checkpoint(state(0), {})
    assert not list(tmp_path.glob("*.npz"))


def test_a_disk_that_refuses_leaves_what_is_there(tmp_path, monkeypatch):
    with Archive.create(tmp_path, METADATA) as archive:
        write_on(archive, 4)

        def full(*_):
            raise OSError(28, "No space left on device")

        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", full)
            with pytest.raises(ArchiveError, match="No space left on device"):
                archive.write_segment([record(4)])
        assert archive.segments == 4
        archive.write_segment([record(4), record(5)], [snapshot(4)])
        assert archive.segments == 6
    assert_consistent(tmp_path)


def test_places_that_cannot_hold_a_run_are_refused_before_it(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    for place in ("file", "file/run"):
        with pytest.raises(ArchiveError, match=r"cannot be made: .*/file is a file\."):
            refuse_if_taken(tmp_path / place, METADATA)
    refuse_if_taken(tmp_path / "new" / "run", METADATA)
    with monkeypatch.context() as patch:
        patch.setattr(os, "access", lambda path, mode: path != tmp_path)
        with pytest.raises(ArchiveError, match=f"cannot be made: {tmp_path} may not be written to"):
            refuse_if_taken(tmp_path / "new" / "run", METADATA)
    with pytest.raises(ArchiveError, match="cannot be made"):
        Archive.create(tmp_path / "file", METADATA)
    with pytest.raises(ArchiveError, match="holds no run"):
        Archive.open(tmp_path / "file")
    with pytest.raises(ArchiveError, match="holds no run"):
        Archive.view(tmp_path / "nowhere")
    assert not (tmp_path / "nowhere").exists()
    with pytest.raises(ArchiveError, match="'name'"):
        Archive.create(tmp_path / "new", {})
    with pytest.raises(ArchiveError, match="plain data"):
        Archive.create(tmp_path / "new", {"name": "x", "effects": {1, 2}})


def test_outputs_that_do_not_fit_together_are_refused(tmp_path):
    with Archive.create(tmp_path, METADATA) as archive:
        with pytest.raises(ArchiveError, match="'inertia_tensor' changes its shape"):
            archive.write_segment([record(0), {**record(1), "inertia_tensor": np.eye(2)}])
        with pytest.raises(ArchiveError, match="differ in what they hold"):
            archive.write_segment([record(0), {**record(1), "more": 1.0}])
        with pytest.raises(ArchiveError, match="Python objects"):
            archive.write_checkpoint({"bad": np.array([{}])}, {})
        with pytest.raises(ArchiveError, match="cannot be archived"):
            archive.write_checkpoint({}, {"bad": {1, 2}})
        assert archive.segments == 0


def test_the_final_file_is_saved_and_known(tmp_path):
    with Archive.create(tmp_path, {**METADATA, "name": "../odd name"}) as archive:
        write_on(archive, 4)
        assert archive.finished is None
        path = archive.finish(lambda aside: aside.write_bytes(b"final"))
        assert path == tmp_path / "_odd_name.nc"
        assert path.read_bytes() == b"final"
        assert archive.finished == path
        write_on(archive, 8)
        assert archive.finished is None  # it lacks the newest outputs
        with pytest.raises(ValueError, match="halfway"):
            archive.finish(_fail)
        assert path.read_bytes() == b"final"
        assert not list(tmp_path.glob("*.tmp"))


def _fail(aside: Path) -> None:
    aside.write_bytes(b"half")
    raise ValueError("halfway")


def test_the_same_arrays_give_the_same_file(tmp_path):
    digests = {write_arrays(tmp_path / name, state(1), {"a": 1.5}) for name in ("one", "two")}
    assert len(digests) == 1
    arrays, scalars = read_arrays(tmp_path / "one", digests.pop())
    assert scalars == {"a": 1.5}
    assert set(arrays) == set(state(1))
