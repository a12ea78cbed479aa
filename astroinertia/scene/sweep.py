"""[sweep] in a scene: several runs of it, each with other values of some of its keys.

    [sweep]                                              every combination: a grid
    "body.radius" = ["10 km", "12 km", "14 km"]
    "body.rotation.period" = {start = "1 ms", stop = "100 ms", number = 5, scale = "log"}

    [sweep]                                              a Latin hypercube (McKay, Beckman & Conover 1979)
    samples = 64
    seed = 1
    "body.radius" = {uniform = ["10 km", "14 km"]}

    [sweep]                                              a list, in which several keys vary together
    members = [{"body.mass" = "1 Msun", "body.radius" = "12 km"}, {"body.mass" = "2 Msun", "body.radius" = "11 km"}]

Tests: tests/unit/scene/test_sweep.py.
"""

import itertools
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.scene import load
from astroinertia.scene.dimensional import described
from astroinertia.scene.from_python import text_of
from astroinertia.scene.problems import nearest
from astroinertia.scene.schema import Scene
from astroinertia.scene.source import KEY, key_of, override, parse
from astroinertia.scene.sweep_values import (
    DISTRIBUTIONS,
    MOST_MEMBERS,
    drawn,
    is_distribution,
    is_rule,
    listed,
    value_text,
)
from astroinertia.scene.text import with_overrides, without_table
from astroinertia.units import shown

OPTIONS = ("samples", "seed", "members")
FIXED = ("name",)  # names the folder of all
GRID, HYPERCUBE, LIST = "grid", "Latin hypercube", "list"


@dataclass(frozen=True)
class Sweep:
    """Several runs of one scene.

    text and overrides: the scene without [sweep], and the --set arguments that go with it; source: the whole text with
    all overrides put in. keys: dotted paths of what varies; members: the values of these keys in each run, in order.
    axes: of a grid, the values of each key, the last of which varies fastest; empty otherwise. own: classes of the
    user's own that were given from Python; no folder keeps them.
    """

    name: str
    kind: str
    text: str
    source: str
    overrides: tuple[str, ...]
    origin: str | None
    keys: tuple[str, ...]
    members: tuple[tuple[Any, ...], ...]
    axes: tuple[tuple[Any, ...], ...] = ()
    file: str = field(default="the scene", compare=False)
    own: tuple[type, ...] = field(default=(), compare=False)

    def settings(self, number: int) -> tuple[str, ...]:
        """What is set in the scene of a member, as --set would have it."""
        return tuple(f"{key}={value_text(value)}" for key, value in zip(self.keys, self.members[number], strict=True))

    def scene(self, number: int) -> Scene:
        """The scene of a member; SceneError names the member."""
        try:
            settings = (*self.overrides, *self.settings(number))
            return load.loads(self.text, settings, self.origin, self.file, effects=self.own)
        except SceneError as error:
            sentence = str(error)
            if any(sentence.startswith(f"--set {shown(item)}: ") for item in self.overrides):
                raise
            for item in self.settings(number):
                sentence = sentence.removeprefix(f"--set {shown(item)}: ")
            where = "" if sentence.startswith(self.file) else f"{self.file}: "
            raise SceneError(
                f"{where}{sentence.removesuffix('.')} ({member(number)}: {self.description(number)})."
            ) from None

    def description(self, number: int) -> str:
        """What is set in the scene of a member, for a message."""
        return ", ".join(shown(item.replace("=", " = ", 1), 60) for item in self.settings(number))


def member(number: int) -> str:
    """The name of a member, and of its folder."""
    return f"member-{number:04d}"


def load_file(path: str | os.PathLike[str], overrides: Sequence[str] = ()) -> Sweep | None:
    """The sweep in a scene file, every member validated; None for a scene of one run. SceneError says what is wrong."""
    text, name, origin = load.read_file(path)
    return loads(text, overrides, origin, name)


def of(scene: Any) -> Sweep | None:
    """The sweep in a scene file, or in tables that are written in Python (load.of); None for a scene of one run."""
    if not isinstance(scene, Mapping):
        return load_file(scene)
    text, own = text_of(scene)
    return None if own else loads(text, origin=str(Path.cwd()))


def loads(
    text: str, overrides: Sequence[str] = (), origin: str | None = None, name: str = "the scene",
    own: tuple[type, ...] = (),
) -> Sweep | None:  # fmt: skip
    """The sweep in a TOML text, as load_file; own: classes of the user's own that stand for kinds that it names."""
    tables = override(parse(text, name), overrides)
    if load.SWEEP not in tables:
        return None
    ours = [item for item in overrides if key_of(item)[0] == load.SWEEP]
    rest = tuple(item for item in overrides if item not in ours)
    try:
        kind, keys, members, axes = _read(tables[load.SWEEP])
        _none_is_fixed(keys, rest)
    except _Refused as refused:
        path = (load.SWEEP, *(refused.key.split(".") if refused.key else ()))
        said = f"[sweep] {shown(refused.key)}" if refused.key else "[sweep]"
        raise SceneError(f"{load.where(text, overrides, path, name)}: {said} {refused}") from None
    scene_name = tables.get("name")
    source = with_overrides(text, overrides)
    sweep = Sweep(
        str(scene_name), kind, without_table(with_overrides(text, ours), load.SWEEP), source, rest, origin, keys,
        members, axes, name, own,
    )  # fmt: skip
    for number in range(len(members)):
        sweep.scene(number)
    return sweep


class _Refused(Exception):
    """What is the matter with a key of [sweep], or with the whole table where the key is empty."""

    def __init__(self, key: str, sentence: object) -> None:
        self.key = key
        super().__init__(str(sentence))


