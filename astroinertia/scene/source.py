"""The text of a scene: limits kept before anything is parsed, TOML, overrides, and where in the text a key stands."""

import difflib
import os
import re
import stat
import tomllib
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from astroinertia.errors import SceneError
from astroinertia.process.words import clause
from astroinertia.units import shown

LARGEST_FILE = 64 * 1024  # bytes
LONGEST_LINE = 1024  # bytes; tomllib needs memory that grows with the square of a dotted key's length
DEEPEST = 6  # levels of tables and lists; [effects.external_field] quadratic = [[...]] needs 5

KEY = re.compile(r"[A-Za-z0-9_-]{1,64}(?:\.[A-Za-z0-9_-]{1,64}){0,5}")


def at_home(path: Path) -> Path:
    """The path with ~ as the user's home; as it is where ~ is nobody's."""
    with suppress(RuntimeError):
        return path.expanduser()
    return path


def file_of_scene(origin: str | None, name: str) -> Path:
    """Where a file is that a scene names, relative to the folder of the scene, `origin`, if it has one."""
    return Path(origin or ".") / at_home(Path(name))


def read_regular_file(path: Path, largest: int, what: str) -> bytes:
    """The bytes of a regular file; SceneError for anything else, without ever opening a pipe or a device to wait."""
    name = shown(str(path), 200)
    try:
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise SceneError(f"{name} is a directory, not {what}.")
        if not stat.S_ISREG(mode):
            raise SceneError(f"{name} is not a regular file, so it is not read as {what}.")
        with open(path, "rb", opener=lambda file, flags: os.open(file, flags | os.O_NONBLOCK)) as stream:
            if not stat.S_ISREG(os.fstat(stream.fileno()).st_mode):  # it may have been replaced since
                raise SceneError(f"{name} is not a regular file, so it is not read as {what}.")
            content = stream.read(largest + 1)
    except FileNotFoundError:
        raise SceneError(f"there is no file {name}{_nearby(path)}.") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise SceneError(f"{name} cannot be read ({shown(reason.lower())}).") from None
    if len(content) > largest:
        raise SceneError(f"{name} is larger than the {largest // 1024} KiB that {what} may have.")
    return content


def _nearby(path: Path) -> str:
    try:
        names = [entry.name for entry in list(os.scandir(path.parent))[:2000]]
    except (OSError, ValueError):
        return ""
    close = difflib.get_close_matches(path.name, names, n=1, cutoff=0.75)
    return f"; the nearest name is {shown(str(path.parent / close[0]), 200)}" if close else ""


def decode(content: bytes, name: str) -> str:
    """The text of a scene file; SceneError where it is not UTF-8."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise SceneError(f"{name}, line {line}: this is not UTF-8 text.") from None


def parse(text: str, name: str) -> dict[str, Any]:
    """The tables of a TOML text within the limits; SceneError with the line where it is not TOML."""
    if len(text.encode("utf-8", "surrogatepass")) > LARGEST_FILE:
        raise SceneError(f"{name} is larger than the {LARGEST_FILE // 1024} KiB that a scene may have.")
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line.encode("utf-8", "surrogatepass")) > LONGEST_LINE:
            raise SceneError(f"{name}, line {number}: the line is longer than the {LONGEST_LINE} bytes allowed.")
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        what, _, place = str(error).partition(" (at ")
        line = re.search(r"line (\d+), column (\d+)", place)
        where = f", line {line[1]}, column {line[2]}" if line else ""
        hint = '; text and quantities stand in quotes, as in mass = "1.4 Msun"' if what == "Invalid value" else ""
        raise SceneError(f"{name}{where}: this is not TOML ({clause(shown(what, 100))}{hint}).") from None
    except RecursionError:
        raise SceneError(f"{name}: tables or lists are nested deeper than {DEEPEST} levels.") from None
    except ValueError as error:  # an integer too long to convert, a date that does not exist
        raise SceneError(f"{name}: this is not TOML ({clause(shown(str(error), 100))}).") from None
    _check_depth(tables, name)
    return tables


def _check_depth(tables: dict[str, Any], name: str) -> None:
    level: list[Any] = [tables]
    for _ in range(DEEPEST):
        level = [
            item
            for container in level
            for item in (container.values() if isinstance(container, dict) else container)
            if isinstance(item, dict | list)
        ]
        if not level:
            return
    raise SceneError(f"{name}: tables or lists are nested deeper than {DEEPEST} levels.")


def key_of(setting: str) -> tuple[str, ...]:
    """The names that lead to the key of a "key.path=value"."""
    return tuple(setting.partition("=")[0].strip().split("."))


def override(tables: dict[str, Any], overrides: Iterable[str]) -> dict[str, Any]:
    """The tables with each "key.path=value" put in; a value that is not TOML is taken as text, quotes left out."""
    for text in overrides:
        key, equals, value = text.partition("=")
        key, value, said = key.strip(), value.strip(), f"--set {shown(text)}"
        if not equals or not value:
            raise SceneError(f"{said}: write key=value, for example --set body.particles=5000.")
        if not KEY.fullmatch(key):
            raise SceneError(f"{said}: the key must be names joined by dots, such as body.particles.")
        path = key.split(".")
        tables = _placed(tables, path, override_value(value, said), said)
    return tables


def override_value(text: str, said: str) -> Any:
    """The value in a "key=value": TOML, or else plain text; SceneError for what no scene could hold."""
    if len(text.encode("utf-8", "surrogatepass")) > LONGEST_LINE or not text.isprintable():
        raise SceneError(f"{said}: the value must be one line of at most {LONGEST_LINE} printable bytes.")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        value = text
    _check_depth({"value": value}, said)
    return value


def _placed(tables: dict[str, Any], path: Sequence[str], value: Any, said: str) -> dict[str, Any]:
    head, *rest = path
    if not rest:
        return {**tables, head: value}
    inner = tables.get(head, {})
    if isinstance(inner, list) and rest[0].isdecimal() and int(rest[0]) < len(inner):
        numbered = {str(number): item for number, item in enumerate(inner)}
        return {**tables, head: list(_placed(numbered, rest, value, said).values())}
    if not isinstance(inner, dict):
        raise SceneError(f"{said}: {head} is not a table, so it has no key {rest[0]}.")
    return {**tables, head: _placed(inner, rest, value, said)}


def line_of(text: str, path: Sequence[str]) -> int | None:
    """The line where a key stands, or else its table's header; None where neither is found.

    A reading of plain lines, good enough for a hint: keys inside inline tables and multi-line strings are not seen.
    """
    section: tuple[str, ...] = ()
    best, best_length = None, 0
    wanted = tuple(path)
    for number, line in enumerate(text.split("\n"), start=1):
        header = re.fullmatch(r"\s*\[\s*([^\[\]]+?)\s*\]\s*(#.*)?", line)
        if header:
            section = _names(header[1])
            here = section
        else:
            key = re.match(r"\s*([A-Za-z0-9_.\"' -]+?)\s*=", line)
            if not key:
                continue
            here = section + _names(key[1])
        if wanted[: len(here)] == here and len(here) > best_length:
            best, best_length = number, len(here)
    return best


def _names(key: str) -> tuple[str, ...]:
    return tuple(part.strip().strip("\"'") for part in key.split("."))
