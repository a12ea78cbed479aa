"""What is wrong with a scene, as one sentence: which key, what it is, what would be right."""

import difflib
from collections.abc import Iterable, Sequence
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from astroinertia.process.words import clause
from astroinertia.scene.dimensional import described
from astroinertia.units import any_quantity, shown

Path = tuple[str | int, ...]
OTHER_WORDS = {  # for keys, that are not spelt alike: the first of them that is known where one stands
    **dict.fromkeys(("angular_velocity", "omega", "spin"), ("rate", "rotation")),
    **dict.fromkeys(("eos", "gas", "matter"), ("equation_of_state",)),
    **dict.fromkeys(("stop", "duration", "t_end", "tmax"), ("end",)),
    **dict.fromkeys(("every", "cadence", "interval"), ("series_every",)),
    **dict.fromkeys(("N", "number", "resolution"), ("particles",)),
    "n": ("index", "particles"),
    "m": ("mass",),
    "r": ("radius",),
    "theta": ("force_error",),
    **dict.fromkeys(("star", "planet"), ("body",)),
}

WANTED = {  # by the types of pydantic's errors: what a value must be
    **dict.fromkeys(("model_type", "model_attributes_type", "dict_type"), "a table"),
    "string_type": "text in quotes",
    **dict.fromkeys(("int_type", "int_from_float", "int_parsing_size"), "a whole number"),
    "float_type": "a number",
    "finite_number": "a finite number",
    "bool_type": "true or false",
    "tuple_type": "a list",
}
BOUNDS = {"gt": "greater than", "ge": "at least", "lt": "less than", "le": "at most"}
OF_THE_SCENE = "it is one of the scene itself: it stands above the first [table]."


class Problem(Exception):
    """A key, or a whole table, and what is the matter; `message` continues a sentence that begins with its name."""

    def __init__(self, path: Sequence[str | int], message: str, table: bool = False) -> None:
        self.path: Path = tuple(path)
        self.message = message
        self.table = table
        super().__init__(self.path, message, table)


def place(path: Path, table: bool = False) -> str:
    """How a key is named to a person: "[body.rotation] rate", "[body] axes[1]", "name"; a table: "[body.rotation]"."""
    names = [number for number, part in enumerate(path) if isinstance(part, str)]
    words = [_word(part) if isinstance(part, str) else str(part) for part in path]
    if table:
        return f"[{'.'.join(words)}]"
    indices = "".join(f"[{part}]" for part in words[names[-1] + 1 :])
    *tables, key = words[: names[-1] + 1]
    return f"[{'.'.join(tables)}] {key}{indices}" if tables else f"{key}{indices}"


def _word(key: str) -> str:
    return key if key.isidentifier() and key.isascii() and len(key) <= 64 else f'"{shown(key)}"'


def nearest(key: str, names: Iterable[str]) -> str:
    """A hint at the nearest known key, or the list of all where none is near; it ends its sentence."""
    names = list(names)
    for word in OTHER_WORDS.get(key, OTHER_WORDS.get(key.lower(), ())):
        if word in names:
            return f"did you mean '{word}'?"
    close = difflib.get_close_matches(key.lower()[:64], names, n=1, cutoff=0.6)
    if close:
        return f"did you mean '{close[0]}'?"
    return f"known are {', '.join(names)}." if names else "nothing can be set here."


def unknown_key(path: Path, names: Iterable[str], elsewhere: str = "") -> Problem:
    """The problem of a key that nobody reads."""
    return Problem(path, f" is not a known key; {elsewhere or nearest(str(path[-1]), names)}")


def wrong_choice(path: Path, value: Any, choices: Iterable[str], missing: bool = False) -> Problem:
    """The problem of a value that is not among the choices, or of a choice that is not made."""
    choices = list(choices)
    if missing:
        return Problem(path, f" is missing; it is one of {', '.join(choices)}.")
    if isinstance(value, str) and difflib.get_close_matches(value.lower()[:64], choices, n=1, cutoff=0.6):
        return Problem(path, f": '{shown(value)}' is not known; {nearest(value, choices)}")
    return Problem(path, f": must be one of {', '.join(choices)}, not {described(value)}.")


