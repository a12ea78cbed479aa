"""JAX's programs on disk: those of one kind of processor are not for another.

XLA compiles for the processor that it runs on, and JAX's cache does not ask for which one a program was made: read by
another, it may stop the process (SIGILL). Here each kind of processor has a folder of its own. Even of programs for
this very processor XLA says, at length, that they may not suit it, because it counts preferences in tuning among the
features of a processor (github.com/openxla/xla, issue 44565). In folders that are apart this is never true, and it is
not shown.
"""

import hashlib
import os
import sys
import warnings
from pathlib import Path

FOLDER = "JAX_COMPILATION_CACHE_DIR"
LEAST = "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"
LOUDNESS = "TF_CPP_MIN_LOG_LEVEL"
FATAL_ONLY = "3"


def keep(place: Path) -> None:
    """Have JAX keep the programs of a command: where $JAX_COMPILATION_CACHE_DIR asks for it, or else in a folder.

    There they are kept however quickly they were compiled. Where the folder cannot be written, none are.
    """
    if not os.environ.get(FOLDER):
        try:
            place.mkdir(parents=True, exist_ok=True)
        except OSError:
            return
        if not os.access(place, os.W_OK):
            return
        os.environ[FOLDER] = str(place)
        os.environ.setdefault(LEAST, "0")
    # JAX compiles a program again that was cut short when it was written, and says so each time.
    warnings.filterwarnings("ignore", message="Error (reading|writing) persistent compilation cache")
    keep_apart()


def keep_apart() -> None:
    """Have JAX keep its programs, where $JAX_COMPILATION_CACHE_DIR asks for it, by kind of processor.

    Holds for this process and its children. A process that has imported JAX before has its own settings and keeps them.
    """
    chosen = os.environ.get(FOLDER)
    if not chosen or "jax" in sys.modules:
        return
    own = processor()
    if Path(chosen).name != own:
        os.environ[FOLDER] = str(Path(chosen) / own)
    os.environ.setdefault(LOUDNESS, FATAL_ONLY)


def processor() -> str:
    """A name for the kind of this processor: what LLVM calls it, and a hash of its features."""
    from llvmlite.binding import get_host_cpu_features, get_host_cpu_name

    features = get_host_cpu_features().flatten()
    return f"{get_host_cpu_name()}-{hashlib.sha256(features.encode()).hexdigest()[:8]}"
