"""Where numba keeps what it compiles, where it finds no place by itself.

It writes beside the source of a function, or under the user's cache, and fails where it may do neither: an installation
that belongs to somebody else, used by an account without a home, as containers have. Tests:
tests/unit/engines/test_numba_place.py.
"""

import os
from pathlib import Path
from typing import Any

from astroinertia.process.cache_directory import users_cache

PACKAGE = Path(__file__).parents[1]


def give_a_place() -> None:
    """Have numba, once it is imported, write where generated modules are kept, if it may write nowhere else."""
    from numba.core import config  # only here: this is called when numba is there

    settings: Any = config  # which fills them in as it is imported
    if settings.CACHE_DIR or _writable(PACKAGE / "__pycache__") or _writable(users_cache() / "numba"):
        return
    from astroinertia.engines.numba_cache import kernel_directory  # only here: most need it not

    settings.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"] = str(kernel_directory())  # for workers of a sweep, too


def _writable(path: Path) -> bool:
    """Whether a folder may be written to, or made."""
    there = next(folder for folder in (path, *path.parents) if folder.exists())
    return there.is_dir() and os.access(there, os.W_OK | os.X_OK)
