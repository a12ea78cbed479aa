"""A scene from a TOML file or text: read within limits, overridden, validated, or refused with one clear sentence."""

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.effects.doors import Door, as_written, made_of
from astroinertia.effects.entries import Entry
from astroinertia.effects.own import EFFECTS, with_functions
from astroinertia.errors import SceneError
from astroinertia.observables.own import OBSERVABLES
from astroinertia.scene import schema
from astroinertia.scene.auto import AUTO, Choice, choose
from astroinertia.scene.body_kinds.profile import shells_of
from astroinertia.scene.dimensional import described, fraction
from astroinertia.scene.fluids import OwnFluid
from astroinertia.scene.from_python import kind_of, text_of
from astroinertia.scene.kinds import BODY_KINDS, FLUID_KINDS
from astroinertia.scene.options import effect_options, options_of
from astroinertia.scene.own import BODIES, MATTER, Given, by_door, door_of
from astroinertia.scene.own_body import KEYS as OF_ANY_BODY, OwnBody
from astroinertia.scene.problems import OF_THE_SCENE, Problem, first_problem, nearest, place, unknown_key, wrong_choice
from astroinertia.scene.scales import refuse_extremes
from astroinertia.scene.schema import RECORD
from astroinertia.scene.source import (
    LARGEST_FILE,
    at_home,
    decode,
    file_of_scene,
    key_of,
    line_of,
    override,
    parse,
    read_regular_file,
)
from astroinertia.scene.text import toml_value, with_overrides
from astroinertia.units import ALL_MODELS, quantity, shown

SWEEP, SI = "sweep", "SI"
"""The table that makes several runs of a scene: scene.sweep."""

BEFORE_CHOICE = 1000  # particles of a scene whose number is to be chosen, until it is
KINDS: dict[str, dict[str, type[Any]]] = {
    "body": BODY_KINDS, "bodies": BODY_KINDS, "equation_of_state": FLUID_KINDS,
}  # fmt: skip
OF_OUTSIDE: dict[str, type[Any]] = {"body": OwnBody, "bodies": OwnBody, "equation_of_state": OwnFluid}
KEYS = [name for name in schema.Scene.model_fields if name not in RECORD]


def load_file(path: str | os.PathLike[str], overrides: Sequence[str] = (), effects: Sequence[Any] = ()) -> schema.Scene:
    """The scene in a TOML file, with "key.path=value" overrides put in; SceneError says in a sentence what is wrong.

    effects: of the user's own, as for `loads`.
    """
    text, name, origin = read_file(path)
    return with_all_listed(loads(text, overrides, origin, name, effects), effects)


def read_file(path: str | os.PathLike[str]) -> tuple[str, str, str]:
    """The text of a scene file, how the file is named in messages, and its folder; SceneError if it is no such text."""
    if not isinstance(path, str | os.PathLike):
        raise SceneError(f"a scene must be a Scene, a table (a dict) or the path of a file, not {kind_of(path)}.")
    file = at_home(Path(path))
    name = shown(str(file), 200)
    return decode(read_regular_file(file, LARGEST_FILE, "a scene"), name), name, str(file.absolute().parent)


def of(scene: Any, effects: Sequence[Any] = ()) -> schema.Scene:
    """The scene in a file, or of tables that are written in Python; effects: of the user's own, as for `loads`."""
    return of_tables(scene, effects) if isinstance(scene, Mapping) else load_file(scene, effects=effects)


def of_tables(tables: Any, effects: Sequence[Any] = ()) -> schema.Scene:
    """The scene of tables that are written in Python (from_python.text_of); SceneError as for a file, without a line.

    File names in it are relative to the current folder. effects: of the user's own, as for `loads`, besides those that
    stand in the tables.
    """
    text, own = text_of(tables)
    return with_all_listed(loads(text, origin=str(Path.cwd()), effects=(*own, *effects), numbered=False), effects)


