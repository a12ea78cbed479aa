"""Every number of every scene in sims/ at its extremes, planned in this process within limits on time and memory.

    python -m tests.extreme_numbers [SHARE SEED]

One line of JSON for each plan that ended neither well nor with one sentence, and at the end one of counts.
"""

import contextlib
import copy
import io
import json
import math
import random
import re
import resource
import signal
import sys
import tempfile
import tomllib
import traceback
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from astroinertia.cli import main as cli
from astroinertia.scene.text import toml_text
from tests.sims import SIMS

SECONDS = 10
MEMORY = 1_000_000_000  # bytes beyond what the imports take
SIZES = (
    1e-300,
    1e-100,
    1e-55,
    1e-30,
    1e-10,
    1.0,
    1e10,
    1e30,
    1e46,
    1e100,
    1e199,
    1e200,
    math.nextafter(1e200, 2e200),
    1e300,
)
EXTREMES = (0.0, *SIZES, *(-size for size in SIZES))
WHOLE = (0, -1, 1, 2, 3, 16, 10**6, 10**7, 10**9, 10**18, 10**30)
QUANTITY = re.compile(r"\s*[+-]?[0-9.]+(?:[eE][+-]?[0-9]+)?(\s+\S.*|)")
NO_NUMBER = re.compile(r"(?<![A-Za-z_])(nan|inf)(?![A-Za-z_])|\\[\\](?!\\S)")
Place = tuple[str | int, ...]


def numbers(value: Any, place: Place = ()) -> Iterator[tuple[Place, Any]]:
    """Where a scene has numbers, and quantities with a unit, and what they are."""
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from numbers(item, (*place, key))
    elif not isinstance(value, bool) and (
        isinstance(value, int | float) or (isinstance(value, str) and QUANTITY.fullmatch(value))
    ):
        yield place, value


def moved(value: Any) -> list[Any]:
    """The extremes of a number, with its unit where it has one."""
    if isinstance(value, int):
        return list(WHOLE)
    if isinstance(value, float):
        return list(EXTREMES)
    found = QUANTITY.fullmatch(value)
    assert found is not None
    return [f"{extreme!r}{found[1]}" for extreme in EXTREMES]


def cases(tables: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """A scene with one of its numbers at an extreme, and which."""
    for place, value in numbers(tables):
        for extreme in moved(value):
            changed = copy.deepcopy(tables)
            inside: Any = changed
            for key in place[:-1]:
                inside = inside[key]
            inside[place[-1]] = extreme
            yield f"{'.'.join(map(str, place))} = {extreme}", changed


class TooLong(BaseException):
    """A plan that did not answer in time."""


def _late(*_: object) -> None:
    raise TooLong


def verdict(file: Path) -> tuple[str, str]:
    """How `plan` ended: "planned", "refused" with its sentence, or "late", "traceback" or "unclear" with where."""
    said, complaint = io.StringIO(), io.StringIO()
    signal.setitimer(signal.ITIMER_REAL, SECONDS, 1.0)  # again, where it was lost in a callback
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(complaint):
            code = cli.main(["plan", str(file)])
        signal.setitimer(signal.ITIMER_REAL, 0)
    except TooLong as error:
        return "late", _where(error)
    except BaseException as error:
        signal.setitimer(signal.ITIMER_REAL, 0)
        return "traceback", f"{_where(error)} {type(error).__name__}: {str(error)[:200]}"
    complaints = complaint.getvalue().splitlines()
    odd = [line for line in (*said.getvalue().splitlines(), *complaints) if NO_NUMBER.search(line)]
    if code == 0:
        return ("unclear", (complaints + odd)[0]) if complaints or odd else ("planned", "")
    one = len(complaints) == 1 and complaints[0].startswith("astroinertia: ") and not odd
    return ("refused" if one else "unclear"), "\n".join(complaints)[-400:]


def _where(error: BaseException) -> str:
    frames = [each for each in traceback.extract_tb(error.__traceback__) if "/astroinertia/" in each.filename]
    last = frames[-1] if frames else traceback.extract_tb(error.__traceback__)[-1]
    return f"{last.filename.rpartition('/astroinertia/')[2]}:{last.lineno}"


def tried(share: float = 1.0, seed: int = 0, scenes: str = "*") -> Iterator[dict[str, str]]:
    """Each case, or a seeded share of them: its scene, what was changed, how `plan` ended and what it said."""
    chosen = random.Random(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file in SIMS.iterdir():
            if file.suffix != ".toml":
                (folder / file.name).symlink_to(file)
        for scene in sorted(SIMS.glob(f"{scenes}.toml")):
            for change, tables in cases(tomllib.loads(scene.read_text())):
                if chosen.random() < share:
                    file = folder / "scene.toml"
                    file.write_text(toml_text(tables))
                    ended, words = verdict(file)
                    yield {"scene": scene.stem, "change": change, "ended": ended, "said": words}


def limited() -> None:
    """Bound the memory of this process, and let a plan that takes too long end."""
    held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (held + MEMORY, resource.RLIM_INFINITY))
    signal.signal(signal.SIGALRM, _late)


def main(share: float, seed: int, scenes: str) -> None:
    """Write what went wrong, and counts."""
    for _ in tried(1e-4, 0):  # what plans import is no part of their memory
        pass
    limited()
    counts: Counter[str] = Counter()
    for each in tried(share, seed, scenes):
        counts[each["ended"]] += 1
        if each["ended"] not in ("planned", "refused") or "enough memory" in each["said"]:
            sys.stdout.write(f"{json.dumps(each)}\n")
            sys.stdout.flush()
    sys.stdout.write(f"{json.dumps(counts)}\n")


if __name__ == "__main__":
    given = [*sys.argv[1:], *("1.0", "0", "*")[len(sys.argv) - 1 :]]
    main(float(given[0]), int(given[1]), given[2])
