"""Run folders from strangers, altered and with hashes that fit: `resume` goes on or refuses in one sentence."""

import hashlib
import os
import shutil
from pathlib import Path

import pytest

from tests.hard.altered_folders import SCENES, altered_folders, stopped_folders
from tests.hard.reading import Reading

pytestmark = pytest.mark.usefixtures("steps_differ")

QUICK = ("individual", "rigid", "scaling")  # without those that compile for seconds
INPUTS = ["tests/hard/altered_folders.py", "tests/hard/malformed_files.py", "tests/hard/malformed_child.py"]


@pytest.fixture
def reading():
    made = Reading()
    yield made
    made.close()


def contents(folder):
    """Every file below a folder by its path, with its hash; links are not followed."""
    found = {}
    for place, folders, names in os.walk(folder):
        for name in (*folders, *names):
            path = Path(place, name)
            found[path] = hashlib.sha256(Path(path).read_bytes()).hexdigest() if Path(path).is_file() else ""
    return found


def resumed(reading, folder, names, seed, count):
    """What became of so many altered folders; every whole one is resumed to its end first."""
    places = [folder / name for name in ("whole", "again", "altered")]
    for place in places:
        place.mkdir()
    whole = stopped_folders(places[0], names)
    for name, path in whole.items():
        shutil.copytree(path, places[1] / name)
        found = reading.of("resume", places[1] / name)
        assert found["became"] == "read", (name, found)
    before = contents(places[0]) | contents(places[1])
    counts = {"read": 0, "refused": 0}
    for number, path in enumerate(altered_folders(whole, places[2], seed, count)):
        found = reading.of("resume", path)
        assert found["became"] in counts, (number, path, found)
        counts[found["became"]] += 1
        assert contents(places[0]) | contents(places[1]) == before
        assert {each.name for each in places[2].iterdir()} <= set(names)
    assert sorted(folder.iterdir()) == sorted(places)
    return counts


def test_altered_folders_are_resumed_or_refused(reading, tmp_path):
    found = resumed(reading, tmp_path, QUICK, 7, 9)
    assert found["refused"] > 3


@pytest.mark.full(inputs=INPUTS)
def test_four_hundred_of_them(reading, tmp_path, result):
    found = resumed(reading, tmp_path, tuple(SCENES), 1, 400)
    result(**found)
    assert found["refused"] > 200
