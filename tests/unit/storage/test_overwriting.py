"""Commands write over nothing that they read, and over no file of another kind."""

import netCDF4
import numpy as np
import pytest

from astroinertia.cli.main import main
from astroinertia.errors import ArchiveError
from astroinertia.storage import overwriting, trailer

BEGINNINGS = {
    overwriting.PNG: b"\x89PNG\r\n\x1a\n", overwriting.HTML: b"<!DOCTYPE html>\n", overwriting.NETCDF: b"CDF\x01",
    overwriting.GIF: b"GIF89a", overwriting.MP4: b"\0\0\0 ftypisom",
}  # fmt: skip


@pytest.mark.parametrize("kind", BEGINNINGS)
def test_only_files_of_the_kind_are_written_over(tmp_path, kind):
    path = tmp_path / "file"
    overwriting.check(path, kind)
    for other, content in BEGINNINGS.items():
        path.write_bytes(content)
        if other == kind:
            overwriting.check(path, kind)
        else:
            with pytest.raises(ArchiveError, match="is not written over"):
                overwriting.check(path, kind)
    path.write_text('name = "star"\n')
    with pytest.raises(ArchiveError, match="is not written over"):
        overwriting.check(path, kind)
    path.unlink()
    path.mkdir()
    with pytest.raises(ArchiveError, match="is not a file"):
        overwriting.check(path, kind)


def test_a_folder_that_is_not_there_is_named(tmp_path):
    for folder in (tmp_path / "none", tmp_path / "file"):
        (tmp_path / "file").touch()
        with pytest.raises(ArchiveError, match=f"there is no folder {folder}[.]$"):
            overwriting.check(folder / "film.gif", overwriting.GIF)


@pytest.fixture
def places(tmp_path, monkeypatch):
    """A scene, a table in netCDF, and a result of a run with so much as `view` and `report` ask for."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "star.toml").write_text('name = "star"\n')
    with netCDF4.Dataset("t.nc", "w") as file:
        file.createDimension("particle", 4)
        for name, values in zip(("mass", "x", "y", "z"), (np.ones(4), *np.eye(3, 4)), strict=True):
            file.createVariable(name, "f8", ("particle",))[:] = values
    with netCDF4.Dataset("result.nc", "w") as file:
        file.astroinertia_format = 1
    trailer.append(tmp_path / "result.nc", 10)
    (tmp_path / "linked.nc").hardlink_to(tmp_path / "t.nc")
    return tmp_path


@pytest.mark.parametrize("target", ["t.nc", "linked.nc", "./t.nc", "result.nc", "not.nc"])
def test_moments_destroys_nothing(places, capsys, target):
    (places / "not.nc").write_text("a letter")
    before = {path.name: path.read_bytes() for path in places.iterdir()}
    assert main(["moments", "t.nc", "--output", target]) == 2
    assert "written over" in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in places.iterdir()} == before


@pytest.mark.slow
def test_moments_writes_over_what_it_has_written(places):
    assert main(["moments", "t.nc", "--output", "m.nc"]) == main(["moments", "t.nc", "--output", "m.nc"]) == 0
    assert main(["moments", "t.nc", "--plot", "m.png"]) == main(["moments", "t.nc", "--plot", "m.png"]) == 0
