"""The command line: what each command prints, writes and returns."""

import gc
import os
import re
import subprocess
import sys
import warnings
import zipfile
from contextlib import suppress
from pathlib import Path

import pytest

from astroinertia.cli import branch
from astroinertia.cli.main import main
from astroinertia.cli.stop import interruption_message, warnings_as_sentences
from astroinertia.errors import ArchiveError, ArchiveWarning, NumericalError, RunInterrupted
from astroinertia.storage.archive import SWEEP
from tests.sims import SIMS

ROOT = Path(__file__).parents[3]


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return tmp_path


def test_help_teaches_with_examples(capsys):
    with pytest.raises(SystemExit) as caught:
        main(["--help"])
    assert caught.value.code == 0
    printed = capsys.readouterr().out
    for command in ("new", "plan", "run", "resume", "show", "movie", "tradeoff", "moments", "ratios"):
        assert f"astroinertia {command} " in printed


@pytest.mark.parametrize(
    "command",
    [
        "new",
        "plan",
        "run",
        "resume",
        "show",
        "movie",
        "report",
        "view",
        "tradeoff",
        "moments",
        "ratios",
        "precession",
        "guide",
    ],
)
def test_every_command_has_an_example_that_parses(command, capsys):
    with pytest.raises(SystemExit):
        main([command, "--help"])
    helped = capsys.readouterr().out
    assert f"example: astroinertia {command} " in " ".join(helped.split())
    assert max(map(len, helped.splitlines())) <= 120


@pytest.mark.parametrize("command", ["run", "resume", "branch"])
def test_exit_codes_have_a_line_each(command, capsys):
    with pytest.raises(SystemExit):
        main([command, "--help"])
    lines = [line.split()[:1] for line in capsys.readouterr().out.partition("exit codes:\n")[2].splitlines()]
    assert [word for line in lines[:6] for word in line] == ["0", "1", "2", "3", "130", "128"]


@pytest.mark.parametrize(
    "arguments",
    [[], ["foo"], ["plan"], ["run", "a", "b"], ["plan", "a", "--set"], ["plan", "--bogus", "a"], ["show"], ["resume"],
     ["verify", "--mode", "xla"]],
)  # fmt: skip
def test_wrong_arguments_get_one_sentence(arguments, capsys):
    assert main(arguments) == 2
    caught = capsys.readouterr()
    assert caught.out == ""
    assert caught.err.count("\n") == 1
    assert caught.err.endswith(".\n")


def test_a_word_of_no_hard_case_lists_their_names(capsys):
    assert main(["verify", "--hard", "--only", "flat"]) == 2
    assert "no hard case; they are: one particle, " in capsys.readouterr().err


@pytest.mark.parametrize(("given", "meant"), [
    (["-o", "here"], "--output"), (["--out=here"], "--output"), (["--outptu", "here"], "--output"),
    (["--eror-bars"], "--error-bars"), (["--zzz"], None), (["other.toml"], None),
])  # fmt: skip
def test_an_option_that_a_command_does_not_have_is_refused_with_the_one_that_was_meant(given, meant, capsys):
    assert main(["run", "star.toml", *given]) == 2
    said = capsys.readouterr().err
    hint = f" (did you mean {meant}?)" if meant else ""
    assert said == (
        f"astroinertia: unrecognized arguments: {' '.join(given)}{hint}; `astroinertia run --help` says more.\n"
    )


@pytest.mark.parametrize(("given", "meant"), [
    (["precession", "Earth"], "--body Earth"), (["ratios", "Mars"], "--body Mars"),
    (["ratios", "--body", "Mars", "Phobos"], None),
])  # fmt: skip
def test_a_body_that_is_given_without_its_option_is_refused_with_it(given, meant, capsys):
    assert main(given) == 2
    hint = f" (did you mean {meant}?)" if meant else ""
    said = f"astroinertia: unrecognized arguments: {given[-1]}{hint}; `astroinertia {given[0]} --help` says more.\n"
    assert capsys.readouterr().err == said


