"""`make docs`: puts the pages of the site together in build/docs, and has mkdocs render them into build/site.

The README, the guide with its two references, the scenes of sims/ with what they show, the notebooks with their
output, and one page of the Python interface for each module. A warning of mkdocs, such as a dead link, ends it.
"""

import ast
import json
import logging
import re
import shutil
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.commands.build import build
from mkdocs.config import load_config
from mkdocs.exceptions import Abort
from nbconvert import MarkdownExporter
from traitlets.config import Config

from astroinertia.guide import pages

ROOT = Path(__file__).parents[2]
PAGES, SITE = ROOT / "build" / "docs", ROOT / "build" / "site"
# Where a file of the repository is in the site; the first that fits. A file that is nowhere is named, without a link.
PLACES = (
    (r"README\.md", "index.md"),
    (r"astroinertia/guide/(.*\.md)", r"guide/\1"),
    (r"data/pictures/(.*)", r"pictures/\1"),
    (r"tests/benchmarks/results/(.*\.png)", r"pictures/\1"),
    (r"sims/README\.md", "scenes/index.md"),
    (r"sims/notebooks/(.*)\.ipynb", r"notebooks/\1.md"),
)
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
COMMAND = re.compile(r"(?<!\[)`astroinertia guide ([a-z-]+)`")
# Rooms and modules that only the package itself calls, and names that begin with an underscore.
INSIDE = (
    *("audit", "build", "cli", "costs", r"dataset\.(?!accessor)[a-z_]+", "engines", "guide", "pages"),
    *("process", "run", "storage", "verify"),
)
HIDDEN = re.compile(rf"({'|'.join(INSIDE)})(?![a-z])|(.*\.)?_")


def main() -> None:
    """Build the site."""
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s: %(message)s")
    shutil.rmtree(PAGES, ignore_errors=True)
    for folder in ("data/pictures", "tests/benchmarks/results"):
        for picture in (ROOT / folder).glob("*.png"):
            write(f"pictures/{picture.name}", picture.read_bytes())
    for name in ("iframe-worker.js", "site.css"):
        write(name, (ROOT / ".ci/docs" / name).read_bytes())
    write("index.md", page((ROOT / "README.md").read_text(), "README.md"))
    for topic in pages.TOPICS:
        write(f"guide/{topic}.md", page(pages.page(topic), f"astroinertia/guide/{topic}.md"))
    write("guide/index.md", topics())
    write("scenes/index.md", page((ROOT / "sims/README.md").read_text(), "sims/README.md"))
    write("scenes/files.md", scenes())
    notebooks = [notebook(path) for path in sorted((ROOT / "sims/notebooks").glob("*.ipynb"))]
    navigation = [
        {"Home": "index.md"},
        {"Guide": ["guide/index.md", *(f"guide/{topic}.md" for topic in pages.TOPICS)]},
        {"Scenes": [{"What they show": "scenes/index.md"}, {"Their files": "scenes/files.md"}]},
        {"Notebooks": notebooks},
        {"Python": interface()},
    ]
    config = load_config(
        str(ROOT / ".ci/docs/mkdocs.yml"), docs_dir=str(PAGES), site_dir=str(SITE), nav=navigation, strict=True
    )
    try:
        build(config)
    except Abort as found:
        raise SystemExit(str(found)) from None


def write(name: str, content: str | bytes) -> None:
    """Write a file of the site's sources."""
    path = PAGES / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())


def page(text: str, source: str) -> str:
    """A page of the repository with its links as they are in the site."""
    here = place(source)
    assert here is not None, source

    def moved(link: re.Match[str]) -> str:
        mark, said, target = link.groups()
        if "://" in target or target.startswith("#"):
            return link.group()
        file, _, anchor = target.partition("#")
        linked_file = resolved(source, file)
        if not (ROOT / linked_file).exists() and Path(file).stem not in pages.WRITTEN_WHEN_READ:
            raise SystemExit(f"{source} has a dead link: {target}")
        there = place(linked_file)
        if there is None:
            return said
        return f"{mark}[{said}]({relative(here, there)}{f'#{anchor}' if anchor else ''})"

    def linked(command: re.Match[str]) -> str:
        topic = command.group(1)
        return (
            f"[{command.group()}]({relative(here, f'guide/{topic}.md')})" if topic in pages.TOPICS else command.group()
        )

    return pages.outside_code(text, lambda line: COMMAND.sub(linked, LINK.sub(moved, line)))


