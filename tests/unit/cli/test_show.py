"""The pictures of `show`: those of particles are drawn by a second process where there is a second core."""

import subprocess
import sys
from contextlib import contextmanager

import pytest
import xarray as xr

import astroinertia
from astroinertia.cli import result, show
from astroinertia.cli.main import main
from astroinertia.pages import report, view
from astroinertia.plots import movie, pictures
from astroinertia.process import children
from tests.sims import SIMS

SERIES, PARTICLES = ["inertia", "spin"], ["density", "projection"]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    settings = ["body.particles=64", "body.relax=false", "body.placement=lattice", "time.max_steps=3"]
    overrides = [part for setting in settings for part in ("--set", setting)]
    main(["new", str(folder / "star.toml")])
    assert main(["run", str(folder / "star.toml"), *overrides, "--output", str(folder / "star")]) == 0
    return folder / "star"


def shown(run, folder, capsys):
    """The names that are printed, in their order, and the pictures' bytes."""
    capsys.readouterr()
    assert main(["show", str(run), "--output", str(folder)]) == 0
    printed = [line.rsplit("/")[-1].removesuffix(".png") for line in capsys.readouterr().out.splitlines()]
    return printed[printed.index("pictures:") + 1 :], {path.stem: path.read_bytes() for path in folder.glob("*.png")}


@pytest.mark.full
def test_two_processes_draw_the_pictures_that_one_draws(run, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(pictures, "FIGURES", {name: pictures.FIGURES[name] for name in SERIES})
    monkeypatch.setattr(show, "cores", lambda: 1)
    names, alone = shown(run, tmp_path / "one", capsys)
    assert names == SERIES + PARTICLES
    assert sorted(names) == sorted(alone)
    monkeypatch.setattr(show, "cores", lambda: 2)
    drawn_here, draw = [], pictures.figures

    def heard(*arguments):
        for name, figure in draw(*arguments):
            drawn_here.append(name)
            yield name, figure

    monkeypatch.setattr(pictures, "figures", heard)
    again, both = shown(run, tmp_path / "two", capsys)
    assert (again, both) == (names, alone)
    assert drawn_here == SERIES


@pytest.mark.full
def test_where_the_second_process_fails_the_first_draws_all(run, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(pictures, "FIGURES", {"spin": pictures.FIGURES["spin"]})
    monkeypatch.setattr(show, "cores", lambda: 2)

    @contextmanager
    def killed(command):
        program = [sys.executable, "-c", "import os; print('  density.png', flush=True); os.kill(os.getpid(), 9)"]
        with subprocess.Popen(program, stdout=subprocess.PIPE, text=True) as child:
            yield child

    monkeypatch.setattr(children, "started", killed)
    assert shown(run, tmp_path, capsys)[0] == ["spin", *PARTICLES]


@pytest.mark.slow
def test_one_picture_may_be_asked_for_alone(run, tmp_path, capsys):
    capsys.readouterr()
    assert main(["show", str(run), "--output", str(tmp_path), "--only", "spin"]) == 0
    assert capsys.readouterr().out.splitlines() == ["pictures:", f"  {tmp_path / 'spin.png'}"]
    assert [path.name for path in tmp_path.iterdir()] == ["spin.png"]
    assert main(["show", str(run), "--output", str(tmp_path), "--only", "spin", "--only", "attitude"]) == 0
    assert capsys.readouterr().out.splitlines()[1:] == [
        f"  {tmp_path / 'spin.png'}",
        "this run has no picture attitude.",
    ]
    assert main(["show", str(run), "--only", "spni"]) == 2
    assert "no picture 'spni'" in capsys.readouterr().err


def test_the_command_knows_the_pictures_of_particles_without_importing_what_draws_them():
    assert show.OF_PARTICLES == pictures.OF_PARTICLES


@pytest.mark.slow
@pytest.mark.parametrize(("command", "output", "sentence"), [
    ("show", "taken", "the folder taken cannot be made: it is a file"),
    ("report", "page.txt", "page.txt cannot be written: it must be a .html file in a folder that is there"),
    ("view", "taken", "taken cannot be written: it must be a .html file in a folder that is there"),
])  # fmt: skip
def test_what_is_no_place_for_a_picture_or_a_page_is_refused(
    command, output, sentence, run, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(show, "cores", lambda: 1)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").touch()
    capsys.readouterr()
    assert main([command, str(run), "--output", output]) == 2
    assert capsys.readouterr().err == f"astroinertia: {sentence}.\n"
    assert [path.name for path in tmp_path.iterdir()] == ["taken"] and not (tmp_path / "taken").read_bytes()


@pytest.mark.parametrize("options", [["--only", "spin"], ["--output", "pictures"]])
def test_options_of_pictures_are_not_for_a_whole_sweep(options, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = (SIMS / "core_to_pulsar_scaling.toml").read_text()
    (tmp_path / "two.toml").write_text(f'{scene}\n[sweep]\n"body.radius" = ["1500 km", "1600 km"]\n')
    assert main(["run", "two.toml", "--set", "time.end='5 ms'", "--workers", "1", "--output", "two"]) == 0
    assert main(["show", "two", *options]) == 2
    assert "--only and --output are of the pictures of one run: add --member N" in capsys.readouterr().err
    assert not (tmp_path / "pictures").exists()


@pytest.mark.slow
@pytest.mark.parametrize("command", [["show"], ["report"], ["compare", "{run}"]])
def test_a_file_of_several_runs_is_refused_in_a_sentence(command, run, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    one = astroinertia.open(run)
    xr.concat([one, one], "mass_of_star").to_netcdf(tmp_path / "both.nc")
    xr.concat([one, one], "member").assign_attrs(sweep="list").to_netcdf(tmp_path / "sweep.nc")
    words = [word.format(run=run) for word in command]
    assert main([*words, "both.nc"]) == 2
    said = capsys.readouterr().err
    assert f"both.nc holds several runs along mass_of_star, and `{command[0]}` takes one: write each to a file" in said
    assert main([*words, "sweep.nc"]) == 2
    assert f"sweep.nc is of a sweep, and `{command[0]}` takes one run: give the folder of a member" in (
        capsys.readouterr().err
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == ["both.nc", "sweep.nc"]


@pytest.mark.parametrize("command", ["show", "report", "view", "movie"])
def test_a_folder_of_somebody_else_is_said_before_anything_is_drawn(command, run, capsys, monkeypatch):
    def drawn(*_, **__):
        raise AssertionError("it is drawn")

    monkeypatch.setattr(show, "cores", lambda: 1)
    monkeypatch.setattr(result.os, "access", lambda *_: False)
    for module, name in ((pictures, "figures"), (view, "write_view"), (report, "write_report"), (movie, "write_movie")):
        monkeypatch.setattr(module, name, drawn)
    capsys.readouterr()
    assert main([command, str(run)]) == 2
    printed = capsys.readouterr()
    assert printed.err == f"astroinertia: nothing may be written to {run}: give --output, elsewhere.\n"
    assert ("ledger closure" in printed.out) is (command == "show")  # its summary needs no place