def test_new_writes_a_scene_that_plans(elsewhere, capsys):
    assert main(["new", "star.toml"]) == 0
    assert main(["plan", "star.toml"]) == 0
    printed = capsys.readouterr().out
    assert "gravity" in printed
    assert "\nstar: A gas sphere" in printed
    absent = printed.partition("not listed, so absent from what is compiled and run\n")[2]
    assert absent and all(line.startswith("  ") for line in absent.splitlines())  # continued lines, too


@pytest.mark.parametrize("minutes", ["-1", "0", "nan", "2 h"])
def test_minutes_are_a_number_above_0_whether_they_are_used_or_not(minutes, elsewhere, capsys):
    assert main(["new", "star.toml"]) == 0
    assert main(["run", "star.toml", f"--minutes={minutes}"]) == 2
    assert f"argument --minutes: '{minutes}' is no number above 0" in capsys.readouterr().err
    assert not Path("runs").exists()


@pytest.mark.parametrize(
    "arguments",
    [("run", "star.toml", "--output", ""), ("run", ""), ("show", ""), ("compare", "a", "", "--plot", "b.png")],
)
def test_an_empty_path_is_not_the_folder_in_which_one_is(arguments, elsewhere, capsys):
    assert main(["new", "star.toml"]) == 0
    assert main([*arguments]) == 2
    assert ": the path is empty; " in capsys.readouterr().err
    assert sorted(path.name for path in Path().iterdir()) == ["star.toml"]


@pytest.mark.parametrize("command", ["run", "plan"])
def test_minutes_are_for_scenes_whose_settings_are_chosen(command, elsewhere, capsys):
    scene = (SIMS / "core_to_pulsar_scaling.toml").read_text()
    Path("one.toml").write_text(scene)
    Path("many.toml").write_text(f'{scene}\n[sweep]\n"body.radius" = ["1500 km", "1600 km"]\n')
    for file in ("one.toml", "many.toml"):
        assert main([command, file, "--minutes", "3"]) == 2
        assert "--minutes is for a scene whose settings are chosen" in capsys.readouterr().err
    assert main(["plan", str(SIMS / "tennis_racket.toml"), "--set", "accuracy=1e-3", "--minutes", "3"]) == 2
    assert "which `run` makes, and `plan` with --pilot alone" in capsys.readouterr().err
    assert not Path("runs").exists()


def test_a_sensitivity_is_of_one_process(elsewhere, capsys, monkeypatch):
    command = ["sensitivity", str(SIMS / "core_to_pulsar_scaling.toml"), "--by", "body.radius"]
    assert main([*command, "--coordinator", "host:1"]) == 2
    assert "unrecognized arguments: --coordinator" in capsys.readouterr().err
    monkeypatch.setenv("PMI_SIZE", "2")
    for number, sentences in (("0", 1), ("1", 0)):  # the first alone says it
        monkeypatch.setenv("PMI_RANK", number)
        assert main(command) == 2
        assert capsys.readouterr().err.count("are not shared out by MPI") == sentences
    assert not Path("runs").exists()


def test_options_that_would_do_nothing_are_refused(elsewhere, capsys):
    one = (SIMS / "core_to_pulsar_scaling.toml").read_text()
    Path("one.toml").write_text(one)
    Path("many.toml").write_text(f'{one}\n[sweep]\n"body.radius" = ["1500 km", "1600 km"]\n')
    for arguments, sentence in (
        (["plan", "one.toml", "--pilot"], "--pilot counts the steps of particles, or chooses the settings"),
        (["run", "many.toml", "--workers", "0"], "argument --workers: '0' is no whole number above 0"),
        (["run", "many.toml", "--workers", "2", "--cluster", "tcp://host:1"], "give one of the two"),
    ):
        assert main(arguments) == 2
        printed = capsys.readouterr()
        assert sentence in printed.err and printed.err.count("\n") == 1 and not printed.out
    assert not Path("runs").exists()


