"""Where generated modules are kept and how they become importable.

The directory holds code that is run, so it must belong to the user alone: mode 0700, and refused if somebody else owns
it or may write to it.
"""

import atexit
import functools
import hashlib
import importlib.util
import os
import shutil
import stat
import sys
import tempfile
import threading
from contextlib import AbstractContextManager
from pathlib import Path
from types import ModuleType

from numba.core.event import Event, Listener, register

from astroinertia.process import activity, interrupts
from astroinertia.process.cache_directory import cache_directory


class _Announced(Listener):
    """Says which function numba compiles, and has signals wait for that; what it finds compiled is not an event."""

    def __init__(self) -> None:
        self.holds: list[AbstractContextManager[None]] = []  # of the main thread, where handlers run

    def on_start(self, event: Event) -> None:
        activity.begin(_words(event))
        if threading.current_thread() is threading.main_thread():
            self.holds.append(interrupts.held())
            self.holds[-1].__enter__()

    def on_end(self, event: Event) -> None:
        activity.end(_words(event))
        if self.holds and threading.current_thread() is threading.main_thread():
            self.holds.pop().__exit__(None, None, None)


def _words(event: Event) -> str:
    function = (event.data or {})["dispatcher"].py_func
    return f"compiling {function.__name__.replace('_', ' ').strip()}"


register("numba:compile", _Announced())


def kernel_directory() -> Path:
    """$ASTROINERTIA_CACHE, or astroinertia/kernels under the user's cache; a temporary one if that is not writable.

    Raises PermissionError for a directory that somebody else owns or may write to.
    """
    path = cache_directory() / ("" if os.environ.get("ASTROINERTIA_CACHE") else "kernels")
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError:
        return _temporary_directory()
    _refuse_strangers(path)
    return path if os.access(path, os.W_OK | os.X_OK) else _temporary_directory()


def load_module(name: str, text: str) -> ModuleType:
    """The module whose source is `text`; its file and its compiled code are kept for later processes."""
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    return _loaded(f"{name[:100]}_{digest}", text)


def taken_from(module: ModuleType) -> str:
    """The line by which another generated module takes all that a generated one defines.

    Its name holds a hash of the text of what is taken, which so is part of the other's text and name, too.
    """
    names = [name for name in vars(module) if not name.startswith("__")]
    return f"from {module.__name__} import {', '.join(names)}"


@functools.cache
def _loaded(name: str, text: str) -> ModuleType:
    path = kernel_directory() / f"{name}.py"
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        handle, temporary = tempfile.mkstemp(suffix=".tmp", dir=path.parent)
        with interrupts.leaving(Path(temporary).unlink), os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        Path(temporary).replace(path)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _refuse_strangers(path: Path) -> None:
    status = path.stat()
    if status.st_uid != os.getuid():
        raise PermissionError(
            f"{path} holds code to be run but belongs to another user: "
            "set ASTROINERTIA_CACHE to a directory of your own"
        )
    if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise PermissionError(f"{path} holds code to be run but others may write to it: chmod 700 it")


@functools.cache
def _temporary_directory() -> Path:
    path = tempfile.mkdtemp(prefix="astroinertia-")
    discard = functools.partial(shutil.rmtree, path, ignore_errors=True)
    atexit.register(discard)
    interrupts.left_behind(discard)
    return Path(path)
