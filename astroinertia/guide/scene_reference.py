"""The reference of scenes, written from the schema: every key with what is written for it, its default and its limits.

Tests: tests/unit/guide/test_guide.py, which looks for every key of the schema.
"""

import inspect
import re
from collections.abc import Iterator
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from astroinertia.guide.tables import bounds, number, table
from astroinertia.scene import box, companions, places, regions, scales, schema, source, sweep, sweep_values
from astroinertia.scene.dimensional import Quantity, quantity_of
from astroinertia.scene.initial_body import Body
from astroinertia.scene.load import KINDS, RECORD
from astroinertia.scene.text import toml_value
from astroinertia.units import EXAMPLES

HEAD = ("key", "what is written", "default", "meaning")
REQUIRED = "**required**"
# What is written for keys whose type does not say it.
WRITTEN = {
    "units": '`"code"`, `"SI"`, or a table `[units]`',
    "constant": 'a quantity in the unit of P/rho^gamma, or `"from body"`',
    "entropy": 'a quantity in the unit of P/rho^gamma, such as `"1e8 m4 kg^(-2/3) s-2"`; not negative',
    "effects": 'a table `[effects.KIND]` for each effect, or `"auto"`',
    "candidates": "tables `[candidates.KIND]`, with the options of effects",
    "observables": "tables `[observables.KIND]`, with the options of each",
    "regions": f"tables `[regions.NAME]`, at most {regions.MOST_REGIONS}",
    "bodies": f"tables `[[bodies]]`, from 2 to {places.MOST_BODIES}",
    "companions": f"tables `[[companions]]`, at most {companions.MOST_COMPANIONS}",
    "sinks": f"tables `[[sinks]]`, at most {companions.MOST_SINKS}",
}
INTRODUCTION = """\
# Scene reference

This page is written from the schema that checks scenes, so the two cannot differ. A scene is a TOML file;
`astroinertia new star.toml` writes one with these same words as comments.

- A quantity is a text with a unit, such as `"1500 km"`, `"1.4 Msun"` or `"33 ms"`. Its dimension is checked. With
  `units = "code"` all quantities are plain numbers, and G = 1.
- A vector is a list of three: `position = ["1 km", "0 km", "0 km"]`.
- An unknown key is an error that names the nearest known one.
- "none" as a default: what the key describes is absent.
- `--set KEY=VALUE` of `plan` and `run` sets any key: `--set body.particles=5000`."""


class Section(NamedTuple):
    """A table of a scene: its title, what is said of it, and its keys."""

    title: str
    said: str
    fields: dict[str, FieldInfo]
    level: int = 2


def text() -> str:
    """The page, as Markdown."""
    parts = [INTRODUCTION, *(_shown(section) for section in sections()), _effects(), _sweep(), _limits()]
    return "\n\n".join(parts) + "\n"


def sections() -> Iterator[Section]:
    """Every table that a scene may have, with its keys, as the schema has them."""
    fields = {name: field for name, field in schema.Scene.model_fields.items() if name not in RECORD}
    yield Section("Keys of the scene itself", "They stand before the first table.", fields)
    yield from _body()
    yield Section("[orbit]", _said(places.Orbit), places.Orbit.model_fields)
    yield from _kinds("equation_of_state", {})
    for title, model in (
        ("[[companions]]", companions.Companion),
        ("[orbits]", companions.Orbits),
        ("[[sinks]]", companions.Sink),
        ("[box]", box.Box),
        ("[regions.NAME]", regions.Region),
        ("[numerics]", schema.Numerics),
        ("[time]", schema.TimeSpan),
        ("[output]", schema.Output),
        ("[units]", schema.Units),
    ):
        yield Section(title, _said(model), model.model_fields)