def test_examples_of_branches_are_of_runs_that_have_ended():
    """A branch without a time begins at the last state of its run, which has ended there, and needs another end."""
    examples = [line for line in branch.HELP.splitlines() if "branch runs/" in line]
    assert len(examples) == 3 and all("--at " in line or "time.end=" in line for line in examples)


def test_a_branch_of_a_sweep_is_led_to_its_members(elsewhere, capsys):
    Path("many").mkdir()
    Path("many", SWEEP).write_text("{}")
    assert main(["branch", "many", "--output", "other"]) == 2
    assert "branch one of its members, such as many/member-0000." in capsys.readouterr().err


def test_commands_that_are_suggested_can_be_copied_whatever_a_file_is_called(elsewhere, capsys):
    assert main(["new", "my star.toml"]) == 0
    assert capsys.readouterr().out.endswith("astroinertia plan 'my star.toml'\n")
    stopped = interruption_message(RunInterrupted(Path("runs/my star"), 0.0, 1.0, "Ctrl-C"))
    assert stopped.endswith("astroinertia resume 'runs/my star'")


def test_new_leaves_an_existing_file_alone(elsewhere, capsys):
    (elsewhere / "star.toml").write_text("mine")
    assert main(["new", "star.toml"]) == 2
    assert (elsewhere / "star.toml").read_text() == "mine"


def test_new_without_a_file_prints_what_it_would_write(elsewhere, capsys):
    assert main(["new"]) == 0
    printed = capsys.readouterr().out
    assert main(["new", "star.toml"]) == 0
    named = printed.replace('name = "rotating_star"', 'name = "star"         ')
    assert (elsewhere / "star.toml").read_text() == named != printed


def test_new_from_a_scene_copies_it(elsewhere, capsys):
    assert main(["new", "--from", "evrard", "cloud.toml"]) == 0
    evrard = (ROOT / "sims" / "evrard.toml").read_text()
    assert (elsewhere / "cloud.toml").read_text() == evrard.replace('name = "evrard"', 'name = "cloud"')
    assert "wrote cloud.toml" in capsys.readouterr().out
    assert main(["new", "--from", "evrad", "other.toml"]) == 2
    assert capsys.readouterr().err.endswith("there is no scene 'evrad' to copy; did you mean 'evrard'?\n")
    assert not (elsewhere / "other.toml").exists()
    with pytest.raises(SystemExit):
        main(["new", "--help"])
    helped = capsys.readouterr().out
    assert all(path.stem in helped for path in (ROOT / "sims").glob("*.toml") if path.stem != "progenitor_collapse")
    assert "progenitor_collapse" not in helped  # takes a table along


def test_plan_follows_overrides(elsewhere, capsys):
    main(["new", "star.toml"])
    assert main(["plan", "star.toml", "--set", "body.particles=4321", "--set", "effects.conduction={}"]) == 0
    printed = capsys.readouterr().out
    assert "4321" in printed
    assert re.search(r"^  conduction +artificial", printed, re.MULTILINE)


def test_plan_refuses_to_judge_by_what_is_no_series(elsewhere, capsys):
    main(["new", "star.toml"])
    assert main(["plan", "star.toml", "--set", "judged_by=['inertia_tensr z z']"]) == 2
    assert capsys.readouterr().err.endswith(
        "'inertia_tensr' is no series of the dataset; did you mean inertia_tensor?\n"
    )


def test_plan_refuses_effects_whose_options_contradict_each_other(elsewhere, capsys):
    """As a run does, before anything is made of the body."""
    main(["new", "star.toml"])
    assert main(["plan", "star.toml", "--set", "effects.viscosity={alpha_min=2.0}"]) == 2
    assert "[effects.viscosity] alpha_min must not be above alpha_max" in capsys.readouterr().err


