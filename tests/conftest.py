"""What all tests share: which of them are quick, and how the long ones keep their results."""

import gc
import os
import sys
from pathlib import Path

import hypothesis
import pytest
from numba.core.targetconfig import TargetConfig

from tests.full_results import FullResult, is_done

HERE = Path(__file__).parent
LARGE = 2.5e9  # bytes of a process

# The same examples everywhere, and no deadline: the machines that test are shared.
hypothesis.settings.register_profile("project", deadline=None, derandomize=True)
hypothesis.settings.load_profile("project")

# To compile is to make very many objects that stay: to look through them as often as usual takes a tenth of the time.
gc.set_threshold(50_000, 20, 100)


def _values(config):
    """All options of how numba compiles, set ones over those of the class: what TargetConfig.values tells, sooner."""
    kind = type(config)
    if kind not in DEFAULTS:
        DEFAULTS[kind] = {name: option.default for name, option in kind.options.items()}
    return DEFAULTS[kind] | config._values


# Numba asks for them half a million times for the programs of one scene, by a property each: 8 % of compiling.
DEFAULTS = {}
TargetConfig.values = _values


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
    """JAX keeps every compiled program of a process: gigabytes, by the end of all tests.

    Small ones serve many test files: all are released only when they have become many.
    """
    yield
    if "jax" in sys.modules and _resident_size() > LARGE:
        sys.modules["jax"].clear_caches()


def _resident_size():
    """Bytes of memory that this process holds; infinite where the system does not tell."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return float("inf")


@pytest.fixture
def result(request):
    """The record of a long test: call it with the figures that the test found; they are kept in tests/results."""
    return request.node.stash.setdefault(FullResult.KEY, FullResult(request.node))
