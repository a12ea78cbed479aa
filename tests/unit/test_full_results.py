"""The record of the long tests: which results are valid, and what makes them so no longer."""

import json
from datetime import UTC, datetime, timedelta
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests import full_results
from tests.full_results import FullResult, is_done, listed, processor, result_path, seconds, state, summary
from tests.imported_code import Code

TEST = "tests/physics/test_x.py"


@pytest.fixture
def item(tmp_path, monkeypatch):
    monkeypatch.setattr(full_results, "RESULTS", tmp_path / "tests" / "results")
    monkeypatch.setattr(full_results, "ROOT", tmp_path)
    monkeypatch.setattr(full_results, "code", lambda: Code(tmp_path))
    (tmp_path / TEST).parent.mkdir(parents=True)
    (tmp_path / TEST).write_text("def test_long(): assert True\n")
    (tmp_path / "scene.toml").write_text("a = 1")
    marker = SimpleNamespace(kwargs={"inputs": ["scene.toml"]})
    return SimpleNamespace(
        name="test_long[3000]",
        path=tmp_path / TEST,
        nodeid=f"{TEST}::test_long[3000]",
        get_closest_marker=lambda name: marker if name == "full" else None,
    )


def report(outcome):
    return SimpleNamespace(outcome=outcome, duration=1.25, failed=outcome == "failed", longrepr="assert 1 == 2")


def content_of(item):
    return json.loads(result_path(item).read_text())


def test_a_passed_test_is_done_and_its_figures_are_kept(item):
    assert not is_done(item)
    assert seconds(item) == float("inf")
    result = FullResult(item)
    result(error=0.01, orders=[1.9, 2.0])
    result.write(report("passed"))
    content = content_of(item)
    assert content["figures"] == {"error": 0.01, "orders": [1.9, 2.0]}
    assert content["test"] == item.nodeid
    assert content["state"] == state(content) == "valid"
    assert content["processor"] == processor()
    assert is_done(item)
    assert seconds(item) == 1.2


def test_a_result_of_a_test_of_the_same_name_in_another_folder_is_none(item, tmp_path):
    FullResult(item).write(report("passed"))
    elsewhere = TEST.replace("physics", "unit")
    other = SimpleNamespace(**vars(item) | {"nodeid": item.nodeid.replace(TEST, elsewhere)})
    assert result_path(other) == result_path(item)
    assert not is_done(other)
    assert seconds(other) == float("inf")
    assert listed([other])[0].startswith("stale: there is no such test")
    (tmp_path / elsewhere).parent.mkdir()
    (tmp_path / TEST).rename(tmp_path / elsewhere)  # moved: its result has to be moved, too, or it is run again
    assert state(content_of(item)) == "stale: there is no such test"


def test_a_failed_test_is_kept_but_not_done(item):
    FullResult(item).write(report("failed"))
    assert content_of(item)["failure"] == "assert 1 == 2"
    assert state(content_of(item)) == "failed"
    assert not is_done(item)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ("test", full_results.OTHER_CODE),
        ("scene", full_results.OTHER_CODE),
        ("no scene", full_results.OTHER_CODE),
        ("no test", full_results.GONE),
        ("processor", full_results.OTHER_PROCESSOR),
        ("kept before code was", full_results.OTHER_CODE),
    ],
)
def test_a_result_is_stale_once_what_it_was_found_with_changes(change, found, item, tmp_path):
    FullResult(item).write(report("passed"))
    content, path = content_of(item), result_path(item)
    if change == "test":
        (tmp_path / TEST).write_text("def test_long(): assert 1\n")
    elif change == "scene":
        (tmp_path / "scene.toml").write_text("a = 2")
    elif change == "no scene":
        (tmp_path / "scene.toml").unlink()
    elif change == "no test":
        (tmp_path / TEST).unlink()
    elif change == "processor":
        path.write_text(json.dumps(content | {"processor": "x86-64-v0"}))
    else:
        path.write_text(json.dumps({name: content[name] for name in content if name != "code"} | {"inputs": "b6a8"}))
    assert state(content_of(item)) == found
    assert not is_done(item)
    listed([item] if change != "no test" else [])
    assert content_of(item)["state"] == found  # the file no longer says "valid" either
    assert content_of(item)["outcome"] == "passed"


@pytest.mark.parametrize(
    ("options", "kept", "reason"),
    [
        ({}, "passed", "has passed with this code"),
        ({"--again": True}, "passed", None),
        ({}, "failed", None),
        ({"--at-most": 2.0}, "failed", None),
        ({"--at-most": 1.0}, "failed", "took more than 1 s"),
        ({"--at-most": 1.0}, None, "never ran"),
    ],
)
def test_of_the_chosen_tests_valid_ones_and_too_long_ones_are_skipped(options, kept, reason, item, request):
    conftest = request.config.pluginmanager.get_plugin(str(Path(__file__).parents[1] / "conftest.py"))
    item.add_marker = (skipped := []).append
    if kept:
        FullResult(item).write(report(kept))
    next(
        conftest.pytest_collection_finish(SimpleNamespace(items=[item], config=SimpleNamespace(getoption=options.get)))
    )
    assert [mark.name for mark in skipped] == ([] if reason is None else ["skip"])
    assert reason is None or reason in skipped[0].kwargs["reason"]


def test_a_marker_that_names_other_files_makes_the_test_run_again(item):
    FullResult(item).write(report("passed"))
    assert is_done(item)
    item.get_closest_marker("full").kwargs["inputs"] = []
    assert not is_done(item)


def test_the_list_names_state_age_and_duration(item):
    other = SimpleNamespace(**vars(item) | {"name": "test_other", "nodeid": f"{TEST}::test_other"})
    FullResult(item).write(report("passed"))
    earlier = (datetime.now(UTC) - timedelta(days=2)).isoformat()
    result_path(item).write_text(json.dumps(content_of(item) | {"date": earlier}))
    lines = listed([item, other])
    assert lines[0].split() == ["missing", other.nodeid]
    assert lines[1].split() == ["valid", "2.0", "days", "1.2", "s", item.nodeid]
    assert lines[2] == "kept results of full tests: 1 valid, 0 stale, 1 missing (`make test-status` lists them)"


def test_the_summary_counts_stale_results_of_all_kinds_as_stale():
    states = ["valid", full_results.OTHER_CODE, full_results.OTHER_PROCESSOR, "failed", "valid", full_results.GONE]
    assert summary(states).startswith("kept results of full tests: 2 valid, 3 stale, 1 failed (")


@pytest.mark.parametrize("text", ["{", "[]", '{"test": 1}'])
def test_a_damaged_result_is_not_done(text, item):
    FullResult(item).write(report("passed"))
    result_path(item).write_text(text)
    assert not is_done(item)


def test_the_processor_is_the_one_that_numba_compiles_for(monkeypatch):
    names = {"x86_64": ("x86-64", "x86-64-v3"), "aarch64": ("arm64", "arm64")}
    avx2 = "+sse4.2,+ssse3,+cx16,+popcnt,+avx2,+bmi,+bmi2,+f16c,+fma,+lzcnt,+movbe,-avx512f"
    for machine, (plain, with_avx2) in names.items():
        monkeypatch.setattr(full_results.platform, "machine", lambda machine=machine: machine)
        for features, expected in (("", plain), (avx2, with_avx2)):
            monkeypatch.setenv("NUMBA_CPU_FEATURES", features)
            assert processor.__wrapped__() == expected
    assert Path(full_results.RESULTS).parts[-2:] == ("tests", "results")
