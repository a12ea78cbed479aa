"""Templates: modules whose text is copied into generated ones, to be compiled for what a scene asks.

What stands above the mark lets a template be imported, checked, tested and stepped through by itself, with one choice
of all that generated modules differ in. Numba compiles nothing of it there; with NUMBA_DISABLE_JIT=1 all is plain
Python, in templates as in generated modules. Tests: tests/unit/engines/test_templates.py.
"""

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from types import SimpleNamespace

MARK = "# Copied into generated modules from here on.\n"
PACKAGE = Path(__file__).parent.parent


def template(place: str, **words: object) -> str:
    """What stands below the mark of a file of the package, which is not imported, with whole words replaced.

    A list stands for a word among arguments, maybe for none of them.
    """
    text = _below_the_mark(place)
    for word, chosen in words.items():
        if isinstance(chosen, list):
            text = re.sub(rf",\s*{word}\b", "".join(f", {name}" for name in chosen), text)
        else:
            text = re.sub(rf"\b{word}\b", str(chosen), text)
    return text


def executed(lines: Iterable[str]) -> SimpleNamespace:
    """Functions that are written line by line, in float64: those that a template calls when it stands by itself."""
    from astroinertia.engines import numba_float64, numba_parts, numba_tables, numba_vectors

    names = vars(numba_vectors) | vars(numba_tables) | vars(numba_parts) | vars(numba_float64)
    names |= {"ENTRY": numba_vectors.PART, "TEST_FLAGS": numba_float64.PAIR_FLAGS}
    exec("\n".join(lines), names)
    return SimpleNamespace(**names)


@cache
def _below_the_mark(place: str) -> str:
    return (PACKAGE / place).read_text(encoding="utf-8").split(MARK, 1)[1]
