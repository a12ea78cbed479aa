"""A scene that is written in Python: its tables as TOML has them, and its text, which is read as that of any file."""

import os
from collections.abc import Mapping
from datetime import timedelta
from decimal import Decimal
from numbers import Integral, Real
from typing import Any

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.scene.auto import AUTO
from astroinertia.scene.dimensional import described
from astroinertia.scene.own import DOORS
from astroinertia.scene.problems import Path, Problem, place
from astroinertia.scene.source import DEEPEST, LARGEST_FILE
from astroinertia.scene.text import toml_text, toml_value
from astroinertia.units import shown, with_unit, written_quantity

NAME = "scene"  # of one that has none: it names the file of its run
LARGEST_INTEGER = 2**63  # from here on they are written as other numbers are


def text_of(tables: Any) -> tuple[str, list[Any]]:
    """The TOML text of a scene's tables, and what of the user's own is among them; SceneError names the key.

    Values are what TOML has, and tuples, arrays, NumPy's numbers, fractions, paths and quantities; a key whose value is
    None is left out. `effects` and `observables` may be a list: of kinds, of tables with their kind, and of the user's
    own. `time` may be the time at the end alone. A kind may be a class of the user's own.
    """
    try:
        if not isinstance(tables, Mapping):
            raise SceneError(
                f"a scene must be keys or a table (a dict), not {kind_of(tables)}; a file is read by astroinertia.load."
            )
        tables, own = _apart(tables)
        return toml_text(_table(tables, ())) + "\n", own
    except Problem as problem:
        raise SceneError(f"the scene: {place(problem.path, problem.table)}{problem.message}") from None


def settings_of(settings: Any) -> list[str]:
    """Texts "key.path=value", of a dict of keys and values, of such a text or of several; SceneError names the key."""
    if isinstance(settings, str):
        return [settings]
    if isinstance(settings, list | tuple):
        for setting in settings:
            if not isinstance(setting, str):
                raise SceneError(f"settings must be a dict or a list of texts, and {kind_of(setting)} is no text.")
        return list(settings)
    if not isinstance(settings, Mapping):
        raise SceneError(f"settings must be a dict or a list of texts, not {kind_of(settings)}.")
    try:
        return [f"{key}={toml_value(_plain(value, tuple(str(key).split('.'))))}" for key, value in settings.items()]
    except Problem as problem:
        raise SceneError(f"settings: {place(problem.path, problem.table)}{problem.message}") from None


def _apart(tables: Mapping[Any, Any]) -> tuple[dict[Any, Any], list[Any]]:
    """The tables with all shorthands written out, and what of the user's own stood in them."""
    tables, own = {"name": NAME, **tables}, []
    for door in DOORS:
        key, listed, value = door.table, not door.single, tables.get(door.table)
        if isinstance(value, str) and value == AUTO:
            continue
        if listed and isinstance(value, list | tuple | str):
            tables[key] = _by_kind(key, [value] if isinstance(value, str) else value, own)
        elif not listed and (_is_own(value) or (isinstance(value, Mapping) and _is_own(value.get("kind")))):
            table = dict(value) if isinstance(value, Mapping) else {"kind": value}
            own.append(thing := table.pop("kind"))
            tables[key] = {"kind": thing.kind, **table} if isinstance(thing, type) and hasattr(thing, "kind") else table
    if "time" in tables and not isinstance(tables["time"], Mapping):
        tables["time"] = {"end": tables["time"]}
    return tables, own


