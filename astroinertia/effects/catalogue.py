"""Every effect that a scene can list: its options, where it lives and what it costs, as plain data.

A scene never names code: it names a kind, which is looked up here, and only that kind's module is imported.
"""

import importlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from astroinertia.effects.entries import AXIS as AXIS, FORCE_ERROR as FORCE_ERROR, Entry as Entry
from astroinertia.effects.field_entries import FIELDS
from astroinertia.effects.fluid_entries import FLUID
from astroinertia.effects.heat_entries import HEAT
from astroinertia.effects.rigid_entries import RIGID
from astroinertia.units import (
    ALL_MODELS as ALL_MODELS,
    LIGHT as LIGHT,
    REQUIRED as REQUIRED,
    Default as Default,
    Option as Option,
    choice as choice,
)

CATALOGUE: Mapping[str, Entry] = {
    kind: replace(entry, kind=kind) for kind, entry in {**FLUID, **FIELDS, **HEAT, **RIGID}.items()
}


def load(kind: str, entries: Mapping[str, Entry] = CATALOGUE) -> type:
    """The class of an effect, importing its module and no other effect's; KeyError for an unknown kind."""
    entry = entries[kind]
    return entry.made or getattr(importlib.import_module(entry.module), entry.class_name)


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
    return load(kind, entries).from_options(values)
