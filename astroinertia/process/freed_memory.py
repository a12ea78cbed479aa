"""Memory that a process frees stays its own, for the next step asks for the same again.

By default glibc hands large pieces back to the system, which clears each page when it is taken once more: of a
million particles that takes 5 to 7 % of a step, all on one thread, and keeping it a fifteenth more memory at the peak.
"""

import ctypes

TRIM_THRESHOLD, MOST_MAPPED = -1, -4  # glibc's malloc.h: M_TRIM_THRESHOLD, M_MMAP_MAX
NEVER = -1  # read as the largest size


def keep_freed_memory() -> None:
    """From now on, in this process; nothing where the C library has no such setting."""
    setting = getattr(ctypes.CDLL(None), "mallopt", None)
    if setting is not None:
        setting(MOST_MAPPED, 0)
        setting(TRIM_THRESHOLD, NEVER)
