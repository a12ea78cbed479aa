"""Where what is worth keeping between runs lives: arrays (storage.cache), JAX's programs, how fast this machine is."""

import os
from pathlib import Path


def cache_directory() -> Path:
    """Return $ASTROINERTIA_CACHE, else astroinertia under $XDG_CACHE_HOME or ~/.cache."""
    own = os.environ.get("ASTROINERTIA_CACHE")
    if own:
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "astroinertia"
