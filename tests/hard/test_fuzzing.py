"""A fuzzer that sees which code its inputs reach finds nothing that readers of scenes and tables do not expect."""

import json
import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.hard.whole_files import ROOT, text_files, whole_files

READERS = ("scene", "csv", "npz", "equation", "profile", "columns", "manifest", "structure")
fuzzer = pytest.mark.skipif(
    find_spec("atheris") is None, reason="atheris, which exists for Linux on x86-64 only, is not installed"
)


def seeds(folder, few):
    """A folder of whole inputs for each reader."""
    whole = folder / "whole"
    whole.mkdir()
    made = text_files(whole) if few else whole_files(whole, few=True)
    chosen = {
        "scene": [whole / "scene.toml", whole / "sweep.toml", *sorted((ROOT / "sims").glob("*.toml"))],
        "profile": [path for kind, path in made if kind == "profile" and path.suffix != ".csv"],
        "columns": [whole / "profile.csv"],
    }
    if not few:
        chosen |= {name: [whole / f"table.{name}"] for name in ("csv", "npz")}
        chosen |= {
            "equation": [whole / "equation.csv"],
            "manifest": [whole / "unfinished" / "manifest.json"],
            "structure": [whole / name for name in ("table.nc", "table.h5", "result.nc")],
        }
    for reader, paths in chosen.items():
        place = folder / "seeds" / reader
        place.mkdir(parents=True)
        for path in paths:
            (place / path.name).write_bytes(path.read_bytes())
    return list(chosen)


def fuzzed(folder, reader, seconds):
    """Executions, edges of the code that they reached, inputs kept for that, and findings."""
    corpus, findings = folder / "corpus" / reader, folder / f"{reader}.jsonl"
    corpus.mkdir(parents=True)
    paths = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, "-m", "tests.hard.fuzzing", reader, str(seconds), folder / "seeds" / reader, corpus, findings],
        cwd=folder, env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    coverage = re.findall(r"cov: (\d+)", done.stderr), re.search(r"Done (\d+) runs", done.stderr)
    assert done.returncode == 0 and coverage[0] and coverage[1], done.stderr[-3000:]
    found = [json.loads(line) for line in findings.read_text().splitlines()] if findings.exists() else []
    return {
        "executions": int(coverage[1][1]), "edges": int(coverage[0][-1]), "inputs": len(list(corpus.iterdir())),
        "findings": [f"{each['content'][:2000]}: {each['said'][-1500:]}" for each in found],
    }  # fmt: skip


@pytest.mark.full
@fuzzer
def test_a_few_seconds_find_nothing(tmp_path):
    for seconds in (2, 8, 32):  # a machine that is busy takes longer
        folder = tmp_path / str(seconds)
        folder.mkdir()
        seeds(folder, few=True)
        found = fuzzed(folder, "columns", seconds)
        assert not found["findings"]
        if found["executions"] > 500:
            break
    assert found["executions"] > 500 and found["edges"] > 100


@fuzzer
@pytest.mark.full(inputs=["tests/hard/fuzzing.py", "tests/hard/whole_files.py"])
def test_eight_minutes_find_nothing(tmp_path, result):
    readers = seeds(tmp_path, few=False)
    assert sorted(readers) == sorted(READERS)
    figures = {reader: fuzzed(tmp_path, reader, 60) for reader in readers}
    keep = os.environ.get("FUZZ_FINDINGS")
    if keep:  # to mend what was found
        Path(keep).write_text(json.dumps(figures, indent=1))
    findings = [each for found in figures.values() for each in found["findings"]]
    result(
        executions={reader: found["executions"] for reader, found in figures.items()},
        edges={reader: found["edges"] for reader, found in figures.items()},
        inputs={reader: found["inputs"] for reader, found in figures.items()},
        findings=len(findings),
    )
    assert not findings, findings[0]
