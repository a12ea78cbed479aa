"""Dataclasses as pytrees of JAX.

jax.tree_util.register_dataclass leaves the class out when it compares two structures, though not when it hashes them
(jaxlib 0.10): Vinet(1.0, 2.0, 3.0) and Murnaghan(1.0, 2.0, 3.0) were "the same" to the cache of a compiled function
whenever their hashes fell together, and one was computed by the other's program. Structures made here carry the class.

Classes are registered when JAX is imported, whoever does: what is done in numpy need not wait for it.
Tests: tests/unit/engines/test_pytree.py.
"""

import sys
from collections.abc import Iterable
from dataclasses import fields
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any, TypeVar

T = TypeVar("T")

_JAX = "jax"
_waiting: list[type] = []


def pytree(cls: type[T]) -> type[T]:
    """Register a dataclass as a pytree; a field with metadata {"static": True} is part of the structure.

    Structures of two classes differ, whatever their fields. Checked by tests/unit/engines/test_pytree.py.
    """
    if _JAX in sys.modules:
        _register(cls)
    else:
        _waiting.append(cls)
    return cls


def _register(cls: type) -> None:
    import jax

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

    def unflatten(constants: tuple, children: Iterable[Any]) -> Any:
        return cls(**dict(zip(data, children, strict=True)), **dict(zip(kept, constants, strict=True)))

    jax.tree_util.register_pytree_with_keys(cls, flatten_with_keys, unflatten, flatten)


class _AfterJax(MetaPathFinder):
    """Finds JAX as Python does, and has what waits for it registered at the end of its import."""

    def find_spec(self, fullname: str, path: Any = None, target: ModuleType | None = None) -> ModuleSpec | None:
        if fullname != _JAX:
            return None
        others = [finder for finder in sys.meta_path if finder is not self]
        specs = (finder.find_spec(fullname, path, target) for finder in others)
        spec = next((spec for spec in specs if spec is not None), None)
        if spec is None or spec.loader is None:
            return spec
        execute = spec.loader.exec_module

        def execute_and_register(module: ModuleType) -> None:
            execute(module)
            while _waiting:
                _register(_waiting.pop())

        spec.loader.exec_module = execute_and_register
        return spec


if _JAX not in sys.modules:
    sys.meta_path.insert(0, _AfterJax())
