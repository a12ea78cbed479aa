"""Every effect that a scene can list: its class, its options and what it costs.

An effect is one module of effects.kinds, with a class and its `ENTRY`, by the name of its kind; nothing else names it.
A scene names no code: it names a kind, which is looked up here.
"""

import pkgutil
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from astroinertia.effects import kinds
from astroinertia.effects.entries import Entry
from astroinertia.units import Default

_FOUND = {
    module.name: import_module(f"astroinertia.effects.kinds.{module.name}").ENTRY
    for module in pkgutil.iter_modules(kinds.__path__)
}
CATALOGUE: Mapping[str, Entry] = dict(sorted(_FOUND.items(), key=lambda item: (item[1].rank, item[0])))


def build(kind: str, options: Mapping[str, Any] | None = None, entries: Mapping[str, Entry] = CATALOGUE) -> Any:
    """The effect from options in code units, defaults filled in; ValueError where options are missing or contradict.

    entries: of the effects that are known, those of a scene (Scene.entries).
    """
    remaining = dict(options or {})
    values = {}
    for name, option in entries[kind].options.items():
        value = remaining.pop(name, option.default)
        if isinstance(value, Default):
            raise ValueError(f"{name} is missing: {option.text}")
        values[name] = value
    if remaining:
        raise ValueError(f"{next(iter(remaining))} is not an option of {kind}")
    return entries[kind].build(values)
