"""Hard cases: a case that is not stable is reported as such, also by the command."""

import json
from dataclasses import replace

import pytest

from astroinertia.cli.main import main
from astroinertia.verify.hard import CASES
from astroinertia.verify.hard.case import tried

QUIET = CASES["eight particles"]


def test_there_are_sixty_hard_cases_and_each_says_what_stable_means():
    assert len(CASES) >= 60
    assert all(len(case.stable) > 10 for case in CASES.values())


@pytest.mark.parametrize("figure", ["energy", "momentum"])
def test_a_figure_above_its_bar_is_not_stable(figure):
    verdict = tried(replace(QUIET, bars={figure: -1.0}), "global")
    assert not verdict.holds and not verdict.error


def test_a_case_that_should_have_been_refused_or_that_ends_early_is_not_stable():
    assert not tried(replace(QUIET, ends="no smoothing length"), "global").holds
    ended = tried(replace(CASES["one particle"], ends=""), "global")
    assert not ended.holds and "no smoothing length is long enough" in ended.error


def test_the_command_tells_figures_and_says_no_to_names_there_are_not(capsys):
    assert main(["verify", "--hard", "--only", "eight particles", "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["stable"] and [row["mode"] for row in content["cases"]] == ["global", "individual"]
    assert main(["verify", "--hard", "--only", "eight particles", "--mode", "global"]) == 0
    assert "1 of 1 are stable" in capsys.readouterr().out
    assert main(["verify", "--hard", "--only", "no such case"]) == 2
