"""The scenes of `sims` by name, as `astroinertia new --from` copies them.

Tests: tests/unit/storage/test_ready_made.py, tests/installed/test_wheel.py.
"""

from pathlib import Path

from astroinertia.storage.data_tables import shipped

ACCOMPANIED = frozenset({"progenitor_collapse"})  # takes a table of `data` along, and so cannot be copied alone


def scenes() -> dict[str, Path]:
    """The files of the scenes that stand alone, by their names, in the order of the alphabet."""
    files = sorted(shipped("sims").glob("*.toml"))
    return {path.stem: path for path in files if path.stem not in ACCOMPANIED}