def first_problem(
    error: ValidationError, model: type[BaseModel], kinds: dict[str, dict[str, type[BaseModel]]]
) -> Problem:
    """The problem to tell first: an unknown key before a missing one, for it may be the same key misspelt.

    `kinds`: for every table with kinds, the model of each kind.
    """
    errors = [item for item in error.errors(include_url=False) if not any(map(_is_word, item["loc"]))]
    errors = errors or error.errors(include_url=False)
    ranks = {"extra_forbidden": 0, "union_tag_invalid": 1, "union_tag_not_found": 1, "missing": 3}
    return _problem(min(errors, key=lambda item: ranks.get(item["type"], 2)), model, kinds)


def _problem(item: Any, model: type[BaseModel], kinds: dict[str, dict[str, type[BaseModel]]]) -> Problem:
    loc, kind = _without_tags(item["loc"], kinds)
    value, context = item.get("input"), item.get("ctx") or {}
    if (wanted := WANTED.get(item["type"])) is not None:
        return Problem(loc, f": must be {wanted}, not {described(value)}.")
    match item["type"]:
        case "extra_forbidden":
            elsewhere = OF_THE_SCENE if _is_of_scene(model, loc) else ""
            elsewhere = elsewhere or _deeper(_model_at(model, loc[:-1], kind, kinds), loc) or _other_kind(loc, kinds)
            return unknown_key(loc, _fields(model, loc, kind, kinds), elsewhere)
        case "missing" if isinstance(loc[-1], int):
            return Problem(loc[:-1], f": must be a longer list, for entry {loc[-1] + 1} is missing.")
        case "missing":
            return Problem(loc, f" is missing{_meaning(model, loc, kind, kinds)}.", table=loc == ("time",))
        case "union_tag_invalid" | "union_tag_not_found":
            path = (*loc, "kind")
            missing = item["type"].endswith("not_found")
            known = [kind for kind in kinds[str(loc[0])] if kind != "own"]
            return wrong_choice(path, None if missing else value.get("kind"), known, missing)
        case "literal_error":
            return _wrong_literal(loc, value, _field(model, loc, kind, kinds))
        case "value_error":
            message = str(context["error"])
            whole = message.startswith(("needs ", "has ", "may "))  # said of a table by its own validator
            return Problem(loc, f" {message}" if whole else f": {message}", table=whole)
        case "string_pattern_mismatch":
            loc = loc[:-1] if loc[-1] == "[key]" else loc  # of a table, whose name it is
            return Problem(loc, f": must be {_in_words(context['pattern'])}, not {described(value)}.")
        case "string_too_long" | "string_too_short":
            limit = context.get("max_length", context.get("min_length"))
            return Problem(loc, f": must have at {'most' if 'max_length' in context else 'least'} {limit} characters.")
        case "greater_than" | "greater_than_equal" | "less_than" | "less_than_equal":
            name, limit = next((name, limit) for name, limit in context.items() if name in BOUNDS)
            si = any_quantity(value) if isinstance(value, str) and limit else None
            unit = f" {si[1]}" if si is not None and si[1] != "1" else ""
            return Problem(loc, f": must be {BOUNDS[name]} {limit:g}{unit}, not {described(value)}.")
        case "too_short" | "too_long":
            return Problem(loc, f": must be a list with {_count(context)}, not with {context['actual_length']}.")
    return Problem(loc, f": {clause(item['msg'])}.")


def _wrong_literal(loc: Path, value: Any, field: Any) -> Problem:
    choices = _arguments(field.annotation) if field else []
    if numbers := [str(choice) for choice in choices if isinstance(choice, int)]:
        return Problem(loc, f": must be one of {', '.join(numbers)}, not {described(value)}.")
    return wrong_choice(loc, value, [choice for choice in choices if isinstance(choice, str)])


def _is_of_scene(scene: type[BaseModel], loc: Path) -> bool:
    """Whether what stands in a table is a key of the scene itself, such as accuracy below [time]."""
    field = scene.model_fields.get(str(loc[-1])) if len(loc) > 1 else None
    return field is not None and bool(field.description)


