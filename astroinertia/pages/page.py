"""What pages share: the style sheet, text that cannot become markup, and what a browser is allowed to do with them."""

import base64
import hashlib
import json
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import xarray as xr

from astroinertia.storage import overwriting
from astroinertia.storage.atomic import write_whole

HERE = Path(__file__).parent


def filled(template: str, **parts: str) -> str:
    """A page from a file beside this one; the parts are markup already."""
    return Template((HERE / template).read_text(encoding="utf-8")).substitute(parts)


def write_page(path: Path, markup: str) -> None:
    """Write a page whole or not at all; ArchiveError where that cannot be done, or would destroy what is no page."""
    overwriting.check(path, overwriting.HTML)
    write_whole(path, lambda aside: aside.write_text(markup, encoding="utf-8"))


def text(value: Any) -> str:
    """Text of anybody's as markup that shows it, and does nothing else."""
    return escape(str(value), quote=True)


def data_block(value: Any) -> str:
    """JSON that stands inside a script element and cannot end it."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def policy(script: str | None = None) -> str:
    """What a page may do: show itself and pictures that it holds, and run this one script."""
    rules = [
        "default-src 'none'",
        "img-src data:",
        "style-src 'unsafe-inline'",
        "base-uri 'none'",
        "form-action 'none'",
    ]
    if script is not None:
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        rules.append(f"script-src 'sha256-{digest}'")
    return "; ".join(rules)


def name_of(dataset: xr.Dataset) -> str:
    """The run's name as it is said."""
    return str(dataset.attrs.get("name", "run")).replace("_", " ")
