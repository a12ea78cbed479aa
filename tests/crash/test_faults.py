"""Disks that are full, tear what they write or flip bits of it: all is noticed, and little is lost.

Run folders are made of small arrays, two segments to a checkpoint, as tests/unit/storage/test_archive.py makes them.
"""

import errno
import io
import os
import random
import shutil
import warnings
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from astroinertia.errors import ArchiveError, ArchiveWarning
from astroinertia.storage.archive import Archive
from tests.unit.storage.test_archive import METADATA, assert_consistent, record, snapshot, state, write_on

INTERVAL = 4  # outputs from one checkpoint to the next
OUTPUTS = 12


class FillsUp:
    """Stands in for io.open: files whose writes fail, from the `fatal`-th of all on, with half of it written."""

    def __init__(self, fatal):
        self.fatal, self.writes, self.opened = fatal, 0, io.open

    def __call__(self, file, mode="r", *arguments, **options):
        found = self.opened(file, mode, *arguments, **options)
        return Filling(found, self) if set(mode) & set("wax+") else found


class Filling:
    def __init__(self, file, disk):
        self.file, self.disk = file, disk

    def write(self, data):
        self.disk.writes += 1
        if self.disk.writes >= self.disk.fatal:
            self.file.write(data[: len(data) // 2])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return self.file.write(data)

    def __getattr__(self, name):
        return getattr(self.file, name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.file.close()


@pytest.fixture
def quick_disk(monkeypatch):
    """Nothing waits for the disk: what is tested here is what is in the files, not when it gets there."""
    monkeypatch.setattr(os, "fsync", lambda _: None)


def final(archive):
    return archive.finish(lambda aside: aside.write_bytes(b"final"))


def test_a_disk_that_is_full_at_any_write_is_reported_and_nothing_saved_is_lost(tmp_path, monkeypatch, quick_disk):
    reached = []
    for fatal in range(1, 1000):
        folder, disk = tmp_path / str(fatal), FillsUp(fatal)
        with Archive.create(folder, METADATA) as archive:
            write_on(archive, INTERVAL)
        with Archive.open(folder) as archive, monkeypatch.context() as patch:
            patch.setattr(io, "open", disk)
            try:
                write_on(archive, 2 * INTERVAL)
                final(archive)
                message = ""
            except ArchiveError as error:
                message = str(error)
        assert message == "" or (str(folder) in message and "No space left on device; what was written" in message)
        assert bool(message) == (disk.writes >= fatal)
        reached.append(assert_consistent(folder))
        if disk.writes < fatal:
            break
        with Archive.open(folder) as archive:  # there is space again
            write_on(archive, 2 * INTERVAL)
            assert final(archive).read_bytes() == b"final"
        assert assert_consistent(folder) == 2 * INTERVAL
    assert len(reached) > 50, "few writes were found to fail"
    assert set(reached) == {INTERVAL, 2 * INTERVAL}
    assert sorted(reached) == reached


def damage(path: Path, chance: random.Random) -> bool:
    """Flip a bit, or cut the file off; whether it is another file now."""
    content = bytearray(path.read_bytes())
    if chance.random() < 0.5:
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    else:
        del content[chance.randrange(len(content)) :]
    changed = bytes(content) != path.read_bytes()
    path.write_bytes(content)
    return changed


def outputs_of(archive: Archive) -> dict[int, dict]:
    return {
        int(step): {"time": time, "inertia_tensor": tensor}
        for part in archive.read_series()
        for step, time, tensor in zip(part["step"], part["time"], part["inertia_tensor"], strict=True)
    }


@pytest.mark.parametrize("damages", [100, pytest.param(500, marks=pytest.mark.full)])
def test_no_damage_to_a_file_goes_unnoticed_and_an_interval_at_most_is_lost(tmp_path, quick_disk, damages):
    """A bit flipped or an end cut off, at random, in one file of each of so many run folders."""
    chance = random.Random(3)
    with Archive.create(tmp_path / "whole", METADATA) as archive:
        write_on(archive, OUTPUTS)
    names = sorted(path.name for path in (tmp_path / "whole").iterdir() if path.name != "lock")
    counts = {"back": 0, "lost": 0, "copy": 0, "harmless": 0}
    for number in range(damages):
        folder = tmp_path / "damaged"
        shutil.copytree(tmp_path / "whole", folder)
        name = chance.choice(names)
        assert damage(folder / name, chance)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            archive = Archive.open(folder)
        with archive:
            stored = archive.read_checkpoint()
            assert stored is not None
            outputs = stored[1]["number"]
            np.testing.assert_array_equal(stored[0]["position"], state(outputs)["position"])
            assert outputs >= OUTPUTS - INTERVAL, (number, name)
            write_on(archive, OUTPUTS + INTERVAL)
            found = outputs_of(archive)
            lost = set(range(OUTPUTS + INTERVAL)) - set(found)
            assert len(lost) <= INTERVAL, (number, name)
            for step, values in found.items():
                assert values["time"] == record(step)["time"]
                np.testing.assert_array_equal(values["inertia_tensor"], record(step)["inertia_tensor"])
            positions = {
                round(10 * time): position
                for part in archive.read_snapshots()
                for time, position in zip(part["time"], part["position"], strict=True)
            }
            dropped = set(range(0, OUTPUTS + INTERVAL, 2)) - set(positions)
            assert len(dropped) <= INTERVAL // 2 and not (lost and dropped), (number, name)
            for step, position in positions.items():
                np.testing.assert_array_equal(position, snapshot(step)["position"])
            sentences = [str(each.message) for each in caught if issubclass(each.category, ArchiveWarning)]
            assert (len(archive.lost) == 1) == bool(lost or dropped)
            assert name == "manifest-copy.json" or all(name in sentence for sentence in sentences)
        if not sentences:  # white space of the manifest, or its copy, which nothing reads
            assert name.startswith("manifest")
            assert outputs == OUTPUTS
        kind = "lost" if lost or dropped else "back" if outputs < OUTPUTS else "copy" if sentences else "harmless"
        counts[kind] += 1
        shutil.rmtree(folder)
    assert min(counts.values()) > damages // 50, counts
    assert sum(counts.values()) == damages


def test_damage_while_only_looking_is_an_error_that_names_the_file(tmp_path, quick_disk):
    chance = random.Random(3)
    with Archive.create(tmp_path / "whole", METADATA) as archive:
        write_on(archive, INTERVAL)
    for path in sorted((tmp_path / "whole").glob("segment-*")):
        for _ in range(20):
            folder = tmp_path / "damaged"
            shutil.copytree(tmp_path / "whole", folder)
            damage(folder / path.name, chance)
            viewed = Archive.view(folder)
            with pytest.raises(ArchiveError, match=path.name):
                outputs_of(viewed)
            assert list(viewed.damaged()) == [path.name]
            shutil.rmtree(folder)


def test_two_damaged_files_leave_an_error_or_a_state_that_is_right(tmp_path, quick_disk):
    chance = random.Random(29)
    with Archive.create(tmp_path / "whole", METADATA) as archive:
        write_on(archive, OUTPUTS)
    names = sorted(path.name for path in (tmp_path / "whole").iterdir() if path.name != "lock")
    refused = 0
    for _ in range(100):
        folder = tmp_path / "damaged"
        shutil.copytree(tmp_path / "whole", folder)
        for name in chance.sample(names[:2] + names[-4:], 2):  # checkpoints, the last segments, manifests
            damage(folder / name, chance)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with suppress(ArchiveError), Archive.open(folder) as archive:
                refused -= 1
                stored = archive.read_checkpoint()
                assert stored is not None
                np.testing.assert_array_equal(stored[0]["position"], state(stored[1]["number"])["position"])
                for step, values in outputs_of(archive).items():
                    np.testing.assert_array_equal(values["inertia_tensor"], record(step)["inertia_tensor"])
            refused += 1
        shutil.rmtree(folder)
    assert 3 < refused < 50
