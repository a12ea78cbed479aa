"""Versions that are known to be wrong are refused in a sentence, by the package's own list of what it needs."""

import subprocess
import sys
from importlib.metadata import requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from astroinertia.errors import InstallationError
from astroinertia.process import requirements

ROOT = Path(__file__).parents[3]


def describe(folder: Path, name: str, version: str, *needs: str) -> None:
    """Make a package of a version look installed to whatever has the folder first on its path."""
    described = folder / f"{name}-{version}.dist-info"
    described.mkdir()
    lines = [f"Name: {name}", f"Version: {version}", *(f"Requires-Dist: {each}" for each in needs)]
    (described / "METADATA").write_text("\n".join(["Metadata-Version: 2.1", *lines, ""]))


def looked_at(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(folder)
    requirements.check.__wrapped__()


def test_what_is_installed_here_is_what_the_metadata_asks_for():
    requirements.check.__wrapped__()
    listed = {Requirement(each).name.lower() for each in requires("astroinertia") or []}
    assert {"numpy", "numba", "jax", "jaxlib", "rebound", "netcdf4", "threadpoolctl"} <= listed


@pytest.mark.parametrize(
    ("name", "version"),
    [
        ("numba", "0.61.2"),  # crashes in intrinsics
        ("numba", "0.69.0"),  # private classes, never tried
        ("jax", "0.7.2"),
        ("jax", "0.10.2"),  # miscompiles
        ("jaxlib", "0.10.2"),
        ("rebound", "4.6.0"),
        ("rebound", "6.0.0"),
        ("numpy", "1.26.4"),
    ],
)
def test_a_wrong_version_is_refused_by_name_with_a_remedy(name, version, tmp_path, monkeypatch):
    describe(tmp_path, name, version)
    with pytest.raises(InstallationError, match=rf"^{name} {version} is installed.*pip install '{name}[^']*'\.$"):
        looked_at(tmp_path, monkeypatch)


def test_a_newer_version_within_the_limits_is_let_through(tmp_path, monkeypatch):
    for name, version in (("numba", "0.62.0"), ("numpy", "3.0rc1"), ("jax", "0.12.0.1")):
        describe(tmp_path, name, version)
    looked_at(tmp_path, monkeypatch)


@pytest.mark.parametrize(("need", "missing"), [("never-there>=1", True), ('never-there>=1; extra == "test"', False)])
def test_what_is_missing_is_named_and_extras_are_not_asked_for(need, missing, tmp_path, monkeypatch):
    describe(tmp_path, "astroinertia", "0.1.0", "numpy>=2.0", need)
    if not missing:
        looked_at(tmp_path, monkeypatch)
        return
    with pytest.raises(InstallationError, match=r"^never-there is not installed.*pip install 'never-there>=1'\.$"):
        looked_at(tmp_path, monkeypatch)


def test_the_command_line_and_the_library_say_it_and_help_is_still_given(tmp_path):
    describe(tmp_path, "numba", "0.61.2")
    program = f"import sys; sys.path[:0] = [{str(tmp_path)!r}, {str(ROOT)!r}]\n"

    def ended(code: str) -> subprocess.CompletedProcess:
        return subprocess.run([sys.executable, "-c", program + code], capture_output=True, text=True, check=False)

    command = "from astroinertia.cli.main import main; sys.exit(main({arguments}))"
    process = ended(command.format(arguments=["new"]))
    assert process.returncode == 1 and process.stdout == ""
    assert process.stderr.startswith("astroinertia: numba 0.61.2 is installed") and process.stderr.count("\n") == 1
    assert ended(command.format(arguments=["--help"])).returncode == 0
    loaded = ended("import astroinertia; astroinertia.load('star.toml')")
    assert "InstallationError: numba 0.61.2" in loaded.stderr
    assert "star.toml" not in loaded.stderr.splitlines()[-1]
