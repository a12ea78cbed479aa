"""Names and sentences use the field's words: words that a newcomer has to guess occur nowhere."""

import importlib
import re
import warnings
from pathlib import Path

import pytest

from astroinertia.accuracy import error_bars
from astroinertia.process.renamed import renamed_keyword

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
# Names of before that are accepted for one release, by the file that says so.
QUOTED = {
    "astroinertia/accuracy/choice.py": ['@renamed_keyword("told", "listener")'],
    "astroinertia/accuracy/tradeoff.py": ['@renamed_keyword("told", "listener")'],
    "astroinertia/plots/movie.py": ['@renamed_keyword("told", "listener")'],
    "astroinertia/sweeps/ensemble.py": ['@renamed_keyword("told", "listener")'],
    "astroinertia/accuracy/error_bars.py": ['if name == "order_told":'],
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


def test_names_of_before_work_for_one_release_and_warn() -> None:
    @renamed_keyword("before", "now")
    def doubled(number: int, now: int = 0) -> int:
        return 2 * number + now

    assert doubled(1, now=3) == 5
    with pytest.warns(FutureWarning, match=re.escape("doubled(before=...) is now doubled(now=...).")):
        assert doubled(1, before=4) == 6
    with pytest.warns(FutureWarning, match=r"error_bars\.order_told is now .*error_bars\.measured_order"):
        assert error_bars.order_told is error_bars.measured_order
    with warnings.catch_warnings(), pytest.raises(AttributeError, match="has no attribute 'order_asked'"):
        error_bars.__getattr__("order_asked")
    from astroinertia.matter import compact_stars

    with pytest.warns(FutureWarning, match=r"bodies\.equations_of_state is now astroinertia\.matter\.compact_stars"):
        moved = importlib.import_module("astroinertia.bodies.equations_of_state")
    assert moved.read2009 is compact_stars.read2009
    from astroinertia.bodies.break_up import break_up

    with pytest.warns(FutureWarning, match=r"rotation\.break_up is now astroinertia\.bodies\.break_up"):
        assert importlib.import_module("astroinertia.rotation.break_up").break_up is break_up
    with pytest.raises(ImportError):
        importlib.import_module("astroinertia.bodies.nowhere")
