"""The door by which classes that are not of this package come in: given from Python, or offered by entry points.

What is imported is the entry point of the name that a scene has, of a distribution that is installed, and no other.
Tests: tests/unit/test_effects_door.py, tests/unit/test_matter_door.py.
"""

import functools
import re
import sys
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, fields, is_dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from astroinertia.effects.entries import Entry
from astroinertia.errors import SceneError
from astroinertia.units import Option, shown, si_unit, with_unit, written_quantity


@dataclass(frozen=True)
class Door:
    """What comes in: its entry point group, what one such thing is called, the class that it derives from, the line of
    its @dataclass, and the kinds that are taken. pytree: whether compiled programs take it.
    """

    group: str
    thing: str
    base: str
    decorated: str
    taken: Collection[str]
    traced: bool = True
    """Whether JAX sees it, so that it must be a pytree."""

    def refused(self, made: Any, package: str, what: str) -> SceneError:
        """The error that says why a class is no such thing; package: that it comes from, or empty."""
        name = shown(getattr(made, "__qualname__", repr(made)))
        return SceneError(f"{f'{name} of {package}' if package else name} is no {self.thing}: {what}.")

    def check(self, made: Any, base: type, package: str) -> str:
        """The first sentence of the docstring of a class, once all that every class needs is found right.

        SceneError, in a sentence, where it is not a pytree of that base, with a kind of its own and all options stated.
        """

        def refused(what: str) -> SceneError:
            return self.refused(made, package, what)

        if not (isinstance(made, type) and issubclass(made, base)):
            raise refused(f"it must be a subclass of {self.base}")
        if absent := sorted(getattr(made, "__abstractmethods__", ())):
            raise refused(f"it has no `{absent[0]}`")
        if not is_dataclass(made) or (self.traced and not _is_pytree(made)):
            raise refused(f"decorate it with {'@pytree above ' * self.traced}{self.decorated}")
        kind, options = (getattr(made, name, None) for name in ("kind", "options"))
        if not isinstance(kind, str) or not re.fullmatch(r"[a-z][a-z0-9_]{0,63}", kind):
            raise refused("its `kind` must be a name of small letters, digits and _")
        if kind in self.taken:
            raise refused(f"its kind '{kind}' is the name of a built-in one; choose another")
        own_fields = {field.name: field for field in fields(made)}
        if not isinstance(options, Mapping) or set(options) != set(own_fields):
            odd = sorted(set(options) ^ set(own_fields)) if isinstance(options, Mapping) else []
            raise refused(f"its `options` must describe each of its fields{f', but not so {odd[0]}' if odd else ''}")
        for key, option in options.items() if self.traced else ():
            fixed = option.dimension in ("choice", "boolean")
            if fixed != bool(own_fields[key].metadata.get("static", False)):
                raise refused(f'its field {key} must {"" if fixed else "not "}have the metadata {{"static": True}}')
        text = " ".join((made.__doc__ or "").split("\n\n")[0].split()).rstrip(".")
        return text[:1].lower() + text[1:] if text[1:2].islower() else text

    def offered(self) -> Mapping[str, tuple[EntryPoint, ...]]:
        """The entry points of installed packages, by the kind that they offer; nothing is imported."""
        return _offers(self.group, tuple(sys.path))

    def installed(self, kind: str, entry_of: Callable[[Any, str], Entry]) -> Entry | None:
        """What an installed package offers under that kind, as entry_of(class, package); None where there is none.

        SceneError where several do, where the name is taken, or where it cannot be imported.
        """
        points = list(self.offered().get(kind, ()))
        if not points:
            return None
        packages = [f"{point.dist.name} {point.dist.version}" if point.dist else "a package" for point in points]
        if kind in self.taken or len(points) > 1:
            other = "this package, which has one built in" if kind in self.taken else packages[1]
            raise SceneError(
                f"an {self.thing} '{kind}' is offered by {packages[0]} and by {other}; keep one of the two."
            )
        try:
            made = points[0].load()
        except Exception as error:  # whatever the package does when it is imported
            why = f"{type(error).__name__}: {shown(str(error), 200)}"
            raise SceneError(f"the {self.thing} '{kind}' of {packages[0]} cannot be imported ({why}).") from error
        entry = entry_of(made, packages[0])
        if made.kind != kind:
            raise SceneError(
                f"{packages[0]} offers an {self.thing} as '{kind}' whose kind is '{made.kind}'; they must agree."
            )
        return entry


def _is_pytree(made: type) -> bool:
    """Whether JAX knows the parts of a class, by @pytree."""
    import jax  # only here: scenes of built-in things need not wait for it

    return not jax.tree_util.all_leaves([object.__new__(made)])


@functools.lru_cache(maxsize=16)
def _offers(group: str, path: tuple[str, ...]) -> dict[str, tuple[EntryPoint, ...]]:
    # Names alone: nothing is imported. `path` is sys.path, where distributions are looked for.
    points: dict[str, tuple[EntryPoint, ...]] = {}
    for point in entry_points(group=group):
        points[point.name] = (*points.get(point.name, ()), point)
    return points


def made_of(thing: Any) -> Any:
    """The class of what is given, which may be the class itself."""
    return thing if isinstance(thing, type) else type(thing)


def as_written(own: Any, code: bool) -> dict[str, Any]:
    """The options of an effect, or other such thing, as a scene would have them: {name: value}, without those of None.

    Numbers are in SI, or in code units where `code`; text with a unit stays as it is, and quantities become such text.
    """
    return {
        name: _written(value, option, code, f"{own.kind} {name}")
        for name, option in own.options.items()
        if (value := getattr(own, name)) is not None
    }


def _written(value: Any, option: Option, code: bool, name: str) -> Any:
    if isinstance(value, str | bool):
        return value
    if (quantity := with_unit(value)) is not None:
        return written_quantity(quantity)
    if getattr(value, "ndim", 0) or isinstance(value, list | tuple):
        return [_written(item, option, code, name) for item in value]
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise SceneError(f"{name} must be a number or a quantity, not a {shown(type(value).__name__)}.") from None
    if code or option.dimension == "dimensionless":
        return number
    unit = "rad" if option.dimension == "angle" else si_unit(option.dimension)
    return f"{number!r} {unit}"
