"""What several processes compiled and kept is used side by side in one."""

import os
import subprocess
import sys

# A program whose constant is part of a function that all generated modules share. For machines that have no
# instruction for it, what is tested here is a loop, which is compiled as a function of its own.
PROGRAM = '''
import sys
import numpy as np
from astroinertia.engines import numba_vectors
from astroinertia.engines.numba_cache import load_module

numba_vectors.COMPRESSES = False
from astroinertia.engines.numba_passes import header

TEXT = """
spread = row_spreader(4, {begin})


@njit(cache=True, nogil=True, error_model="numpy")
def taken(table, index, count, out):
    spread(table, index, count, out)
"""
table, out = np.arange(16.0 * 12).reshape(16, 12), np.empty((4, 16))
for begin in map(int, sys.argv[1:]):
    text = "\\n".join([*header("float64"), TEXT.format(begin=begin)])
    load_module(f"taken_{begin}", text).taken(table, np.arange(16), 16, out)
    print(begin, np.array_equal(out, table[:, begin : begin + 4].T))
'''


def test_programs_that_different_processes_compiled_do_not_mix(tmp_path):
    """Functions made with other constants have the same name, types and, each in its process, number: once taken for
    each other, they gave wrong sums over pairs.
    """
    kept = {"NUMBA_CACHE_DIR": str(tmp_path / "numba"), "ASTROINERTIA_CACHE": str(tmp_path / "kernels")}

    def told(*begins: str) -> str:
        return subprocess.run(
            [sys.executable, "-c", PROGRAM, *begins], env=os.environ | kept, capture_output=True, text=True, check=True
        ).stdout

    assert told("0") == "0 True\n"
    assert told("4") == "4 True\n"
    assert told("0", "4") == "0 True\n4 True\n"
