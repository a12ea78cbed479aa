"""What commands say of results that others made, which have the format's number and little else; and what links do."""

import os

import netCDF4
import numpy as np
import pytest

from astroinertia.cli.main import main
from astroinertia.errors import ArchiveError
from astroinertia.storage import bounded
from astroinertia.storage.archive import locked
from astroinertia.storage.atomic import read_json, write_json


@pytest.fixture
def bare(tmp_path, monkeypatch):
    """A file with a few variables of ours, some of other shapes than ours have."""
    monkeypatch.chdir(tmp_path)
    with netCDF4.Dataset("bare.nc", "w") as file:
        file.astroinertia_format = 1
        file.scene = "= no TOML"
        file.createDimension("time", 2)
        file.createVariable("time", "f8", ("time",))[:] = [0.0, 1.0]
        file.createVariable("inertia_tensor", "f8", ("time",))[:] = 1.0
        snapshots = file.createGroup("snapshots")
        snapshots.createDimension("particle", 3)
        snapshots.createVariable("mass", "f8", ("particle",))[:] = 1.0
    return tmp_path / "bare.nc"


@pytest.mark.parametrize(
    "command", ["show", "report", "view", "moments", "compare", "export --to csv", "export --to vtk"]
)
def test_a_result_that_lacks_everything_is_refused_in_a_sentence(bare, command, capsys):
    name, *options = command.split()
    files = [str(bare)] * (2 if name == "compare" else 1)
    code = main([name, *files, *options])
    complaint = capsys.readouterr().err
    assert code == 2 or command == "export --to csv"  # a series is what is there
    assert code == 0 or (complaint.startswith("astroinertia: ") and complaint.count("\n") == 1), complaint


def test_nothing_is_written_through_links(tmp_path):
    outside, folder = tmp_path / "outside", tmp_path / "run"
    folder.mkdir()
    outside.write_text("precious")
    for name in ("content.json", "lock"):
        (folder / name).symlink_to(outside)
    with pytest.raises(ArchiveError, match="leads out of its folder"):
        read_json(folder / "content.json")
    write_json(folder / "content.json", [1])
    assert read_json(folder / "content.json") == [1] and not (folder / "content.json").is_symlink()
    with pytest.raises(ArchiveError, match="cannot be written"):
        locked(folder)
    assert outside.read_text() == "precious"
    (folder / "lock").unlink()
    os.mkfifo(folder / "lock")
    with pytest.raises(ArchiveError, match="cannot be written"):
        locked(folder)


def test_arrays_come_back_as_numpy_wrote_them(tmp_path):
    arrays = {
        "c": np.arange(6.0).reshape(2, 3), "f": np.asfortranarray(np.arange(6).reshape(2, 3)), "none": np.zeros((0, 3)),
        "one": np.array(3.5), "text": np.array(["a", "bcd"]), "fields": np.zeros(2, [("a", "f8"), ("b", "i4")]),
    }  # fmt: skip
    np.savez_compressed(tmp_path / "a.npz", **arrays)
    found = {name: read() for name, read in bounded.npz_members(tmp_path / "a.npz").items()}
    assert list(found) == list(arrays)
    for name, array in arrays.items():
        np.testing.assert_array_equal(found[name], array)
        assert found[name].dtype == array.dtype and found[name].flags.writeable
