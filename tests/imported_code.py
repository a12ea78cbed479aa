"""All code that a test can run, found by reading: what its file imports of the package and of tests/, transitively.

Nothing is imported for it. Counted are imports anywhere in a file, within functions too; modules that a text names (a
table of modules, a program that a test runs in another process); all modules that a text with gaps could name, as in
`f"astroinertia.engines.{name}"`; and the data files that a text names. Of a package whose submodule is imported only
what runs at its own import counts.
"""

import ast
import hashlib
import re
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

TOPS = ("astroinertia", "tests")
DATA = ("sims", "data", "tests/reference", "tests/data", "tests/benchmarks")  # where texts name files, beside their own
DATA_SUFFIXES = (".toml", ".json", ".csv")
GAP = "*"
MODULE = re.compile(rf"(?:{'|'.join(TOPS)})(?:\.[\w{GAP}]+)+")
LONGEST_NAME = 100
BODIES = ("module", "functions")  # what runs at import, and what may run later


@dataclass(frozen=True)
class Needs:
    """What a part of a file needs: modules with what their functions need, texts that may name modules or files."""

    imports: set[str] = field(default_factory=set)  # with their functions
    packages: set[str] = field(default_factory=set)  # only what runs at their import
    members: set[tuple[str, str]] = field(default_factory=set)  # `from a import b`: b may be a module
    texts: set[str] = field(default_factory=set)


class Code:
    """The files below a root; `read` gives a file's bytes by its path from there."""

    def __init__(self, root: Path, read: Callable[[str], bytes] | None = None):
        self.root = root
        self.read = read or (lambda name: (root / name).read_bytes())
        self._files: dict[str, tuple[str, dict[str, Needs]]] = {}
        self._closures: dict[tuple[str, bool], frozenset[str]] = {}
        self._steps: dict[tuple[str, str, bool], list[tuple[str, str]]] = {}  # what parts of files lead to
        self._digests: dict[str, str] = {}
        paths = sorted(path for top in TOPS for path in (root / top).rglob("*.py"))
        self._modules = {_module(path.relative_to(root)): path.relative_to(root).as_posix() for path in paths}
        self._named: dict[str, list[str]] = {}  # files that a text can name, by their last part
        for path in sorted(path for folder in DATA for path in (root / folder).rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                self._named.setdefault(path.name, []).append(path.relative_to(root).as_posix())

    def digest(self, test: str, inputs: tuple[str, ...] | None = None) -> str:
        """A hash of all that the test file `test` can run, comments, docstrings and layout left out, and of `inputs`.

        Where inputs are given (those that a test's marker names), names with gaps in its own file name no others.
        """
        files = self.closure(test, inputs is None) | set(inputs or ())
        lines = [f"{name} {self._digest(name)}" for name in sorted(files)]
        return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]

    def closure(self, test: str, gaps: bool = True) -> frozenset[str]:
        """Files, by their paths from the root, that the code of the file `test` consists of and reads."""
        if (test, gaps) not in self._closures:
            self._closures[test, gaps] = frozenset(self._found(test, gaps))
        return self._closures[test, gaps]

    def _found(self, test: str, gaps: bool) -> set[str]:
        seen: set[tuple[str, str]] = set()
        todo = [(test, body) for body in BODIES]
        while todo:
            if (place := todo.pop()) in seen:
                continue
            seen.add(place)
            name, body = place
            if name.endswith(".py"):
                todo += self._led_to(name, body, gaps or name != test)
        return {name for name, _ in seen}

    def _led_to(self, name: str, body: str, gaps: bool) -> list[tuple[str, str]]:
        part = name, body, gaps
        if part not in self._steps:
            self._steps[part] = list(self._needed(name, self._parsed(name)[1][body], gaps))
        return self._steps[part]

    def _needed(self, name: str, needs: Needs, gaps: bool) -> Iterator[tuple[str, str]]:
        whole, bare = set(needs.imports), set(needs.packages)
        for module, member in needs.members:
            inner = f"{module}.{member}"
            if inner in self._modules:
                whole.add(inner)
                bare.add(module)
            else:  # a name that the module itself defines
                whole.add(module)
        for text in needs.texts:
            whole |= self._modules_named(text)
            yield from ((file, body) for file in self._files_named(name, text, gaps) for body in BODIES)
        for module in whole | bare:
            parts = module.split(".")
            bare |= {".".join(parts[:count]) for count in range(1, len(parts))}
        for module in whole | bare:
            if (file := self._modules.get(module)) is not None:
                yield from ((file, body) for body in (BODIES if module in whole else BODIES[:1]))

    def _modules_named(self, text: str) -> set[str]:
        named = set()
        for found in MODULE.findall(text):
            if GAP in found:
                named |= {module for module in self._modules if fnmatchcase(module, found)}
                continue
            while found not in self._modules and "." in found:
                found = found.rpartition(".")[0]
            named |= {found} - set(TOPS)
        return named

    def _files_named(self, name: str, text: str, gaps: bool) -> set[str]:
        if not 0 < len(text) <= LONGEST_NAME or "\n" in text:
            return set()
        last, of_tests = text.rpartition("/")[2], name.startswith("tests/")
        if GAP in last:
            if not (gaps and of_tests and last.endswith(DATA_SUFFIXES)):
                return set()
            return {file for key, files in self._named.items() if fnmatchcase(key, last) for file in files}
        found = {file for file in self._named.get(last, ()) if of_tests or file.startswith("data/")}
        beside = (Path(name).parent / text).as_posix()
        if "." in last and ".." not in text and not text.startswith("/") and (self.root / beside).is_file():
            found.add(beside)
        folder = f"tests/data/{text}/"
        return found | {file for files in self._named.values() for file in files if file.startswith(folder)}

    def _digest(self, name: str) -> str:
        if name not in self._digests:
            if name.endswith(".py"):
                self._digests[name] = self._parsed(name)[0]
            else:
                self._digests[name] = hashlib.sha256(self.read(name)).hexdigest()
        return self._digests[name]

    def _parsed(self, name: str) -> tuple[str, dict[str, Needs]]:
        if name not in self._files:
            tree = ast.parse(self.read(name))
            _drop_docstrings(tree)
            package = _module(Path(name)) if name.endswith("__init__.py") else _module(Path(name)).rpartition(".")[0]
            reader = _Reader(package)
            reader.visit(tree)
            self._files[name] = hashlib.sha256(ast.unparse(tree).encode()).hexdigest(), reader.needs
        return self._files[name]


