"""Dataclasses as pytrees of JAX.

jax.tree_util.register_dataclass leaves the class out when it compares two structures, though not when it hashes them
(jaxlib 0.10): Vinet(1.0, 2.0, 3.0) and Murnaghan(1.0, 2.0, 3.0) were "the same" to the cache of a compiled function
whenever their hashes fell together, and one was computed by the other's program. Structures made here carry the class.

Classes are registered when JAX is imported, whoever does: what is done in numpy need not wait for it, and goes through
its trees with `mapped` and `named_leaves`.
Tests: tests/unit/engines/test_pytree.py.
"""

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from functools import partial
from typing import Any, TypeVar

from astroinertia.process.imports import once_imported

T = TypeVar("T")

_fields: dict[type, tuple[list[str], list[str]]] = {}  # of each class, what is data and what part of the structure


def pytree(cls: type[T]) -> type[T]:
    """Register a dataclass as a pytree; a field with metadata {"static": True} is part of the structure.

    Structures of two classes differ, whatever their fields. Checked by tests/unit/engines/test_pytree.py.
    """
    names = [field.name for field in fields(cls) if field.init]  # type: ignore[arg-type]
    static = {field.name for field in fields(cls) if field.metadata.get("static", False)}  # type: ignore[arg-type]
    _fields[cls] = [name for name in names if name not in static], [name for name in names if name in static]
    once_imported("jax", partial(_register, cls))
    return cls


def mapped(function: Callable[[Any], Any], tree: Any) -> Any:
    """The tree with function(leaf) in place of each leaf, as jax.tree.map has it."""
    return _rebuilt(lambda _, leaf: function(leaf), tree, "")


def named_leaves(tree: Any) -> dict[str, Any]:
    """{path: leaf}, with paths as jax.tree_util.keystr has them: `.rates.fluid.density`, `.memory['name']`."""
    found: dict[str, Any] = {}
    _rebuilt(found.__setitem__, tree, "")
    return found


def with_leaves(tree: Any, leaves: Mapping[str, Any]) -> Any:
    """The tree with other leaves, by their paths; KeyError where one is missing."""
    return _rebuilt(lambda path, _: leaves[path], tree, "")


def with_fields(tree: T, **values: Any) -> T:
    """The dataclass with other fields: dataclasses.replace, which looks at every field, where that takes too long.

    For classes whose instances hold their fields alone and check none. TypeError for a field that there is not.

    >>> from astroinertia.engines.terms import Output
    >>> with_fields(Output("signal", "max"), name="rate")
    Output(name='rate', how='max', of=None)
    """
    fields = vars(tree) | values
    if len(fields) > len(vars(tree)):
        raise TypeError(f"{type(tree).__name__} has no field {', '.join(sorted(values.keys() - vars(tree).keys()))}")
    made = object.__new__(type(tree))
    object.__setattr__(made, "__dict__", fields)
    return made


def _rebuilt(function: Callable[[str, Any], Any], tree: Any, path: str) -> Any:
    # With function(path, leaf) in place of each leaf. None is a tree without leaves.
    cls = type(tree)
    if cls in _fields:
        data, kept = _fields[cls]
        parts = {name: _rebuilt(function, getattr(tree, name), f"{path}.{name}") for name in data}
        return cls(**parts, **{name: getattr(tree, name) for name in kept})
    if cls is dict:
        return {key: _rebuilt(function, part, f"{path}[{key!r}]") for key, part in sorted(tree.items())}
    if hasattr(tree, "_fields"):
        return cls(*(_rebuilt(function, part, f"{path}.{name}") for name, part in zip(tree._fields, tree, strict=True)))
    if cls in (tuple, list):
        return cls(_rebuilt(function, part, f"{path}[{number}]") for number, part in enumerate(tree))
    return None if tree is None else function(path, tree)


def _register(cls: type) -> None:
    import jax

    data, kept = _fields[cls]
    keys = [jax.tree_util.GetAttrKey(name) for name in data]

    def flatten(tree: Any) -> tuple[tuple, tuple]:
        return tuple(getattr(tree, name) for name in data), tuple(getattr(tree, name) for name in kept)

    def flatten_with_keys(tree: Any) -> tuple[tuple, tuple]:
        children, constants = flatten(tree)
        return tuple(zip(keys, children, strict=True)), constants

    fill: Any = inspect.unwrap(cls.__init__)  # leaves of JAX may be anything, and are not looked at

    def unflatten(constants: tuple, children: Iterable[Any]) -> Any:
        made = object.__new__(cls)
        fill(made, **dict(zip(data, children, strict=True)), **dict(zip(kept, constants, strict=True)))
        return made

    jax.tree_util.register_pytree_with_keys(cls, flatten_with_keys, unflatten, flatten)
