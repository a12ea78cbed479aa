"""A bit that a disk flips in a finished netCDF file is noticed, wherever it is."""

import random
import shutil
from contextlib import suppress
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import pytest
import xarray as xr

from astroinertia import dataset
from astroinertia.errors import ArchiveError
from astroinertia.storage import trailer
from astroinertia.storage.archive import Archive
from astroinertia.studies.moments import read_matter

DATA = Path(__file__).parents[1] / "data"
FLIPS = 1000


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A run of three outputs and two snapshots of 20 particles."""
    folder = tmp_path_factory.mktemp("run") / "run"
    shutil.copytree(DATA / "format_2_run", folder)
    with Archive.open(folder) as archive:
        return dataset.finish(archive)


def flipped(content, place, bit):
    changed = bytearray(content)
    changed[place] ^= 1 << bit
    return bytes(changed)


def test_no_flipped_bit_is_silent(finished, tmp_path):
    content, chance = finished.read_bytes(), random.Random(7)
    end = content.rindex(b"\nastroinertia-sha256")
    whole, path = dataset.open(finished), tmp_path / "flipped.nc"
    harmless = 0
    for _ in range(FLIPS):
        place = chance.randrange(len(content))
        path.write_bytes(flipped(content, place, chance.randrange(8)))
        with suppress(ArchiveError):
            assert dataset.open(path).identical(whole)
            assert place >= end  # of the line itself, which then says nothing of a file that is whole
            harmless += 1
    assert harmless < 10


def test_bytes_that_are_lost_or_added_are_noticed_and_other_programs_read_the_file(finished, tmp_path):
    content, path = finished.read_bytes(), tmp_path / "other.nc"
    for other in (content[:5000] + content[5001:], content[:5000] + b"\0" + content[5000:]):
        path.write_bytes(other)
        with pytest.raises(ArchiveError, match="is damaged"):
            dataset.open(path)
    with xr.open_dataset(finished) as plain, netCDF4.Dataset(finished) as file:
        assert plain.sizes["time"] == 3
        assert all(variable.filters()["fletcher32"] for variable in file.variables.values() if variable.ndim)
        assert all(variable.filters()["fletcher32"] for variable in file["snapshots"].variables.values())


def test_a_file_that_is_changed_on_purpose_is_read_without_its_line(finished, tmp_path):
    path = tmp_path / "changed.nc"
    shutil.copy(finished, path)
    with netCDF4.Dataset(path, "a") as file:
        file.comment = "looked at"
        file["mass"][:] = 2.0 * file["mass"][:]
    found = dataset.open(path)
    assert found.attrs["comment"] == "looked at"
    np.testing.assert_array_equal(found["mass"], 2.0 * dataset.open(finished)["mass"])


@pytest.mark.full
def test_large_files_are_checked_in_their_head_and_where_particles_are_read(finished, tmp_path, monkeypatch):
    """As if the file were too large to be read as a whole whenever it is opened."""
    monkeypatch.setattr(trailer, "WHOLE", 0)
    content, path = finished.read_bytes(), tmp_path / "flipped.nc"
    end = content.rindex(b"\nastroinertia-sha256")
    head = int(content[end:].split()[2])
    path.write_bytes(content[:end])
    trailer.append(path, head)
    content = path.read_bytes()
    assert content[end:].count(content[end:].split()[3]) == 2  # nothing but the head was read
    place = content.index(b"gravity")
    assert place < head
    path.write_bytes(flipped(content, place, 0))
    with pytest.raises(ArchiveError, match="is damaged"):
        dataset.open(path)
    with h5py.File(finished) as file:
        chunk = file["snapshots/position"].id.get_chunk_info(1)
    assert chunk.byte_offset > head
    for place in range(chunk.byte_offset, chunk.byte_offset + chunk.size, 20):
        path.write_bytes(flipped(content, place, 3))
        with pytest.raises(ArchiveError, match="is damaged"):
            read_matter(path)


def test_old_files_have_no_line_and_open():
    assert b"astroinertia-sha256" not in (DATA / "format_1.nc").read_bytes()
    trailer.check(DATA / "format_1.nc")
    assert dataset.open(DATA / "format_1.nc").sizes["time"] == 3
