"""What all tests share: which of them are quick, and how the long ones keep their results."""

import sys
from pathlib import Path

import hypothesis
import pytest

from tests.full_results import FullResult, is_done

HERE = Path(__file__).parent

# The same examples everywhere, and no deadline: the machines that test are shared.
hypothesis.settings.register_profile("project", deadline=None, derandomize=True)
hypothesis.settings.load_profile("project")


def pytest_addoption(parser):
    parser.addoption("--again", action="store_true", help="run long tests that have passed before, too")


def pytest_collection_modifyitems(config, items):
    for item in items:
        folders = item.path.relative_to(HERE).parts
        if folders[0] == "unit" and not any(item.get_closest_marker(name) for name in ("slow", "full")):
            item.add_marker(pytest.mark.quick)
        if item.get_closest_marker("full") and not config.getoption("--again") and is_done(item):
            item.add_marker(
                pytest.mark.skip(
                    reason="takes minutes to hours and has passed before with the same inputs; "
                    "its figures are in tests/results, and --again repeats it"
                )
            )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if report.when == "call" and item.get_closest_marker("full"):
        item.stash.setdefault(FullResult.KEY, FullResult(item)).write(report)
    return report


@pytest.fixture(autouse=True, scope="module")
def _compiled_programs_are_released():
    """JAX keeps every compiled program of a process: gigabytes, by the end of all tests."""
    yield
    if "jax" in sys.modules:
        sys.modules["jax"].clear_caches()


@pytest.fixture
def result(request):
    """The record of a long test: call it with the figures that the test found; they are kept in tests/results."""
    return request.node.stash.setdefault(FullResult.KEY, FullResult(request.node))
