"""Dataclasses as pytrees of JAX.

jax.tree_util.register_dataclass leaves the class out when it compares two structures, though not when it hashes them
(jaxlib 0.10): Vinet(1.0, 2.0, 3.0) and Murnaghan(1.0, 2.0, 3.0) were "the same" to the cache of a compiled function
whenever their hashes fell together, and one was computed by the other's program. Structures made here carry the class.
Tests: tests/unit/engines/test_pytree.py.
"""

from collections.abc import Iterable
from dataclasses import fields
from typing import Any, TypeVar

import jax

T = TypeVar("T")


def pytree(cls: type[T]) -> type[T]:
    """Register a dataclass as a pytree; a field with metadata {"static": True} is part of the structure.

    Structures of two classes differ, whatever their fields. Checked by tests/unit/engines/test_pytree.py.
    """
    names = [field.name for field in fields(cls) if field.init]  # type: ignore[arg-type]
    static = {field.name for field in fields(cls) if field.metadata.get("static", False)}  # type: ignore[arg-type]
    data = [name for name in names if name not in static]
    kept = [name for name in names if name in static]
    keys = [jax.tree_util.GetAttrKey(name) for name in data]

    def flatten(tree: Any) -> tuple[tuple, tuple]:
        return tuple(getattr(tree, name) for name in data), tuple(getattr(tree, name) for name in kept)

    def flatten_with_keys(tree: Any) -> tuple[tuple, tuple]:
        children, constants = flatten(tree)
        return tuple(zip(keys, children, strict=True)), constants

    def unflatten(constants: tuple, children: Iterable[Any]) -> T:
        return cls(**dict(zip(data, children, strict=True)), **dict(zip(kept, constants, strict=True)))

    jax.tree_util.register_pytree_with_keys(cls, flatten_with_keys, unflatten, flatten)
    return cls