def loads(
    text: str, overrides: Sequence[str] = (), origin: str | None = None, name: str = "the scene",
    effects: Sequence[Any] = (), numbered: bool = True,
) -> schema.Scene:  # fmt: skip
    """The scene in a TOML text; raises SceneError.

    origin: the folder that file names in it are relative to. name: what messages call the text; numbered: whether its
    lines are those that its author wrote, so that messages name them. effects: of the user's own; a class stands for
    what the text names, an effect, or a function that serves for one, is listed besides, as if by overrides. An
    equation of state may be among them, and takes the place of [equation_of_state]; an initial body, of what is of its
    kind in [body]; and observables, which are listed likewise.
    """
    effects = with_functions(effects)
    given = by_door(effects)
    tables = override(parse(text, name), overrides)
    listed = _listing(tables, effects)
    overrides = (*overrides, *listed)
    tables = override(tables, overrides)
    overrides = (*overrides, *_units_of_files(tables, origin), *_particles_to_choose(tables))
    tables = override(tables, overrides)
    if overrides:
        parse(with_overrides(text, overrides), name)  # what a run folder keeps must be readable when it is resumed
    try:
        return _validated(tables, text, tuple(overrides), origin, given)
    except Problem as problem:
        path = tuple(part for part in problem.path if isinstance(part, str))
        at = where(text if numbered else "", [item for item in overrides if item not in listed], path, name)
        named, message = place(problem.path, problem.table) if problem.path else "", problem.message
        raise SceneError(f"{at}: {named}{message if named else message.lstrip(': ')}") from None


def with_effects(scene: schema.Scene, effects: Sequence[Any]) -> schema.Scene:
    """The scene with effects of the user's own besides those that it lists; SceneError where they do not go with it."""
    if not effects:
        return scene
    found = loads(scene.source, scene.overrides, scene.origin, effects=(*scene.own_classes, *effects))
    return with_all_listed(found, effects)


def with_all_listed(scene: schema.Scene, given: Sequence[Any]) -> schema.Scene:
    """The scene; SceneError for the class of an effect, or of an observable, that is given and not listed in it."""
    classes = by_door([each for each in given if isinstance(each, type)])
    for door, listed in ((EFFECTS, {**scene.effects, **scene.candidates}), (OBSERVABLES, scene.observables)):
        for kind, entry in classes[door].items():
            if kind not in listed:
                raise door.unnamed(entry.made)
    return scene


def refuse_other_options(scene: schema.Scene, own: Any) -> None:
    """SceneError where something of the user's own that is given for a scene is not among its own, or not as there.

    For runs that go on: what they were given is in the text of their scenes. own: an object, or its class.
    """
    made: Any = made_of(own)
    thing = f"the {door_of(made).thing} '{made.kind}' is given"
    began = next((each.options for each in scene.outside if each.entry.made is made), None)
    if began is None:
        raise SceneError(f"{thing}, but the run began without it.")
    if isinstance(own, type):
        return
    if options_of((made.kind,), made.options, as_written(own, scene.dimensionless), scene.dimensionless) != began:
        was = ", ".join(f"{name} = {value}" for name, value in began.items())
        raise SceneError(f"{thing} with other options than the run began with: {was}.")


def _listing(tables: dict[str, Any], things: Sequence[Any]) -> list[str]:
    """Overrides that list what is given from Python, with its options."""
    overrides, code = [], tables.get("units") == "code"
    for own in things:
        if isinstance(own, type):
            continue
        door, kind, written = door_of(own), type(own).kind, as_written(own, code)
        table = "candidates" if door is EFFECTS and tables.get("effects") == AUTO else door.table
        listed = tables.get(table, {})
        if door.single:
            written = {"kind": kind, **written, **(_stays(tables) if door is BODIES else {})}
        elif isinstance(listed, dict) and kind in listed:
            raise SceneError(
                f"the {door.thing} '{kind}' is listed in the scene and given besides; give its class alone."
            )
        overrides.append(f"{table if door.single else f'{table}.{kind}'}={toml_value(written)}")
    return overrides


