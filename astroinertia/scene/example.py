"""A commented scene for `astroinertia new`, written from the descriptions of the schema and the catalogue.

What the program explains and what it accepts cannot drift apart: every comment is the description of the field itself.
"""

import textwrap
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.scene import box, companions, initial_body, places, regions, schema
from astroinertia.scene.dimensional import quantity_of
from astroinertia.scene.load import KINDS
from astroinertia.scene.text import toml_value
from astroinertia.units import EXAMPLES, LIGHT, REQUIRED, Option

WIDTH = 118  # of a line
COLUMN = 36  # where comments begin

HEADER = """\
# A scene for astroinertia. Lines that begin with # are comments, or settings with their default or an example.
# Quantities are written with their unit, such as "1500 km", "1.4 Msun" or "33 ms".
#     astroinertia plan FILE     says what would be run
#     astroinertia run FILE      runs it
# A table [sweep] makes several runs, with other values of some keys, and one dataset of all:
#     [sweep]
#     "body.mass" = ["1 Msun", "2 Msun"]
#     "body.rotation.t_over_w" = {start = 0.01, stop = 0.1, number = 5, scale = "log"}"""

SEVERAL = f"""\
# One body, or several (up to {places.MOST_BODIES}): then [[bodies]] in place of [body] for each, with its own
# position, velocity and [bodies.rotation]; two of them may be put on an [orbit] instead."""

# What the example sets; everything else is shown as a comment.
SET: dict[str, dict[str, Any]] = {
    "": {
        "name": "rotating_star",
        "description": "A gas sphere like a small star, turning, left to itself: it stays as it is.",
    },
    "body": {"kind": "polytrope", "particles": 3000, "mass": "1 Msun", "radius": "700000 km", "index": 1.5},
    "body.rotation": {"law": "rigid", "t_over_w": 0.02},
    "equation_of_state": {"kind": "ideal", "gamma": 5.0 / 3.0},
    "numerics": {"engine": "numba_cpu"},
    "time": {"end": "2 h"},
    "output": {},
}
# Tables that most scenes do without, shown as comments.
ABSENT: dict[str, type[BaseModel]] = {
    "[regions.core]": regions.Region,
    "[body.perturbation]": initial_body.Perturbation,
    "[body.change]": initial_body.Change,
    "[orbit]": places.Orbit,
    "[[companions]]": companions.Companion,
    "[orbits]": companions.Orbits,
    "[[sinks]]": companions.Sink,
    "[box]": box.Box,
}
LISTED = ("gravity", "pressure", "viscosity")
SUBTABLES = ("rotation", "change", "perturbation")
# Examples of settings that have no default and whose type alone suggests no good one.
SUGGESTED: dict[str, Any] = {
    "index": 1.5,
    "accuracy": 1e-3,
    "judged_by": ["inertia_tensor z z"],
    "exponent": 1.0,
    "gamma": 5.0 / 3.0,
    "file": "particles.csv",
    "body": "Earth",
    "mean_molecular_weight": 0.6,
    "eta": 1.3,
    "neighbours": 74.0,
    "max_steps": 100000,
    "series_every": "1 min",
    "snapshot_every": "10 min",
    "max_timestep": "1 min",
    "free_fall_factor": 0.1,
    "period": "12 h",
    "rate": "1.5e-4 rad/s",
    "angular_momentum": "1e43 kg m2/s",
    "series_steps": 10,
    "pressure_fraction": 0.9,
    "t_over_w": 0.02,
    "axis_ratio": 0.8,
    "breakup_fraction": 0.8,
    "moments": ["8.0e37 kg m2", "8.0e37 kg m2", "8.1e37 kg m2"],
    "moment_ratios": [0.33, 0.33, 0.3307],
    "times": ["1 h", "2 h"],
    "factors": [0.5, 0.3],
    "name": "moon",
    "position": ["384400 km", "0 km", "0 km"],
    "problem": "sod",
    "lengths": ["2 m", "1 m", "1 m"],
    "velocity": ["0 km/s", "1 km/s", "0 km/s"],
    "archive": "orbits.bin",
    "mode": 2,
    "amplitude": 0.1,
    "timestep": "1 h",
    "entropy": "1e8 m4 kg^(-2/3) s-2",
    "particles": 3000,
    "units": "code",
    "layers": [{"material": "rock", "mass_fraction": 1.0}],
    "materials": [{"name": "rock", "tillotson": "basalt"}],
    "densities": ["2e14 g/cm3"],
    "gammas": [4.0 / 3.0, 2.5],
    "velocity_gradient": [["0 1/s", "-0.1 1/s", "0 1/s"], ["0.1 1/s", "0 1/s", "0 1/s"], ["0 1/s", "0 1/s", "0 1/s"]],
}


