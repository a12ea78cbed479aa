"""What users install and run: the wheel in an environment of its own, not the checkout that tests import."""

import pytest
from hatchling.builders.sdist import SdistBuilder

from tests.installed.environment import ROOT, run, run_scenes, wheel, with_the_wheel

PLACES = """
import importlib.util as found
from importlib.resources import files
import astroinertia
print(astroinertia.__file__)
print(found.find_spec("pytest"), found.find_spec("dask"))
print(*sorted(each.name for each in files("astroinertia.data").iterdir()))
"""
# One start for commands that take no time: each is a part of the installed package, read from where it lies there.
COMMANDS = """
from astroinertia.cli.main import main
for words in (
    ["ratios", "--body", "Mars"], ["new", "--from", "evrard", "cloud.toml"], ["plan", "cloud.toml"],
    ["guide", "ledger"], ["guide", "scene"], ["guide", "effects"],
):
    assert main(words) == 0
    print("and then")
"""


def test_the_source_distribution_has_what_its_commands_and_tests_read():
    held = {each.distribution_path for each in SdistBuilder(str(ROOT)).recurse_included_files()}
    read = {"Makefile", "README.md", ".ci/constraints.txt", ".ci/run", ".ci/docs/build_site.py"}
    assert read - held == set()
    assert "astroinertia/py.typed" in held
    assert not [name for name in held if "__pycache__" in name or name.startswith((".venv", ".cache", "runs/"))]


@pytest.mark.slow
def test_each_model_runs_from_the_wheel_with_only_what_it_asks_for(tmp_path):
    elsewhere = tmp_path / "empty"
    elsewhere.mkdir()
    programs = with_the_wheel(wheel(tmp_path), tmp_path / "environment")
    place, missing, names = run([programs / "python", "-c", PLACES], elsewhere).splitlines()
    assert place.startswith(str(tmp_path / "environment"))
    assert missing == "None None"
    for name in names.split():
        assert (ROOT / "data" / name).exists()
    run_scenes(programs, elsewhere)
    said = run([programs / "python", "-c", COMMANDS], elsewhere).split("and then\n")
    words = ("Mars", "cloud.toml", "power law of exponent 1", "# The ledger", 'kind = "polytrope"', "## `gravity`")
    assert [word in each for word, each in zip(words, said, strict=False)] == [True] * 6
    evrard = (ROOT / "sims" / "evrard.toml").read_text()
    assert (elsewhere / "cloud.toml").read_text() == evrard.replace('name = "evrard"', 'name = "cloud"')
