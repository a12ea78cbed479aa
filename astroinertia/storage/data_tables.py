"""Tables that come with the package: the cited ones of `data`, and those that stand beside the code."""

import csv
from functools import lru_cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent.parent


def data_path(name: str) -> Path:
    """Return the path of the data file `name`; FileNotFoundError where there is none of that name.

    It lies in a checkout at the top, in an installed package beside the code.
    """
    for folder in (_PACKAGE / "data", _PACKAGE.parent / "data"):
        if (folder / name).is_file():
            return folder / name
    raise FileNotFoundError(f"there is no data file {name!r} in this installation")


def data_rows(name: str) -> tuple[dict[str, str], ...]:
    """Return the rows of the cited table `name`, each by the heads of its columns, as texts."""
    return rows_of(data_path(name))


@lru_cache(maxsize=32)
def rows_of(path: Path) -> tuple[dict[str, str], ...]:
    """Return the rows of a CSV table of the package; lines that begin with # are comments."""
    with path.open(encoding="utf-8", newline="") as lines:
        return tuple(csv.DictReader(line for line in lines if not line.startswith("#")))
