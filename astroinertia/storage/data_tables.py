"""Where the cited tables of `data` lie: in a checkout at the top, in an installed package beside the code."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent.parent


def data_path(name: str) -> Path:
    """Return the path of the data file `name`; FileNotFoundError where there is none of that name."""
    for folder in (_PACKAGE / "data", _PACKAGE.parent / "data"):
        if (folder / name).is_file():
            return folder / name
    raise FileNotFoundError(f"there is no data file {name!r} in this installation")