def _in_words(pattern: str) -> str:
    # The patterns of names: what they begin with, then what they may have, so many times.
    first = "a letter" if pattern.startswith("^[A-Za-z][") else "a letter or a digit"
    allowed = "letters, digits, _ and -" if r"\-" in pattern else "letters, digits and _"
    most = int(pattern.rpartition(",")[2].removesuffix("}$")) + 1
    return f"{allowed}, {most} at most, {first} first"


def _count(context: dict[str, Any]) -> str:
    if "min_length" in context:
        side, count = "at least", context["min_length"]
    else:
        side, count = "at most", context["max_length"]
    return f"{side} {count} {'entry' if count == 1 else 'entries'}"


def _without_tags(loc: tuple[str | int, ...], kinds: dict[str, Any]) -> tuple[Path, str | None]:
    """The path as it stands in the scene, and the kind that pydantic put into it."""
    names = [part for part in loc if isinstance(part, str)]  # without the numbers of entries in lists
    if len(names) > 1 and names[1] in kinds.get(names[0], {}):
        tag = loc.index(names[1])
        return (*loc[:tag], *loc[tag + 1 :]), names[1]
    if len(loc) > 1 and loc[0] == "units":
        return (loc[0], *(part for part in loc[1:] if part != "Units")), None
    if loc[:2] == ("numerics", "neighbours"):
        return loc[:2], None
    return loc, None


def _is_word(part: str | int) -> bool:
    """Whether a part of a path is how pydantic names a choice of words, among other things that a value may be."""
    return isinstance(part, str) and part.startswith("literal[")


def _model_at(model: type[BaseModel], loc: Path, kind: str | None, kinds: dict[str, Any]) -> type[BaseModel] | None:
    named = False  # whether this part of the path is a name that the scene gives to one of several tables
    for depth, part in enumerate(part for part in loc if isinstance(part, str)):
        if depth == 0 and kind is not None:
            model = kinds[str(part)][kind]
            continue
        if named:
            named = False
            continue
        field = model.model_fields.get(str(part))
        inner = [item for item in _arguments(field.annotation) if _is_model(item)] if field else []
        if field is None or len(inner) != 1:
            return None
        model, named = inner[0], get_origin(field.annotation) is dict
    return model


def _arguments(annotation: Any) -> list[Any]:
    """What an annotation is made of at last: classes, and the words of choices."""
    arguments = get_args(annotation)
    return [inner for item in arguments for inner in _arguments(item)] if arguments else [annotation]


def _is_model(item: Any) -> bool:
    return isinstance(item, type) and issubclass(item, BaseModel)


def _fields(model: type[BaseModel], loc: Path, kind: str | None, kinds: dict[str, Any]) -> list[str]:
    at = _model_at(model, loc[:-1], kind, kinds)
    return [name for name, field in at.model_fields.items() if not field.exclude] if at else []


def _field(model: type[BaseModel], loc: Path, kind: str | None, kinds: dict[str, Any]) -> Any:
    names = [part for part in loc if isinstance(part, str)]
    at = _model_at(model, tuple(names[:-1]), kind, kinds)
    return at.model_fields.get(names[-1]) if at else None


def _meaning(model: type[BaseModel], loc: Path, kind: str | None, kinds: dict[str, Any]) -> str:
    field = _field(model, loc, kind, kinds)
    return f" ({field.description})" if field is not None and field.description else ""


def _deeper(at: type[BaseModel] | None, loc: Path) -> str:
    """The table within this one that has such a key, as `rotation` of a body has `period`."""
    for name, field in (at.model_fields if at else {}).items():
        if any(_is_model(inner) and loc[-1] in inner.model_fields for inner in _arguments(field.annotation)):
            return f"did you mean '{name}.{loc[-1]}'?"
    return ""


def _other_kind(loc: Path, kinds: dict[str, dict[str, type[BaseModel]]]) -> str:
    names = [part for part in loc if isinstance(part, str)]
    if len(names) != 2 or names[0] not in kinds:
        return ""
    owners = [kind for kind, model in kinds[names[0]].items() if names[1] in model.model_fields]
    return f"it belongs to the kind {' or '.join(owners)}." if owners else ""