def _units_of_files(tables: dict[str, Any], origin: str | None) -> list[str]:
    """Overrides that give a scene without units, or in SI, those of the first file among its bodies.

    None where a table is there whose numbers have no units: its body says so.
    """
    units, bodies = tables.get("units"), tables.get("bodies", [tables.get("body")])
    if units not in (None, SI) or not isinstance(bodies, list):
        return []
    from_files = [body for body in bodies if isinstance(body, dict) and body.get("kind") in ("table", "profile")]
    if not from_files or not all(isinstance(body.get("file"), str) and body["file"] for body in from_files):
        return []
    stated = [_sizes(body, file_of_scene(origin, body["file"]), units == SI) for body in from_files]
    if None in stated:
        return []
    mass, length = stated[0]
    return [f'units={{mass="{mass!r} kg", length="{length!r} m"}}']


def _sizes(body: Mapping[str, Any], path: Path, in_si: bool) -> Any:
    """Mass (kg) and radius (m) of what a body takes from its file; None where its numbers have no units."""
    if body["kind"] == "table":
        from astroinertia.sph.table import units_for  # only where there is a file to open

        return units_for(path, in_si)
    inner = None
    with suppress(SceneError, TypeError):  # what is no mass is refused with its key, below
        inner = quantity(body["inner_mass"], "mass") if "inner_mass" in body else None
    shells = shells_of(path, inner)
    return float(shells.mass[-1]), float(shells.radius[-1])


def _particles_to_choose(tables: dict[str, Any]) -> list[str]:
    """An override that gives a body particles, whose number is chosen for the accuracy asked for before the run."""
    body = tables.get("body")
    chosen = "accuracy" in tables and tables.get("settings", "chosen") == "chosen"
    if not chosen or tables.get("model", "sph") != "sph" or not isinstance(body, dict) or "particles" in body:
        return []
    made = KINDS["body"].get(str(body.get("kind")))
    return [f"body.particles={BEFORE_CHOICE}"] if made is not None and "particles" in made.model_fields else []


def _stays(tables: Mapping[str, Any]) -> dict[str, Any]:
    """What stays of a scene's body where another is given from Python: what does not depend on its kind."""
    if "bodies" in tables:
        raise SceneError("an initial body is given, but the scene has several: name its kind there, give its class.")
    body = tables.get("body", {})
    stays = [key for key in OF_ANY_BODY if key not in ("kind", "placement", "relax", "pressure_fraction")]
    return {key: body[key] for key in stays if isinstance(body, dict) and key in body}


def where(text: str, overrides: Sequence[str], path: tuple[str, ...], name: str) -> str:
    """Where a key was given, for a message: an override, a line of the text, or the text as a whole."""
    for item in reversed(overrides):
        key = key_of(item)
        if path[: len(key)] == key:
            return f"--set {shown(item)}"
    line = line_of(text, path)
    return f"{name}, line {line}" if line else name


def _refuse_wrong_tables(tables: dict[str, Any], given: Given) -> None:
    """Problem for tables that no scene has, or has otherwise, and for those of a sweep."""
    for door in (door for door, classes in given.items() if classes and SWEEP in tables):
        raise Problem((SWEEP,), f" takes no {door.thing} from Python, but what is built in or installed.", table=True)
    if SWEEP in tables:
        raise Problem(
            (SWEEP,),
            " makes several runs of a scene: `run` and `plan` take its file, and run_scene a dict of its tables.",
            table=True,
        )
    for key in tables:
        if key not in KEYS:
            raise unknown_key((key,), [*KEYS, SWEEP])
    units = tables.get("units")
    if units is not None and units not in ("code", SI) and not isinstance(units, dict):
        raise Problem(("units",), f': must be "code", "SI" or a table with mass and length, not {described(units)}.')
    if "effects" not in tables:
        for name, table in tables.items():
            if isinstance(table, dict) and "effects" in table:
                raise unknown_key((name, "effects"), (), OF_THE_SCENE)
        raise Problem(("effects",), " is missing (a table for each effect called for, such as [effects.gravity]).")
    automatic = tables["effects"] == AUTO
    if isinstance(tables["effects"], str) and not automatic:
        raise Problem(
            ("effects",), f": '{shown(tables['effects'])}' is not known; {nearest(tables['effects'], [AUTO])}"
        )
    if "candidates" in tables and not automatic:
        raise Problem(("candidates",), ' are for effects = "auto", which chooses among them.', table=True)


