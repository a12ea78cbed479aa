"""What several processes compiled and kept is used side by side in one."""

import os
import subprocess
import sys

import pytest

# A program whose constant is part of a function that all generated modules share. For machines that have no
# instruction for it, what is tested here is a loop, which is compiled as a function of its own.
PROGRAM = '''
import sys
import numpy as np
from astroinertia.engines import numba_vectors
from astroinertia.engines.numba_cache import load_module

numba_vectors.CLOSED_UP = 0
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

SUMS = """
import hashlib
import numpy as np
from astroinertia.effects.catalogue import build
from astroinertia.engines.numba_cpu import Engine

random = np.random.default_rng(4)
position, length = random.normal(size=(400, 3)), np.full(400, 0.3)
engine = Engine(precision="float64")
order, arrangement = engine.arrange(position, length)
fields = {"position": position[order], "mass": np.full(400, 1 / 400), "smoothing_length": length}
sums = engine.all_pair_sums(arrangement, "wendland_c2", build("gravity").all_pair_terms, fields, virial=True)["gravity"]
print(hashlib.sha256(b"".join(np.ascontiguousarray(sums[name]).tobytes() for name in sorted(sums))).hexdigest())
"""


def told_by(program: str, place, *arguments: str) -> str:
    """What a process prints that keeps its programs in a folder."""
    kept = {"NUMBA_CACHE_DIR": str(place / "numba"), "ASTROINERTIA_CACHE": str(place / "kernels")}
    command = [sys.executable, "-c", program, *arguments]
    return subprocess.run(command, env=os.environ | kept, capture_output=True, text=True, check=True).stdout


@pytest.mark.slow
def test_the_process_that_compiles_a_program_rounds_as_those_that_find_it(tmp_path):
    """A loop compiled by itself and within its caller once stood twice under one name, and rounded otherwise."""
    compiled = told_by(SUMS, tmp_path)
    assert (tmp_path / "numba").exists()
    assert told_by(SUMS, tmp_path) == compiled


def test_programs_that_different_processes_compiled_do_not_mix(tmp_path):
    """Functions made with other constants have the same name, types and, each in its process, number: once taken for
    each other, they gave wrong sums over pairs.
    """
    assert told_by(PROGRAM, tmp_path, "0") == "0 True\n"
    assert told_by(PROGRAM, tmp_path, "4") == "4 True\n"
    assert told_by(PROGRAM, tmp_path, "0", "4") == "0 True\n4 True\n"
