"""Files and folders from strangers: no link out of a folder is followed, and numbers are what they look like."""

import os

import numpy as np
import pytest
from scipy.io import netcdf_file

from astroinertia.accuracy import measuring, running
from astroinertia.accuracy.knobs import Setting
from astroinertia.cli.main import main
from astroinertia.errors import ArchiveError, SceneError
from astroinertia.scene import load
from astroinertia.sph.progenitor import read_progenitor
from astroinertia.sph.table import read_table
from astroinertia.storage.atomic import own_folder

SWEEP = """\
name = "top"
accuracy = 1e-3
model = "rigid"
units = "code"
[sweep]
"body.mass" = [1.0]
[body]
kind = "rigid"
mass = 1.0
moments = [1.0, 1.3, 1.7]
rotation = { rate = 1.0, axis = [0.3, 1.0, 0.2] }
[effects]
[time]
end = 10.0
"""
ROWS = "1,0,0,0\n1,1,0,0\n1,0,1,0\n1,0,0,1\n"


def test_no_component_below_a_folder_may_be_a_link(tmp_path):
    outside = tmp_path / "outside"
    (outside / "inner").mkdir(parents=True)
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "a").symlink_to(outside)
    (tmp_path / "run" / "b").mkdir()
    (tmp_path / "run" / "b" / "c").symlink_to(outside)
    (tmp_path / "run" / "file").write_text("")
    for names in (("a",), ("a", "inner"), ("b", "c"), ("b", "c", "inner"), ("file",)):
        with pytest.raises(ArchiveError, match=r"is a link|is not a folder"):
            own_folder(tmp_path / "run", *names)
    assert own_folder(tmp_path / "run", "b", "new", "newer") == tmp_path / "run/b/new/newer"
    (tmp_path / "mine").symlink_to(tmp_path / "run")  # where its user goes through a link, that is the user's choice
    assert own_folder(tmp_path / "mine", "b") == tmp_path / "mine/b"


@pytest.mark.slow
def test_companion_runs_are_not_written_through_a_link(tmp_path, monkeypatch):
    outside = tmp_path / "outside"
    outside.mkdir()
    scene = load.load_file("sims/tennis_racket.toml", ["time.end='1 s'", "output.error_bars=true"])
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "companion_runs").symlink_to(outside)
    with pytest.raises(ArchiveError, match="companion_runs is a link"):
        running.run_scene(scene, tmp_path / "run")
    assert not list(outside.iterdir())
    with pytest.raises(ArchiveError, match="companion_runs is a link"):
        running.resume(tmp_path / "run")
    assert not list(outside.iterdir())


def test_pilots_neither_write_nor_remove_through_a_link(tmp_path):
    outside, pilots = tmp_path / "outside", tmp_path / "pilots"
    scene, setting = load.load_file("sims/tennis_racket.toml"), Setting("pilot", "coarse", ())
    place = measuring.folder_of(pilots, scene, setting)
    (outside / place.name).mkdir(parents=True)
    (outside / place.name / "precious").write_text("x")
    pilots.mkdir()
    (pilots / "settings").symlink_to(outside)
    with pytest.raises(ArchiveError, match="settings is a link"):
        measuring.folder_of(pilots, scene, setting)
    assert (outside / place.name / "precious").exists()


def test_a_sweep_does_not_follow_the_link_of_its_members_pilots(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    outside = tmp_path / "outside"
    outside.mkdir()
    (tmp_path / "sweep").mkdir()
    (tmp_path / "sweep/member-0000-pilots").symlink_to(outside)
    (tmp_path / "s.toml").write_text(SWEEP)
    assert main(["run", "s.toml", "--output", "sweep"]) == 1
    assert "member-0000-pilots is a link" in capsys.readouterr().out
    assert not list(outside.iterdir())


def test_a_csv_may_begin_with_a_byte_order_mark(tmp_path):
    (tmp_path / "t.csv").write_text(f"mass,x,y,z\n{ROWS}", encoding="utf-8-sig")
    assert read_table(tmp_path / "t.csv").mass.tolist() == [1.0] * 4
    radius = np.linspace(1, 9, 12)
    rows = "\n".join(f"{r:.6g},{r**3:.9g},{9 - r:.3g}" for r in radius)
    (tmp_path / "p.csv").write_text(f"radius (km), mass (kg), omega (rad/s)\n{rows}\n", encoding="utf-8-sig")
    assert len(read_progenitor(tmp_path / "p.csv").mass) > 0
    (tmp_path / "p.csv").write_text(f"radius (km), mass (kg), omega (rad/s)\n{rows.replace('9,', '1_9,')}\n")
    with pytest.raises(SceneError, match="is not a number"):
        read_progenitor(tmp_path / "p.csv")


def test_a_number_with_underscores_is_none(tmp_path):
    (tmp_path / "t.csv").write_text(f"mass,x,y,z\n{ROWS}1_0,1,1,1\n")
    with pytest.raises(SceneError, match="row 5 is not numbers"):
        read_table(tmp_path / "t.csv")


@pytest.mark.parametrize("name", ["pipe.csv", "pipe.npz", "pipe.nc", "pipe.h5", "pipe.stl", "pipe.obj"])
def test_a_pipe_is_there_and_is_no_file(tmp_path, capsys, name):
    os.mkfifo(tmp_path / name)
    assert main(["moments", str(tmp_path / name)]) == 2
    assert "is not a file" in capsys.readouterr().err


def test_values_that_were_never_written_are_no_masses(tmp_path):
    with netcdf_file(tmp_path / "t.nc", "w") as file:
        file.createDimension("particle", 4)
        for name, values in zip(("mass", "x", "y", "z"), (np.ones(4), *np.eye(3, 4)), strict=True):
            file.createVariable(name, "f8", ("particle",))[:] = values
        file.variables["mass"][2] = 9.969209968386869e36  # which netCDF fills up with
    with pytest.raises(SceneError, match="mass of row 3 is not finite"):
        read_table(tmp_path / "t.nc")
