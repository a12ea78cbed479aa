"""Where what is worth keeping between runs lives: arrays (storage.cache), JAX's programs, how fast this machine is."""

import os
from pathlib import Path

NO_HOME = Path("/dev/null")  # of a user whom the system does not know: nothing can be kept there


def cache_directory() -> Path:
    """Return $ASTROINERTIA_CACHE, else astroinertia under the user's cache."""
    own = os.environ.get("ASTROINERTIA_CACHE")
    return Path(own) if own else users_cache() / "astroinertia"


def users_cache() -> Path:
    """$XDG_CACHE_HOME or ~/.cache."""
    if own := os.environ.get("XDG_CACHE_HOME"):
        return Path(own)
    try:
        home = Path.home()
    except RuntimeError:
        home = NO_HOME
    return home / ".cache"
