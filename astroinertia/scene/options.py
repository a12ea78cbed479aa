"""The options of the effects that a scene lists, checked against what their entries say."""

from collections.abc import Mapping
from typing import Any

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.effects.doors import Door
from astroinertia.effects.entries import Entry
from astroinertia.effects.own import EFFECTS
from astroinertia.scene.dimensional import described, dimensional
from astroinertia.scene.problems import Problem, nearest, unknown_key, wrong_choice
from astroinertia.units import LIGHT, SPEED_OF_LIGHT, Default, Option


def effect_options(
    effects: Any, code: bool, table: str = "effects", entries: Mapping[str, Entry] = CATALOGUE, door: Door = EFFECTS
) -> dict[str, dict[str, Any]]:
    """Each listed effect with all its options, in SI (in code units where `code`); raises Problem.

    An option that a scene does not give has the catalogue's default; those are zero, without dimension, None, or the
    speed of light. `table` is the name that the scene gives to what lists them; `entries`, the effects that are known;
    `door`, that by which others come, as observables do that a scene lists likewise.
    """
    if not isinstance(effects, dict):
        raise Problem((table,), f": must be a table with a table for each {door.thing}, not {described(effects)}.")
    result = {}
    for kind, table_of_kind in effects.items():
        if kind not in entries:
            kinds = dict.fromkeys((*entries, *door.offered()))
            hint = nearest(kind, kinds) if kinds else "no installed package offers one."
            raise Problem((table, kind), f" is not a known {door.thing}; {hint}")
        if not isinstance(table_of_kind, dict):
            raise Problem((table, kind), f": must be a table (an empty one will do), not {described(table_of_kind)}.")
        result[kind] = options_of((table, kind), entries[kind].options, table_of_kind, code)
    return result


def options_of(
    table: tuple[str, ...], declared: Mapping[str, Option], values_in_scene: Mapping[str, Any], code: bool
) -> dict[str, Any]:
    """All options that are known, as a table of that path gives them or by default; raises Problem."""
    for name in values_in_scene:
        if name not in declared:
            raise unknown_key((*table, name), declared)
    values = {}
    for name, option in declared.items():
        path = (*table, name)
        if name in values_in_scene:
            values[name] = _value(path, option, values_in_scene[name], code)
        elif option.default is LIGHT and not code:
            values[name] = SPEED_OF_LIGHT
        elif isinstance(option.default, Default):
            raise Problem(path, f" is missing ({option.text}).")
        else:
            values[name] = option.default
    return values


def _value(path: tuple[str | int, ...], option: Option, value: Any, code: bool) -> Any:
    if option.dimension == "choice":
        if value not in option.choices:
            raise wrong_choice(path, value, option.choices)
        return value
    if option.dimension == "boolean":
        if not isinstance(value, bool):
            raise Problem(path, f": must be true or false, not {described(value)}.")
        return value
    result = _array(path, option, option.shape, value, code)
    if option.nonzero and not any(result):
        raise Problem(path, ": must not be a vector of zero length.")
    return result


def _array(path: tuple[str | int, ...], option: Option, shape: tuple[int, ...], value: Any, code: bool) -> Any:
    if shape:
        if not isinstance(value, list) or len(value) != shape[0]:
            actual = f"a list of {len(value)}" if isinstance(value, list) else described(value)
            what = "numbers" if len(shape) == 1 else "rows"
            raise Problem(path, f": must be a list of {shape[0]} {what}, not {actual}.")
        return tuple(_array((*path, k), option, shape[1:], item, code) for k, item in enumerate(value))
    try:
        number = dimensional(value, option.dimension, code)
    except ValueError as error:
        raise Problem(path, f": {error}") from None
    below = number <= option.minimum if option.exclusive else number < option.minimum
    if below or number > option.maximum:
        bound = f"at most {option.maximum:g}" if not below else f"{'more than' if option.exclusive else 'at least'} "
        raise Problem(path, f": must be {bound}{f'{option.minimum:g}' if below else ''}, not {described(value)}.")
    return number