def written(name: str, field: FieldInfo) -> str:
    """What may be written for a key: its type or dimension, with an example, and its limits."""
    if name in WRITTEN:
        return WRITTEN[name]
    quantity = quantity_of(field)
    constraints = [*field.metadata]
    said = _type(field.annotation, constraints, quantity)
    sign = "" if quantity is None or quantity.sign == "any" else quantity.sign
    counted = "characters" if said.startswith("text") else "entries"
    return "; ".join(part for part in (said, sign, _limits_of(constraints, counted)) if part)


def default(field: FieldInfo) -> str:
    """The default of a key, as it would be written."""
    if field.is_required():
        return REQUIRED
    if field.default is None or field.default_factory is not None or field.default == ():
        return "none"
    value = field.default
    if isinstance(value, float) and value != 0.0 and not value.is_integer():
        return f"`{value:g}`"
    return f"`{toml_value(value)}`"


def _body() -> Iterator[Section]:
    said = f"{_said(Body)} `kind` is one of {_choices(KINDS['body'])}. Each of several `[[bodies]]` has the same keys."
    yield Section("[body], of any kind", said, Body.model_fields)
    yield from _kinds("body", Body.model_fields)


def _kinds(name: str, shared: dict[str, FieldInfo]) -> Iterator[Section]:
    """The tables of each kind, and then the tables inside them, each once."""
    inner: dict[str, type[BaseModel]] = dict(_tables(shared))
    if not shared:
        yield Section(f"[{name}]", f"`kind` is one of {_choices(KINDS[name])}.", {})
    for kind, model in KINDS[name].items():
        own = {key: field for key, field in model.model_fields.items() if _differs(key, field, shared)}
        yield Section(f'[{name}] kind = "{kind}"', _said(model), own, 3)
        inner |= dict(_tables(own))
    for key, model in inner.items():
        listed = key in ("layers", "materials")
        title = f"[[{name}.{key}]]" if listed else f"[{name}.{key}]"
        yield Section(title, _said(model), model.model_fields, 3)


def _differs(key: str, field: FieldInfo, shared: dict[str, FieldInfo]) -> bool:
    if key == "kind" or key not in shared:
        return key != "kind"
    other = shared[key]
    return (field.description, field.default) != (other.description, other.default)


def _tables(fields: dict[str, FieldInfo]) -> Iterator[tuple[str, type[BaseModel]]]:
    for key, field in fields.items():
        for model in _models(field.annotation):
            yield key, model


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from _models(argument)


def _shown(section: Section) -> str:
    rows = [
        (f"`{name}`", written(name, field), default(field), field.description or _table_said(field))
        for name, field in section.fields.items()
        if name != "kind"
    ]
    parts = [f"{'#' * section.level} {_title(section.title)}", section.said]
    if rows:
        parts.append(table(HEAD, rows))
    elif section.level > 2:
        parts.append("It has no keys of its own.")
    return "\n\n".join(part for part in parts if part)


def _title(title: str) -> str:
    return f"`{title}`" if title.startswith("[") and "," not in title else title


def _table_said(field: FieldInfo) -> str:
    return next((_said(model) for model in _models(field.annotation)), "")


def _said(model: type[BaseModel]) -> str:
    """The first paragraph of what a part of the schema says of itself."""
    return " ".join(inspect.cleandoc(model.__doc__ or "").split("\n\n")[0].split())


def _type(annotation: Any, constraints: list[Any], quantity: Quantity | None) -> str:
    """What kind of value it is; constraints met on the way are added to the list."""
    origin = get_origin(annotation)
    if origin is Annotated:
        inner, *metadata = get_args(annotation)
        for item in metadata:
            constraints.extend(item.metadata if isinstance(item, FieldInfo) else [item])
        return _type(inner, constraints, quantity)
    if origin in (Union, UnionType):
        kinds = [_type(kind, constraints, quantity) for kind in get_args(annotation) if kind is not NoneType]
        return " or ".join(dict.fromkeys(kinds))
    if origin is Literal:
        return ", ".join(f"`{toml_value(kind)}`" for kind in get_args(annotation))
    if origin is tuple:
        return _list(get_args(annotation), constraints, quantity)
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        return "a table, below"
    if annotation is float and quantity is not None:
        return _quantity(quantity)
    plain = {float: "number", int: "whole number", bool: "`true` or `false`", str: "text"}
    return plain.get(annotation) or getattr(annotation, "__name__", str(annotation))