def test_plan_writes_nothing_and_shows_markup_as_it_is(elsewhere, capsys):
    main(["new", "star.toml"])
    assert main(["plan", "star.toml", "--set", "description=[bold]not markup[/red]"]) == 0
    assert "[bold]not markup[/red]" in capsys.readouterr().out
    assert [path.name for path in elsewhere.iterdir()] == ["star.toml"]


def test_show_does_not_wait_for_a_pipe(elsewhere, capsys):
    os.mkfifo("pipe")
    assert main(["show", "pipe"]) == 2
    assert "neither a file nor a run folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (
            NumericalError("the state is no longer finite", "gravity", 0.25, 7),
            1,
            "effect gravity, time 0.25, particle 7",
        ),
        (ArchiveError("the folder holds another run."), 2, "another run"),
        (RunInterrupted("runs/x", 1.0, 4.0), 130, "25.0%"),
        (MemoryError(), 1, "memory"),
        (OSError(28, "No space left on device", "runs/x"), 1, "no space left"),
        (
            PermissionError("c is another user's: set ASTROINERTIA_CACHE"),
            1,
            "astroinertia: c is another user's: set AST",
        ),
    ],
)
def test_what_goes_wrong_in_a_run_gets_one_sentence(error, code, words, elsewhere, capsys, monkeypatch):
    import astroinertia.run.loop

    def run_scene(*_, **__):
        raise error

    monkeypatch.setattr(astroinertia.run.loop, "run_scene", run_scene)
    main(["new", "star.toml"])
    capsys.readouterr()
    assert main(["run", "star.toml"]) == code
    printed = capsys.readouterr().err
    assert words in printed
    assert printed.count("\n") == 1


@pytest.mark.filterwarnings("always::astroinertia.errors.ArchiveWarning")
def test_damage_is_said_once_however_often_a_command_comes_upon_it():
    """A run folder is read before its lock is taken, and again after that."""
    said = []
    with warnings_as_sentences(said.append):
        for name in ("manifest.json", "manifest.json", "segment-000001.npz"):
            warnings.warn(f"{name} is damaged", ArchiveWarning, stacklevel=1)
    assert said == ["manifest.json is damaged", "segment-000001.npz is damaged"]


@pytest.mark.parametrize("command", ["guide", "plan star.toml"])
def test_a_full_disk_behind_the_standard_output_is_said(command, elsewhere, capsys, monkeypatch):
    main(["new", "star.toml"])
    with suppress(OSError), Path("/dev/full").open("w") as full:  # which cannot be closed either
        monkeypatch.setattr(sys, "stdout", full)
        assert main(command.split()) == 1
    assert capsys.readouterr().err == "astroinertia: standard output: no space left on device.\n"


@pytest.mark.full
def test_a_closed_pipe_is_no_error(elsewhere):
    main(["new", "star.toml"])
    command = f"{sys.executable} -m astroinertia plan star.toml | true; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(
        ["bash", "-c", command],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=False,
    )
    assert done.returncode == 0
    assert done.stderr == ""


@pytest.mark.slow
def test_a_scene_runs_resumes_and_shows(elsewhere, capsys, monkeypatch):
    import xarray

    from astroinertia.cli import show
    from astroinertia.plots import pictures

    monkeypatch.setattr(show, "cores", lambda: 1)  # pictures by two processes are those of test_show.py
    monkeypatch.setattr(pictures, "FIGURES", {"inertia": pictures.FIGURES["inertia"]})  # all are drawn in test_plots.py
    settings = ["body.particles=64", "body.relax=false", "body.placement=lattice", "time.max_steps=3"]
    main(["new", "star.toml"])
    overrides = [part for setting in settings for part in ("--set", setting)]
    assert main(["run", "star.toml", *overrides]) == 0
    file = elsewhere / "runs" / "star" / "star.nc"
    with xarray.open_dataset(file) as opened:
        assert {"inertia_tensor", "virial_tensor"} <= set(opened.variables)
        assert list(opened["effect"].values) == ["gravity", "pressure", "viscosity"]
    before = file.read_bytes()
    assert main(["resume", "runs/star"]) == 0
    assert file.read_bytes() == before
    assert main(["run", "star.toml", *overrides]) == 2
    assert file.read_bytes() == before
    capsys.readouterr()
    assert main(["show", "runs/star", "--output", "pictures"]) == 0
    assert "star" in capsys.readouterr().out
    assert list((elsewhere / "pictures").glob("*.png"))


