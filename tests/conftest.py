"""What all tests share: which of them are quick, and how the long ones keep their results."""

import gc
import os
import sys
from pathlib import Path

import hypothesis
import pytest

from astroinertia.process import kept_programs
from astroinertia.sph import rung_costs
from tests import few_with_steps, full_results
from tests.full_results import FullResult

HERE = Path(__file__).parent
LARGE = 2.5e9  # bytes of a process

# As the command line does, and before anything imports JAX.
kept_programs.keep_apart()

# The same examples everywhere, and no deadline: the machines that test are shared.
hypothesis.settings.register_profile("project", deadline=None, derandomize=True)
hypothesis.settings.load_profile("project")

# To compile is to make very many objects that stay: to look through them as often as usual takes a tenth of the time.
gc.set_threshold(50_000, 20, 100)


def pytest_addoption(parser):
    parser.addoption("--again", action="store_true", help="run long tests whose results are valid, too")
    parser.addoption(
        "--at-most",
        type=float,
        metavar="SECONDS",
        help="of the long tests only those that took no longer when last run",
    )
    parser.addoption("--kept", action="store_true", help="say at the end how many results of long tests are valid")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    for item in items:
        folders = item.path.relative_to(HERE).parts
        if folders[0] == "unit" and not any(item.get_closest_marker(name) for name in ("slow", "full")):
            item.add_marker(pytest.mark.quick)


@pytest.hookimpl(wrapper=True)
def pytest_collection_finish(session):
    # Only now, of the tests that were chosen: to find what a long test depends on is to read much code.
    longest, again = session.config.getoption("--at-most"), session.config.getoption("--again")
    for item in session.items:
        if item.get_closest_marker("full"):
            if not again and full_results.is_done(item):
                item.add_marker(pytest.mark.skip(reason="has passed with this code; --again repeats it"))
            elif longest is not None and full_results.seconds(item) > longest:
                item.add_marker(pytest.mark.skip(reason=f"took more than {longest:g} s when it last ran, or never ran"))
    return (yield)


def pytest_terminal_summary(terminalreporter, config):
    if config.getoption("--kept"):
        states = [full_results.state(content) for _, content in full_results.kept()]
        terminalreporter.write_line(full_results.summary(states))


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
def float64():
    """JAX computes in 64 bits."""
    import jax  # only here: most tests do without

    with jax.enable_x64(True):
        yield


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    """What is kept between runs is kept for this test alone."""
    monkeypatch.setenv("ASTROINERTIA_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """An empty folder as the working one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def steps_differ(monkeypatch):
    """Few particles have steps of their own where many would (tests/few_with_steps.py)."""
    for name, value in few_with_steps.CHOICE.items():
        monkeypatch.setattr(rung_costs, name, value)


@pytest.fixture
def result(request):
    """The record of a long test: call it with the figures that the test found; they are kept in tests/results."""
    return request.node.stash.setdefault(FullResult.KEY, FullResult(request.node))
