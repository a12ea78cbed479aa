"""Arrays as large as those that went before take no new pages of memory once a process keeps what it frees."""

import subprocess
import sys
import textwrap

import pytest

FAULTS = """
    import resource
    import sys

    import numpy as np

    from astroinertia.process.freed_memory import keep_freed_memory

    if sys.argv[1] == "kept":
        keep_freed_memory()

    def faults():
        return resource.getrusage(resource.RUSAGE_SELF).ru_minflt

    def used():
        for _ in range(4):
            np.ones(6_000_000)  # 48 MB, more than glibc ever keeps by itself

    used()
    before = faults()
    used()
    print(faults() - before)
"""


def faults(how: str) -> int:
    command = [sys.executable, "-c", textwrap.dedent(FAULTS), how]
    return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


@pytest.mark.slow
def test_kept_memory_is_taken_again_without_new_pages():
    by_default = faults("not kept")
    if by_default < 50:
        pytest.skip("this machine's C library keeps freed memory by itself")
    assert faults("kept") < 0.1 * by_default
