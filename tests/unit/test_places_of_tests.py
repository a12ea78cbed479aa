"""The test of a file is found by its name: tests/unit mirrors the package."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]
UNIT = ROOT / "tests" / "unit"
PACKAGE = ROOT / "astroinertia"


def imported(test: Path) -> set[str]:
    """Modules, and names in them, that a test imports anywhere in its file."""
    names = set()
    for node in ast.walk(ast.parse(test.read_bytes())):
        if isinstance(node, ast.ImportFrom):
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return names


def in_its_place(test: Path) -> bool:
    """Whether a test lies in the folder of what it tests: one module, by its name, or several, by another name.

    A name may go on after that of the module or of the room. Tests of several rooms, or of the tree, lie at the root.
    """
    folder = PACKAGE / test.parent.relative_to(UNIT)
    if not (folder / "__init__.py").is_file():
        return False
    modules = {path.stem for path in folder.glob("*.py")}
    name = test.stem.removeprefix("test_")
    if any(name == module or name.startswith(f"{module}_") for module in modules | {folder.name}):
        return True
    rooms = {path.parent.name for path in folder.glob("*/__init__.py")}
    prefix = ".".join(folder.relative_to(ROOT).parts) + "."
    used = {name.removeprefix(prefix).partition(".")[0] for name in imported(test) if name.startswith(prefix)}
    if folder == PACKAGE:
        return len(used & rooms) != 1
    return len(used & (modules | rooms)) > 1


def test_tests_lie_in_the_folder_of_what_they_test() -> None:
    tests = sorted(UNIT.rglob("test_*.py"))
    assert len(tests) > 200
    assert [test.relative_to(UNIT).as_posix() for test in tests if not in_its_place(test)] == []
