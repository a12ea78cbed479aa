"""The oldest versions of everything that the package allows: the floor of each dependency is tried, not guessed."""

import sys
from importlib.metadata import version

import pytest

from tests.installed.environment import FEW, ROOT, STAR, run, run_scenes, wheel
from tests.installed.floors import dependencies, floors

QUICK = (
    "bodies/test_oscillations", "dataset/test_dataset", "engines/test_adaptive", "engines/test_numba_cpu",
    "engines/test_pytree", "engines/test_xla", "gravity/test_multipole", "ledger/test_moments",
    "orbits/test_simulation", "process/test_blas", "process/test_requirements", "scene/test_scene",
    "test_problems/test_exact_solutions",
)  # fmt: skip
FILES = [ROOT / "tests" / "unit" / f"{name}.py" for name in QUICK]


def test_the_floor_of_each_dependency_is_its_least_version():
    assert floors(["numba>=0.62,<0.69", "rebound<6,>=5.2.2", "jaxlib!=0.10.2"]) == ["numba==0.62", "rebound==5.2.2"]
    assert "rebound==5.2.2" in floors(dependencies())  # those before refuse the heartbeat that long orbits are read by
    open_ended = [each for each in dependencies() if ">=" not in each]
    assert [each.split("!")[0] for each in open_ended] == ["jaxlib"]  # which jax asks for by version


def test_the_tests_that_the_oldest_versions_are_to_pass_are_there():
    assert [file for file in FILES if not file.exists()] == []


@pytest.mark.full(inputs=["pyproject.toml"])
def test_the_oldest_versions_allowed_run_each_model_and_pass_quick_tests(tmp_path, result):
    elsewhere = tmp_path / "empty"
    elsewhere.mkdir()
    constraints = tmp_path / "oldest.txt"
    constraints.write_text("\n".join([*floors(dependencies()), ""]))
    run([sys.executable, "-m", "venv", tmp_path / "environment"], elsewhere)
    programs = tmp_path / "environment" / "bin"
    testing = [f"{name}=={version(name)}" for name in ("pytest", "hypothesis", "mpmath")]
    installing = [programs / "python", "-m", "pip", "install", "-q", "-c", constraints, wheel(tmp_path), *testing]
    run(installing, elsewhere, PIP_CONSTRAINT=str(constraints))
    listing = "import sys; from importlib.metadata import version; print(*map(version, sys.argv[1:]))"
    names = [each.split("==")[0] for each in floors(dependencies())]
    found = dict(zip(names, run([programs / "python", "-c", listing, *names], elsewhere).split(), strict=True))
    run_scenes(programs, elsewhere)
    few = [part for setting in (*FEW, "numerics.engine=xla") for part in ("--set", setting)]
    run([programs / "astroinertia", "run", STAR, *few, "--output", "xla"], elsewhere)
    # what is deprecated since is no error there
    command = [programs / "python", "-m", "pytest", "-q", "-m", "quick and not full", "-W", "default", *FILES]
    output = run([*command, "-p", "no:cacheprovider"], ROOT)
    result(versions=found, tests=output.strip().splitlines()[-1])
