"""A run whose ledger or energy does not close says so: in its file, while it goes, in its summary and exit code."""

from io import StringIO

import numpy as np
import pytest
from rich.console import Console

import astroinertia
from astroinertia import plots
from astroinertia.cli.main import main
from astroinertia.dataset.bounds import CLOSURE, ENERGY, MISMATCH, doubtful, ledger_warnings, message
from astroinertia.effects.kinds import companions
from astroinertia.gravity import point_masses
from astroinertia.run.loop import Progress
from astroinertia.run.meter import Meter
from tests.sims import SIMS

EFFECTS = ("gravity", "companions")


def records(closure=1e-13, mismatch=1e-4, energy=5e-3) -> dict[str, np.ndarray]:
    """Of three outputs, the figures in the middle one; energies are 2 at most."""
    peak = np.array([0.0, 1.0, 0.0])
    return {
        "ledger_closure": np.array([0.0, closure, 0.0]),
        "virial_mismatch": np.outer(peak, [1e-15, mismatch]),
        "integration_energy_error": -2.0 * energy * peak,
        "kinetic_energy": np.array([1.0, 1.0, 0.5]),
        "gravitational_energy": np.array([-1.0, -2.0, -1.0]),
        "internal_energy": np.full(3, np.nan),
    }


def test_what_shipped_scenes_and_models_without_a_ledger_record_is_no_doubt():
    assert ledger_warnings(records(), EFFECTS) == []
    assert ledger_warnings({name: np.full_like(array, np.nan) for name, array in records().items()}, EFFECTS) == []
    assert ledger_warnings({}, EFFECTS) == []


def test_a_body_on_which_nothing_acts_is_no_doubt():
    nothing = {"virial_mismatch": np.zeros((3, 0)), "virial_tensor": np.zeros((3, 0, 3, 3))}
    assert ledger_warnings(records() | nothing, ()) == []


@pytest.mark.parametrize("unit", [1e-30, 1e30])
def test_warnings_do_not_depend_on_the_unit_of_energies(unit):
    lost = records(energy=2 * ENERGY)
    other = {name: values / unit if "energy" in name else values for name, values in lost.items()}
    assert ledger_warnings(other, EFFECTS) == ledger_warnings(lost, EFFECTS) != []


def test_a_body_whose_shape_is_rounded_away_gets_no_advice_to_take_shorter_steps():
    second = np.array([0.4, 0.2, 0.2])[:, None, None] * np.eye(3)
    away = np.outer([1.0, 0.5, 0.0], np.full(3, 4e7))  # it comes nearer
    far = {"mass": np.full(3, 0.3), "second_moment": second, "centre_of_mass": away}
    (sentence,) = ledger_warnings(records(closure=97.0) | far, EFFECTS)
    assert "the body is 3.5e+07 of its sizes from the origin" in sentence and "shorter" not in sentence
    (sentence,) = ledger_warnings(records(closure=97.0) | far | {"centre_of_mass": 0.01 * away}, EFFECTS)
    assert "take shorter time steps" in sentence


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"closure": 97.0}, ("does not close", "97")),
        ({"closure": 2 * CLOSURE}, ("does not close", "2e-06")),
        ({"closure": np.inf}, ("does not close", "inf")),
        ({"mismatch": 475.0}, ("virial tensor of companions is off by 4.8e+02",)),
        ({"mismatch": 2 * MISMATCH}, ("virial tensor of companions",)),
        ({"energy": 2 * ENERGY}, ("lost or made 0.1 of the largest energy",)),
    ],
)
def test_each_figure_beyond_its_bound_is_named(change, words):
    (sentence,) = ledger_warnings(records(**change), EFFECTS)
    assert all(word in sentence for word in words)
    assert message({"ledger_warnings": sentence}, "ledger") == f"warning: {sentence}"


@pytest.mark.parametrize(("done", "named"), [([0.01, -0.19], True), ([-0.19, -0.19], False), ([0.01, -0.15], False)])
def test_an_effect_whose_work_is_all_that_is_missing_is_named_and_shorter_steps_are_not(done, named):
    """Of an energy error of 0.2 in the middle; half of the work has gone into heat."""
    rows = np.outer([0.0, 0.5, 0.1], done)
    (sentence,) = ledger_warnings(records(energy=0.1) | {"work": rows, "heating": rows}, EFFECTS)
    assert ("what companions has done, with no energy that makes up for it" in sentence) == named
    assert ("take shorter time steps" in sentence) != named


