"""The oldest versions that pyproject.toml allows, as constraints for pip: `python tests/installed/floors.py`."""

import sys
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

PROJECT = Path(__file__).parents[2] / "pyproject.toml"


def floors(listed: list[str]) -> list[str]:
    """Of "name>=1.2,<3" the constraint "name==1.2"; what is listed without a least version is left open."""
    constraints = []
    for needed in map(Requirement, listed):
        least = [each.version for each in needed.specifier if each.operator == ">="]
        constraints += [f"{needed.name}=={version}" for version in least]
    return constraints


def dependencies() -> list[str]:
    """What pyproject.toml lists, without extras."""
    return tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]["dependencies"]


if __name__ == "__main__":
    sys.stdout.write("\n".join([*floors(dependencies()), ""]))
