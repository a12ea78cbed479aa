"""To open a result takes what its headline series take, however many particles its snapshots hold."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

from astroinertia import dataset
from astroinertia.errors import ArchiveError
from astroinertia.storage.archive import Archive
from tests.unit.affine_body import METADATA, affine_run

HERE = Path(__file__).parent
KINDS = ("open", "tree", "lazy_tree")
FIELDS = {"position": 3, "velocity": 3, "mass": 1, "density": 1, "smoothing_length": 1, "internal_energy": 1}


def snapshot(number, particles):
    """Noise, which does not compress, about a centre that tells the snapshot."""
    generator = np.random.default_rng(number)
    shapes = {name: (particles, width)[: 1 + (width > 1)] for name, width in FIELDS.items()}
    fields = {name: generator.random(shape) for name, shape in shapes.items()}
    fields["position"] += number
    return {"time": float(number), **fields}


def written(folder, particles, segments, in_each, finished=True):
    """A run folder, and beside it the finished one that shares its segments, as links."""
    records, _ = affine_run(outputs=24, particles=64)
    records = [{**record, "time": float(number)} for number, record in enumerate(records * (2 * segments))]
    with Archive.create(folder / "unfinished", METADATA) as archive:
        for number in range(segments):
            archive.write_segment(
                records[2 * number : 2 * number + 2],
                [snapshot(in_each * number + k, particles) for k in range(in_each)],
            )
        archive.write_checkpoint({"position": np.zeros((particles, 3))}, {"number": segments})
    if finished:
        shutil.copytree(
            folder / "unfinished", folder / "finished", copy_function=os.link, ignore=shutil.ignore_patterns("lock")
        )
        for manifest in (folder / "finished").glob("manifest*"):
            content = manifest.read_bytes()
            manifest.unlink()
            manifest.write_bytes(content)
        with Archive.open(folder / "finished") as archive:
            dataset.finish(archive)
    return folder


def opened(*asked):
    """What it takes in a new process to open results: each a path, the path of a small one, and how."""
    command = [sys.executable, str(HERE / "opening.py"), *(str(word) for each in asked for word in each)]
    environment = {**os.environ, "PYTHONPATH": str(HERE.parents[1])}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


FEW, MANY = 10_000, 40_000  # both more than the netCDF library reads of any file to see what it is: 4 MiB


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return {count: written(tmp_path_factory.mktemp(f"of_{count}"), count, 3, 2) for count in (10, FEW, MANY)}


@pytest.mark.full
def test_bytes_read_do_not_grow_with_the_particles(results):
    cases = [(state, kind) for state in ("finished", "unfinished") for kind in KINDS]
    asked = [(results[count] / state, results[10] / state, kind) for state, kind in cases for count in (FEW, MANY)]
    found = opened(*asked)
    for case, few, many in zip(cases, found[::2], found[1::2], strict=True):
        assert many["records"] == few["records"] == 6
        if case == ("finished", "open"):  # the first time, a file that is not large is compared with its hash
            for count, figures in ((FEW, few), (MANY, many)):
                figures["read"] -= (results[count] / "finished" / "affine_star.nc").stat().st_size
        # Numbers in the manifest, and chunks of HDF5's metadata, have another length.
        assert abs(many["read"] - few["read"]) < 0.05 * few["read"] + 20_000, case
        if case[1] != "open":
            assert many["bytes"] == 4 * few["bytes"] == 6 * MANY * 80
            # Of the particles only one snapshot's file is read then, twice where its hash is checked.
            assert many["one_snapshot"]["read"] < many["bytes"], case
            np.testing.assert_allclose(many["centre"], 1.5e6 * 5.5, rtol=1e-2)  # the unit of length


def test_what_is_read_later_is_what_was_written(results):
    for state in ("finished", "unfinished"):
        particles = dataset.open_snapshots(results[FEW] / state)
        assert particles is not None
        unit = dataset.open(results[FEW] / state).attrs["code_unit_length"]
        for picked in (5, -1, slice(1, 5, 2), [0, 3], slice(0, 0)):
            found = particles["position"].isel(snapshot_time=picked, particle=slice(7, 30, 3), i=[2, 0]).values
            wanted = np.array([snapshot(number, FEW)["position"] for number in range(6)])[picked]
            np.testing.assert_array_equal(found, (unit * wanted)[..., 7:30:3, :][..., [2, 0]])
        np.testing.assert_array_equal(particles["mass"].isel(particle=3).values.shape, (6,))
        particles.close()


def test_damage_to_snapshots_is_reported_when_they_are_read(results, tmp_path):
    folder = tmp_path / "damaged"
    shutil.copytree(results[FEW] / "unfinished", folder)
    path = folder / "snapshots-000002.npz"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    particles = dataset.open_snapshots(folder)
    assert particles is not None
    assert dataset.open(folder).sizes["time"] == 6
    assert np.isfinite(particles["position"].isel(snapshot_time=[0, 1, 4]).values).all()
    with pytest.raises(ArchiveError, match=r"snapshots-000002\.npz is damaged"):
        particles["mass"].isel(snapshot_time=2).load()
    with pytest.warns(UserWarning, match=r"snapshots-000002\.npz is damaged.* Its 2 snapshots are left out"):
        whole = dataset.open_snapshots(folder, damaged="skip")
    assert whole is not None
    assert whole["snapshot_time"].size == 4
    path.unlink()
    with pytest.raises(ArchiveError, match=r"snapshots-000002\.npz is missing"):
        dataset.open_snapshots(folder)


PARTICLES, SEGMENTS, IN_EACH = 100_000, 800, 2  # a fifth of this noise goes when netCDF packs it
SIZE, SECONDS, MEMORY = 10e9, 2.0, 200e6


def forget(folder):
    """Let the system forget what it holds of files in memory."""
    for path in folder.iterdir():
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
            os.posix_fadvise(descriptor, 0, 0, os.POSIX_FADV_DONTNEED)
        finally:
            os.close(descriptor)


@pytest.mark.full(inputs=["tests/scale/opening.py"])
def test_ten_gigabytes_are_opened_in_two_seconds_and_200_megabytes(result):
    with tempfile.TemporaryDirectory() as place:  # pytest keeps its own
        begin = time.perf_counter()
        folder = written(Path(place), PARTICLES, SEGMENTS, IN_EACH)
        result(seconds_of_writing=time.perf_counter() - begin)
        small = written(Path(place) / "small", 10, 3, 2)
        sizes = {
            "finished": (folder / "finished" / "affine_star.nc").stat().st_size,
            "unfinished": sum(path.stat().st_size for path in (folder / "unfinished").iterdir()),
        }
        result(bytes=sizes)
        worst = {"seconds": 0.0, "memory": 0.0}
        for state in sizes:
            for kind in KINDS:
                forget(folder / state)
                (found,) = opened((folder / state, small / state, kind))
                result(**{f"{state} {kind}": found})
                worst = {name: max(value, found[name]) for name, value in worst.items()}
    assert min(sizes.values()) >= SIZE
    assert worst["seconds"] < SECONDS
    assert worst["memory"] < MEMORY
