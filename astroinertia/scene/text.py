"""Scene text that is written by the program: TOML values, and a text with its overrides put in."""

import re
from collections.abc import Sequence
from typing import Any

from astroinertia.errors import SceneError
from astroinertia.scene.source import key_of, line_of, override, override_value, parse

LONG = 400  # characters of a value on one line; a line of a scene may have 1 KiB, and one character up to 10 bytes
IN_ORDER = ("effects", "candidates", "regions", "observables")  # tables whose entries are rows of records

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_HEADER = re.compile(r"\s*\[\[?\s*([A-Za-z0-9_-]+)[^\[\]=]*\]\]?\s*(#.*)?")
_WHOLE_LINE = re.compile(r"(\s*)([A-Za-z0-9_.-]+)\s*=.*")


def toml_value(value: Any) -> str:
    """A TOML value on one line, inline tables included; TypeError for what a scene cannot hold."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{"".join(_escaped(character) for character in value)}"'
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value)  # TOML writes nan and inf as Python does
    if isinstance(value, list | tuple):
        return f"[{', '.join(toml_value(item) for item in value)}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{toml_key(key)} = {toml_value(item)}' for key, item in value.items())}}}"
    raise TypeError(f"{type(value).__name__} has no place in a scene")


def toml_key(key: str) -> str:
    """A key, quoted where it must be."""
    return key if _BARE.fullmatch(key) else toml_value(key)


def _escaped(character: str) -> str:
    if character in '"\\':
        return "\\" + character
    if character.isprintable():
        return character
    return f"\\u{ord(character):04x}" if ord(character) < 0x10000 else f"\\U{ord(character):08x}"


def toml_text(tables: dict[str, Any], path: tuple[str, ...] = (), listed: bool = False) -> str:
    """A TOML document: plain keys first, then a section for each table, and for each of several in a list.

    listed: whether the table at the path is one of several.
    """
    several = {key: item for key, item in tables.items() if _are_tables(item)}
    inner = {key: item for key, item in tables.items() if isinstance(item, dict)}
    others = [key for key in tables if key not in several and key not in inner]
    plain = [f"{toml_key(key)} = {_broken(tables[key])}" for key in others]
    header = [f"[{_dotted(path)}]"] if path and not listed and (plain or not tables) else []
    header += [f"[[{_dotted(path)}]]"] if listed else []
    sections = [toml_text(inner[key], (*path, key)) for key in inner]
    sections += [toml_text(item, (*path, key), listed=True) for key in several for item in several[key]]
    return "\n\n".join(part for part in ("\n".join(header + plain), *sections) if part)


def _dotted(path: tuple[str, ...]) -> str:
    return ".".join(toml_key(part) for part in path)


def _are_tables(value: Any) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(item, dict) for item in value)


def _broken(value: Any) -> str:
    """A value over several lines where one line would be too long to be read back."""
    text = toml_value(value)
    if len(text) <= LONG:
        return text
    if isinstance(value, str):
        pieces = [value[start : start + LONG // 4] for start in range(0, len(value), LONG // 4)]
        lines = [toml_value(piece)[1:-1] for piece in pieces]
        # a backslash at the end of a line removes the white space that begins the next
        lines = [f"\\u0020{line[1:]}" if line.startswith(" ") else line for line in lines]
        return '"""\\\n' + "\\\n".join(lines) + '"""'
    if isinstance(value, list | tuple):
        return "[\n" + ",\n".join(_broken(item) for item in value) + ",\n]"
    return text


def with_overrides(text: str, overrides: Sequence[str]) -> str:
    """The text that says on its own what `text` says with its overrides; comments are kept where they can be.

    Tables whose entries are rows of records keep the order that overrides give them: a run goes on with this text.
    """
    for item in overrides:
        wanted = override(parse(text, "the scene"), [item])
        said = item.partition("=")[2].strip()
        edited = _edited(text, key_of(item), f"{toml_value(override_value(said, item))}  # --set")
        try:
            found = parse(edited, "the scene")
            kept = found == wanted and all(repr(found.get(name)) == repr(wanted.get(name)) for name in IN_ORDER)
        except SceneError:
            kept = False
        # an override inside an inline table or over several lines cannot be placed by lines; then comments are lost
        text = edited if kept else toml_text(wanted) + "\n"
    return text


def _edited(text: str, path: tuple[str, ...], value: str) -> str:
    lines = text.split("\n")
    *tables, key = path
    at = line_of(text, path)
    entry = _WHOLE_LINE.fullmatch(lines[at - 1]) if at else None
    if at and entry and entry[2].split(".")[-1] == key:
        lines[at - 1] = f"{entry[1]}{entry[2]} = {value}"
    elif not tables:
        lines.insert(0, f"{key} = {value}")
    elif at and re.fullmatch(rf"\s*\[\s*{re.escape('.'.join(tables))}\s*\].*", lines[at - 1]):
        lines.insert(_end_of_table(lines, at) if path[0] in IN_ORDER else at, f"{key} = {value}")
    else:
        lines += [f"[{'.'.join(tables)}]", f"{key} = {value}", ""]
    return "\n".join(lines)


def _end_of_table(lines: list[str], begun: int) -> int:
    # Behind the last line of what the header above line `begun` (from 0) begins.
    end = next((at for at in range(begun, len(lines)) if _HEADER.fullmatch(lines[at])), len(lines))
    while end > begun and not lines[end - 1].strip():
        end -= 1
    return end


def without_table(text: str, table: str) -> str:
    """The text without a table and those below it; its lines stay, empty, so that all others keep their numbers."""
    wanted = {key: item for key, item in parse(text, "the scene").items() if key != table}
    lines, inside = [], False
    for line in text.split("\n"):
        header = _HEADER.fullmatch(line)
        inside = header[1] == table if header else inside
        lines.append("" if inside else line)
    cut = "\n".join(lines)
    try:
        kept = parse(cut, "the scene") == wanted
    except SceneError:
        kept = False
    # a table inline, or a line of a list that looks like a header: then comments are lost
    return cut if kept else toml_text(wanted) + "\n"
