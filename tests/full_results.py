"""Results of the long tests (marked full), one JSON file each in tests/results, so that none runs twice for nothing.

A result is valid where its file says that the test passed with the code and on the kind of processor that are here now:
the code is all that the test's file can run (tests/imported_code.py) and the files that the test's marker names, as in
`@pytest.mark.full(inputs=["sims/evrard.toml"])`. Any other result is stale. `python -m tests.full_results` lists the
states of all, and writes each into its file.
"""

import contextlib
import functools
import io
import json
import os
import platform
import re
import sys
from collections import Counter
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.imported_code import Code

ROOT = Path(__file__).parent.parent
RESULTS = ROOT / "tests" / "results"
VALID, MISSING = "valid", "missing"
OTHER_CODE, OTHER_PROCESSOR = "stale: the code has changed", "stale: another kind of processor"
GONE = "stale: there is no such test"
# The levels of the x86-64 psABI, by what LLVM names their features.
LEVELS = {
    "x86-64-v4": ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
    "x86-64-v3": ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"),
    "x86-64-v2": ("cx16", "popcnt", "sse4.2", "ssse3"),
}


class FullResult:
    """What a long test found: `result(error=..., order=...)` adds figures, plain numbers, texts, or lists of them."""

    KEY = pytest.StashKey["FullResult"]()

    def __init__(self, item):
        self.item = item
        self.figures = {}

    def __call__(self, **figures):
        self.figures.update(json.loads(json.dumps(figures, default=float)))

    def write(self, report):
        inputs = inputs_of(self.item)
        content = {
            "test": self.item.nodeid,
            "outcome": report.outcome,
            "state": VALID if report.outcome == "passed" else report.outcome,
            "figures": self.figures,
            "seconds": round(report.duration, 1),
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
            "inputs": inputs,
            "code": digest(self.item.nodeid, inputs),
            "processor": processor(),
            "python": platform.python_version(),
            "cores": os.cpu_count(),
        }
        if report.failed:
            crash = getattr(report.longrepr, "reprcrash", None)
            content["failure"] = str(crash.message if crash else report.longrepr)[:1000]
        _write(result_path(self.item), content)


def is_done(item) -> bool:
    """Whether the test has passed with this code on this kind of processor."""
    content = _content(item)
    return content.get("inputs") == inputs_of(item) and state(content) == VALID


def state(content: dict) -> str:
    """Whether a kept result holds here and now, and why not."""
    if not content:
        return MISSING
    if content.get("outcome") != "passed":
        return str(content.get("outcome"))
    if not (ROOT / content["test"].partition("::")[0]).is_file():
        return GONE
    inputs = content.get("inputs")
    if not (inputs is None or isinstance(inputs, list)) or content.get("code") != digest(content["test"], inputs):
        return OTHER_CODE
    return VALID if content.get("processor") == processor() else OTHER_PROCESSOR


def digest(test: str, inputs: list[str] | None) -> str | None:
    """A hash of all code and data that a test, by its node, depends on; None where a file of its inputs is no more."""
    try:
        return code().digest(test.partition("::")[0], None if inputs is None else tuple(inputs))
    except FileNotFoundError:
        return None


@functools.cache
def code() -> Code:
    """The code of this checkout, read once."""
    return Code(ROOT)


@functools.cache
def processor() -> str:
    """The kind of processor that numba compiles for here, its variables obeyed: x86-64-v3, arm64, ..."""
    from llvmlite.binding import get_host_cpu_features

    machine = platform.machine().lower()
    if machine not in ("x86_64", "amd64"):
        return {"aarch64": "arm64"}.get(machine, machine)
    asked = os.environ.get("NUMBA_CPU_FEATURES")
    if asked is not None:
        features = {name[1:] for name in asked.split(",") if name.startswith("+")}
    else:
        generic = os.environ.get("NUMBA_CPU_NAME") == "generic"
        features = set() if generic else {name for name, has in get_host_cpu_features().items() if has}
    for index, level in enumerate(LEVELS):
        if all(features.issuperset(LEVELS[below]) for below in list(LEVELS)[index:]):
            return level
    return "x86-64"


def result_path(item) -> Path:
    """Where a test's result is kept: its file and name, made fit for a file name."""
    return RESULTS / f"{item.path.stem}-{re.sub(r'[^A-Za-z0-9.]+', '-', item.name).strip('-')}.json"


def inputs_of(item) -> list[str] | None:
    """The files that the test's marker names; None where it says nothing of files."""
    inputs = item.get_closest_marker("full").kwargs.get("inputs")
    return None if inputs is None else [str(name) for name in inputs]


def seconds(item) -> float:
    """How long the test took when it last ran; infinite where that is not known."""
    return _content(item).get("seconds", float("inf"))


def kept() -> list[tuple[Path, dict]]:
    """All files of results, and what they hold."""
    return [(path, _read(path)) for path in sorted(RESULTS.glob("*.json"))]


def summary(states: Iterable[str]) -> str:
    """One line: how many results are valid, and how many are not."""
    count = Counter(states)
    parts = [f"{count.pop(VALID, 0)} valid", f"{sum(n for name, n in count.items() if name.startswith('stale'))} stale"]
    parts += [f"{number} {name}" for name, number in sorted(count.items()) if not name.startswith("stale")]
    return f"kept results of full tests: {', '.join(parts)} (`make test-status` lists them)"


def listed(items: list) -> list[str]:
    """A line for every full test and every result of a test that is no more: state, age, seconds, name.

    Writes the states into the files.
    """
    by_path = {result_path(item): item.nodeid for item in items}
    held = dict(kept())
    states, lines = [], []
    for path in sorted(by_path.keys() | held.keys()):
        content = held.get(path, {})
        of_this = path in by_path and content.get("test", by_path[path]) == by_path[path]
        now = state(content) if of_this else GONE
        if content and content.get("state") != now:
            _write(path, content | {"state": now})
        states.append(now)
        took = f"{content['seconds']:8.1f} s" if "seconds" in content else ""
        lines.append(f"{now:33} {_age(content):>9} {took:>10}  {by_path.get(path) or content.get('test', path.name)}")
    return [*sorted(lines), summary(states)]


def _age(content: dict) -> str:
    if "date" not in content:
        return ""
    return f"{(datetime.now(UTC) - datetime.fromisoformat(content['date'])).total_seconds() / 86400:.1f} days"


def _content(item) -> dict:
    """What is kept of a test; nothing where the file is that of another test of that name, in another folder."""
    content = _read(result_path(item))
    return content if content.get("test") == item.nodeid else {}


def _read(path: Path) -> dict:
    try:
        content = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) and isinstance(content.get("test"), str) else {}


def _write(path: Path, content: dict) -> None:
    RESULTS.mkdir(exist_ok=True)
    temporary = path.with_suffix(".tmp")
    temporary.write_text(json.dumps(content, indent=1) + "\n")
    temporary.replace(path)


class _Collected:
    items: list = []

    def pytest_collection_finish(self, session):
        self.items = list(session.items)


def main() -> int:
    """List the states of all full tests, as they are collected."""
    collected, said = _Collected(), io.StringIO()
    with contextlib.redirect_stdout(said):
        ended = pytest.main(["-m", "full", "--collect-only", "-qq"], plugins=[collected])
    lines = listed(collected.items) if ended == 0 else [said.getvalue()]
    sys.stdout.write("\n".join(lines) + "\n")
    return int(ended)


if __name__ == "__main__":
    sys.exit(main())