def _validated(
    tables: dict[str, Any], text: str, overrides: tuple[str, ...], origin: str | None, given: Given
) -> schema.Scene:
    _refuse_wrong_tables(tables, given)
    code, automatic = tables.get("units") == "code", tables["effects"] == AUTO
    table = "candidates" if automatic else "effects"
    listed = tables.get(table, {})
    kinds = list(listed) if isinstance(listed, dict) else []
    own = EFFECTS.known(kinds, given[EFFECTS])
    entries = {**CATALOGUE, **own}
    if misplaced := [kind for kind in kinds if kind in KEYS and kind not in entries]:
        raise unknown_key((table, misplaced[0]), (), OF_THE_SCENE)
    effects = effect_options(listed, code, table, entries)
    _check_model(tables.get("model", "sph"), effects, table, entries)
    _check_softening(effects, table, entries)
    if not automatic:
        _check_needs(effects, table, entries)
    if "box" in tables:
        _check_box(effects, table, entries)
    tables = {**tables, **_of_outside(tables, given, code)}
    context = {"code": code, "gamma_thermal": _thermal_exponent(tables.get("equation_of_state"))}
    record = {"effects": effects, "source": text, "overrides": overrides, "origin": origin, "own": own}
    record |= _observables(tables, code, given[OBSERVABLES]) | _first_of(tables)
    if not automatic:
        return _scene_of({**tables, **record}, context)
    everything = {**tables, **record, "candidates": effects, "effects": {"gravity": {}, **effects}}
    choice: Choice = choose(_scene_of(everything, context))
    chosen = {"effects": choice.effects, "reasons": choice.reasons}
    return _scene_of({**everything, **chosen} | ({} if choice.companions else {"companions": []}), context)


def _scene_of(tables: dict[str, Any], context: dict[str, Any]) -> schema.Scene:
    try:
        scene = schema.Scene.model_validate(tables, context=context)
    except ValidationError as error:
        kinds = {table: {**kinds, "own": OF_OUTSIDE[table]} for table, kinds in KINDS.items()}
        raise first_problem(error, schema.Scene, kinds) from None
    refuse_extremes(scene)
    return scene


def _of_outside(tables: Mapping[str, Any], given: Given, code: bool) -> dict[str, Any]:
    """[body] or [[bodies]], and [equation_of_state], as OwnBody and OwnFluid take them where not of a built-in kind."""
    several = isinstance(tables.get("bodies"), list)
    found: dict[str, Any] = {}
    for door, name in ((MATTER, MATTER.table), (BODIES, "bodies" if several else BODIES.table)):
        items = tables[name] if name == "bodies" else [tables.get(name)]
        made = [_of_own_kind(item, door, given[door], code) if isinstance(item, dict) else item for item in items]
        for entry in given[door].values():
            if not any(isinstance(item, dict) and item.get("entry") is entry for item in made):
                raise door.unnamed(entry.made)
        if name in tables:
            found[name] = made if name == "bodies" else made[0]
    return found