def _list(items: tuple[Any, ...], constraints: list[Any], quantity: Quantity | None) -> str:
    inner: list[Any] = []
    item = _type(items[0], inner, quantity)
    constraints.extend(limit for limit in inner if not isinstance(limit, MinLen | MaxLen))
    return f"list: {item}" if items[-1] is Ellipsis else f"{len(items)} times: {item}"


def _quantity(quantity: Quantity) -> str:
    if quantity.dimension == "dimensionless":
        return "number"
    name = quantity.dimension.replace("_", " ")
    return f'{name}, such as `"{EXAMPLES[quantity.dimension]}"`'


def _limits_of(constraints: list[Any], counted: str) -> str:
    """Limits of a number, or of the length of a list or text, in words."""
    limits = {type(limit): limit for limit in constraints}
    least = limits[Ge].ge if Ge in limits else limits[Gt].gt if Gt in limits else None
    most = limits[Le].le if Le in limits else limits[Lt].lt if Lt in limits else None
    said = [bounds(least, most, Gt in limits, Lt in limits)]
    shortest = limits[MinLen].min_length if MinLen in limits else None
    longest = limits[MaxLen].max_length if MaxLen in limits else None
    if length := bounds(shortest, longest):
        said.append(f"{length} {counted}")
    said += [f"of the form `{limit.pattern}`" for limit in constraints if getattr(limit, "pattern", None)]
    return "; ".join(part for part in said if part)


def _choices(kinds: Any) -> str:
    return ", ".join(f"`{kind}`" for kind in kinds)


def _effects() -> str:
    return """\
## `[effects.KIND]` and `[candidates.KIND]`

A table for each effect, empty where the defaults will do. An effect that is not listed does not exist for the run.
`astroinertia guide effects` has every kind with its options.

## `[observables.KIND]`

A table for each observable of your own that is to be recorded beside the quantities of the dataset, empty where it has
no options. KIND is what an installed package offers; `astroinertia guide own-effects` says how."""


def _sweep() -> str:
    _, _, rest = inspect.cleandoc(sweep.__doc__ or "").partition("\n\n")
    example = inspect.cleandoc(rest.partition("Tests:")[0].rstrip())
    example = re.sub(r"^(\[sweep\] +)(?=\S)", r"\1# ", example, flags=re.MULTILINE)
    return f"""\
## `[sweep]`

A table that makes several runs of the scene, each with other values of some of its keys: at most
{number(sweep_values.MOST_MEMBERS)} members.

```toml
{example}
```

Distributions are {_choices(sweep_values.DISTRIBUTIONS)}; a range has {_choices(sweep_values.RANGE)}, and its scale is
{" or ".join(f"`{name}`" for name in sweep_values.SCALES)}. Options beside the parameters: {_choices(sweep.OPTIONS)}."""


def _limits() -> str:
    rows = [
        ("size of a scene file", f"{source.LARGEST_FILE // 1024} KiB"),
        ("a line of it", f"{source.LONGEST_LINE} bytes"),
        ("tables and lists inside each other", f"{source.DEEPEST} deep"),
        (
            "a number in the units of the run",
            f"{bounds(None, scales.LARGEST)}, and {scales.SMALLEST:g} at least if positive",
        ),
        ("units of mass, length and time, in SI", f"from {scales.SMALLEST_UNIT:g} to {scales.LARGEST_UNIT:g}"),
        ("records of a run", f"{schema.MOST_RECORDS:g}"),
        ("snapshots of a run", f"{schema.MOST_SNAPSHOTS:g}"),
        ("steps that `max_timestep` may ask for", f"{schema.MOST_STEPS:g}"),
    ]
    return f"## Limits of a scene\n\n{table(('what', 'limit'), rows)}"
