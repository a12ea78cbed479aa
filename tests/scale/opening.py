"""What opening results takes in a process of its own: prints a list in JSON.

python tests/scale/opening.py RESULT SMALL open|tree|lazy_tree [RESULT SMALL ...]

SMALL, a small result, is opened in the same way first: what that leaves in memory is the idle program, and what it
imports is not counted.
"""

import gc
import json
import sys
import time
from pathlib import Path

import astroinertia

KINDS = {
    "open": astroinertia.open,
    "tree": astroinertia.open_tree,
    "lazy_tree": lambda path: astroinertia.open_tree(path, chunks={}),
}
STATUS, CLEAR, COUNTED = (Path("/proc/self") / name for name in ("status", "clear_refs", "io"))


def kernel_count(path, kind):
    """What the kernel tells of this process: a number of bytes."""
    line = next(line for line in path.read_text().splitlines() if line.startswith(kind))
    return int(line.split()[1]) * (1024 if path is STATUS else 1)


def taken(action):
    """Seconds of an action, bytes that it read, and the most memory beyond what the process had before."""
    gc.collect()
    CLEAR.write_text("5")  # forget the peak
    memory, read, begin = kernel_count(STATUS, "VmRSS"), kernel_count(COUNTED, "rchar"), time.perf_counter()
    result = action()
    seconds = time.perf_counter() - begin
    return result, {
        "seconds": seconds,
        "read": kernel_count(COUNTED, "rchar") - read,
        "memory": kernel_count(STATUS, "VmHWM") - memory,
    }


def figures_of(result, small, kind):
    """What opening a result takes, and then what the mean place of its last snapshot takes."""
    act = KINDS[kind]
    kept = act(small)
    opened, figures = taken(lambda: act(result))
    assert kept["inertia_tensor"].sizes["i"] == opened["inertia_tensor"].sizes["i"]
    figures["records"] = opened.sizes["time"]
    if kind != "open":
        particles = opened["snapshots"]
        figures["snapshots"] = particles.sizes["snapshot_time"]
        figures["bytes"] = sum(int(variable.nbytes) for variable in particles.data_vars.values())
        centre, figures["one_snapshot"] = taken(
            lambda: particles["position"].isel(snapshot_time=-1).mean("particle").values
        )
        figures["centre"] = centre.tolist()
    return figures


def main():
    asked = sys.argv[1:]
    sys.stdout.write(json.dumps([figures_of(*asked[k : k + 3]) for k in range(0, len(asked), 3)]))


if __name__ == "__main__":
    main()
