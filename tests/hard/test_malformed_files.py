"""Files with mistakes that chance or enemies made: read, or refused in a sentence, within bounds, and nothing else.

A process of its own reads them, so that one that ends it is noticed; all are read as every command would read them.
"""

import hashlib

import pytest

from astroinertia.errors import SceneError
from astroinertia.orbits import rebound_archive as orbits
from astroinertia.sph.progenitor import read_progenitor
from tests.hard.crafted_files import crafted_files
from tests.hard.malformed_files import malformed
from tests.hard.reading import Reading
from tests.hard.whole_files import orbit_files, text_files, whole_files

LONGEST = 2.0  # seconds of processor time
MOST = 300e6  # bytes more than before
PARTS = ("crafted_files", "malformed_bytes", "malformed_child", "malformed_files", "whole_files")
INPUTS = ["tests/phantom_dump.py", *(f"tests/hard/{name}.py" for name in PARTS)]


class Judge:
    """Asks a process to read one file after the other, and fails at the first that is not as it should be."""

    def __init__(self, reading):
        self.reading, self.counts, self.seconds, self.bytes = reading, {"read": 0, "refused": 0}, 0.0, 0

    def __call__(self, kind, path):
        found = self.reading.of(kind, path)
        assert found["became"] in self.counts, (kind, path, found)
        assert found["seconds"] < LONGEST and found["bytes"] < MOST, (kind, path, found)
        self.counts[found["became"]] += 1
        self.seconds, self.bytes = max(self.seconds, found["seconds"]), max(self.bytes, found["bytes"])
        return found["became"], found["said"]

    def figures(self):
        return {**self.counts, "longest_seconds": round(self.seconds, 2), "most_bytes": self.bytes}


@pytest.fixture
def judge():
    reading = Reading()
    yield Judge(reading)
    reading.close()


def judged(judge, folder, count, few):
    """Read whole files, crafted ones and malformed ones, so many in all of the latter two."""
    places = [folder / name for name in ("whole", "crafted", "outside", "malformed")]
    for place in places:
        place.mkdir()
    whole, crafted, outside, changed = places
    files = whole_files(whole, few)
    for kind, path in files:
        if path.is_file():  # folders have a mistake each: the scenes of two of them are not whole
            assert judge(kind, path) == ("read", "")
    bad = crafted_files(crafted, {path.name: path for _, path in files}, outside, few)
    before = contents(outside)
    for kind, path in bad:
        became, said = judge(kind, path)
        # What is wrong is said of the file; a damaged checkpoint has another before it, and its scene is then refused.
        assert became == "refused" and (path.stem in said or path.stem == "linked-checkpoint"), (kind, path, said)
    read = judge.counts["read"]
    for kind, path in malformed(files, changed, 5, count - len(bad)):
        judge(kind, path)
        assert contents(outside) == before
    assert sorted(folder.iterdir()) == sorted(places)
    return {"files": count, "crafted": len(bad), **judge.figures(), "read": judge.counts["read"] - read}


def contents(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.iterdir()}


def test_a_hundred_malformed_files_are_read_or_refused(judge, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = judged(judge, tmp_path, 100, few=True)
    assert found["refused"] > 80


@pytest.mark.full(inputs=INPUTS)
def test_two_thousand_of_them(judge, tmp_path, monkeypatch, result):
    monkeypatch.chdir(tmp_path)
    result(**judged(judge, tmp_path, 2000, few=False))


def test_the_first_row_of_a_profile_may_not_be_short(tmp_path):
    text_files(tmp_path)
    for name, first in (("example_kepler_presn", 2), ("example_mesa_profile.data", 6)):
        lines = (tmp_path / name).read_text().splitlines()
        lines[first] = "1: 2.0"
        (tmp_path / name).write_text("\n".join(lines))
        with pytest.raises(SceneError, match="row 1 has"):
            read_progenitor(tmp_path / name)


def test_an_archive_that_crashes_rebound_is_refused(tmp_path):
    ((_, path),) = orbit_files(tmp_path)
    content, refused = path.read_bytes(), 0
    for place in range(100, 2000, 300):  # lengths and addresses among them
        (tmp_path / "changed.bin").write_bytes(content[:place] + b"\xff" * 8 + content[place + 8 :])
        try:
            orbits.snapshots(tmp_path / "changed.bin")
        except ValueError as error:
            refused += "it is damaged" in str(error)
    assert refused > 0
