"""How many of the machine's cores this process may use."""

import os


def cores() -> int:
    """Those that it is bound to, or all of the machine where the system does not tell."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
