"""A netCDF file with mutated bytes where HDF5 has no checksums: read, shown and reported in seconds, or refused."""

import random
import re

import pytest

from astroinertia import dataset
from astroinertia.accuracy.running import run_scene
from astroinertia.scene import load
from tests.hard.altered_folders import SCENES
from tests.hard.reading import Reading

pytestmark = pytest.mark.usefixtures("steps_differ")

# Blocks of names and attributes, of the places of chunks, and of references: how far each is mutated.
UNCHECKED = {b"FHDB": 4096, b"TREE": 600, b"GCOL": 2000, b"FHIB": 200}
INPUTS = ["tests/hard/altered_folders.py", "tests/hard/malformed_child.py"]


def mutated(content, seed, count):
    """So many versions of a file without the line that knows its hash, with one to four places changed."""
    content = content[: content.rindex(b"\nastroinertia-sha256")]
    chance = random.Random(seed)
    found = [(each.start(), size) for name, size in UNCHECKED.items() for each in re.finditer(name, content)]
    places = [place for begin, size in found for place in range(begin, min(begin + size, len(content) - 8))]
    for _ in range(count):
        changed = bytearray(content)
        for _ in range(chance.choice((1, 1, 2, 4))):
            place, size = chance.choice(places), chance.choice((1, 1, 2, 4, 8))
            changed[place : place + size] = bytes([chance.choice((0, 1, 128, 255, chance.randrange(256)))]) * size
        yield bytes(changed)


@pytest.fixture
def content(tmp_path):
    (tmp_path / "run").mkdir()
    file = run_scene(load.loads(SCENES["individual"].replace("LAST", "4")), tmp_path / "run")
    assert dataset.open(file).sizes["time"] > 4
    return file.read_bytes()


@pytest.fixture
def reading():
    made = Reading()
    yield made
    made.close()


def judged(reading, folder, content, seed, count, commands):
    """What became of mutated files: read or refused; those that are read are then shown by the commands."""
    counts = {"read": 0, "refused": 0}
    for number, changed in enumerate(mutated(content, seed, count)):
        # HDF5 may keep a file open that it could not read, and would take the next one of that name for it.
        path = folder / f"mutated-{number}.nc"
        path.write_bytes(changed)
        found = reading.of("result", path)
        assert found["became"] in counts and found["seconds"] < 5.0, (number, found)
        counts[found["became"]] += 1
        for command in commands if found["became"] == "read" else ():
            outcome = reading.of(command, path)  # a process that takes 30 s of processor time is ended
            assert outcome["became"] in ("read", "refused"), (number, command, outcome)
        path.unlink()
    return counts


@pytest.mark.full
def test_mutated_results_are_read_or_refused(reading, content, tmp_path):
    found = judged(reading, tmp_path, content, 3, 24, ())
    assert found["read"] > 0 and found["refused"] > 7


@pytest.mark.full(inputs=INPUTS)
def test_thousand_mutated_results_are_shown_or_refused(reading, content, tmp_path, result):
    result(**judged(reading, tmp_path, content, 1, 1000, ("show", "report")))