def test_a_virial_tensor_of_nothing_but_zeros_is_judged():
    """As that of an effect of one's own whose part `virial` gives 0 whatever its forces are."""
    tensors = np.einsum("te,ij->teij", np.outer(np.ones(3), [1.0, 0.0]), np.eye(3))
    (sentence,) = ledger_warnings(records(mismatch=0.4) | {"virial_tensor": tensors}, EFFECTS)
    assert "the virial tensor of companions is off by 0.4" in sentence
    assert ledger_warnings(records(mismatch=0.0) | {"virial_tensor": tensors}, EFFECTS) == []


@pytest.mark.parametrize(("share", "sentences"), [(1e-10, 0), (1e-3, 1)])
def test_forces_that_cancel_to_nothing_are_not_judged(share, sentences):
    tensors = np.einsum("te,ij->teij", np.outer(np.ones(3), [1.0, share]), np.eye(3))
    assert len(ledger_warnings(records(mismatch=0.01) | {"virial_tensor": tensors}, EFFECTS)) == sentences
    unknown = np.full_like(tensors, np.nan)
    assert len(ledger_warnings(records(mismatch=0.01) | {"virial_tensor": unknown}, EFFECTS)) == 1


@pytest.mark.parametrize(
    ("closure", "error", "expected"),
    [
        (1e-12, 1e-2, ""),
        (np.nan, np.nan, ""),
        (1.0, 1e-2, "ledger NOT CLOSED"),
        (1.0, 0.2, "ledger and energy NOT CLOSED"),
    ],
)
def test_the_line_of_a_run_says_it_at_once(closure, error, expected):
    assert doubtful(closure, error) == expected
    stream = StringIO()
    Meter(Console(file=stream, width=300)).tell(Progress(0.0, 1.0, 7, 1.0, error, closure, 1.0))
    assert ("NOT CLOSED" in stream.getvalue()) == bool(expected) and expected in stream.getvalue()


@pytest.fixture
def wrong_inside(monkeypatch):
    """The virial tensor of a companion within the star is made wrong."""

    def virial(xp, weight, position, centre, mass, place, *rest):
        found = point_masses.virial(xp, weight, position, centre, mass, place, *rest)
        return 100.0 * found if xp.sum((place - centre) ** 2) < 1e-6 else found

    monkeypatch.setattr(companions, "virial", virial)


@pytest.mark.slow
def test_a_run_ends_with_the_exit_code_of_a_ledger_that_does_not_close(tmp_path, capsys, wrong_inside):
    settings = ("body.particles=64", "body.relax=false", "body.placement=lattice", "time.max_steps=3")
    changed = [part for setting in settings for part in ("--set", setting)]
    command = ["run", str(SIMS / "star_and_companion.toml"), *changed]
    assert main([*command, "--output", str(tmp_path / "apart")]) == 0
    capsys.readouterr()
    inside = tmp_path / "inside"
    assert main([*command, "--set", "companions.0.semi_major_axis=1e-10", "--output", str(inside)]) == 3
    assert "virial tensor of companions is off by" in capsys.readouterr().out
    opened = astroinertia.open(inside)
    assert float(opened.virial_mismatch.sel(effect="companions").max()) > 1.0
    assert opened.attrs["ledger_warnings"] in plots.summary(opened).replace("warning: ", "")
    assert main(["resume", str(inside)]) == 3


@pytest.mark.full(inputs=["sims/star_and_companion.toml"])
def test_a_sweep_names_the_member_whose_ledger_does_not_close(tmp_path, capsys, wrong_inside):
    scene = (SIMS / "star_and_companion.toml").read_text()
    (tmp_path / "sweep.toml").write_text(
        scene.replace("particles = 500", 'particles = 64\nrelax = false\nplacement = "lattice"')
        .replace("end = 30.0", "max_steps = 3\nend = 30.0")
        .replace("[[companions]]", '[sweep]\n"companions.0.semi_major_axis" = [4.0, 1e-10]\n[[companions]]')
    )
    folder = tmp_path / "run"
    assert main(["run", str(tmp_path / "sweep.toml"), "--workers", "1", "--output", str(folder)]) == 3
    warning = "warning: member-0001: the virial tensor of companions is off by"
    printed = capsys.readouterr().out
    assert warning in printed and "member-0000: the" not in printed
    assert main(["show", str(folder)]) == 0
    assert warning in capsys.readouterr().out
    assert main(["resume", str(folder)]) == 3


@pytest.mark.parametrize("command", ["run", "resume"])
def test_help_says_what_the_exit_code_means(command, capsys):
    with pytest.raises(SystemExit):
        main([command, "--help"])
    assert "3 it has ended, and its file is written, but its ledger" in " ".join(capsys.readouterr().out.split())
