"""What a test's result depends on, found by reading: all modules that can run, and few that cannot."""

import functools
import subprocess
import sys
from pathlib import Path

import pytest

from tests.imported_code import Code

ROOT = Path(__file__).parents[2]
FILES = {
    "astroinertia/__init__.py": "def run():\n    from astroinertia.run import go\n    go()\n",
    "astroinertia/errors.py": '"""Errors."""\nclass Broken(Exception):\n    """It broke."""\n',
    "astroinertia/run.py": "from astroinertia import errors\ndef go(): pass\n",
    "astroinertia/types.py": "x = 1\n",
    "astroinertia/gravity/__init__.py": "",
    "astroinertia/gravity/tree.py": "import typing\nif typing.TYPE_CHECKING:\n    import astroinertia.types\n",
    "astroinertia/gravity/fast.py": "def fast():\n    from . import tree\n    return tree\n",
    "astroinertia/effects/__init__.py": "",
    "astroinertia/effects/table.py": 'TABLE = {"pull": ("astroinertia.effects.pull", "Pull")}\n',
    "astroinertia/effects/pull.py": "from astroinertia.gravity.fast import fast\n",
    "astroinertia/effects/push.py": "y = 2\n",
    "astroinertia/engines/__init__.py": "",
    "astroinertia/engines/one.py": "",
    "astroinertia/engines/two.py": "",
    "astroinertia/start.py": "from importlib import import_module\n"
    "def engine(name): return import_module(f'astroinertia.engines.{name}')\n",
    "astroinertia/bodies.py": "def table(): return data_path('planets.csv')\n",
    "data/planets.csv": "a,b\n",
    "sims/star.toml": "",
    "sims/disc.toml": "",
    "tests/reference/top.json": "{}",
    "tests/helper.py": "from astroinertia.start import engine\n",
    "tests/child.py": "from astroinertia import bodies\n",
}
# A test file, and what it depends on besides the __init__ of every package on the way.
CASES = {
    "a module": ("from astroinertia.errors import Broken", {"astroinertia/errors.py"}),
    "a module of a package": ("from astroinertia import errors", {"astroinertia/errors.py"}),
    "a relative import within a function": (
        "import astroinertia.gravity.fast as fast",
        {"astroinertia/gravity/fast.py", "astroinertia/gravity/tree.py", "astroinertia/run.py",
         "astroinertia/errors.py"},
    ),
    "what a package defines": ("from astroinertia import run", {"astroinertia/run.py", "astroinertia/errors.py"}),
    "a table of modules": (
        "from astroinertia.effects import table",
        {"astroinertia/effects/table.py", "astroinertia/effects/pull.py", "astroinertia/gravity/fast.py",
         "astroinertia/gravity/tree.py"},
    ),
    "any of some modules, through a helper": (
        "def test():\n    from tests import helper",
        {"tests/helper.py", "astroinertia/start.py", "astroinertia/engines/one.py", "astroinertia/engines/two.py"},
    ),
    "a program": ("P = 'import sys; from astroinertia.gravity import tree'", {"astroinertia/gravity/tree.py"}),
    "a program with gaps": (
        "P = '''\n    from astroinertia.gravity import tree\n    x = {x!}\n    '''", {"astroinertia/gravity/tree.py"}
    ),
    "a module to run": ("command = ['-m', 'astroinertia.run']", {"astroinertia/run.py", "astroinertia/errors.py"}),
    "a file to run, and its data": (
        "P = Path(__file__).parents[1] / 'child.py'\nimport tests.child",
        {"tests/child.py", "astroinertia/bodies.py", "data/planets.csv"},
    ),
    "data": ("R = REFERENCE / 'top.json'", {"tests/reference/top.json"}),
    "scenes": ("def scene(name): return SIMS / f'{name}.toml'", {"sims/star.toml", "sims/disc.toml"}),
    "words alone": ("message = 'astroinertia cannot do this.'", set()),
}  # fmt: skip


@pytest.fixture
def tree(tmp_path):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.parametrize("case", CASES)
def test_all_that_can_run_is_found(case, tree):
    text, expected = CASES[case]
    (tree / "tests" / "test_it.py").write_text(text + "\n")
    found = Code(tree).closure("tests/test_it.py")
    assert {name for name in found if not name.endswith("__init__.py")} - {"tests/test_it.py"} == expected


def test_named_inputs_stand_for_names_with_gaps(tree):
    (tree / "tests" / "test_it.py").write_text(CASES["scenes"][0])
    code = Code(tree)
    before = code.digest("tests/test_it.py", ("sims/star.toml",)), code.digest("tests/test_it.py")
    (tree / "sims" / "disc.toml").write_text("a = 1")
    code = Code(tree)
    assert code.digest("tests/test_it.py", ("sims/star.toml",)) == before[0]
    assert code.digest("tests/test_it.py") != before[1]
    (tree / "sims" / "star.toml").write_text("a = 1")
    assert Code(tree).digest("tests/test_it.py", ("sims/star.toml",)) != before[0]


CHANGED = "astroinertia/gravity/tree.py"
DEPEND = {"tests/unit/gravity/test_multipole.py", "tests/physics/test_fast_runs.py"}  # itself; by names in a scene
DO_NOT = {
    "tests/physics/test_hydrostatic.py",
    "tests/unit/bodies/test_clairaut.py",
    "tests/unit/bodies/test_break_up.py",
}


@functools.cache
def as_it_is():
    """The code that is here."""
    return Code(ROOT)


def with_more(text):
    """The same with a text at the end of one file, which alone is read again."""
    code = Code(ROOT, lambda name: (ROOT / name).read_bytes() + (text if name == CHANGED else b""))
    code._files = {name: read for name, read in as_it_is()._files.items() if name != CHANGED}
    return code


@pytest.mark.slow
def test_a_line_in_gravity_makes_results_stale_that_depend_on_it_and_no_others():
    before = {name: as_it_is().digest(name) for name in DEPEND | DO_NOT}
    changed, only_said = with_more(b"\nTWO = 2\n"), with_more(b"\n# Only said.\n")
    assert {name for name in before if changed.digest(name) != before[name]} == DEPEND
    assert only_said.digest("tests/unit/gravity/test_multipole.py") == before["tests/unit/gravity/test_multipole.py"]


@pytest.mark.full
def test_what_a_run_of_the_command_line_imports_was_found(tmp_path):
    program = (
        "import sys; from astroinertia.cli.main import main; main(sys.argv[1:]);"
        "print(*(m.__file__ for n, m in sys.modules.items() if n.partition('.')[0] == 'astroinertia'), sep='\\n')"
    )
    command = [sys.executable, "-c", program, "run", "sims/gyroscope.toml", "--output", str(tmp_path / "run")]
    command += ["--set", 'time.end="0.1 s"']
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    loaded = {str(Path(line).relative_to(ROOT)) for line in done.stdout.splitlines() if line.endswith(".py")}
    assert len(loaded) > 100
    assert loaded <= as_it_is().closure("astroinertia/cli/main.py")