def _by_kind(table: str, items: Any, own: list[Any]) -> dict[Any, Any]:
    """A list of kinds, of tables that name theirs and of the user's own, as a table of tables; the last join `own`."""
    tables: dict[Any, Any] = {}
    for number, item in enumerate(items):
        if (_is_own(item) or callable(item)) and not isinstance(item, type):
            own.append(item)
            continue
        if isinstance(item, str | type):
            named = [(item, {})]
        elif isinstance(item, Mapping) and "kind" in item:
            named = [(item["kind"], {key: value for key, value in item.items() if key != "kind"})]
        elif isinstance(item, Mapping) and item and all(isinstance(options, Mapping) for options in item.values()):
            named = item.items()
        else:
            raise Problem((table, number), f": must be a kind, or a table with its kind, not {kind_of(item)}.")
        for kind, options in named:
            if isinstance(kind, type):
                own.append(kind)
                kind = getattr(kind, "kind", kind.__name__)
            if not isinstance(kind, str):
                raise Problem((table, number), f": its kind must be text, not {kind_of(kind)}.")
            if kind in tables:
                raise Problem((table, kind), " is listed twice.", table=True)
            tables[kind] = options
    return tables


def _is_own(value: Any) -> bool:
    """Whether it is a class, or an object of one of the user's own, and nothing that a scene is made of."""
    return isinstance(value, type) or hasattr(value, "kind")


def _table(table: Mapping[Any, Any], path: Path) -> dict[str, Any]:
    _refuse_deep(path)
    for key in table:
        if not isinstance(key, str):
            raise Problem((*path, shown(str(key))), f": a key must be text, not {kind_of(key)}.")
    required = len(path) == 1 and path[0] in ("effects", "candidates", "observables")
    kept = {key: value for key, value in table.items() if value is not None or required}
    return {str(key): _plain(value, (*path, str(key))) for key, value in kept.items()}


def _plain(value: Any, path: Path) -> Any:
    """A value as TOML has it; Problem where there is none such."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, str | os.PathLike):
        return _text(os.fspath(value), path)
    if isinstance(value, Mapping):
        return _table(value, path)
    try:
        quantity = with_unit(value)
    except SceneError as error:
        raise Problem(path, f": {error}") from None
    if quantity is not None:
        _refuse_many(quantity, path)
        return written_quantity(quantity)
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise Problem(path, ": has masked entries; a scene needs all of them.")
    if isinstance(value, np.timedelta64 | timedelta):
        raise Problem(path, f': must be text or a quantity with a unit, such as "3 s", not {kind_of(value)}.')
    if isinstance(value, Integral) and abs(int(value)) < LARGEST_INTEGER:
        return int(value)
    if isinstance(value, Real | Decimal):
        return _number(value)
    if isinstance(value, list | tuple | range):
        _refuse_deep(path)
        _refuse_many(value, path)
        return [_plain(item, (*path, number)) for number, item in enumerate(value)]
    if isinstance(getattr(value, "dtype", None), np.dtype) and hasattr(value, "__array__"):
        array = np.asarray(value)
        _refuse_many(array, path)
        return _plain(array.tolist(), path)
    raise Problem(path, f": must be text, a number, a quantity, a list or a table, not {kind_of(value)}.")


def _text(text: Any, path: Path) -> str:
    try:
        text.encode()
    except (AttributeError, UnicodeEncodeError):
        raise Problem(path, ": must be text in Unicode, and is not.") from None
    return str(text)


def _number(value: Any) -> float:
    try:
        return float(value)
    except OverflowError:
        return float("inf")


def _refuse_deep(path: Path) -> None:
    if len(path) > DEEPEST:
        raise Problem(path[:2], f": tables or lists are nested deeper than {DEEPEST} levels.")


def _refuse_many(values: Any, path: Path) -> None:
    count = np.size(values) if hasattr(values, "dtype") else len(values)
    if count > LARGEST_FILE // 2:
        raise Problem(path, f": {count} values are more than the {LARGEST_FILE // 1024} KiB of a scene can hold.")


def kind_of(value: Any) -> str:
    """What a value from Python is, for a message."""
    if isinstance(value, str | int | float | list | tuple | dict):
        return described(value)
    return "None" if value is None else f"something of the type {shown(type(value).__name__)}"