def place(file: str) -> str | None:
    """Where a file of the repository is in the site; None if it is not there."""
    for pattern, there in PLACES:
        if match := re.fullmatch(pattern, file):
            return match.expand(there)
    return None


def resolved(source: str, target: str) -> str:
    """The path in the repository that a relative link of a file means."""
    return str((ROOT / source).parent.joinpath(target).resolve().relative_to(ROOT))


def relative(here: str, there: str) -> str:
    """A link from one page of the site to another."""
    return "../" * here.count("/") + there


def topics() -> str:
    """The first page of the guide."""
    lines = [f"- [{topic}]({topic}.md): {text}" for topic, text in pages.TOPICS.items()]
    return "\n".join(["# Guide", "", "In a terminal, `astroinertia guide TOPIC` shows the same pages.", "", *lines, ""])


def scenes() -> str:
    """The text of every scene, with what its first comment says."""
    parts = ["# The files of the scenes", "Every scene runs as it stands: `astroinertia run sims/NAME.toml`."]
    for path in sorted((ROOT / "sims").glob("*.toml")):
        parts.append(f"## {path.stem}\n\n```toml\n{path.read_text().rstrip()}\n```")
    return "\n\n".join(parts) + "\n"


def notebook(path: Path) -> str:
    """A notebook as it was executed, with its pictures; returns its page."""
    shown = ["image/png", "text/markdown", "text/plain"]
    exporter = MarkdownExporter(config=Config({"NbConvertBase": {"display_data_priority": shown}}))
    text, resources = exporter.from_filename(
        str(path), resources={"unique_key": path.stem, "output_files_dir": path.stem}
    )
    for name, picture in resources["outputs"].items():
        write(f"notebooks/{name}", picture)
    write(f"notebooks/{path.stem}.md", with_formulas(text))
    return f"notebooks/{path.stem}.md"


def with_formulas(text: str) -> str:
    """Markdown with its formulas as MathML, which browsers show by themselves."""

    def displayed(formula: re.Match[str]) -> str:
        return f"\n\n<div>{convert(formula[1].strip(), display='block')}</div>\n\n"

    def inline(formula: re.Match[str]) -> str:
        return f"<span>{convert(formula[1])}</span>"

    pieces = re.split(r"(^```.*?^```$|^    [^\n]*$|`[^`\n]*`)", text, flags=re.MULTILINE | re.DOTALL)
    for k in range(0, len(pieces), 2):  # what is between blocks and pieces of code
        pieces[k] = re.sub(r"\$\$(.+?)\$\$", displayed, pieces[k], flags=re.DOTALL)
        pieces[k] = re.sub(r"\$([^$\s](?:[^$]*[^$\s])?)\$", inline, pieces[k])
    return "".join(pieces)


def interface() -> list:
    """A page for each module that has something public; returns them by room."""
    rooms: dict[str, list] = {}
    for path in sorted((ROOT / "astroinertia").rglob("*.py")):
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        members = public(path)
        if HIDDEN.match(name.removeprefix("astroinertia").lstrip(".")) or not members:
            continue
        write(f"python/{name}.md", f"::: {name}\n    options:\n      members: {json.dumps(members)}\n")
        room = name.split(".")[1] if name.count(".") > 1 else "astroinertia"
        rooms.setdefault(room, []).append({name.removeprefix("astroinertia."): f"python/{name}.md"})
    return [{room: modules} for room, modules in rooms.items()]


def public(path: Path) -> list[str]:
    """The public functions and classes of a module, also those that it takes from elsewhere to offer them."""
    found = []
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.append(node.name)
        elif isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            found += ast.literal_eval(node.value)
        elif isinstance(node, ast.ImportFrom):
            found += [alias.name for alias in node.names if alias.asname == alias.name]
    return [name for name in dict.fromkeys(found) if not name.startswith("_")]


if __name__ == "__main__":
    main()
