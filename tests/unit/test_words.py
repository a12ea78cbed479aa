"""Names and sentences use the field's words: words that a newcomer has to guess occur nowhere."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = {
    "astroinertia": ("*.py", "*.js", "*.html", "*.css", "*.toml", "*.md"),
    "sims": ("*.py", "*.toml", "*.md"),
    "tests": ("*.py",),
    ".ci": ("*",),
}
# The word, and what to write in its place.
WORDS = {
    "told": "message, description, reported, stated",
    "books": "ledger, or sums",
    "warmed": "heated",
    "mended": "corrected, fixed",
    "dear": "expensive",
    "dearer": "more expensive",
    "anew": "again",
    "awake": "active",
    "asleep": "inactive",
    "parted": "split, separated",
    "swallowed": "accreted",
    "seal": "save, checkpoint",
    "seals": "saves",
    "sealed": "saved, atomic",
    "sealing": "saving",
    "woken": "activated",
    "handed on": "deferred",
    "closed up": "compacted",
    "closing up": "stream compaction",
    "slip": "relative rotation",
    "slips": "turns relative to it",
}
# Lines in which such a word means what it says, by their file.
QUOTED = {
    # What a body does that rolls without friction enough.
    "astroinertia/inertia/rolling.py": [
        '"""tan(incline) k / (1 + k): the coefficient of static friction below which the body slips.',
        '"""The bodies, by name, in the order in which they arrive; all start from rest together and none slips.',
    ],
}
FORBIDDEN = re.compile(rf"(?<![A-Za-z])({'|'.join(WORDS)})(?![A-Za-z])", re.IGNORECASE)


def files() -> list[Path]:
    found = [
        path for top, names in FILES.items() for name in names for path in (ROOT / top).rglob(name) if path.is_file()
    ]
    found += [ROOT / name for name in ("Makefile", "README.md", "pyproject.toml", "CHANGELOG.md")]
    read = [path for path in found if path.is_file() and path != Path(__file__)]
    return sorted(path for path in read if "__pycache__" not in path.parts)


def test_words_of_the_field_are_used() -> None:
    wrong = []
    for path in files():
        name = path.relative_to(ROOT).as_posix()
        for part in FORBIDDEN.findall(name):
            wrong.append(f"{name}: its name has '{part}'; write {WORDS[part.lower()]}")
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if (match := FORBIDDEN.search(line)) and line.strip() not in QUOTED.get(name, []):
                wrong.append(f"{name}:{number}: '{match[0]}'; write {WORDS[match[0].lower()]}")
    assert not wrong, "\n".join(wrong)


def test_every_quotation_is_needed() -> None:
    for name, lines in QUOTED.items():
        there = {line.strip() for line in (ROOT / name).read_text(encoding="utf-8").splitlines()}
        assert all(line in there and FORBIDDEN.search(line) for line in lines), name


@pytest.mark.parametrize(
    "text", ["what is told", "order_told", "_books", "DEAR = 1", "tests/unit/told.py", "Anew.", "is closed up"]
)
def test_parts_of_names_are_found(text: str) -> None:
    assert FORBIDDEN.search(text)


@pytest.mark.parametrize("text", ["notebooks", "textbook", "imparted", "dearth", "handbooks", "warmer"])
def test_other_words_are_not(text: str) -> None:
    assert not FORBIDDEN.search(text)
