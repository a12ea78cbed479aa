"""The scenes of `sims` by name, as `astroinertia new --from` copies them: in a checkout at the top, in an installed
package beside the code.

Tests: tests/unit/storage/test_ready_made.py, tests/installed/test_wheel.py.
"""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent.parent
ACCOMPANIED = frozenset({"progenitor_collapse"})  # takes a table of `data` along, and so cannot be copied alone


def scenes() -> dict[str, Path]:
    """The files of the scenes that stand alone, by their names, in the order of the alphabet."""
    for folder in (_PACKAGE / "sims", _PACKAGE.parent / "sims"):
        if found := {path.stem: path for path in sorted(folder.glob("*.toml")) if path.stem not in ACCOMPANIED}:
            return found
    return {}
