"""What comes with the package: the cited tables of `data`, those that stand beside the code, the scenes of `sims`."""

import csv
from functools import lru_cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent.parent


def shipped(folder: str) -> Path:
    """The folder `data` or `sims`: in an installed package beside the code, in a checkout at the top."""
    beside = _PACKAGE / folder
    return beside if beside.is_dir() else _PACKAGE.parent / folder


def data_path(name: str) -> Path:
    """Return the path of the data file `name`; FileNotFoundError where there is none of that name."""
    path = shipped("data") / name
    if not path.is_file():
        raise FileNotFoundError(f"there is no data file {name!r} in this installation")
    return path


def data_rows(name: str) -> tuple[dict[str, str], ...]:
    """Return the rows of the cited table `name`, each by the heads of its columns, as texts."""
    return rows_of(data_path(name))


@lru_cache(maxsize=32)
def rows_of(path: Path) -> tuple[dict[str, str], ...]:
    """Return the rows of a CSV table of the package; lines that begin with # are comments."""
    with path.open(encoding="utf-8", newline="") as lines:
        return tuple(csv.DictReader(line for line in lines if not line.startswith("#")))


ACCOMPANIED = frozenset({"progenitor_collapse"})  # takes a table of `data` along, and so cannot be copied alone


def scenes() -> dict[str, Path]:
    """The files of the scenes that stand alone, by their names, in the order of the alphabet."""
    files = sorted(shipped("sims").glob("*.toml"))
    return {path.stem: path for path in files if path.stem not in ACCOMPANIED}
