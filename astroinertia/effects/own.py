"""Effects that are not of this package: classes that are given from Python, or that installed packages offer.

A package offers an effect by an entry point of the group `astroinertia.effects`, named as the effect's kind:

    [project.entry-points."astroinertia.effects"]
    cubic_drag = "cubic_drag:CubicDrag"

A scene names a kind and never code: what is imported is the entry point of that name, of a distribution that is
installed, and no other. The class says of itself what the catalogue says of built-in effects (effects.effect.Effect).
Tests: tests/unit/test_doors.py.
"""

import functools
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.effects.entries import ALL_MODELS, Cost, Entry, Option, exponents
from astroinertia.errors import SceneError
from astroinertia.units import shown, si_unit

GROUP = "astroinertia.effects"
TAKEN = ("common", "motion", "rigidity")  # names of what belongs to no effect, in audits, ledgers and figures


def entry_of(made: Any, package: str = "") -> Entry:
    """What a class says of itself as an effect; SceneError, in a sentence, where it is none.

    package: name and version of the package that offers it; empty for a class that is given from Python.
    """
    from astroinertia.effects.effect import Effect, is_pytree  # with JAX, which other scenes do without here

    name = shown(getattr(made, "__qualname__", repr(made)))
    who = f"{name} of {package}" if package else name

    def refused(what: str) -> SceneError:
        return SceneError(f"{who} is no effect: {what}.")

    if not (isinstance(made, type) and issubclass(made, Effect)):
        raise refused("it must be a subclass of astroinertia.effects.Effect")
    if not (is_dataclass(made) and is_pytree(made)):
        raise refused("decorate it with @pytree above @dataclass(frozen=True, eq=False)")
    kind = getattr(made, "kind", None)
    if not isinstance(kind, str) or not re.fullmatch(r"[a-z][a-z0-9_]{0,63}", kind):
        raise refused("its `kind` must be a name of small letters, digits and _")
    if kind in CATALOGUE or kind in TAKEN:
        raise refused(f"its kind '{kind}' is the name of a built-in one; choose another")
    options, given = made.options, {field.name: field for field in fields(made)}
    if not isinstance(options, Mapping) or set(options) != set(given):
        odd = sorted(set(options) ^ set(given)) if isinstance(options, Mapping) else []
        raise refused(f"its `options` must describe each of its fields{f', but not so {odd[0]}' if odd else ''}")
    for key, option in options.items():
        fixed = option.dimension in ("choice", "boolean")
        if fixed != bool(given[key].metadata.get("static", False)):
            raise refused(f'its field {key} must {"" if fixed else "not "}have the metadata {{"static": True}}')
    if not made.models or not set(made.models) <= set(ALL_MODELS):
        raise refused(f"its `models` must be some of {', '.join(ALL_MODELS)}")
    text = " ".join((made.__doc__ or "").split("\n\n")[0].split()).rstrip(".")
    text = text[:1].lower() + text[1:] if text[1:2].islower() else text
    return Entry(
        made.__module__, made.__name__, text, options, _loop(made, Effect), made.source, tuple(made.models),
        made.numerical, size=made.size, made=made, package=package,
    )  # fmt: skip


def _loop(made: Any, plain: Any) -> Cost:
    """The loop that it needs, by the parts that it has."""

    def has(*names: str) -> bool:
        return any(getattr(made, name) is not getattr(plain, name) for name in names)

    if has("all_pair_terms"):
        return "all pairs"
    return "neighbours" if has("neighbour_terms", "gradient_terms") else "body" if made.whole_body else "particles"


@functools.lru_cache(maxsize=8)
def _offers(path: tuple[str, ...]) -> dict[str, tuple[EntryPoint, ...]]:
    # Names alone: nothing is imported. `path` is sys.path, where distributions are looked for.
    found: dict[str, tuple[EntryPoint, ...]] = {}
    for point in entry_points(group=GROUP):
        found[point.name] = (*found.get(point.name, ()), point)
    return found


def offered() -> Mapping[str, tuple[EntryPoint, ...]]:
    """The entry points of installed packages, by the kind of the effect that they offer; nothing is imported."""
    return _offers(tuple(sys.path))


def installed(kind: str) -> Entry | None:
    """The effect of that kind that an installed package offers; None where there is none.

    SceneError where several do, where the name is that of a built-in effect, or where it cannot be imported.
    """
    points = list(offered().get(kind, ()))
    if not points:
        return None
    packages = [f"{point.dist.name} {point.dist.version}" if point.dist else "a package" for point in points]
    if kind in CATALOGUE or len(points) > 1:
        other = "this package, which has one built in" if kind in CATALOGUE else packages[1]
        raise SceneError(f"an effect '{kind}' is offered by {packages[0]} and by {other}; keep one of the two.")
    try:
        made = points[0].load()
    except Exception as error:  # whatever the package does when it is imported
        why = f"{type(error).__name__}: {shown(str(error), 200)}"
        raise SceneError(f"the effect '{kind}' of {packages[0]} cannot be imported ({why}).") from error
    entry = entry_of(made, packages[0])
    if made.kind != kind:
        raise SceneError(f"{packages[0]} offers an effect as '{kind}' whose kind is '{made.kind}'; they must agree.")
    return entry


def classes(effects: Sequence[Any]) -> dict[str, Entry]:
    """Of effects that are given from Python, or their classes, what they say of themselves, by kind."""
    found: dict[str, Entry] = {}
    for each in effects:
        made = each if isinstance(each, type) else type(each)
        entry = entry_of(made)
        if made.kind in found:
            raise SceneError(f"two effects of the kind '{made.kind}' are given; give one.")
        found[made.kind] = entry
    return found


def own_entries(kinds: Iterable[str], given: Mapping[str, Entry]) -> dict[str, Entry]:
    """Of the kinds that a scene lists, those that are not built in and known: given from Python, or installed."""
    found = {kind: given[kind] if kind in given else installed(kind) for kind in kinds}
    return {kind: entry for kind, entry in found.items() if entry is not None}


def as_written(effect: Any, code: bool) -> dict[str, Any]:
    """The options of an effect as a scene would have them: {name: value}, without those that are None.

    Numbers are in SI, or in code units where `code`; text with a unit stays as it is.
    """
    return {
        name: _written(value, option, code)
        for name, option in effect.options.items()
        if (value := getattr(effect, name)) is not None
    }


def _written(value: Any, option: Option, code: bool) -> Any:
    if isinstance(value, str | bool):
        return value
    if getattr(value, "ndim", 0) or isinstance(value, list | tuple):
        return [_written(item, option, code) for item in value]
    number = float(value)
    if code or option.dimension == "dimensionless":
        return number
    unit = "rad" if option.dimension == "angle" else si_unit(exponents(option.dimension))
    return f"{number!r} {unit}"