def _of_own_kind(table: dict[str, Any], door: Door, given: Mapping[str, Entry], code: bool) -> dict[str, Any]:
    """A table as OwnBody or OwnFluid takes it, or as it is where its kind is built in."""
    kind = table.get("kind")
    if not isinstance(kind, str):
        return table
    entry = door.known([kind], given).get(kind)
    if entry is None:
        kinds = KINDS[door.table]
        if kind not in kinds:
            raise wrong_choice((door.table, "kind"), kind, [*kinds, *door.offered()])
        return table
    of_any = OF_ANY_BODY if door is BODIES else ("kind",)
    common = {name: value for name, value in table.items() if name in of_any}
    others = {name: value for name, value in table.items() if name not in of_any}
    options = options_of((door.table,), entry.options, others, code)
    try:
        entry.build(options)
    except ValueError as error:
        raise Problem((door.table,), f" {error}", table=True) from None
    return {**common, "kind": "own", "name": kind, "options": options, "entry": entry}


def _observables(tables: dict[str, Any], code: bool, classes: Mapping[str, Entry]) -> dict[str, Any]:
    """The observables that a scene lists with all their options, and what their classes say."""
    listed, table, model = tables.get("observables", {}), "observables", tables.get("model", "sph")
    entries = OBSERVABLES.known(listed if isinstance(listed, dict) else (), classes)
    options = effect_options(listed, code, table, entries, OBSERVABLES)
    for kind, entry in entries.items():
        if model in ALL_MODELS and model not in entry.models:
            raise Problem((table, kind), f" belongs to the model {' or '.join(entry.models)}, not {model}.", table=True)
        try:
            entry.build(options[kind])
        except ValueError as error:
            raise Problem((table, kind), f" {error}", table=True) from None
    return {"observables": options, "observed": entries}


def _first_of(tables: dict[str, Any]) -> dict[str, Any]:
    """The first of several bodies stands where a scene of one has it."""
    if "bodies" not in tables:
        return {}
    if "body" in tables:
        raise Problem(("bodies",), " is given besides [body]; keep one of them.", table=True)
    bodies = tables["bodies"]
    return {"body": bodies[0]} if isinstance(bodies, list) and bodies else {"body": {"kind": "uniform"}}


def _check_model(model: Any, effects: dict[str, Any], table: str, entries: Mapping[str, Entry]) -> None:
    if model not in ALL_MODELS:
        return  # said by the field itself
    for kind in effects:
        entry = entries[kind]
        if model not in entry.models and not entry.numerical:
            has = ", ".join(name for name, other in CATALOGUE.items() if model in other.models)
            raise Problem(
                (table, kind), f" belongs to the model {' or '.join(entry.models)}; {model} has {has}.", table=True
            )


def _check_box(effects: dict[str, Any], table: str, entries: Mapping[str, Entry]) -> None:
    for kind in effects:
        if entries[kind].cost != "neighbours":
            has = ", ".join(name for name, other in CATALOGUE.items() if other.cost == "neighbours")
            raise Problem((table, kind), f" cannot act in a periodic box, where only neighbours do: {has}.", table=True)


def _check_needs(effects: dict[str, Any], table: str, entries: Mapping[str, Entry]) -> None:
    for kind in effects:
        missing = [name for name in entries[kind].needs if name not in effects]
        if missing and not entries[kind].numerical:
            raise Problem((table, kind), f" acts beside {missing[0]}: list [effects.{missing[0]}], too.", table=True)


def _check_softening(effects: dict[str, Any], table: str, entries: Mapping[str, Entry]) -> None:
    near = [kind for kind in effects if entries[kind].cost == "neighbours"]
    if near and effects.get("gravity", {}).get("softening") is not None:
        raise Problem(
            (table, "gravity", "softening"),
            f" keeps smoothing lengths as they are, but {near[0]} needs ones that follow the density; leave out one.",
        )


def _thermal_exponent(table: Any) -> float | None:
    """Exponent of the thermal part, which sets the dimension of an entropy in [body]; None without it."""
    made = KINDS["equation_of_state"].get(str(table.get("kind"))) if isinstance(table, dict) else None
    if made is None or not made.thermal_key:
        return None
    value = fraction(table.get(made.thermal_key, made.model_fields[made.thermal_key].default))
    right = isinstance(value, int | float) and not isinstance(value, bool) and 1.0 < value <= 10.0
    return float(value) if right else None
