"""The reference of effects, written from their catalogue: what each is, its options with units and limits, its source.

Tests: tests/unit/guide/test_guide.py, which looks for every effect and every option.
"""

import math

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.effects.entries import Entry
from astroinertia.guide.tables import bounds, table
from astroinertia.scene.text import toml_value
from astroinertia.units import EXAMPLES, LIGHT, REQUIRED, Option

HEAD = ("option", "what is written", "default", "meaning")
LOOPS = {
    "particles": "each particle by itself",
    "neighbours": "pairs of neighbours",
    "all pairs": "all pairs of particles",
    "body": "the body as a whole",
}
INTRODUCTION = """\
# Effects

This page is written from the catalogue that scenes are checked against. An effect is present only where a scene lists
it, as a table `[effects.KIND]`, empty where the defaults will do. An effect that is not listed is not made, not
compiled and not run.

```toml
[effects.gravity]

[effects.viscosity]
alpha_max = 1.5
```

`astroinertia plan SCENE` says how large each effect is in a scene, and what leaving it out would cost;
[choosing effects](choosing-effects.md) explains `effects = "auto"`."""


def text() -> str:
    """The page, as Markdown."""
    rows = [(f"`{kind}`", entry.text, ", ".join(entry.models)) for kind, entry in CATALOGUE.items()]
    parts = [INTRODUCTION, table(("effect", "what it is", "models"), rows)]
    return "\n\n".join([*parts, *(_effect(kind, entry) for kind, entry in CATALOGUE.items())]) + "\n"


def _effect(kind: str, entry: Entry) -> str:
    said = [
        f"## `{kind}`",
        f"{entry.text[:1].upper()}{entry.text[1:]}.",
        f"- models: {', '.join(entry.models)}\n"
        f"- computed over: {LOOPS.get(entry.cost, entry.cost)}"
        f"{'; a numerical device, which models without particles skip' if entry.numerical else ''}\n"
        f"- source: {entry.source}",
    ]
    rows = [
        (f"`{name}`", written(option), default(option), _meaning(option, entry))
        for name, option in entry.options.items()
    ]
    return "\n\n".join([*said, table(HEAD, rows) if rows else "It has no options."])


def written(option: Option) -> str:
    """What may be written for an option: its choices, or its dimension with an example and its limits."""
    if option.dimension == "choice":
        return ", ".join(f"`{toml_value(choice)}`" for choice in option.choices)
    if option.dimension == "boolean":
        return "`true` or `false`"
    dimension = str(option.dimension)  # which has a name, in every effect of the catalogue
    example = EXAMPLES.get(dimension)
    said = "number" if dimension == "dimensionless" else dimension.replace("_", " ")
    said += f', such as `"{example}"`' if example else ""
    for length in reversed(option.shape):
        said = f"{length} times: {said}"
    least = option.minimum if math.isfinite(option.minimum) else None
    most = option.maximum if math.isfinite(option.maximum) else None
    if least == 0.0 and most is None:
        return f"{said}; {'positive' if option.exclusive else 'not negative'}"
    limits = bounds(least, most, above=option.exclusive)
    return f"{said}; {limits}" if limits else said


def default(option: Option) -> str:
    """The default of an option, as it would be written."""
    if option.default is REQUIRED:
        return "**required**"
    if option.default is LIGHT:
        return f"{LIGHT!r}"
    if option.default is None:
        return "none"
    return f"`{toml_value(list(option.default) if isinstance(option.default, tuple) else option.default)}`"


def _meaning(option: Option, entry: Entry) -> str:
    fewer = [model for model in entry.models if model not in option.models]
    return f"{option.text} (not for {', '.join(fewer)})" if fewer else option.text
