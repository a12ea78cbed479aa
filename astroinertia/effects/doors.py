"""The door by which classes that are not of this package come in: given from Python, or offered by installed packages.

There are four: EFFECTS (effects.own), OBSERVABLES (observables.own), MATTER and BODIES (scene.own). A package offers a
class by an entry point of the door's group, named as its kind, which scenes may then have as any other:

    [project.entry-points."astroinertia.effects"]
    cubic_drag = "cubic_drag:CubicDrag"

What is imported is the entry point of the name that a scene has, of a distribution that is installed, and no other.
Tests: tests/unit/test_effects_door.py, test_matter_door.py, test_body_door.py and test_observables_door.py.
"""

import functools
import re
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from astroinertia.effects.entries import Entry
from astroinertia.errors import SceneError
from astroinertia.units import ALL_MODELS, Option, failure, shown, si_unit, with_unit, written_quantity


@dataclass(frozen=True, eq=False)
class Door:
    """What comes in, and all that is particular to it.

    name: of its entry point group, astroinertia.NAME, and in a run's description, own_NAME. thing: what one is called.
    base: the class that it derives from, as users import it. table: of a scene, where it stands. argument: how it is
    given from Python. taken: the kinds that it cannot be of. besides: of a class, what its entry has beside what all
    have; ValueError says, in half a sentence, why the class is no such thing. decorated: the line of its @dataclass.
    """

    name: str
    thing: str
    base: str
    table: str
    argument: str
    taken: Collection[str]
    besides: Callable[[Any], Mapping[str, Any]]
    decorated: str = "@dataclass(frozen=True)"
    models: tuple[str, ...] = ALL_MODELS
    """Those that its class may name."""
    single: bool = False
    """Whether its table in a scene is one such thing, which names its kind, and not a table of several by kind."""
    traced: bool = True
    """Whether JAX sees it, so that it must be a pytree."""

    @property
    def described(self) -> str:
        """The key of a run's description that says where each comes from."""
        return f"own_{self.name}"

    def takes(self, made: Any) -> bool:
        """Whether it is a class that derives from the base."""
        module, _, name = self.base.rpartition(".")
        return isinstance(made, type) and issubclass(made, getattr(import_module(module), name))

    def entry_of(self, thing: Any, package: str = "") -> Entry:
        """What a class, or that of an object, says of itself; SceneError, in a sentence, where it is no such thing.

        package: name and version of the package that offers it; empty for what is given from Python.
        """
        made = made_of(thing)
        try:
            text = self._checked(made)
            said = {"models": tuple(made.models) if self.models else (), **self.besides(made)}
        except ValueError as error:
            name = shown(getattr(made, "__qualname__", repr(made)))
            raise SceneError(f"{f'{name} of {package}' if package else name} is no {self.thing}: {error}.") from None
        return Entry(text, made.options, source=made.source, made=made, package=package, **said)

    def _checked(self, made: Any) -> str:
        """The first sentence of the docstring of a class, once all that every class needs is found right."""
        if not self.takes(made):
            raise ValueError(f"it must be a subclass of {self.base}")
        if absent := sorted(getattr(made, "__abstractmethods__", ())):
            raise ValueError(f"it has no `{absent[0]}`")
        if not is_dataclass(made) or (self.traced and not _is_pytree(made)):
            raise ValueError(f"decorate it with {'@pytree above ' * self.traced}{self.decorated}")
        kind, models, source = (getattr(made, name, None) for name in ("kind", "models", "source"))
        if not isinstance(source, str):
            raise ValueError("its `source` must be text")
        if not isinstance(kind, str) or not re.fullmatch(r"[a-z][a-z0-9_]{0,63}", kind):
            raise ValueError("its `kind` must be a name of small letters, digits and _")
        if kind in self.taken:
            raise ValueError(f"its kind '{kind}' is the name of a built-in one; choose another")
        self._check_options(made)
        some = isinstance(models, Collection) and bool(models) and all(model in self.models for model in models)
        if self.models and not some:
            raise ValueError(f"its `models` must be some of {', '.join(self.models)}")
        text = " ".join((made.__doc__ or "").split("\n\n")[0].split()).rstrip(".")
        return text[:1].lower() + text[1:] if text[1:2].islower() else text

    def _check_options(self, made: Any) -> None:
        options, own_fields = getattr(made, "options", None), {field.name: field for field in fields(made)}
        if not isinstance(options, Mapping):
            raise ValueError("its `options` must describe each of its fields")
        if odd := sorted(map(str, set(options) ^ set(own_fields))):
            raise ValueError(f"its `options` must describe each of its fields, but not so {odd[0]}")
        if plain := [key for key, option in options.items() if not isinstance(option, Option)]:
            raise ValueError(f"its `options` must describe {plain[0]} by an Option")
        for key, option in options.items() if self.traced else ():
            fixed = option.dimension in ("choice", "boolean")
            if fixed != bool(own_fields[key].metadata.get("static", False)):
                raise ValueError(f'its field {key} must {"" if fixed else "not "}have the metadata {{"static": True}}')

    def offered(self) -> Mapping[str, tuple[EntryPoint, ...]]:
        """The entry points of installed packages, by the kind that they offer; nothing is imported."""
        return _offers(f"astroinertia.{self.name}", tuple(sys.path))

    def known(self, kinds: Iterable[str], given: Mapping[str, Entry]) -> dict[str, Entry]:
        """Of the kinds that a scene has, those that come from outside: given from Python, or installed."""
        entries = {kind: given[kind] if kind in given else self._installed(kind) for kind in kinds}
        return {kind: entry for kind, entry in entries.items() if entry is not None}

    def _installed(self, kind: str) -> Entry | None:
        """What an installed package offers under that kind; None where there is none.

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
            why = failure(error)
            raise SceneError(f"the {self.thing} '{kind}' of {packages[0]} cannot be imported ({why}).") from error
        entry = self.entry_of(made, packages[0])
        if made.kind != kind:
            raise SceneError(
                f"{packages[0]} offers an {self.thing} as '{kind}' whose kind is '{made.kind}'; they must agree."
            )
        return entry

    def unnamed(self, made: Any) -> SceneError:
        """The error that says that a class is given and its kind stands nowhere in the scene."""
        place = f'[{self.table}] of kind "{made.kind}"' if self.single else f"[{self.table}.{made.kind}]"
        return SceneError(
            f"the class of the {self.thing} '{made.kind}' is given, but the scene has no {place}: write it there, or "
            f"give {made.__name__}(...), which has its options."
        )


def _is_pytree(made: Any) -> bool:
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
