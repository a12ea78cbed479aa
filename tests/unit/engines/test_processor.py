"""Which vectors are compacted is decided by the processor that numba compiles for."""

import os
import subprocess
import sys

import llvmlite.binding as llvm
import pytest

from astroinertia.engines.processor import FEATURES, mean_estimates
from tests.processors import PROCESSORS

# Numbers of 32 bits stand beside keys of 64: the widest vectors hold half as many of those. The program is run
# only where the processor is at hand.
PROGRAM = """
import sys
import numpy as np
from numba import njit, types
from astroinertia.engines.processor import vector_bits
from astroinertia.gravity import compaction


@njit
def entry(values, key, count, out, filled):
    return compaction.compacted(values, key, count, out, filled)


def check(number, key):
    keys = np.random.default_rng(2).normal(size=164).astype(key)
    keys[[3, 77]] = np.nan
    values, out = np.arange(164).astype(number), np.full(200, -1, number)
    for count in (0, 1, 7, 8, 9, 100, 101):
        kept = values[:count][~(keys[:count] >= 0)]
        assert entry(values, keys, count, out, 5) == 5 + len(kept), count
        assert np.array_equal(out[5 : 5 + len(kept)], kept), count


for number, key in (("int32", "float64"), ("int32", "float32"), ("int64", "float64")):
    integers, keys = (types.Array(getattr(types, name), 1, "C") for name in (number, key))
    entry.compile((integers, keys, types.int64, integers, types.int64))
    if sys.argv[1] == "run":
        check(number, key)
print(vector_bits())
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=() if name in ("generic", "AVX-512") else pytest.mark.full) for name in PROCESSORS],
)
def test_numbers_are_compacted_for_every_processor(name):
    processor = PROCESSORS[name]
    command = [sys.executable, "-c", PROGRAM, "run" if processor.is_here else "compile"]
    environment = os.environ | processor.environment
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(done.stdout) == processor.bits


@pytest.mark.parametrize(("bits", "bound"), [(512, 2.0**-14), (256, 1.5 * 2.0**-12)])
def test_means_of_estimated_roots_are_those_of_small_errors(bits, bound):
    """Of errors of at most some bound that of the cube is thrice their mean, and thrice their mean square."""
    mean, cube = mean_estimates(bits)
    if not llvm.get_host_cpu_features().get(FEATURES[bits]):
        assert (mean, cube) == (1.0, 1.0)
        return
    assert abs(mean - 1.0) < bound
    assert 0.0 < cube - 1.0 - 3.0 * (mean - 1.0) < 3.1 * bound**2