HEAVY = {"astropy", "diffrax", "jax", "matplotlib", "netCDF4", "numba", "scipy.integrate", "scipy.optimize",
         "scipy.special"}  # fmt: skip
LOADED = {
    "moments": ("main(['moments', 'table.csv'])", {"scipy.special"}),
    "ratios": ("main(['ratios', '--body', 'Mars'])", {"jax", "scipy.integrate", "scipy.optimize", "scipy.special"}),
    "show": ("from astroinertia import dataset, plots; plots.summary, plots.write_all, dataset.open",
             {"matplotlib", "netCDF4"}),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [pytest.param(command, marks=() if command in ("moments", "show") else pytest.mark.full) for command in LOADED],
)
def test_a_command_imports_only_what_it_uses(command, tmp_path):
    statement, needed = LOADED[command]
    (tmp_path / "table.csv").write_text("mass,x,y,z\n1,0,0,0\n1,1,0,0\n")
    program = (
        f"import sys; from astroinertia.cli.main import main; {statement};"
        f"open('loaded', 'w').write(' '.join({HEAVY} & set(sys.modules)))"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", program], capture_output=True, check=True, cwd=tmp_path, env=environment)
    assert set((tmp_path / "loaded").read_text().split()) <= needed


def test_help_does_not_wait_for_numpy():
    program = "import sys, astroinertia.cli.main; sys.exit('numpy' in sys.modules)"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    assert subprocess.run([sys.executable, "-c", program], env=environment).returncode == 0


def test_no_cycles_of_objects_are_looked_for_at_the_end_of_the_process(tmp_path):
    program = (
        "import gc; from astroinertia.__main__ import main; main();open('kept', 'w').write(str(gc.get_freeze_count()))"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", program, "guide"]
    subprocess.run(command, capture_output=True, check=True, cwd=tmp_path, env=environment)
    assert int((tmp_path / "kept").read_text()) > 10_000


def test_no_cycles_of_objects_are_looked_for_while_pictures_are_drawn(monkeypatch, tmp_path):
    from astroinertia import plots

    looked = []
    monkeypatch.setattr(plots, "summary", lambda *_: "", raising=False)
    monkeypatch.setattr(plots, "write_all", lambda *_, **__: looked.append(gc.isenabled()) or [], raising=False)
    assert main(["show", str(ROOT / "tests" / "data" / "format_1.nc"), "--output", str(tmp_path)]) == 0
    assert looked == [False]
    assert gc.isenabled()


def test_a_wheel_holds_the_package(tmp_path):
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)], check=True, cwd=ROOT
    )
    (wheel,) = tmp_path.glob("astroinertia-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        entry = next(name for name in names if name.endswith("entry_points.txt"))
        assert "astroinertia = astroinertia.__main__:main" in archive.read(entry).decode()
    every = (path for kind in ("py", "html", "js", "md") for path in (ROOT / "astroinertia").rglob(f"*.{kind}"))
    sources = {str(path.relative_to(ROOT)) for path in every}
    assert sources <= names
    assert not any(name.startswith(("tests/", "sims/")) for name in names)


def test_imports_run_downward_only():
    done = subprocess.run(
        [str(Path(sys.executable).parent / "lint-imports")], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