_Members = tuple[tuple[Any, ...], ...]


def _read(table: Any) -> tuple[str, tuple[str, ...], _Members, _Members]:
    """The kind, the keys, the members and, of a grid, the axes."""
    if not isinstance(table, dict):
        raise _Refused("", f"must be a table, not {described(table)}.")
    options = {key: table[key] for key in OPTIONS if key in table}
    rules = _rules({key: value for key, value in table.items() if key not in OPTIONS})
    if "members" in options:
        if rules or len(options) > 1:
            raise _Refused("members", "is a list of all members, so nothing else may stand beside it.")
        return LIST, *_of_list(options["members"]), ()
    if not rules:
        raise _Refused("", 'needs a parameter, such as "body.mass" = ["1 Msun", "2 Msun"].')
    keys = tuple(rules)
    if "samples" in options:
        return HYPERCUBE, keys, _of_hypercube(rules, options["samples"], options.get("seed", 0)), ()
    if "seed" in options:
        raise _Refused("seed", "is for a Latin hypercube, which needs samples.")
    axes = _of_grid(rules)
    return GRID, keys, tuple(itertools.product(*axes)), axes


def _rules(table: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """What is said of each dotted path, whether the path is written in quotes or as tables."""
    rules: dict[str, Any] = {}
    for key, value in table.items():
        path = f"{above}{key}"
        inner = _rules(value, f"{path}.") if isinstance(value, dict) and not is_rule(value) else {path: value}
        for name, rule in inner.items():
            if not above:
                _check_key(name, (*OPTIONS, *load.KEYS))
            if name in rules:
                raise _Refused(name, "is given twice.")
            rules[name] = rule
    return rules


def _check_key(key: str, names: Sequence[str]) -> None:
    if not KEY.fullmatch(key):
        raise _Refused(key, "is no key of a scene, which is names joined by dots, such as body.mass.")
    if (first := key.split(".")[0]) not in names:
        hint = nearest(first, names)
        if key == first and hint.startswith("known are"):
            hint = "a key of a table has the table before it, as body.mass has."
        raise _Refused(key, f"is not a known key; {hint}")


def _of_grid(rules: Mapping[str, Any]) -> _Members:
    axes = []
    for key, rule in rules.items():
        if is_rule(rule) and is_distribution(rule):
            raise _Refused(key, "is a distribution, for which [sweep] needs samples, a number of members.")
        axes.append(tuple(_checked(key, listed, rule)))
    count = math.prod(len(axis) for axis in axes)
    if count > MOST_MEMBERS:
        raise _Refused("", f"has {count} members, more than the {MOST_MEMBERS} that it may have.")
    return tuple(axes)


def _of_hypercube(rules: Mapping[str, Any], samples: Any, seed: Any) -> _Members:
    for key, value, least, most in (("samples", samples, 1, MOST_MEMBERS), ("seed", seed, 0, 2**63)):
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise _Refused(key, f"must be a whole number from {least} to {most}, not {described(value)}.")
    for key, rule in rules.items():
        if not isinstance(rule, dict) or not rule or any(name in rule for name in ("start", "stop", "number")):
            raise _Refused(
                key, f"must be a distribution ({', '.join(DISTRIBUTIONS)}), for [sweep] has samples, not a grid."
            )
    from scipy.stats import qmc

    generator = np.random.default_rng(seed)
    design = qmc.LatinHypercube(d=len(rules), rng=generator)
    shares = design.random(samples)
    columns = [_checked(key, drawn, rule, shares[:, k]) for k, (key, rule) in enumerate(rules.items())]
    return tuple(zip(*columns, strict=True))


def _of_list(members: Any) -> tuple[tuple[str, ...], _Members]:
    if not isinstance(members, list) or not members or not all(isinstance(table, dict) for table in members):
        raise _Refused("members", "must be a list of tables, one for each member, with the keys that it sets.")
    if len(members) > MOST_MEMBERS:
        raise _Refused("members", f"are {len(members)}, more than the {MOST_MEMBERS} that a sweep may have.")
    flat = [_flat(table) for table in members]
    keys = tuple(flat[0])
    if not keys:
        raise _Refused("members", "must each set at least one key.")
    for number, values in enumerate(flat):
        odd = sorted(set(values) ^ set(keys))
        if odd:
            raise _Refused(
                "members", f"must all set the same keys, but {member(number)} and {member(0)} differ in {odd[0]}."
            )
        for key, value in values.items():
            _check_key(key, load.KEYS)
            _checked(key, value_text, value)
    return keys, tuple(tuple(values[key] for key in keys) for values in flat)


def _flat(table: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """Values by dotted paths; a table below a path that is written in quotes is itself the value."""
    values = {}
    for key, value in table.items():
        path = f"{above}{key}"
        values |= _flat(value, f"{path}.") if isinstance(value, dict) and "." not in key else {path: value}
    return values


def _checked(key: str, function: Any, *arguments: Any) -> Any:
    try:
        return function(*arguments)
    except SceneError as error:
        raise _Refused(key, error) from None


def _none_is_fixed(keys: Sequence[str], overrides: Sequence[str]) -> None:
    for key in keys:
        if key.split(".")[0] in FIXED:
            raise _Refused(key, "cannot vary, for it names the folder of all members.")
        for item in overrides:
            path, other = tuple(key.split(".")), key_of(item)
            if path[: len(other)] == other or other[: len(path)] == path:
                raise _Refused(key, f"varies, so it cannot be set by --set {shown(item)}.")