def example_text() -> str:
    """The scene as TOML text; it loads as it stands."""
    parts = [
        HEADER,
        _plain_keys(),
        SEVERAL,
        *(_section(table) for table in ("body", "body.rotation", "equation_of_state")),
    ]
    parts += [
        "# Effects: only those listed here are computed; an effect that is not listed does not exist for the run.\n"
        '# Or let the program choose: effects = "auto" beside the name, [candidates.cooling] and so on for effects\n'
        "# that need numbers, and accuracy for what they are judged against; `astroinertia plan` says what and why."
    ]
    parts += [_effect(kind) for kind in CATALOGUE]
    parts += [_section(table) for table in ("numerics", "time", "output")]
    parts += [_absent_section(name, model) for name, model in ABSENT.items()]
    return "\n\n".join(parts) + "\n"


def _plain_keys() -> str:
    fields = schema.Scene.model_fields
    lines = [
        _line(name, SET[""].get(name), fields[name])
        for name in ("name", "description", "model", "accuracy", "settings", "judged_by")
    ]
    return "\n".join([*lines, _line("units", None, fields["units"])])


def _section(table: str) -> str:
    example, model = SET[table], _model(table)
    lines = [f"[{table}]"]
    for name, field in model.model_fields.items():
        if name == "kind":
            lines.insert(1, _entry(f"kind = {toml_value(example[name])}", f"one of {', '.join(KINDS[table])}"))
        elif name not in SUBTABLES:
            lines.append(_line(name, example.get(name), field))
    for kind, other in KINDS.get(table, {}).items():
        own = {name: field for name, field in other.model_fields.items() if name not in model.model_fields}
        lines += [_line(name, None, field, f"kind {kind}: ") for name, field in own.items()]
    return "\n".join(lines)


def _absent_section(title: str, model: type[BaseModel]) -> str:
    lines = [f"# {title}", *(_line(name, None, field) for name, field in model.model_fields.items())]
    return "\n".join([_entry(lines[0], (model.__doc__ or "").split("\n")[0]), *lines[1:]])


def _model(table: str) -> type[BaseModel]:
    if table in KINDS:
        return KINDS[table][SET[table]["kind"]]
    models = {
        "body.rotation": initial_body.Rotation,
        "numerics": schema.Numerics,
        "time": schema.TimeSpan,
        "output": schema.Output,
    }
    return models[table]


def _line(name: str, value: Any, field: FieldInfo, prefix: str = "") -> str:
    text = f"{prefix}{field.description or ''}"
    if value is not None:
        return _entry(f"{name} = {toml_value(value)}", text)
    shown = field.default if field.default is not None and not field.is_required() else _suggestion(name, field)
    return _entry(f"# {name} = {toml_value(shown)}", text)


def _suggestion(name: str, field: FieldInfo) -> Any:
    if name in SUGGESTED:
        return SUGGESTED[name]
    quantity = quantity_of(field)
    assert quantity is not None  # what has no dimension is in SUGGESTED
    return EXAMPLES[quantity.dimension]


def _effect(kind: str) -> str:
    entry = CATALOGUE[kind]
    mark = "" if kind in LISTED else "# "
    models = "" if "sph" in entry.models else f" (model {' or '.join(entry.models)})"
    lines = [_entry(f"{mark}[effects.{kind}]", f"{entry.text}{models}")]
    return "\n".join(lines + [_option(name, option) for name, option in entry.options.items()])


def _option(name: str, option: Option) -> str:
    value = "299792.458 km/s" if option.default is LIGHT else option.default
    dimension = str(option.dimension)  # which has a name, in every effect of the catalogue
    if value is None or value is REQUIRED:
        value = "" if dimension == "choice" else EXAMPLES.get(dimension, 1.0)
        for length in reversed(option.shape):
            value = [value] * length
    elif dimension in EXAMPLES and option.default is not LIGHT:
        value = _with_unit(value, EXAMPLES[dimension].split(" ", 1)[1])
    choices = f" ({', '.join(option.choices)})" if option.choices else ""
    return _entry(f"# {name} = {toml_value(value)}", option.text + choices)


def _with_unit(value: Any, unit: str) -> Any:
    if isinstance(value, tuple | list):
        return [_with_unit(item, unit) for item in value]
    return f"{value:g} {unit}"


def _entry(setting: str, comment: str) -> str:
    """A setting with its comment beside it, or above where both do not fit on a line."""
    beside = f"{setting:<{COLUMN}}# {comment}"
    if len(beside) <= WIDTH and len(setting) < COLUMN:
        return beside
    return "\n".join([*textwrap.wrap(comment, WIDTH, initial_indent="# ", subsequent_indent="#   "), setting])
