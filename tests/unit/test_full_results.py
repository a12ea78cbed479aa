"""The record of the long tests: what counts as done, and what makes it count no more."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests import full_results
from tests.full_results import FullResult, inputs_hash, is_done, result_path


def long_test(particles):
    assert particles > 0


def changed_test(particles):
    assert particles > 1


@pytest.fixture
def item(tmp_path, monkeypatch):
    monkeypatch.setattr(full_results, "RESULTS", tmp_path / "results")
    (tmp_path / "scene.toml").write_text("a = 1")
    marker = SimpleNamespace(kwargs={"inputs": [str(tmp_path / "scene.toml")]})
    return SimpleNamespace(
        function=long_test,
        name="long_test[3000]",
        path=Path("tests/physics/test_x.py"),
        nodeid="tests/physics/test_x.py::long_test[3000]",
        get_closest_marker=lambda name: marker if name == "full" else None,
    )


def report(outcome):
    return SimpleNamespace(outcome=outcome, duration=1.25, failed=outcome == "failed", longrepr="assert 1 == 2")


def test_a_passed_test_is_done_and_its_figures_are_kept(item):
    assert not is_done(item)
    result = FullResult(item)
    result(error=0.01, orders=[1.9, 2.0])
    result.write(report("passed"))
    content = json.loads(result_path(item).read_text())
    assert content["figures"] == {"error": 0.01, "orders": [1.9, 2.0]}
    assert content["test"] == item.nodeid
    assert is_done(item)


def test_a_failed_test_is_kept_but_not_done(item):
    FullResult(item).write(report("failed"))
    assert json.loads(result_path(item).read_text())["failure"] == "assert 1 == 2"
    assert not is_done(item)


@pytest.mark.parametrize("change", ["source", "parameters", "file"])
def test_changed_inputs_are_not_done(change, item, tmp_path):
    FullResult(item).write(report("passed"))
    before, path = inputs_hash(item), result_path(item)
    if change == "source":
        item.function = changed_test
    elif change == "parameters":
        item.name = "long_test[6000]"
    else:
        (tmp_path / "scene.toml").write_text("a = 2")
    assert inputs_hash(item) != before
    assert not is_done(item)
    assert path.exists()


def test_a_damaged_result_is_not_done(item):
    FullResult(item).write(report("passed"))
    result_path(item).write_text("{")
    assert not is_done(item)
