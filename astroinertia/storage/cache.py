"""Results worth keeping between runs: arrays in npz files under the user's cache directory, named by content."""

import contextlib
import hashlib
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import ArchiveError
from astroinertia.process.cache_directory import cache_directory
from astroinertia.storage.atomic import write_whole


def content_key(**content: Any) -> str:
    """Return a hash of what a result depends on: numbers, strings, lists and dicts of them, arrays by their bytes."""
    digest = hashlib.sha256()

    def plain(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return ["array", value.dtype.str, value.shape, hashlib.sha256(np.ascontiguousarray(value).data).hexdigest()]
        if isinstance(value, np.generic):
            return value.item()
        raise TypeError(f"a cache key cannot be made of {type(value).__name__}")

    digest.update(json.dumps(content, sort_keys=True, default=plain).encode())
    return digest.hexdigest()[:32]


def load(kind: str, key: str) -> dict[str, np.ndarray] | None:
    """Return the arrays kept under a key, or None where there are none or they cannot be read."""
    path = cache_directory() / f"{kind}-{key}.npz"
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            return {name: stored[name] for name in stored.files}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None


def save(kind: str, key: str, arrays: dict[str, np.ndarray]) -> None:
    """Keep arrays under a key, whole or not at all; a cache that cannot be written is no error."""
    path = cache_directory() / f"{kind}-{key}.npz"

    def fill(aside: Path) -> None:
        with aside.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays)

    with contextlib.suppress(OSError, ArchiveError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, fill)
