"""A report of a run in one HTML file: scene, plan, summary, pictures, ledger, accuracy, versions, and how to repeat it.

Nothing in it is a script, and it forbids a browser to load or run anything. Whatever the result says of
itself, its name, scene or attributes, may come from anybody, and is shown as text.
"""

import base64
import io
import json
import shlex
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from astroinertia import plots
from astroinertia.dataset.absent import with_absent
from astroinertia.dataset.bounds import message
from astroinertia.pages.page import filled, name_of, policy, text, write_page
from astroinertia.plots import style
from astroinertia.plots.in_words import Table, heading, tables
from astroinertia.plots.shown_units import raised

CAPTIONS = {
    "inertia": "The moment of inertia by its own evolution equation, and summed over the body",
    "spin": "The spin against what scaling laws say, and how it is spread over the body",
    "attitude": "The attitude: rates about the body's own axes, Euler angles, the polhode",
    "ledger": "The ledger: what each effect does to the moment of inertia and to the angular momentum",
    "shape": "The shape: semi-axes of the equivalent ellipsoid, and its outline through time",
    "energy": "Energies, the work and heat of each effect, and the errors",
    "profiles": "Profiles of density, rotation and specific angular momentum",
    "waves": "Gravitational waves, strain times distance",
    "error_bars": "Error bars over the values that they belong to",
    "density": "Slices of the density, with the flow",
    "projection": "Column density side-on and pole-on; lines are principal axes, as long as the tensor makes them",
    "exact": "Beside the exact flow",
}
RESOLUTION = 110  # dots an inch of the pictures
_CARDS = ("moment of inertia", "mean angular velocity", "ledger closure", "change of the total energy")
_REPEATED = ("model", "engine", "precision", "kernel", "neighbours", "seed", "approximation", "frame", "units_system",
             "measured_wall_time", "measured_memory", "Conventions", "astroinertia_format")  # fmt: skip


@with_absent
def write_report(dataset: xr.Dataset, snapshots: xr.Dataset | None, path: Path) -> int:
    """Write the report; how many pictures are in it. ArchiveError where it cannot be written.

    Tests: tests/unit/pages/test_pages.py.
    """
    pictures = [_figure(name, figure) for name, figure in plots.figures(dataset, snapshots)]
    attrs, summary = dataset.attrs, tables(dataset)
    sections = {
        "Summary": "".join(_table(table) for table in summary),
        "Pictures": "".join(pictures),
        "Plan": _pre(attrs.get("plan")),
        "Scene": _pre(attrs.get("scene")),
        "How to repeat it": _repeat(attrs),
    }
    sections = {title: body for title, body in sections.items() if body}
    # The first line of the heading is the name and the description, which stand above it.
    how = " ".join(heading(dataset).splitlines()[-1:])
    warnings = message(attrs, "resolution")
    page = filled(
        "report.html",
        policy=text(policy()),
        name=text(name_of(dataset)),
        description=text(attrs.get("description", "")),
        heading=text(how),
        warnings=f'<div class="warning">{text(warnings)}</div>' if warnings else "",
        cards="".join(_cards(summary)),
        contents="".join(f'<a href="#{_anchor(title)}">{title}</a>' for title in sections),
        sections="".join(f'<section id="{_anchor(k)}"><h2>{k}</h2>{body}</section>' for k, body in sections.items()),
        version=text(_version()),
    )
    write_page(path, page)
    return len(pictures)


def _figure(name: str, figure: Figure) -> str:
    stream = io.BytesIO()
    style.write_png(figure, stream, RESOLUTION)
    coded, caption = base64.b64encode(stream.getvalue()).decode(), text(CAPTIONS[name])
    return (
        f'<figure><img src="data:image/png;base64,{coded}" alt="{caption}"><figcaption>{caption}</figcaption></figure>'
    )


def _table(table: Table) -> str:
    head = "".join(f"<th>{text(raised(cell))}</th>" for cell in table.head)
    body = "".join(_row(row, len(table.widths)) for row in table.rows)
    below = f'<p class="soft">{text(raised(table.below))}</p>' if table.below else ""
    head = f"<thead><tr>{head}</tr></thead>" if head else ""
    inside = f'<div class="scroll"><table>{head}<tbody>{body}</tbody></table></div>'
    return f"<h3>{text(table.title)}</h3>{inside}{below}"


def _row(cells: tuple[str, ...], columns: int) -> str:
    # Cells beyond the columns of numbers are words that say of what they are.
    numbered = (f"<td>{text(raised(cell))}</td>" for cell in cells[:columns])
    words = (f'<td class="words soft">{text(cell)}</td>' for cell in cells[columns:])
    return f"<tr>{''.join(numbered)}{''.join(words)}</tr>"


def _cards(summary: list[Table]) -> Iterator[str]:
    for name, *cells in (row for table in summary for row in table.rows):
        if name.startswith(_CARDS):
            # A series goes from its start to its end; a figure of accuracy has one number.
            shown = cells[0] if len(cells) < 4 else f"{cells[0]} → {cells[-1]}"
            yield f'<div class="card"><b>{text(shown)}</b><span>{text(raised(name))}</span></div>'


def _pre(words: Any) -> str:
    return f"<pre>{text(words)}</pre>" if words else ""


def _repeat(attrs: dict[Any, Any]) -> str:
    file = f"{attrs.get('name', 'scene')}.toml"
    overrides = _listed(attrs.get("overrides"))
    settings = "".join(f" --set {shlex.quote(str(line))}" for line in overrides) if isinstance(overrides, list) else ""
    command = f"astroinertia run {shlex.quote(file)}{settings}"
    rows = [(name.replace("_", " "), str(attrs[name])) for name in _REPEATED if name in attrs]
    versions = _listed(attrs.get("versions"))
    if isinstance(versions, dict):
        rows += [(f"version of {name}", str(value)) for name, value in versions.items()]
    cells = "".join(f'<tr><td>{text(name)}</td><td class="words">{text(value)}</td></tr>' for name, value in rows)
    instruction = (
        f"<p>Save the scene above as {text(file)}, with the files that it names beside it, and run:</p>{_pre(command)}"
    )
    return f'{instruction if attrs.get("scene") else ""}<div class="scroll"><table><tbody>{cells}</tbody></table></div>'


def _listed(value: Any) -> Any:
    """Lists and tables among the attributes are JSON text; what is not stays as it is."""
    try:
        return json.loads(value) if isinstance(value, str) else value
    except ValueError:
        return value


def _anchor(title: str) -> str:
    return title.lower().replace(" ", "-")


def _version() -> str:
    try:
        return version("astroinertia")
    except PackageNotFoundError:
        return ""
