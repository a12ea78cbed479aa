"""The cross-checks: their references, how a verdict comes about, and the command."""

import json
import math
from io import StringIO

import pytest
from rich.console import Console

from astroinertia.bodies import maclaurin
from astroinertia.cli import verify
from astroinertia.cli.main import main
from astroinertia.verify import comparison
from astroinertia.verify.comparison import BESIDE, SECTIONS, Verdict, compare, compare_section, compare_sections
from astroinertia.verify.references import Reference, references


def reference(value=2.0, tolerance=1e-3, measure="relative"):
    return Reference("polytropes", "key", "a quantity", "1", value, tolerance, measure, "why", "who")


def test_every_reference_has_a_section_a_source_and_a_reason():
    assert list(references()) == list(SECTIONS)
    rows = [row for section in references().values() for row in section]
    assert len({(row.section, row.key) for row in rows}) == len(rows)
    for row in rows:
        size = abs(row.value) if row.measure == "absolute" else 1.0
        assert 0 < row.tolerance < 0.1 * size, row.key
        assert len(row.quantity) > 0 and len(row.reason) > 4 and len(row.source) > 10, row.key
        assert row.measure != "below" or row.value == 0.0, row.key
        assert row.measure != "relative" or row.value != 0.0, row.key


@pytest.mark.parametrize(
    ("measure", "found", "difference", "verdict"),
    [
        ("relative", 2.001, 5e-4, Verdict.AGREES),
        ("relative", 1.997, -1.5e-3, Verdict.DIFFERS),
        ("absolute", 2.0015, 1.5e-3, Verdict.DIFFERS),
        ("absolute", 2.0005, 5e-4, Verdict.AGREES),
        ("below", 5e-4, 5e-4, Verdict.AGREES),
        ("below", 2e-3, 2e-3, Verdict.DIFFERS),
        ("relative", (4.0, 4.0), 0.0, Verdict.AGREES),  # beside: its own other side, not the table's
        ("relative", (4.0, 0.0), math.nan, Verdict.DIFFERS),
        ("absolute", math.nan, math.nan, Verdict.DIFFERS),
        ("absolute", math.inf, math.inf, Verdict.DIFFERS),
        ("relative", None, math.nan, Verdict.FAILED),
    ],
)
def test_a_verdict_follows_from_the_difference(measure, found, difference, verdict):
    result = compare(reference(measure=measure), found)
    assert result.verdict == verdict
    assert result.difference == pytest.approx(difference, rel=1e-9, nan_ok=True)


def test_a_section_that_holds():
    section = compare_section("ellipsoids")
    assert section.holds
    assert {each.reference.key for each in section.comparisons} == {row.key for row in references()["ellipsoids"]}


def test_a_wrong_number_fails_the_command_and_is_named(monkeypatch, capsys):
    wrong = maclaurin.from_eccentricity(0.8127)
    monkeypatch.setattr(maclaurin, "bifurcation", lambda: wrong)
    assert main(["verify", "--only", "ellipsoids"]) == 1
    printed = capsys.readouterr().out
    differing = [line for line in printed.splitlines() if line.rstrip().endswith("differs")]
    assert len(differing) == 2  # T/|W| is printed to too few digits to tell
    assert "branch off" in differing[0] and "0.8127" in differing[0]
    assert printed.splitlines()[-1].startswith("15 of 17 agree")


def test_what_cannot_be_computed_is_reported_and_stops_nothing_else(monkeypatch, capsys):
    def broken():
        raise ValueError("a root was lost")

    monkeypatch.setattr(maclaurin, "bifurcation", broken)
    assert main(["verify", "--only", "ellipsoids", "--json"]) == 1
    content = json.loads(capsys.readouterr().out)
    lost = [row for row in content["comparisons"] if row["verdict"] == "not computed"]
    assert len(lost) == 8  # all that maclaurin_points would have found
    assert all(row["problem"] == "ValueError: a root was lost" and row["here"] is None for row in lost)
    assert not content["agree"]
    assert len(content["comparisons"]) == 17


def test_a_missing_part_is_a_verdict_not_a_traceback(monkeypatch):
    monkeypatch.setitem(comparison.SECTIONS, "ellipsoids", "a title")
    monkeypatch.setattr(comparison.importlib, "import_module", lambda name: (_ for _ in ()).throw(ImportError(name)))
    section = compare_section("ellipsoids")
    assert all(each.verdict == Verdict.FAILED and "verify.ellipsoids" in each.problem for each in section.comparisons)


def test_a_process_that_fails_is_a_verdict_not_a_traceback(monkeypatch):
    monkeypatch.setattr(comparison.sys, "executable", "false")
    heard = []
    constants, *beside = compare_sections([*BESIDE, "constants"], heard.append)
    assert heard == [SECTIONS["constants"], " and ".join(SECTIONS[name] for name in BESIDE)]
    assert constants.holds and [section.name for section in beside] == list(BESIDE)
    assert {(each.verdict, each.problem) for section in beside for each in section.comparisons} == {
        (Verdict.FAILED, "its process ended with 1")
    }


def test_json_tells_reasons_and_the_other_side(capsys):
    assert main(["verify", "--only", "constants", "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["agree"] is True
    rows = {row["key"]: row for row in content["comparisons"]}
    assert rows["earth_radius"]["here"] == 6378136.6
    assert rows["earth_radius"]["reference"] == 6378100.0
    assert rows["earth_radius"]["difference"] == pytest.approx(36.6 / 6378100)
    assert "digits" in rows["earth_radius"]["reason"]


@pytest.mark.parametrize("width", [80, 110, 150])
def test_the_table_fits_and_keeps_its_verdicts(width):
    section = compare_section("constants")
    stream = StringIO()
    Console(file=stream, width=width).print(verify.table(section, width))
    lines = stream.getvalue().splitlines()
    assert max(map(len, lines)) <= width
    assert sum(line.rstrip().endswith("agrees") for line in lines) == len(section.comparisons)
    assert "IAU 2012" in stream.getvalue()


def test_a_section_there_is_not_is_refused_in_a_sentence(capsys):
    assert main(["verify", "--only", "astrology"]) == 2
    caught = capsys.readouterr()
    assert "no section 'astrology'" in caught.err and "polytropes" in caught.err
    assert caught.out == ""