def _module(path: Path) -> str:
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _drop_docstrings(tree: ast.Module) -> None:
    for node in ast.walk(tree):
        documented = isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        if documented and ast.get_docstring(node, clean=False) is not None:
            node.body = node.body[1:] or [ast.Pass()]


class _Reader(ast.NodeVisitor):
    """Collects what the module level of a file needs, and what its functions do."""

    def __init__(self, package: str):
        self.package, self.body = package, "module"
        self.needs = {body: Needs() for body in BODIES}

    def visit_FunctionDef(self, node: ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) -> None:
        outer = self.body
        for part in (*getattr(node, "decorator_list", ()), node.args):  # these run where the function is defined
            self.visit(part)
        self.body = "functions"
        for part in node.body if isinstance(node.body, list) else [node.body]:
            self.visit(part)
        self.body = outer

    visit_AsyncFunctionDef = visit_Lambda = visit_FunctionDef

    def visit_If(self, node: ast.If) -> None:
        if "TYPE_CHECKING" in ast.dump(node.test):  # for readers alone: never run
            for part in node.orelse:
                self.visit(part)
            return
        self.generic_visit(node)

    def visit_Import(self, node: ast.Import) -> None:
        for alias in node.names:
            parts = alias.name.split(".")
            if parts[0] in TOPS:  # `import a.b` gives all of a and of a.b
                self.needs[self.body].imports.update(".".join(parts[:count]) for count in range(1, len(parts) + 1))

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        module = node.module or ""
        if node.level:
            base = self.package.split(".")
            module = ".".join([*base[: len(base) - node.level + 1], *([module] if module else [])])
        if module.split(".")[0] in TOPS:
            self.needs[self.body].members.update((module, alias.name) for alias in node.names)

    def visit_Constant(self, node: ast.Constant) -> None:
        if isinstance(node.value, str):
            self._text(node.value)

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        parts = (part.value if isinstance(part, ast.Constant) else GAP for part in node.values)
        self._text("".join(str(part) for part in parts))
        self.generic_visit(node)

    def _text(self, text: str) -> None:
        self.needs[self.body].texts.add(text)
        if "import" in text and any(top in text for top in TOPS):
            self._program(text)

    def _program(self, text: str) -> None:
        """What a text imports if it is a program, which a test may run in another process."""
        try:
            tree = ast.parse(textwrap.dedent(text))
        except SyntaxError:  # a program with gaps to fill: its lines that import can be read nonetheless
            lines = (line.strip() for part in text.splitlines() for line in part.split(";"))
            for line in lines:
                if line.startswith(("import ", "from ")) and line != text:
                    self._program(line)
            return
        outer, self.body = self.body, "functions"
        self.visit(tree)
        self.body = outer
