"""Results of the long tests (marked full), one JSON file each in tests/results, so that none runs twice for nothing.

A test counts as done where its file says that it passed with the same inputs: its own source, its parameters, and the
files that its marker names, as in `@pytest.mark.full(inputs=["sims/evrard.toml"])`. A change of the package alone does
not make it run again; the file records which package it ran with.
"""

import ast
import hashlib
import inspect
import json
import os
import platform
import re
import textwrap
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
RESULTS = ROOT / "tests" / "results"


class FullResult:
    """What a long test found: `result(error=..., order=...)` adds figures, plain numbers, texts, or lists of them."""

    KEY = pytest.StashKey["FullResult"]()

    def __init__(self, item):
        self.item = item
        self.figures = {}

    def __call__(self, **figures):
        self.figures.update(json.loads(json.dumps(figures, default=float)))

    def write(self, report):
        content = {
            "test": self.item.nodeid,
            "outcome": report.outcome,
            "figures": self.figures,
            "seconds": round(report.duration, 1),
            "inputs": inputs_hash(self.item),
            "package": package_hash(),
            "python": platform.python_version(),
            "processor": platform.machine(),
            "cores": os.cpu_count(),
        }
        if report.failed:
            crash = getattr(report.longrepr, "reprcrash", None)
            content["failure"] = str(crash.message if crash else report.longrepr)[:1000]
        RESULTS.mkdir(exist_ok=True)
        path = result_path(self.item)
        temporary = path.with_suffix(".tmp")
        temporary.write_text(json.dumps(content, indent=1) + "\n")
        temporary.replace(path)


def is_done(item) -> bool:
    """Whether the test passed before with the same inputs."""
    try:
        content = json.loads(result_path(item).read_text())
    except (OSError, ValueError):
        return False
    return content.get("outcome") == "passed" and content.get("inputs") == inputs_hash(item)


def result_path(item) -> Path:
    """Where a test's result is kept: its file and name, made fit for a file name."""
    return RESULTS / f"{item.path.stem}-{re.sub(r'[^A-Za-z0-9.]+', '-', item.name).strip('-')}.json"


def inputs_hash(item) -> str:
    """A hash of the test's source (comments and layout left out), its parameters and the files its marker names."""
    digest = hashlib.sha256(ast.dump(ast.parse(textwrap.dedent(inspect.getsource(item.function)))).encode())
    digest.update(item.name.encode())
    for name in item.get_closest_marker("full").kwargs.get("inputs", ()):
        digest.update((ROOT / name).read_bytes())
    return digest.hexdigest()[:16]


def package_hash() -> str:
    """A hash of the package's source."""
    digest = hashlib.sha256()
    for path in sorted((ROOT / "astroinertia").rglob("*.py")):
        digest.update(str(path.relative_to(ROOT)).encode() + path.read_bytes())
    return digest.hexdigest()[:16]
