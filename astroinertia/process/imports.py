"""What is done as soon as a package is imported, whoever imports it: nothing waits for it until then."""

import sys
from collections.abc import Callable
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from importlib.machinery import ModuleSpec

_waiting: dict[str, list[Callable[[], None]]] = {}  # by package: what is done at the end of its import


def once_imported(package: str, action: Callable[[], None]) -> None:
    """Do something as soon as a package is there: now, or at the end of its import."""
    if package in sys.modules:
        action()
        return
    if not any(isinstance(finder, _After) for finder in sys.meta_path):
        sys.meta_path.insert(0, _After())
    actions = _waiting.setdefault(package, [])
    if action not in actions:
        actions.append(action)


class _After:
    """Finds packages as Python does, and has what waits for one done at the end of its import.

    It has what a MetaPathFinder has, and no base of importlib.abc, which imports tempfile and more: 10 ms.
    """

    def find_spec(self, fullname: str, path: Any = None, target: ModuleType | None = None) -> "ModuleSpec | None":
        if fullname not in _waiting:
            return None
        others = [finder for finder in sys.meta_path if finder is not self]
        specs = (finder.find_spec(fullname, path, target) for finder in others)
        spec = next((spec for spec in specs if spec is not None), None)
        if spec is None or spec.loader is None:
            return spec
        execute = spec.loader.exec_module

        def execute_and_act(module: ModuleType) -> None:
            execute(module)
            actions = _waiting[fullname]
            while actions:
                actions.pop()()

        spec.loader.exec_module = execute_and_act
        return spec
